"""In the machine: plays the devices of the robot lbr to its kernel, and says on the console what its motors get.

python -m tests.lab.played prepare   the service's home, with rows for these devices
python -m tests.lab.played           until it is told to end
"""

import signal
import sys
import tempfile
import threading
import time
from pathlib import Path

from msgspec.structs import replace

from lbr.simulation.twins import Twin
from lbr.testing.device import AT_REST, RANGES_M
from tests.support import robot as robots
from tests.support.usb import robots as usb_robots
from tests.support.usb.rig import ARDUINO, ROBOTEQ, CdcAcm, given_to, on_line

HOME = Path("/var/lib/lbr")
CONSOLE = Path("/dev/ttyS0")
LOOK_S = 0.004


def main() -> None:
    if sys.argv[1:] == ["prepare"]:
        prepare()
        return
    over = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: over.set())
    with (
        tempfile.TemporaryDirectory(prefix="lab-") as name,
        on_line("roboteq", Path(name), CdcAcm, ROBOTEQ) as motors,
        on_line("ultrasonic_ring", Path(name), CdcAcm, ARDUINO, live=_in_a_room),
    ):
        outputs, last = usb_robots.Outputs(motors), None
        say("devices are plugged in")
        while not over.wait(LOOK_S):
            now = outputs.now
            if now != last:
                last = now
                say("outputs {:g} {:g}".format(*now))
        say("devices are unplugged")


def _in_a_room(twin: Twin, now: float) -> None:
    """Measure walls a metre away; a reading that never changes is rightly taken for a frozen one."""
    away_m = 1.0 + 0.02 * (int(now * 10) % 3)
    twin.sense(replace(AT_REST, ranges_m=dict.fromkeys(RANGES_M, away_m)))


def say(words: str) -> None:
    """Write a line to the machine's console, which is a file outside, with the machine's time since its start."""
    with CONSOLE.open("w") as console:
        console.write(f"\r\n@{time.monotonic():.3f} {words}\r\n")


def prepare() -> None:
    """Make the service's home anew, for the capabilities that have a device here."""
    robots.prepare(HOME, edits=(*usb_robots.ON_WHEELS_EDITS, robots.only("lbr", *usb_robots.ON_WHEELS)), whole=True)
    given_to("lbr", HOME)


if __name__ == "__main__":
    main()
