"""The robot as a service of the machine: at boot, killed, frozen, stopped and restarted in motion, and cut off its power.

Run from outside, because the machine goes off in between. What its motors get is on its console, by its own clock.
"""

import json
import random
import re
import shlex
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import msgspec
from msgspec import Struct

from tests.lab import edits
from tests.lab.machine import Machine
from tests.support import programs

PLAYER = """[Unit]
Description=devices played to the kernel
Before=lbr@lbr.service lbr@bioloid.service
[Service]
WorkingDirectory=/opt/lab
ExecStartPre=/sbin/modprobe -a vhci-hcd i2c-dev
ExecStart=/opt/lbr/bin/python -m tests.lab.played play {}
TimeoutStopSec=60
[Install]
WantedBy=multi-user.target
"""
UNIT, HUMANOID = "lbr@lbr.service", "lbr@bioloid.service"
AS_SERVICE = "cd / && LBR_HOME=/var/lib/lbr setpriv --reuid=lbr --regid=lbr --init-groups -- /opt/lbr/bin/lbr"
DRIVES = f"({AS_SERVICE} send --hold 30 /r/0.3/90) >/tmp/drives 2>&1 </dev/null &"
PLAYED = "cd /opt/lab && /opt/lbr/bin/python -m tests.lab.played"
WAIT_S = 1200.0
OFF_S = 900.0
STILL_S = 3.0
MOST_SERVOS = 12
"""So many of eighteen hold, and the robot stands."""
ZERO_S = 0.3
FROZEN_ZERO_S = 3.5
"""The watchdog of the unit is 2 s, and what it aborts has a second."""
SEED = 20261126
KEPT = "service.json"


class Scene(Struct, frozen=True):
    """What was tried, whether it came out as promised, and what was seen."""

    what: str
    passed: bool
    seen: str


class SceneError(AssertionError):
    """A scene that did not come out as promised."""


def play(machine: Machine, send: Callable[[Machine], None], cuts: int) -> Iterator[Scene]:
    """Try it all, one after the other; a scene that fails is told, and the next one begins from a boot."""
    stage = Stage(machine, send)
    for what, scene in (
        ("up at boot, by its own user, on the devices' names", stage.boots),
        ("drives when told to, and stands when nothing renews", stage.drives),
        ("its executive killed in motion: zero, back, nothing resumes", stage.killed),
        ("its executive frozen in motion: zero, aborted, back", stage.frozen),
        ("stopped in motion", stage.stopped),
        ("Shutdown is said: stays down until started again", stage.shut_down),
        ("the machine restarted in motion", stage.restarted_in_motion),
        ("the machine powered off in motion", stage.powered_off_in_motion),
        (
            "a humanoid whose battery runs out: its joints lose their torque, then the machine goes off",
            stage.out_of_power,
        ),
        (f"{cuts} power cuts amid edits of rows", lambda: stage.cut(cuts)),
    ):
        yield stage.tell(what, scene)


