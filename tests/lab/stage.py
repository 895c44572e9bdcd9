"""What scenes are made of: a machine with a robot as its service, what that robot's motors get, and what came of a scene.

What the motors get is on the machine's console, by its own clock.
"""

import json
import re
import shlex
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import msgspec
from msgspec import Struct

from tests.lab.machine import Machine

T = TypeVar("T")
PLAYER = """[Unit]
Description=devices played to the kernel
Before=lbr@lbr.service lbr@bioloid.service lbr@two.service
[Service]
WorkingDirectory=/opt/lab
ExecStartPre=/sbin/modprobe -a vhci-hcd i2c-dev
ExecStart=/opt/lbr/bin/python -m tests.lab.played play {}
TimeoutStopSec=60
[Install]
WantedBy=multi-user.target
"""
AS_SERVICE = "cd / && LBR_HOME=/var/lib/lbr setpriv --reuid=lbr --regid=lbr --init-groups -- /opt/lbr/bin/lbr"
PLAYED = "cd /opt/lab && /opt/lbr/bin/python -m tests.lab.played"
WAIT_S = 1200.0
OFF_S = 900.0
LOOK_S = 0.5
STILL_S = 3.0
Output = tuple[float, float, float]
"""When, and what the left and the right motor got from then on."""


class Scene(Struct, frozen=True):
    """What was tried, whether it came out as promised, and what was seen."""

    what: str
    passed: bool
    seen: str


class SceneError(AssertionError):
    """A scene that did not come out as promised."""


def tell(what: str, scene: Callable[[], str]) -> Scene:
    """Play a scene; whatever it raises is what was seen."""
    try:
        return Scene(what, True, scene())
    except subprocess.CalledProcessError as err:
        return Scene(
            what, False, f"'{err.cmd[-1][-80:]}' ends with {err.returncode}: {(err.stderr or b'').decode()[-300:]}"
        )
    except Exception as err:  # noqa: BLE001 - the next scene is to be played, too
        return Scene(what, False, f"{type(err).__name__}: {err}"[:400])


def keep(path: Path, scenes: Sequence[Scene]) -> None:
    """Keep what came of it."""
    path.write_bytes(msgspec.json.encode(scenes))


def kept(path: Path) -> list[Scene]:
    """Return what came of it last, nothing if it was never tried."""
    return msgspec.json.decode(path.read_bytes(), type=list[Scene]) if path.exists() else []


def until(look: Callable[[], T], what: str, limit_s: float = WAIT_S) -> T:
    """Look until something is seen, and return it; the limit is for a machine that has much else to do."""
    end = time.monotonic() + limit_s
    while not (found := look()):
        if time.monotonic() > end:
            raise SceneError(f"not within {limit_s:g} s of this machine's time: {what}")
        time.sleep(LOOK_S)
    return found


def within(seen_s: float, limit_s: float) -> float:
    """Return how long it took to zero, if that is as promised."""
    if not seen_s <= limit_s:
        raise SceneError(f"zero after {seen_s:.2f} s, {limit_s:g} s is promised")
    return seen_s


class Stage:
    """A machine with a robot's service in it, and the ways to look at both."""

    def __init__(self, machine: Machine, send: Callable[[Machine], None], unit: str) -> None:
        self.machine = machine
        self.send = send
        self.unit = unit
        self._log = machine.folder / "serial.log"

    def plays(self, devices: str) -> None:
        """Put in a unit that plays devices."""
        self.send(self.machine)
        unit = PLAYER.format(devices).encode()
        self.machine.run("cat >/etc/systemd/system/lab-player.service && systemctl daemon-reload", data=unit)

    def ready(self, unit: str = "") -> None:
        """Wait until the service says that every capability is ready, or told why not."""
        unit = unit or self.unit
        until(lambda: self.property("ActiveState", unit) == "active", "the unit active")
        until(lambda: re.search(r"\bready\b|\bdegraded\b", self.property("StatusText", unit)), "ready")

    def property(self, name: str, unit: str = "") -> str:
        return self.machine.run(f"systemctl show -P {name} {unit or self.unit}").stdout.decode().strip()

    def capabilities(self) -> dict[str, dict[str, Any]]:
        """Return what the robot's status says of each capability."""
        said = self.machine.run(f"{AS_SERVICE} status --json", limit_s=WAIT_S).stdout
        return {one["name"]: one for one in json.loads(said)["capabilities"]}

    def now(self, then: str = "true") -> float:
        """Return the machine's time since its start, right before it did something."""
        words = f"import os, time; print(time.monotonic(), flush=True); os.execlp('sh', 'sh', '-c', {then!r})"
        return float(self.machine.run(f"python3 -c {shlex.quote(words)}", limit_s=WAIT_S).stdout.split()[0])

    def said(self, pattern: str) -> list[tuple[str, ...]]:
        """Return what the machine's console has of a kind: the time of each, and its words."""
        found = re.finditer(rf"@([\d.]+) {pattern}", self._log.read_text(errors="replace"))
        return [one.groups() for one in found]

    def last(self, pattern: str) -> float:
        """Return when the machine's console had something of a kind last."""
        return float(self.said(pattern)[-1][0])

    def outputs(self) -> list[Output]:
        found = self.said(r"outputs (\S+) (\S+)")
        return [(float(at), float(left), float(right)) for at, left, right in found] or [(0.0, 0.0, 0.0)]

    def moving(self) -> bool:
        return self.outputs()[-1][1:] != (0.0, 0.0)

    def zero_after(self, at: float) -> float:
        """Wait until both motors get zero, and return how long after a moment that was."""
        found = until(lambda: [seen for seen in self.outputs() if seen[0] >= at and seen[1:] == (0.0, 0.0)], "zero")
        return found[0][0] - at

    def still(self, for_s: float = STILL_S) -> None:
        """Let time pass, in which the motors get nothing but zero."""
        before = len(self.outputs())
        self.machine.run(f"sleep {for_s:g}", limit_s=WAIT_S)
        if self.moving() or any(seen[1:] != (0.0, 0.0) for seen in self.outputs()[before:]):
            raise SceneError("the old motion goes on")

    def off(self, command: str, *, moving: bool = False) -> float:
        """Give the machine a command that ends it; return how long the motors went on by the machine's own clock."""
        at = self.now()
        self.machine.run(f"sync; {command}", check=False, limit_s=OFF_S)
        if not self.machine.ended(OFF_S):
            raise SceneError(f"the machine is not off {OFF_S:g} s after '{command}'")
        if not moving:
            return 0.0
        zeros = [seen for seen in self.outputs() if seen[0] > at and seen[1:] == (0.0, 0.0)]
        if not zeros or self.moving():
            raise SceneError("the motors were not at zero when the machine went off")
        return zeros[0][0] - at
