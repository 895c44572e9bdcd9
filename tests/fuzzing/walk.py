"""Z7: walks over everything that a robot can be asked, by chance, with what must hold after every step."""

import os
import random
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from lbr.errors import BusError
from lbr.testing.robot import NoAnswerError
from tests.fuzzing.mutation import SPLINTERS, mutated
from tests.support.bench import Bench, bench
from tests.support.figures import Results
from tests.support.mover import Mover
from tests.support.robot import Robot
from tests.support.trace import limit_violations

STEPS = 30
LATE_NS = 300_000_000
LEASE_NS = 600_000_000
REST_S = 6.0
POWER = 0.4
KILLED = ("motors", "drive", "ranges", "world")
ROWS = (
    "UPDATE verb SET help = help || '.' WHERE word = 'f'",
    "UPDATE capability SET settings = json_set(settings, '$.max_power', 0.5) WHERE name = 'drive'",
    "UPDATE capability SET settings = json_set(settings, '$.max_power', 1.0) WHERE name = 'drive'",
    "UPDATE capability SET settings = json_set(settings, '$.max_power', 7) WHERE name = 'drive'",
    "UPDATE capability SET kind = 'os' WHERE name = 'ranges'",
    "UPDATE capability SET settings = '{\"device\": \"range_board\"}', kind = 'ultrasonic_ring' WHERE name = 'ranges'",
)
"""Some good, some bad; a bad one is put right at the walk's end."""


def walks(results: Results, n: int, dice: random.Random) -> None:
    """Walk `n` times; each begins with a robot that is ready and at rest."""
    with bench(results) as under_test:
        for number in range(n):
            _rest(under_test)
            under_test.trace.read()  # the end of the walk before is not the beginning of this one
            under_test.trace.entries.clear()
            walk = Walk(under_test, random.Random(dice.getrandbits(32)))
            for _ in range(STEPS):
                walk.step()
                wrong = walk.wrong()
                results.check("Z7", [f"walk {number}: {text}; after {', '.join(walk.said)}" for text in wrong])
                if wrong:
                    break
            walk.end()
        results.check("Z7", _told_traceback(under_test))


