"""The guard's program for STS3215; run as in `lbr.drivers.servos.guard_release`, with baud and margin at the end."""

import sys
from collections.abc import Sequence

from lbr.drivers.servos.guard_release import run
from lbr.drivers.servos.line import ServoLine
from lbr.drivers.servos.register_release import RegisterRelease
from lbr_so101.bus import FeetechBus
from lbr_so101.model import Sts3215


def released(line: int, servos: list[int], words: Sequence[str]) -> RegisterRelease:
    """Return the guard's commands to the servos on a line with this baud and margin."""
    baud, margin_s = words
    bus = FeetechBus(ServoLine(line, "of the servos", int(baud), margin_s=float(margin_s)))
    return RegisterRelease(bus, Sts3215(), servos)


if __name__ == "__main__":
    run(sys.argv[1:], released)
