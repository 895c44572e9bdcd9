"""The robot as a service of the machine: at boot, killed, frozen, stopped and restarted in motion, and cut off its power.

Run from outside, because the machine goes off in between. What its motors get is on its console, by its own clock.
"""

import random
import subprocess
import time
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

from tests.lab import edits, stage
from tests.lab.machine import Machine
from tests.lab.stage import AS_SERVICE, PLAYED, WAIT_S, Scene, SceneError, until, within
from tests.support import programs

UNIT, HUMANOID = "lbr@lbr.service", "lbr@bioloid.service"
DRIVES = f"({AS_SERVICE} send --hold 30 /r/0.3/90) >/tmp/drives 2>&1 </dev/null &"
MOST_SERVOS = 12
"""So many of eighteen hold, and the robot stands."""
ZERO_S = 0.3
FROZEN_ZERO_S = 3.5
"""The watchdog of the unit is 2 s, and what it aborts has a second."""
SEED = 20261126
KEPT = "service.json"


def play(machine: Machine, send: Callable[[Machine], None], cuts: int, words: Sequence[str] = ()) -> Generator[Scene]:
    """Try it all, or what is told with one of these words, one after the other; a scene that fails is told."""
    robot = Service(machine, send, UNIT)
    for what, scene in (
        ("up at boot, by its own user, on the devices' names", robot.boots),
        ("drives when told to, and stands when nothing renews", robot.drives),
        ("its executive killed in motion: zero, back, nothing resumes", robot.killed),
        ("its executive frozen in motion: zero, aborted, back", robot.frozen),
        ("stopped in motion", robot.stopped),
        ("Shutdown is said: stays down until started again", robot.shut_down),
        ("the machine restarted in motion", robot.restarted_in_motion),
        ("the machine powered off in motion", robot.powered_off_in_motion),
        (
            "a humanoid whose battery runs out: its joints lose their torque, then the machine goes off",
            robot.out_of_power,
        ),
        (f"{cuts} power cuts amid edits of rows", lambda: robot.cut(cuts)),
    ):
        if not words or any(one in what for one in words):
            yield stage.tell(what, scene)