class Walk:
    """What was done, and until when outputs may turn because of it."""

    def __init__(self, under_test: Bench, dice: random.Random) -> None:
        self.said: list[str] = []
        self._bench = under_test
        self._robot = under_test.robot
        self._dice = dice
        self._mover: Mover | None = None
        self._may_turn: list[list[int]] = []
        self._latched_ns = 0
        self._checked_ns = time.monotonic_ns()
        self._ways: tuple[tuple[int, Callable[[], None]], ...] = (
            (6, self._drive), (3, self._drive_once), (4, self._line), (3, self._stop), (3, self._nonsense), (2, self._estop),
            (3, self._reset), (1, self._kill), (2, self._row), (1, self._restart), (1, self._freeze), (2, self._forge), (3, self._look),
        )  # fmt: skip

    def step(self) -> None:
        """Do one thing, and let a little time pass."""
        shares, ways = zip(*self._ways, strict=True)
        way = self._dice.choices(ways, shares)[0]
        self.said.append(way.__name__.strip("_"))
        with suppress(BusError, StopIteration, NoAnswerError):  # what it asked may be what was just killed
            way()
        self._bench.pass_time(self._dice.choice((0.0, 0.02, 0.1)))

    def wrong(self) -> list[str]:
        """Return what an output did that nothing explains, since the last look."""
        trace = self._bench.trace
        trace.read()
        new = [entry for entry in trace.outputs(self._checked_ns) if not entry.zero]
        self._checked_ns = time.monotonic_ns()
        found = [f"outputs {e.left:g} {e.right:g}, and nobody drove" for e in new if not self._explained(e.at_ns)]
        if self._latched_ns:
            late = [e for e in new if e.at_ns > self._latched_ns + LATE_NS]
            found += [f"outputs {e.left:g} {e.right:g} under the emergency stop" for e in late]
        return found[:3] or limit_violations(trace.outputs(), max_power=POWER, accel_per_s=2.0)[:3]

    def end(self) -> None:
        """Let go of the robot."""
        self._cease()

    def _explained(self, at_ns: int) -> bool:
        return any(since <= at_ns <= until for since, until in self._may_turn)

    def _begin(self, until_ns: int) -> None:
        self._may_turn.append([time.monotonic_ns(), until_ns])

    def _cease(self) -> None:
        mover, self._mover = self._mover, None
        if mover is not None:
            mover.cease()
        self._lapse(LEASE_NS)

    def _lapse(self, after_ns: int) -> None:
        """Nothing that began before now may turn later than this."""
        now_ns = time.monotonic_ns()
        for span in self._may_turn:
            span[1] = min(span[1], now_ns + after_ns)

    def _drive(self) -> None:
        self._cease()
        self._begin(2**63)
        mover = Mover(self._robot, self._dice.choice((90.0, 270.0, 0.0, 180.0)), power=POWER, source="walk")
        with suppress(AssertionError):
            self._mover = mover.start(0.05)
        if self._mover is None:
            self._lapse(LEASE_NS)

    def _drive_once(self) -> None:
        self._begin(time.monotonic_ns() + 2 * LEASE_NS)
        self._robot.put("drive/command", {"power": 0.3, "angle_deg": 90}, source=self._dice.choice(("walk", "other")))

    def _line(self) -> None:
        line = self._dice.choice(("/r/0.3/90", "f", "/r/0.2/270/0/forward/1", "/r/0/0", "status", "disable", "enable"))
        self._begin(time.monotonic_ns() + 2 * LEASE_NS)
        self.said.append(line)
        self._robot.line(line)

    def _stop(self) -> None:
        self._robot.line(self._dice.choice(("s", "stop", "S")))
        if self._mover is None:
            self._lapse(LATE_NS)

    def _nonsense(self) -> None:
        self._robot.put("drive/command", {"power": self._dice.choice((7, -1, "x", None, 1e999))})
        raw = mutated(self._dice, b"/r/nan/0", SPLINTERS).replace(b"\n", b"")
        next(iter(self._robot.bus.get(f"{self._robot.name}/@console", payload=raw, timeout=2.0)))

    def _estop(self) -> None:
        if self._dice.random() < 0.5:
            self._robot.put("@estop", {"engaged": True, "reason": "walk"})
        else:
            self._robot.line("estop")
        self._latched_ns = self._latched_ns or time.monotonic_ns()
        self._lapse(LATE_NS)
        self._cease()

    def _reset(self) -> None:
        self._bench.trace.read()
        said = self._robot.ask("@estop/reset", source="walk")
        if said and said["accepted"]:
            self._latched_ns = 0

    def _kill(self) -> None:
        name = self._dice.choice(KILLED)
        self.said.append(name)
        pid = self._bench.unit(name)["pid"]
        if pid is not None:
            with suppress(ProcessLookupError):
                os.kill(pid, self._dice.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGSEGV)))

    def _freeze(self) -> None:
        """Hold a process up, the executive with all its routers too; afterwards everybody must answer again."""
        name = self._dice.choice(("executive", *KILLED))
        self.said.append(name)
        pid = self._robot.ready["pid"] if name == "executive" else self._bench.unit(name)["pid"]
        if pid is not None:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGSTOP)
                self._bench.pass_time(self._dice.uniform(0.1, 0.7))
                os.kill(pid, signal.SIGCONT)

    def _row(self) -> None:
        row = self._dice.choice(ROWS)
        self.said.append(row)
        self._robot.edit(row)

    def _restart(self) -> None:
        name = self._dice.choice(KILLED)
        self.said.append(name)
        self._robot.line(f"/restart/{name}")

    def _forge(self) -> None:
        self._robot.put("motors/setpoint", {"left": 0.9, "right": 0.9, "lease": "walk"}, source="drive")
        self._robot.put("motors/state", {"left": 0.0, "right": 0.0, "armed": True, "reason": "", "estop": False})

    def _look(self) -> None:
        status: dict[str, Any] | None = self._robot.ask("@status")
        assert status is None or status["robot"] == self._robot.name
        self._robot.line(self._dice.choice(("/report/telemetry", "/report/events", "help", "status")))


def _rest(under_test: Bench) -> None:
    """Put everything right: rows, latch, enabling, processes that were given up."""
    robot = under_test.robot
    under_test.reached(REST_S)
    for row in (ROWS[2], ROWS[5]):
        robot.edit(row)
    for name in KILLED:
        if under_test.unit(name)["phase"] == "failed":
            robot.line(f"/restart/{name}")
    under_test.until(lambda: robot.line("s")["code"] == 0, REST_S, "a stop", every_s=0.1)
    under_test.until(lambda: robot.line("reset")["code"] == 0, REST_S, "reset", every_s=0.1)
    under_test.until(lambda: robot.line("enable")["code"] == 0, REST_S, "enable", every_s=0.1)
    under_test.all_ready(REST_S)
    under_test.until(lambda: _stands(robot), REST_S, "rest")


def _stands(robot: Robot) -> bool:
    """Ask the world itself: one that was killed while the wheels turned has written down no end of it."""
    pose = robot.ask("world/pose")
    return pose is not None and pose["left"] == 0.0 and pose["right"] == 0.0


def _told_traceback(under_test: Bench) -> list[str]:
    said = (under_test.robot.home / "stderr.txt").read_text(errors="replace")
    return [f"the executive told a traceback: {said[-500:]}"] if "Traceback" in said else []
