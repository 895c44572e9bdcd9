"""The guard's program for a bus of AX-12A; for its arguments, ended by baud and margin, see
`lbr.drivers.servos.guard_release`."""

import sys
from collections.abc import Sequence

from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.model import Ax12
from lbr.drivers.servos.guard_release import run
from lbr.drivers.servos.line import ServoLine
from lbr.drivers.servos.register_release import RegisterRelease


def released(line: int, servos: list[int], words: Sequence[str]) -> RegisterRelease:
    """Return the release for the servos on a line with this baud and margin."""
    baud, margin_s = words
    return RegisterRelease(Bus(ServoLine(line, "of the servos", int(baud), margin_s=float(margin_s))), Ax12(), servos)


if __name__ == "__main__":
    run(sys.argv[1:], released)
