"""A simulated robot under measurement: driven by a stubborn sender, watched at its motor controller's outputs."""

import os
import random
import select
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import psutil

from lbr.errors import BusError
from lbr.testing.robot import NoAnswerError
from tests.support.figures import Results
from tests.support.mover import RENEW_S, Mover
from tests.support.robot import Robot, start
from tests.support.robot import prepare as prepare_base
from tests.support.trace import Output, Trace, limit_violations
from tests.support.waiting import HANG_S, STOPS_S

VICTIMS = Path(__file__).parent / "victims"
ALMOST = 0.39
ATTEMPTS = 20
"""Of a start, by which nothing is measured: on a machine that is full many are broken off, as they must be."""
STARTS_S = 10.0
"""A program that drives has begun to, or has been refused on a machine that is full."""
LAST_BYTES_S = 0.15
"""A killed driver's last bytes may wait this long in the line; no new one is ready so soon."""
ROUNDED_S = 0.1
"""Uptimes are told in tenths of a second."""
ACCEL_PER_S = 2.0
ANGLES = (90.0, 270.0)
"""Spinning on the spot needs no room, so a robot may be driven for as long as it takes."""


def prepare(home: Path, *victims: str, edits: tuple[str, ...] = (), whole: bool = False) -> Path:
    """Make a home for tests, with the named victims' kinds in it; lbr runs its base alone unless it is to be whole."""
    kinds = home / "capabilities"
    kinds.mkdir(mode=0o700, parents=True)
    for victim in victims:
        shutil.copy(VICTIMS / f"{victim}.py", kinds / f"{victim}.py")
        (kinds / f"{victim}.py").chmod(0o600)
    return prepare_base(home, edits=edits, whole=whole)