class Stage:
    """The machine with the robot in it, and the ways to look at both."""

    def __init__(self, machine: Machine, send: Callable[[Machine], None]) -> None:
        self.machine = machine
        self._send = send
        self._log = machine.folder / "serial.log"

    def tell(self, what: str, scene: Callable[[], str]) -> Scene:
        """Play a scene; whatever it raises is what was seen."""
        try:
            return Scene(what, True, scene())
        except Exception as err:  # noqa: BLE001 - the next scene is to be played, too
            return Scene(what, False, f"{type(err).__name__}: {err}"[:400])

    # -- scenes -------------------------------------------------------------------------------------------------

    def boots(self) -> str:
        """Install what plays the devices and the robot's rows, enable both, restart, and wait until it is ready."""
        self._install("lbr")
        self.machine.run(f"systemctl enable {UNIT} lab-player")
        self._off("systemctl reboot")
        self.machine.start(snapshot=False)
        self._ready()
        up_s = int(self._property("ActiveEnterTimestampMonotonic")) / 1e6
        user = self.machine.run("ps -o user= -p $(systemctl show -P MainPID lbr@lbr)").stdout.decode().strip()
        if user != "lbr":
            raise SceneError(f"it runs as {user}")
        return f"ready {up_s:.1f} s after the kernel; user {user}; {self._phases()}"

    def drives(self) -> str:
        """Drive, and let go."""
        self._in_motion()
        told_s = self._now()
        self.machine.run("pkill -KILL -f 'lbr send'")
        return f"zero {self._zero_after(told_s) * 1e3:.0f} ms after its sender was killed"

    def killed(self) -> str:
        """Kill the executive in motion."""
        self._in_motion()
        at = self._now(f"kill -KILL {self._property('MainPID')}")
        zero_s = self._zero_after(at)
        self._ready()
        self._still()
        self._within(zero_s, ZERO_S)
        return f"zero after {zero_s * 1e3:.0f} ms; ready again; starts {self._property('NRestarts')}"

    def frozen(self) -> str:
        """Freeze the executive in motion; only the unit's watchdog ends it."""
        self._in_motion()
        pid = self._property("MainPID")
        at = self._now(f"kill -STOP {pid}")
        zero_s = self._zero_after(at)
        self._until(lambda: self._property("MainPID") not in {pid, "0"}, "another executive")
        self._ready()
        self._still()
        self._within(zero_s, FROZEN_ZERO_S)
        told = self.machine.run(f"journalctl -u {UNIT} --no-pager | grep -i 'watchdog timeout'", check=False).stdout
        if not told:
            raise SceneError("the journal tells of no watchdog")
        return f"zero after {zero_s:.2f} s; the watchdog's time was over; ready again"

    def stopped(self) -> str:
        """Stop the service in motion."""
        self._in_motion()
        at = self._now(f"systemctl stop {UNIT}")
        zero_s = self._zero_after(at)
        left = self.machine.run("pgrep -c -u lbr -f 'lbr run|lbr.capability'", check=False).stdout.decode().strip()
        if left != "0":
            raise SceneError(f"{left} processes of the robot are left")
        self._within(zero_s, ZERO_S)
        return f"zero after {zero_s * 1e3:.0f} ms; no process left"

    def shut_down(self) -> str:
        """Say Shutdown at the console of a robot that was started again."""
        self.machine.run(f"systemctl start {UNIT}", limit_s=WAIT_S)
        self._ready()
        self.machine.run(f"{AS_SERVICE} send Shutdown", limit_s=WAIT_S)
        self._until(lambda: self._property("ActiveState") == "inactive", "the unit inactive")
        self.machine.run("sleep 5")
        if self._property("ActiveState") != "inactive":
            raise SceneError("it came back")
        self.machine.run(f"systemctl start {UNIT}", limit_s=WAIT_S)
        self._ready()
        return "inactive 5 s later; starts again when told to"

    def restarted_in_motion(self) -> str:
        """Restart the machine in motion, and wait until it is up."""
        self._in_motion()
        zero_s = self._off("systemctl reboot", moving=True)
        self.machine.start(snapshot=False)
        self._ready()
        self._still()
        return f"zero {zero_s:.2f} s after it was told to restart; up again, stands"

    def powered_off_in_motion(self) -> str:
        """Power the machine off in motion."""
        self._in_motion()
        zero_s = self._off("systemctl poweroff", moving=True)
        self.machine.start(snapshot=False)
        self._ready()
        return f"zero {zero_s:.2f} s after it was told to power off; it went off"

    def out_of_power(self) -> str:
        """Have a humanoid stand, and its battery run out."""
        self.machine.cut()
        self.machine.start(snapshot=True)
        self._install("bioloid")
        self.machine.run(f"systemctl start lab-player && systemctl start {HUMANOID}", limit_s=WAIT_S)
        self._ready(HUMANOID)
        self._until(lambda: self.machine.run(f"{AS_SERVICE} send /torque/on", check=False).returncode == 0, "torque")
        self._until(lambda: self._servos()[-1][1] >= MOST_SERVOS, "its joints hold")
        self.machine.run(f"{AS_SERVICE} send arm")
        at = self._now("touch /run/lab-low")
        if not self.machine.ended(WAIT_S):
            raise SceneError("the machine is not off")
        let_go = [when for when, held in self._servos() if when > at and held == 0]
        if not let_go:
            raise SceneError("the joints were not let go before")
        return f"its joints were let go {let_go[0] - at:.0f} s after the voltage fell, and the machine went off"

    def cut(self, cuts: int) -> str:
        """Edit rows and press the emergency stop without a pause, take the power away, and look at what is on the disk.

        What was told as written before the cut has to be there, and the database has to be whole.
        """
        dice, told = random.Random(SEED), 0
        self.machine.cut()
        for number in range(cuts):
            self.machine.start(snapshot=True)
            self._send(self.machine)
            self.machine.run(f"{PLAYED} prepare lbr")
            editing = programs.start(
                [*self.machine.ssh(), EDITING], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            assert editing.stdout is not None
            last = 0
            end = time.monotonic() + dice.uniform(2.0, 12.0)
            while time.monotonic() < end:
                line = editing.stdout.readline()
                last = int(line) if line.strip().isdigit() else last
            self.machine.cut()
            last = max([last, *(int(line) for line in editing.stdout if line.strip().isdigit())])
            editing.wait()
            editing.stdout.close()
            self._whole(number, last)
            told += last
            print(f"cut {number + 1} of {cuts}: {last} edits were told, all there", flush=True)
        return f"{cuts} cuts, seed {SEED}: {told} edits told as written, all there; every database whole"

    # -- what scenes are made of --------------------------------------------------------------------------------

    def _install(self, robot: str) -> None:
        """Put in what plays a robot's devices, and that robot's rows."""
        self._send(self.machine)
        unit = PLAYER.format(robot).encode()
        self.machine.run("cat >/etc/systemd/system/lab-player.service && systemctl daemon-reload", data=unit)
        self.machine.run(f"{PLAYED} prepare {robot}")

    def _whole(self, number: int, last: int) -> None:
        """Look at the database as the disk has it."""
        folder = self.machine.folder
        raw, found = folder / "cut.raw", folder / "cut"
        programs.run(["qemu-img", "convert", "-O", "raw", str(folder / "disk.qcow2"), str(raw)], check=True)
        try:
            programs.run(["e2fsck", "-fy", str(raw)], check=False, capture_output=True)
            found.mkdir(exist_ok=True)
            for name in edits.FILES:
                (found / Path(name).name).unlink(missing_ok=True)
                request = f"dump {edits.HOME / name} {found / Path(name).name}"
                programs.run(["debugfs", "-R", request, str(raw)], check=False, capture_output=True)
            if why := edits.damage(found, last):
                raise SceneError(f"cut {number}: {why}")
        finally:
            raw.unlink()

    def _in_motion(self) -> None:
        self._ready()
        self._until(lambda: self._outputs()[-1][1:] == (0.0, 0.0), "at rest before")
        self.machine.run(DRIVES)
        self._until(lambda: self._outputs()[-1][1:] != (0.0, 0.0), "motion")

    def _off(self, command: str, *, moving: bool = False) -> float:
        """Give the machine a command that ends it; return how long the motors went on by the machine's own clock."""
        at = self._now()
        self.machine.run(f"sync; {command}", check=False, limit_s=OFF_S)
        if not self.machine.ended(OFF_S):
            raise SceneError(f"the machine is not off {OFF_S:g} s after '{command}'")
        if not moving:
            return 0.0
        zeros = [seen for seen in self._outputs() if seen[0] > at and seen[1:] == (0.0, 0.0)]
        if not zeros or self._outputs()[-1][1:] != (0.0, 0.0):
            raise SceneError("the motors were not at zero when the machine went off")
        return zeros[0][0] - at

    def _ready(self, unit: str = UNIT) -> None:
        self._until(lambda: self._property("ActiveState", unit) == "active", "the unit active")
        self._until(lambda: re.search(r"\bready\b|\bdegraded\b", self._property("StatusText", unit)), "ready")

    def _phases(self) -> str:
        said = self.machine.run(f"{AS_SERVICE} status --json", limit_s=WAIT_S).stdout
        return ", ".join(f"{one['name']} {one['phase']}" for one in json.loads(said)["capabilities"])

    def _still(self) -> None:
        before = len(self._outputs())
        self.machine.run(f"sleep {STILL_S:g}")
        if any(seen[1:] != (0.0, 0.0) for seen in self._outputs()[before:]):
            raise SceneError("the old motion goes on")

    def _zero_after(self, at: float) -> float:
        found = self._until(
            lambda: [seen for seen in self._outputs() if seen[0] >= at and seen[1:] == (0.0, 0.0)], "zero"
        )
        return float(found[0][0] - at)

    @staticmethod
    def _within(seen_s: float, limit_s: float) -> None:
        if seen_s > limit_s:
            raise SceneError(f"zero after {seen_s:.2f} s, {limit_s:g} s is promised")

    def _now(self, then: str = "true") -> float:
        """Return the machine's time since its start, right before it did something."""
        words = f"import os, time; print(time.monotonic(), flush=True); os.execlp('sh', 'sh', '-c', {then!r})"
        return float(self.machine.run(f"python3 -c {shlex.quote(words)}", limit_s=WAIT_S).stdout.split()[0])

    def _property(self, name: str, unit: str = UNIT) -> str:
        return self.machine.run(f"systemctl show -P {name} {unit}").stdout.decode().strip()

    def _servos(self) -> list[tuple[float, int]]:
        found = re.findall(r"@([\d.]+) servos (\d+)", self._log.read_text(errors="replace"))
        return [(float(at), int(held)) for at, held in found] or [(0.0, 0)]

    def _outputs(self) -> list[tuple[float, float, float]]:
        text = self._log.read_text(errors="replace")
        found = re.findall(r"@([\d.]+) outputs (\S+) (\S+)", text)
        return [(float(at), float(left), float(right)) for at, left, right in found] or [(0.0, 0.0, 0.0)]

    def _until(self, look: Callable[[], object], what: str) -> list[tuple[float, float, float]]:
        end = time.monotonic() + WAIT_S
        while not (found := look()):
            if time.monotonic() > end:
                raise SceneError(f"not within {WAIT_S:g} s of this machine's time: {what}")
            time.sleep(0.5)
        return found if isinstance(found, list) else []


EDITING = "cd /opt/lab && setpriv --reuid=lbr --regid=lbr --init-groups -- /opt/lbr/bin/python -u -m tests.lab.edits"
"""Edits one after the other, as the service's user; each is told once it is written."""


def keep(folder: Path, scenes: Sequence[Scene]) -> None:
    """Keep what came of it."""
    (folder / KEPT).write_bytes(msgspec.json.encode(scenes))


def kept(folder: Path) -> list[Scene]:
    """Return what came of it last, nothing if it was never tried."""
    path = folder / KEPT
    return msgspec.json.decode(path.read_bytes(), type=list[Scene]) if path.exists() else []
