"""One trial of a table: a robot somewhere in its world, from the table's beginning to a little after its end."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from math import degrees, hypot
from pathlib import Path
from random import Random
from typing import Any, Literal

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import keys
from lbr.capability import registry
from lbr.capability.config import ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.stage import ROUND_S, Stage, Told
from lbr.messages.behaviour import BehaviourState, RunBehaviour
from lbr.messages.codes import Reason, ReasonCode, heard
from lbr.messages.leases import StopCommand
from lbr.messages.rows import Row
from lbr.simulation.engine import Engine, body_of
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.messages import WorldPose
from lbr.simulation.settings import StartPose, Ultrasonic, WorldSettings
from lbr.simulation.trials.faults import NONE, Faults
from lbr.simulation.trials.instruments import Instruments

AS_THEY_ARE = frozenset({"drive", "beacon", "behaviour", "battery", "odometry"})
"""Kinds that run here unchanged; instruments publish in place of the others, or nothing does."""
RUNS, WORLD, HUMANOID = "behaviour", "world", "humanoid_world"
Begins = Literal["standing", "fallen"]
BY = "trial"
WARM_S, LAST_S = 2.0, 2.0
"""All streams are present before the table begins; after its end the robot is watched for a while, and must stand."""
NOISY = Ultrasonic(noise_m=0.01, noise_per_m=0.01, dropout=0.01)
COMPASS_DEG = 20.0
WALKING_MPS = 1.4
STANDS_MPS, STANDS_RPS = 0.02, 0.05
STUCK_S, STUCK_M, STUCK_TRANSITIONS = 45.0, 0.3, 6
"""A robot that changes its state repeatedly without moving for so long is stuck. One that waits is not, even after many
changes."""
LOOK_S = 1.0


class Setup(Struct, frozen=True, kw_only=True):
    """The common part of all trials of a table: the robot's planned processes, its world, and the table's name.

    `humanoid` is a humanoid's world, which `begins` so.
    """

    robot: str
    table: str
    world: WorldSettings = WorldSettings()
    humanoid: HumanoidWorldSettings | None = None
    begins: Begins = "standing"
    units: dict[str, ProcessConfig]
    home: str
    max_s: float

    def kinds(self) -> dict[str, Kind]:
        """Return the kind of each."""
        return {name: registry.find(unit.kind, Path(self.home)) for name, unit in self.units.items()}


def rows_of(unit: ProcessConfig) -> Callable[[type[Row]], tuple[Any, ...]]:
    """Return a function for the rows of a table in a process's document."""
    return lambda row: tuple(msgspec.json.decode(unit.rows[row.TABLE].rows, type=list[row]))  # type: ignore[valid-type]


class Outcome(Struct, frozen=True, kw_only=True):
    """The end of a trial. `good`: by the table's own result, or if it was still under way at the end of its time.

    `state` and `row` are the table's last ones. For a humanoid, `began` is its start, `falls` the number of falls, and
    `stands` whether it stood at the end. `contact_mps` is the greatest speed of a contact with anything, including the
    dock. `unsafe` lists violations of safety.
    """

    number: int
    start: StartPose
    began: str = ""
    fault: str = ""
    good: bool
    code: ReasonCode
    text: str
    table: str = ""
    state: str = ""
    row: int = 0
    took_s: float = 0.0
    moved_m: float = 0.0
    contact_mps: float = 0.0
    charging: bool = False
    falls: int = 0
    stands: bool = False
    unsafe: tuple[str, ...] = ()

    @property
    def place(self) -> str:
        """Return its start, for people."""
        if self.began:
            return self.began
        return f"{self.start.x_m:.2f} {self.start.y_m:.2f} {degrees(self.start.yaw_rad):.0f} deg"