@contextmanager
def temporary_home(*victims: str, edits: tuple[str, ...] = (), whole: bool = False) -> Iterator[Path]:
    """Give a prepared home with a short path, because the names of sockets are bounded."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h", *victims, edits=edits, whole=whole)


class NoMotionError(AssertionError):
    """The motors did not turn in time, or their process is another: a machine that was busy for 0.1 s has disarmed them."""


def _is_well(unit: dict[str, Any]) -> bool:
    """Return whether a capability is ready, or would be but for the emergency stop."""
    return unit["phase"] == "ready" or unit["code"] == "estop"


class Bench:
    """One robot, what is measured on it, and the means to hurt it."""

    def __init__(self, robot: Robot, results: Results, *, dice: random.Random | None = None) -> None:
        self.robot = robot
        self.results = results
        self.trace = Trace(robot.trace)
        self.dice = dice or random.Random()
        self.excused: list[tuple[int, int]] = []
        """Spans in which an output may jump, because something else bounds what it does there."""
        self._turn = 0

    def drive(self, angle_deg: float | None = None) -> Mover:
        """Bring both motors to 40 %, then let a random part of a renewal's period pass; without an angle on the spot."""
        for _ in range(ATTEMPTS - 1):
            mover = self._start(angle_deg)
            with suppress(NoMotionError):
                self.wait_for_motion(1.5)
                return mover
            mover.cease()
            self.results.repeated.append("a start of both motors: they did not come to 40 % in 1.5 s")
        mover = self._start(angle_deg)
        self.wait_for_motion()
        return mover

    def wait_for_motion(self, limit_s: float = HANG_S) -> None:
        """Wait until both motors turn at 40 %, and still do after a random phase."""

        def turns() -> bool:
            return self.trace.now().least >= ALMOST

        try:
            self.until(turns, limit_s, "motion")
            self.pass_time(self.dice.uniform(0.0, RENEW_S))
            self.until(turns, limit_s, "motion that goes on")
        except AssertionError as err:
            raise NoMotionError(*err.args) from None

    def once_it_moves(self, way: Callable[["Bench"], None]) -> None:
        """Go a way again where the robot did not begin to move, as it may not on a machine that is full; it is told."""
        for _ in range(ATTEMPTS - 1):
            with suppress(NoMotionError):
                way(self)
                return
            self.results.repeated.append(f"a start by a client: the motors did not turn in {STARTS_S:g} s")
        way(self)

    def _start(self, angle_deg: float | None) -> Mover:
        self._turn += 1
        return Mover(self.robot, ANGLES[self._turn % 2] if angle_deg is None else angle_deg).start()

    def pid(self, name: str) -> int:
        """Return the process of a capability."""
        pid = self.unit(name)["pid"]
        assert isinstance(pid, int), f"{name} does not run"
        return pid

    def unit(self, name: str) -> dict[str, Any]:
        """Return a capability's status at this moment; the stream on `@status` is up to a second old."""
        return next(unit for unit in self.units() if unit["name"] == name)

    def units(self) -> list[dict[str, Any]]:
        """Return every capability's status at this moment; asks again if no answer comes, as when links come back."""
        end = time.monotonic() + HANG_S
        while True:
            try:
                units: list[dict[str, Any]] = self.robot.line("/report/health")["data"]["capabilities"]
            except NoAnswerError:
                if time.monotonic() > end:
                    raise AssertionError(f"no answer from the console; {self.state()}") from None
                self.pass_time(RENEW_S)
            else:
                return units

    def answer(self, key: str, message: Any = None) -> dict[str, Any]:
        """Return the answer to what may be asked more than once; asks again if none comes."""
        end = time.monotonic() + HANG_S
        while (found := self.robot.ask(key, message, timeout_s=3.0)) is None:
            if time.monotonic() > end:
                raise AssertionError(f"no answer from {key}; {self.state()}")
            self.pass_time(RENEW_S)
        return dict(found)

    def release(self) -> None:
        """Reset the emergency stop once every device has acknowledged it."""
        self.until(lambda: not self.answer("@estop")["waiting"], HANG_S, "the emergency stop acknowledged")
        self.until(lambda: self.answer("@estop/reset", {})["accepted"], HANG_S, "its reset")

    def reached(self, limit_s: float = HANG_S) -> None:
        """Wait until the robot answers again, operators and its owner alike."""
        self.until(lambda: self.robot.answers(timeout_s=0.2), limit_s, "an answer", every_s=0.02)

    def all_ready(self, limit_s: float = HANG_S) -> None:
        """Wait until everything has been ready for a moment, not only on its way through."""

        def ready() -> bool:
            return all(map(_is_well, self.units()))

        for _ in range(2):
            self.until(ready, limit_s, "all ready", every_s=0.02)
            self.pass_time(0.1)

    def kill(self, pid: int, number: int = signal.SIGKILL) -> int:
        """Signal a process; return the moment before."""
        at_ns = time.monotonic_ns()
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            raise NoMotionError(f"process {pid} was gone before") from None
        return at_ns

    def stopped_after(
        self, figure: str, fault_ns: int, *, limit_s: float = STOPS_S, with_it: str = ""
    ) -> Output | None:
        """Measure from a fault to both outputs zero; `with_it` is what else was done to the robot, told if they are not."""
        zero = self.trace.first_zero(fault_ns, limit_s)
        before = self.trace.at(fault_ns)  # now that all until then is read
        if not before.least >= ALMOST:
            self.results.disturbed.append(f"{figure}: the motors were at {before.left:g} {before.right:g} before")
        elif zero is None:
            last = self.trace.at(time.monotonic_ns())
            seen = (
                f"last {last.left:g} {last.right:g} by '{last.cause}' {(last.at_ns - fault_ns) * 1e-6:.0f} ms after it"
            )
            self.results.check(figure, [f"the motors still turn {limit_s:g} s after the fault ({seen}){with_it}"])
        else:
            self.results.sample(figure, (zero.at_ns - fault_ns) * 1e-6)
        return zero

    def stays_at_rest(self, zero: Output | None, figure: str = "S14") -> None:
        """Check that nothing has turned since the motors came to rest."""
        if zero is None:
            return
        self.trace.read()
        moved = [entry for entry in self.trace.outputs(zero.at_ns + 1) if not entry.zero]
        text = [f"after the stop at {zero.at_ns} the outputs were {e.left:g} {e.right:g} at {e.at_ns}" for e in moved]
        self.results.check(figure, text[:1])

    def begins_with_zero(self, fault_ns: int, *, last_bytes_s: float = LAST_BYTES_S) -> None:
        """Check that the first motor command of the new driver's life is zero; the old one's last bytes are let pass."""
        self.trace.read()
        lines = self.trace.lines(fault_ns + int(last_bytes_s * 1e9))
        commands = [line for line in lines if line.text.startswith(("!M", "!G"))]
        if commands and commands[0].moves:
            after_ms = (commands[0].at_ns - fault_ns) * 1e-6
            text = f"the first command of a new life was {commands[0].text}, {after_ms:.0f} ms after the fault"
            self.results.check("S14", [text])

    def ready_again(self, name: str, gone: int, fault_ns: int, figure: str = "", *, limit_s: float = HANG_S) -> None:
        """Wait for another process of that name to be ready, and measure how long that took."""

        def other() -> bool:
            unit = self.unit(name)
            return _is_well(unit) and unit["pid"] not in {None, gone}

        self.until(other, limit_s, f"{name} ready again", every_s=0.015)
        if figure:
            self.results.sample(figure, (time.monotonic_ns() - fault_ns) * 1e-6)

    def forget_deaths(self, name: str) -> None:
        """Restart a capability by the console, with all that share its process, so that their earlier ends are forgotten."""
        begun = time.monotonic()
        process = self.unit(name)["process"]
        names = {unit["name"] for unit in self.units() if process and unit["process"] == process} | {name}
        for one in names:
            said = self.robot.line(f"/restart/{one}")
            assert said["code"] == 0, said

        def anew() -> bool:
            return all(
                unit["phase"] == "ready" and unit["uptime_s"] <= time.monotonic() - begun + ROUNDED_S
                for unit in self.units()
                if unit["name"] in names
            )

        self.until(anew, HANG_S, f"{name} ready again", every_s=0.015)

    def check_limits(self, max_power: float = 1.0, accel_per_s: float = ACCEL_PER_S) -> None:
        """Check everything that the outputs ever did against the configured limits."""
        self.trace.read()
        outputs = [entry for entry in self.trace.outputs() if not any(a <= entry.at_ns <= b for a, b in self.excused)]
        found = limit_violations(outputs, max_power=max_power, accel_per_s=accel_per_s)
        self.results.check("F6", found)

    def until(self, look: Callable[[], bool], limit_s: float, what: str, *, every_s: float = 0.005) -> None:
        """Look again and again until it is so."""
        end = time.monotonic() + limit_s
        while not look():
            if time.monotonic() > end:
                raise AssertionError(f"not within {limit_s:g} s: {what}; {self.state()}")
            self.pass_time(every_s)

    def state(self) -> str:
        """Say how the robot is, for a person who wonders."""
        try:
            units = self.robot.ask("@status")["capabilities"]
        except (BusError, TypeError):
            return "the robot does not answer"
        phases = ", ".join(f"{unit['name']} {unit['phase']} {unit['reason']}".strip() for unit in units)
        return f"{phases}; {self.robot.ask('drive/state')}"

    @staticmethod
    def pass_time(seconds: float) -> None:
        """Let time pass."""
        select.select([], [], [], max(0.0, seconds))


