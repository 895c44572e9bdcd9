"""The guard's program."""

import sys
from collections.abc import Sequence

from lbr.drivers.servos.guard_release import run
from lbr.drivers.servos.protocol1.line import ServoLine
from lbr.drivers.servos.register_release import RegisterRelease
from tests.drivers.sts.driver import StsBus, StsModel


def released(line: int, servos: list[int], words: Sequence[str]) -> RegisterRelease:
    """Return what the servos are told."""
    baud, margin_s = words
    bus = StsBus(ServoLine(line, "of the servos", int(baud), margin_s=float(margin_s)))
    return RegisterRelease(bus, StsModel(), servos)


if __name__ == "__main__":
    run(sys.argv[1:], released)