class TableTrial(ABC):
    """A robot on the stage whose table is run once; subclasses know its world."""

    _runs: str
    number: int
    start: StartPose
    fault: str

    def __init__(self, setup: Setup, board: Stage) -> None:
        self._setup = setup
        self.board = board
        self.state = BehaviourState(phase="resting")
        self.moved_m = 0.0

    def _begin(self, kinds: frozenset[str], random: Random) -> dict[str, tuple[ProcessConfig, Kind]]:
        """Start the real capabilities of these kinds, with that of the table; return the others."""
        of, others = self._setup.kinds(), {}
        for name, unit in self._setup.units.items():
            if of[name].name not in kinds:
                others[name] = (unit, of[name])
                continue
            capability: Any = self.board.add(unit, of[name], random.uniform(0.0, 0.02))
            if of[name].name == RUNS:
                self._runs = name
                capability.dice.seed(random.randrange(1 << 30))
        self.board.listen(keys.port(self._setup.robot, self._runs, "state"), BehaviourState, self._follow)
        return others

    @property
    def events(self) -> list[Told]:
        """Return the events so far."""
        return self.board.told

    def run(self) -> Outcome:
        """Run the table to its end, or for as long as a trial may last."""
        self.warm_up()
        asked = self.board.command(self._runs, "run", RunBehaviour(name=self._setup.table), BY)
        while (answers := asked.answers()) is None:
            self.round()
        reply = answers[self._runs]
        if not reply.accepted:
            return self._outcome(self.state, 0.0, good=False, why=reply.why)
        began_s = self.board.now
        while self._phase() != "running":
            self.round()
        why: Reason | None = None
        good = False
        while self._phase() == "running" and why is None:
            self.round()
            if self._stuck():
                why = Reason("stuck", f"it stays where it is for {STUCK_S:g} s")
            elif self.board.now - began_s >= self._setup.max_s:
                why, good = Reason("time_over", f"it goes on after {self._setup.max_s:g} s"), True
        at, took_s = self.state, self.board.now - began_s
        if why is not None:
            self.board.command(self._runs, "stop", StopCommand(reason="the trial is over"), BY)
        self.rounds(LAST_S)
        if why is not None:
            return self._outcome(at, took_s, good=good, why=why)
        return self._outcome(at, took_s, good=bool(at.good), why=heard(at.code, at.reason))

    def warm_up(self) -> None:
        """Let time pass until all streams are present."""
        self.rounds(WARM_S)

    def _phase(self) -> str:
        return self.state.phase

    def rounds(self, seconds: float) -> None:
        """Let time pass."""
        until = self.board.now + seconds
        while self.board.now < until:
            self.round()

    @abstractmethod
    def round(self) -> None:
        """Let one round pass, and watch the robot."""

    def _follow(self, state: BehaviourState) -> None:
        self.state = state

    def _stuck(self) -> bool:
        return False

    def _outcome(self, at: BehaviourState, took_s: float, *, good: bool, why: Reason) -> Outcome:
        """Return the end of the trial."""
        return Outcome(
            number=self.number,
            start=self.start,
            fault=self.fault,
            good=good,
            code=why.code,
            text=why.text,
            table=at.table or self._setup.table,
            state=at.state,
            row=at.row,
            took_s=round(took_s, 2),
            moved_m=round(self.moved_m, 2),
            **self._seen(),
        )

    @abstractmethod
    def _seen(self) -> dict[str, Any]:
        """Return further fields of the outcome, for this world."""


class Trial(TableTrial):
    """A robot at a place with a fault, by random numbers that are the same for a seed and a number."""

    def __init__(
        self, setup: Setup, number: int, start: StartPose, *, seed: int = 1, fault: str = "", faults: Faults = NONE
    ):
        self.number, self.start, self.fault = number, start, fault
        random = Random(f"{seed}/{number}/{fault}")
        super().__init__(setup, Stage(setup.robot))
        world = faults.world(replace(setup.world, start=start, seed=random.randrange(1 << 30)))
        if world.ultrasonic == Ultrasonic():
            world = replace(world, ultrasonic=NOISY)
        sensors, wheels, rollers = body_of(world, rows_of(setup.units[WORLD]))
        self.engine = Engine(world, sensors, wheels, rollers=rollers)
        others = self._begin(AS_THEY_ARE, random)
        error_deg = random.uniform(-COMPASS_DEG, COMPASS_DEG) if number else 0.0
        self.instruments = Instruments(self.board, others, self.engine, random, faults, error_deg)
        self.contact_mps = 0.0
        self._against = False
        self._speed_mps = 0.0
        self._been: deque[tuple[float, float, int]] = deque(maxlen=round(STUCK_S / LOOK_S))
        self._look_at_s = 0.0

    def round(self) -> None:
        """Let one round pass, and watch the robot."""
        self.board.round()
        self.instruments.round()
        pose = self.instruments.pose
        against = pose.touching or pose.charging
        if against and not self._against:
            self.contact_mps = max(self.contact_mps, abs(self._speed_mps))
        self._against, self._speed_mps = against, pose.speed_mps
        self.moved_m += abs(pose.speed_mps) * ROUND_S
        if self.board.now >= self._look_at_s:
            self._look_at_s = self.board.now + LOOK_S
            self._been.append((pose.x_m, pose.y_m, self.state.transitions))

    def _stuck(self) -> bool:
        if len(self._been) < (self._been.maxlen or 0):
            return False
        x, y, first = self._been[0]
        of_late, last = self._been[-len(self._been) // 3][2], self._been[-1][2]
        decides = last - first >= STUCK_TRANSITIONS and last - of_late >= STUCK_TRANSITIONS // 3
        return decides and all(hypot(one[0] - x, one[1] - y) < STUCK_M for one in self._been)

    def _seen(self) -> dict[str, Any]:
        pose = self.instruments.pose
        return {
            "contact_mps": round(self.contact_mps, 3),
            "charging": pose.charging,
            "unsafe": tuple(_unsafe(pose, self.contact_mps)),
        }


def _unsafe(pose: WorldPose, contact_mps: float) -> list[str]:
    """Return the violations of safety at the end of a trial."""
    wrong = [] if abs(pose.speed_mps) < STANDS_MPS and abs(pose.turn_rps) < STANDS_RPS else ["it moves on"]
    if contact_mps > WALKING_MPS:
        wrong.append(f"it came against something at {contact_mps:.1f} m/s")
    return wrong
