"""The reports of a humanoid's drivers on its simulated body, with their rates, delays and faults.

Joints are mounted askew, goals reach servos late, measurements jitter, and a main board needs time to end a motion.
"""

from collections.abc import Mapping, Sequence
from math import inf
from random import Random
from typing import Protocol

from msgspec.structs import replace

from lbr.bus import keys
from lbr.capability import twins
from lbr.capability.config import ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.stage import ROUND_S, Stage
from lbr.messages.attitude import AttitudeState
from lbr.messages.joints import Joint
from lbr.messages.servos import ServoSetpoint, ServosState, ServoState, StoredState
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.servos import servo
from lbr.simulation.measured import ServoDrive, ServoFelt
from lbr.simulation.trials.faults import Faults

ATTITUDE_S = 0.04
ASKEW_RAD, JITTER_RAD = 0.006, 0.005
LEAN_NOISE_RAD = 0.01
LATE_ROUNDS = (1, 4)
GIVES_UP_S, PASSES_S = (0.01, 0.04), (0.06, 0.2)
"""The time that a main board plays on after a request to end, and then until its servos obey again; assumed."""
PUSH_NS_PER_KG = 0.35


class Player(Protocol):
    """The player of motions that a controller stores, which moves all servos meanwhile."""

    playing: int | None

    def press(self, slot: int, now: float) -> bool:
        """Begin a motion; return whether it exists."""

    def drives(self, now: float) -> dict[int, ServoDrive]:
        """Return the motor state of each servo."""

    def feel(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Set the servos' angles in the body."""


def standing_angles(engine: HumanoidEngine) -> list[float]:
    """Return the angles of all joints in a straight stance."""
    return [0.0] * len(engine.body.positions)


class BodyInstruments:
    """Moves the body to its servos' goals, and publishes on the keys of the drivers. `pose` is the truth."""

    def __init__(
        self,
        board: Stage,
        others: Mapping[str, tuple[ProcessConfig, Kind]],
        engine: HumanoidEngine,
        rows: Sequence[Joint],
        random: Random,
        faults: Faults,
    ) -> None:
        self._board, self._engine, self._rows, self._random, self._faults = board, engine, rows, random, faults
        self._began_s = board.now
        self.pose = engine.pose()
        self._askew = {row.name: random.gauss(0.0, ASKEW_RAD) for row in rows}
        self._delayed: list[ServoSetpoint | None] = [None] * random.randint(*LATE_ROUNDS)
        self._setpoint: ServoSetpoint | None = None
        self._goals = self._angles()
        self._limp: set[int] = set()
        self._dead = random.choice([row.device_id for row in rows]) if faults.dead_s < inf else None
        self._pushed = False
        self._halt: int | None = None
        self._stored: StoredState | None = None
        self._gives_up_at = self._passes_at = -inf
        self._sweep = 0
        self._due_s = board.now
        self._main_board: Player | None = None
        self._servos: list[tuple[str, str]] = []
        self._attitudes: list[tuple[str, str]] = []
        for name, (config, kind) in sorted(others.items()):
            for output, message in kind.outputs.items():
                key = keys.port(board.robot, name, output)
                if message is ServosState and output in config.outputs:
                    self._servos.append((key, name))
                    self._main_board = _player(kind) or self._main_board
                elif message is AttitudeState and output in config.outputs:
                    self._attitudes.append((key, name))
                else:
                    continue
                board.names.add(name)
            for port, message in kind.setpoints.items():
                if message is ServoSetpoint:
                    board.listen(keys.port(board.robot, name, port), ServoSetpoint, self._take)

    def round(self) -> None:
        """Move the body for one round, and publish the states that are due."""
        now = self._board.now
        self._push(now)
        self._move(now)
        self.pose = self._engine.pose()
        self._sweep += 1
        for key, name in self._servos:
            self._board.put(key, self._state(now), name)
        if now >= self._due_s:
            self._due_s += ATTITUDE_S
            for key, name in self._attitudes:
                if now - self._began_s < self._faults.lost_s:
                    self._board.put(key, self._attitude(now), name)

    def fastest_rps(self) -> float:
        """Return the speed of the fastest joint."""
        return max((abs(felt.speed_rps) for felt in self._engine.felt().values()), default=0.0)

    def _take(self, setpoint: ServoSetpoint) -> None:
        """Act as a driver: begin the main board's motion, and end it when all servos are to hold."""
        now, asked, playing = self._board.now, setpoint.stored, self._stored
        if (
            self._halt is not None
            and setpoint.halt != self._halt
            and playing is not None
            and playing.phase == "playing"
        ):
            self._gives_up_at = now + self._random.uniform(*GIVES_UP_S)
            self._passes_at = self._gives_up_at + self._random.uniform(*PASSES_S)
            self._stored = None
        self._halt = setpoint.halt
        new = asked is not None and (self._stored is None or self._stored.count != asked.count)
        if self._main_board is not None and asked is not None and new and now > self._passes_at:
            self._main_board.press(asked.slot, now)
            self._stored = StoredState(slot=asked.slot, count=asked.count, phase="playing")
        self._setpoint = setpoint

    def _move(self, now: float) -> None:
        stored, main_board = self._stored, self._main_board
        if main_board is not None and ((stored is not None and stored.phase == "playing") or now < self._gives_up_at):
            self._engine.step(self._suffered(main_board.drives(now), now), ROUND_S)
            self._feel(main_board, now)
            self._goals = self._angles()
            self._delayed = [None] * len(self._delayed)
            if stored is not None and main_board.playing is None:
                self._passes_at = now + self._random.uniform(*PASSES_S)
                self._stored = StoredState(slot=stored.slot, count=stored.count, phase="over")
            return
        self._delayed.append(self._setpoint if now > self._passes_at else None)
        due = self._delayed.pop(0)
        if due is not None:
            goals = {goal.id: goal for goal in due.goals}
            self._limp = {n for n in self._goals if n not in goals or goals[n].torque <= 0.0}
            by_id = {row.device_id: row.name for row in self._rows}
            for n, goal in goals.items():
                if goal.position_rad is not None and n in by_id:
                    self._goals[n] = goal.position_rad + self._askew[by_id[n]]
        drives = {n: ServoDrive(goal_rad=goal, torque=1.0) for n, goal in self._goals.items() if n not in self._limp}
        self._engine.step(self._suffered(drives, now), ROUND_S)
        if main_board is not None:
            self._feel(main_board, now)

    def _feel(self, main_board: Player, now: float) -> None:
        felt = {n: one for n, one in self._engine.felt().items() if isinstance(n, int)}
        main_board.feel(felt, self._engine.battery.voltage_v, now)

    def _suffered(self, drives: Mapping[int, ServoDrive], now: float) -> dict[int | tuple[str, int], ServoDrive]:
        """Return the motors' states, with their faults."""
        buses = {row.device_id: row.bus for row in self._rows}
        dead = self._dead if now - self._began_s >= self._faults.dead_s else None
        return {
            servo(buses.get(n, ""), n): ServoDrive() if n == dead else _weaker(drive, self._faults.strength)
            for n, drive in drives.items()
        }

    def _push(self, now: float) -> None:
        if not self._pushed and now - self._began_s >= self._faults.pushed_s:
            self._pushed = True
            self._engine.push(
                self._random.uniform(-PUSH_NS_PER_KG, PUSH_NS_PER_KG), self._random.choice((-1.0, 1.0)) * PUSH_NS_PER_KG
            )

    def _angles(self) -> dict[int, float]:
        joints = self._engine.pose().joints
        return {row.device_id: row.zero_rad + row.sign * joints[row.name] for row in self._rows}

    def _state(self, now: float) -> ServosState:
        servos = tuple(
            ServoState(
                id=n,
                position_rad=angle + self._random.uniform(-0.5, 0.5) * JITTER_RAD,
                torque=0.0 if n in self._limp else 1.0,
                age_s=0.0,
            )
            for n, angle in self._angles().items()
        )
        stores = self._main_board is not None
        return ServosState(
            sweep=self._sweep,
            measured_s=now,
            armed=True,
            phase="following",
            servos=servos,
            halt=self._halt or 0,
            stores=stores,
            stored=self._stored,
            mode="" if not stores else "taking" if now < self._passes_at else "pc",
        )

    def _attitude(self, now: float) -> AttitudeState:
        pose = self.pose
        return AttitudeState(
            valid=True,
            epoch="trial",
            measured_s=now,
            roll_rad=pose.roll_rad + self._random.gauss(0.0, LEAN_NOISE_RAD),
            pitch_rad=pose.pitch_rad + self._random.gauss(0.0, LEAN_NOISE_RAD),
            heading_reason="no compass in a trial",
        )


def _player(kind: Kind) -> Player | None:
    twin = twins.find(kind.device_type) if kind.device else None
    found: Player | None = twin.load_player() if twin is not None else None
    return found


def _weaker(drive: ServoDrive, strength: float) -> ServoDrive:
    return drive if strength >= 1.0 else replace(drive, torque=drive.torque * strength)