@contextmanager
def bench(
    results: Results,
    *victims: str,
    edits: tuple[str, ...] = (),
    profile: str = "lbr-sim",
    prefix: tuple[str, ...] = (),
) -> Iterator[Bench]:
    """Run a robot to be measured, or what a scenario put in its place; check its outputs' limits, let no process be left."""
    with temporary_home(*victims, edits=edits, whole=results.whole) as home:
        under_test = Bench(start(home, profile=profile, prefix=prefix), results)
        try:
            yield under_test
        finally:
            let_go(under_test.robot)
        under_test.check_limits()


def processes_of(home: Path) -> list[psutil.Process]:
    """Return the processes that run in a home, by their environment or arguments, this one excepted."""
    wanted = str(home)
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            alive = process.pid != os.getpid() and process.status() != psutil.STATUS_ZOMBIE
            if alive and (wanted in process.cmdline() or process.environ().get("LBR_HOME") == wanted):
                found.append(process)
    return found


def let_go(robot: Robot) -> None:
    """Shut a robot down if it still runs, and let no process of its home be left."""
    with suppress(Exception):  # whatever a scenario has left of it
        robot.close()
    for process in processes_of(robot.home):
        with suppress(psutil.Error):
            process.kill()
    robot.popen.wait()
    for pipe in (robot.popen.stdin, robot.popen.stdout):
        if pipe is not None:
            pipe.close()
