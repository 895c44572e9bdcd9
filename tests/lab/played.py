"""In the machine: plays a robot's devices to its kernel, and says on the console what its motors get.

python -m tests.lab.played prepare ROWS    the service's home, with rows for these devices
python -m tests.lab.played play DEVICES    until it is told to end; says, too, when the cable to another machine is out or in
"""

import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from msgspec.structs import replace

from lbr.simulation.twins import ServoBus, Twin
from lbr.testing.device import AT_REST, RANGES_M
from tests.support import robot as robots
from tests.support.usb import robots as usb_robots
from tests.support.usb.rig import ARDUINO, ROBOTEQ, USB2AX, CdcAcm, adaptor, given_to, on_line

HOME = Path("/var/lib/lbr")
CONSOLE = Path("/dev/console")
LOW = Path("/run/lab-low")
"""While it is there, the supply's battery is empty."""
FULL_V, EMPTY_V = 12.6, 9.5
LOOK_S = 0.004
CARRIER = Path("/sys/class/net/eth1/carrier")
OPEN = """UPDATE capability SET settings = json_set(settings, '$.host', '0.0.0.0', '$.announce', json('true'))
    WHERE robot = 'lbr' AND name = 'web'"""
ROWS = {
    "lbr": (*usb_robots.ON_WHEELS_EDITS, robots.only("lbr", *usb_robots.ON_WHEELS)),
    "bioloid": (robots.only("bioloid", "servos", "joints", "motions", "ups", "power"),),
    "two": (
        *usb_robots.ON_WHEELS_EDITS,
        robots.only("lbr", *usb_robots.ON_WHEELS, "dance", "box", "lan", "web"),
        "UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'lan'",
        OPEN,
    ),
}
Look = Callable[[], str]


def main() -> None:
    what, wanted = sys.argv[1:]
    if what == "prepare":
        robots.prepare(HOME, edits=ROWS[wanted], whole=True)
        given_to("lbr", HOME)
        return
    over = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: over.set())
    with tempfile.TemporaryDirectory(prefix="lab-") as folder, DEVICES[wanted](Path(folder)) as look:
        last = ["", ""]
        say("devices are plugged in")
        while not over.wait(LOOK_S):
            now = [look(), _cable()]
            for words, before in zip(now, last, strict=True):
                if words and words != before:
                    say(words)
            last = now
        say("devices are unplugged")


def say(words: str) -> None:
    """Write a line to the machine's console, which is a file outside, with the machine's time since its start."""
    with CONSOLE.open("w") as console:
        console.write(f"\r\n@{time.monotonic():.3f} {words}\r\n")


def _cable() -> str:
    """Return whether the cable to another machine is in; nothing if there is no such card, or it is off."""
    with suppress(OSError):
        return f"cable {CARRIER.read_text().strip()}"
    return ""


@contextmanager
def _wheels(folder: Path) -> Iterator[Look]:
    with on_line("roboteq", folder, CdcAcm, ROBOTEQ) as motors:
        outputs = usb_robots.Outputs(motors)
        yield lambda: "outputs {:g} {:g}".format(*outputs.now)


@contextmanager
def _ring(folder: Path) -> Iterator[Look]:
    with on_line("ultrasonic_ring", folder, CdcAcm, ARDUINO, live=_in_a_room):
        yield lambda: ""


@contextmanager
def _on_wheels(folder: Path) -> Iterator[Look]:
    with _wheels(folder) as look, _ring(folder):
        yield look


@contextmanager
def _on_legs(folder: Path) -> Iterator[Look]:
    with on_line("dynamixel", folder, CdcAcm, USB2AX) as bus, adaptor(folder, "pico", live=_on_a_battery):
        servos = bus.twin.twin
        assert isinstance(servos, ServoBus)
        yield lambda: f"servos {sum(one.torque > 0 for one in servos.drives(time.monotonic()).values())}"


def _in_a_room(twin: Twin, now: float) -> None:
    """Measure walls a metre away; a reading that never changes is rightly taken for a frozen one."""
    away_m = 1.0 + 0.02 * (int(now * 10) % 3)
    twin.sense(replace(AT_REST, ranges_m=dict.fromkeys(RANGES_M, away_m)))


def _on_a_battery(twin: Twin, _now: float) -> None:
    twin.sense(replace(AT_REST, battery_v=EMPTY_V if LOW.exists() else FULL_V))


DEVICES = {"lbr": _on_wheels, "wheels": _wheels, "ring": _ring, "bioloid": _on_legs}

if __name__ == "__main__":
    main()