class Service(stage.Stage):
    """The machine with the robot in it, and its scenes."""

    # -- scenes -------------------------------------------------------------------------------------------------

    def boots(self) -> str:
        """Install what plays the devices and the robot's rows, enable both, restart, and wait until it is ready."""
        self._install("lbr")
        self.machine.run(f"systemctl enable {UNIT} lab-player")
        self.off("systemctl reboot")
        self.machine.start(snapshot=False)
        self.ready()
        up_s = int(self.property("ActiveEnterTimestampMonotonic")) / 1e6
        user = self.machine.run("ps -o user= -p $(systemctl show -P MainPID lbr@lbr)").stdout.decode().strip()
        if user != "lbr":
            raise SceneError(f"it runs as {user}")
        return f"ready {up_s:.1f} s after the kernel; user {user}; {self._phases()}"

    def drives(self) -> str:
        """Drive, and let go."""
        self._in_motion()
        told_s = self.now()
        self.machine.run("pkill -KILL -f 'lbr send'")
        return f"zero {self.zero_after(told_s) * 1e3:.0f} ms after its sender was killed"

    def killed(self) -> str:
        """Kill the executive in motion."""
        self._in_motion()
        at = self.now(f"kill -KILL {self.property('MainPID')}")
        zero_s = self.zero_after(at)
        self.ready()
        self.still()
        within(zero_s, ZERO_S)
        return f"zero after {zero_s * 1e3:.0f} ms; ready again; starts {self.property('NRestarts')}"

    def frozen(self) -> str:
        """Freeze the executive in motion; only the unit's watchdog ends it."""
        self._in_motion()
        pid = self.property("MainPID")
        at = self.now(f"kill -STOP {pid}")
        zero_s = self.zero_after(at)
        until(lambda: self.property("MainPID") not in {pid, "0"}, "another executive")
        self.ready()
        self.still()
        within(zero_s, FROZEN_ZERO_S)
        told = self.machine.run(f"journalctl -u {UNIT} --no-pager | grep -i 'watchdog timeout'", check=False).stdout
        if not told:
            raise SceneError("the journal tells of no watchdog")
        return f"zero after {zero_s:.2f} s; the watchdog's time was over; ready again"

    def stopped(self) -> str:
        """Stop the service in motion."""
        self._in_motion()
        at = self.now(f"systemctl stop {UNIT}")
        zero_s = self.zero_after(at)
        left = self.machine.run("pgrep -c -u lbr -f 'lbr run|lbr.capability'", check=False).stdout.decode().strip()
        if left != "0":
            raise SceneError(f"{left} processes of the robot are left")
        within(zero_s, ZERO_S)
        return f"zero after {zero_s * 1e3:.0f} ms; no process left"

    def shut_down(self) -> str:
        """Say Shutdown at the console of a robot that was started again."""
        self.machine.run(f"systemctl start {UNIT}", limit_s=WAIT_S)
        self.ready()
        self.machine.run(f"{AS_SERVICE} send Shutdown", limit_s=WAIT_S)
        until(lambda: self.property("ActiveState") == "inactive", "the unit inactive")
        self.machine.run("sleep 5")
        if self.property("ActiveState") != "inactive":
            raise SceneError("it came back")
        self.machine.run(f"systemctl start {UNIT}", limit_s=WAIT_S)
        self.ready()
        return "inactive 5 s later; starts again when told to"

    def restarted_in_motion(self) -> str:
        """Restart the machine in motion, and wait until it is up."""
        self._in_motion()
        zero_s = self.off("systemctl reboot", moving=True)
        self.machine.start(snapshot=False)
        self.ready()
        self.still()
        return f"zero {zero_s:.2f} s after it was told to restart; up again, stands"

    def powered_off_in_motion(self) -> str:
        """Power the machine off in motion."""
        self._in_motion()
        zero_s = self.off("systemctl poweroff", moving=True)
        self.machine.start(snapshot=False)
        self.ready()
        return f"zero {zero_s:.2f} s after it was told to power off; it went off"

    def out_of_power(self) -> str:
        """Have a humanoid stand, and its battery run out."""
        self.machine.cut()
        self.machine.start(snapshot=True)
        self._install("bioloid")
        self.machine.run(f"systemctl start lab-player && systemctl start {HUMANOID}", limit_s=WAIT_S)
        self.ready(HUMANOID)
        until(lambda: self.machine.run(f"{AS_SERVICE} send /torque/on", check=False).returncode == 0, "torque")
        until(lambda: self._servos()[-1][1] >= MOST_SERVOS, "its joints hold")
        self.machine.run(f"{AS_SERVICE} send arm")
        at = self.now("touch /run/lab-low")
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
            self.send(self.machine)
            self.machine.run(f"{PLAYED} prepare lbr")
            editing = programs.start(
                [*self.machine.ssh(), EDITING], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            assert editing.stdout is not None
            last = int(editing.stdout.readline() or 0)  # a host that is busy has it begin late
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
        self.plays(robot)
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
        self.ready()
        until(lambda: not self.moving(), "at rest before")
        self.machine.run(DRIVES)
        until(self.moving, "motion")

    def _phases(self) -> str:
        return ", ".join(f"{name} {one['phase']}" for name, one in self.capabilities().items())

    def _servos(self) -> list[tuple[float, int]]:
        return [(float(at), int(held)) for at, held in self.said(r"servos (\d+)")] or [(0.0, 0)]


EDITING = "cd /opt/lab && setpriv --reuid=lbr --regid=lbr --init-groups -- /opt/lbr/bin/python -u -m tests.lab.edits"
"""Edits one after the other, as the service's user; each is told once it is written."""
