"""Humanoids that are stopped at random moments of their motions, as the kernel of the joints operation moves them.

Nothing sleeps; the same seed gives the same figures. Joints sit askew, servos hear of their goals late, what they measure
jitters, and a main board takes its time to give up what it plays.
"""

import sqlite3
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from random import Random
from typing import Any

import msgspec
from msgspec.structs import replace

from lbr.leases.lease import Setpoint, Stop
from lbr.messages.joints import (
    Joint,
    JointsCommand,
    KeyFrame,
    Motion,
    MotionRow,
    MotionStep,
    StoredMotion,
    TorqueCommand,
    motions_of,
)
from lbr.messages.servos import ServoSetpoint, ServosState, ServoState, StoredState
from lbr.operations.joints.body import body
from lbr.operations.joints.kernel import decide
from lbr.operations.joints.settings import JointsSettings
from lbr.operations.joints.state import Command, ServosSeen, Tick, Torque, first_state
from lbr.robots.uxa90.twin.board import MainBoard
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.measured import ServoDrive
from tests.support import shipped
from tests.support.figures import Promise, Results

TICK_S = 0.01
ASKEW_RAD = 0.006
JITTER_RAD = 0.005
"""One step of an AX-12A."""
LATE_TICKS = (1, 4)
"""A servo begins 17 to 50 ms after it was told."""
GIVES_UP_S, PASSES_S = (0.01, 0.04), (0.06, 0.2)
"""How long a main board plays on once it is to give up, and when its servos are read and told again; assumed."""
WATCHED_S = 3.0
ROUNDS = 3
STAND, STANCE, SIT = 7, 1, 21
MOST = 48 / 50
KEPT = {"bioloid": ("walk", "walk_ahead", "walk_back", "turn_left", "stand_up"), "uxa90": (4, 3, 5, 6, 8, 9, 11, 2, 7)}
"""The walks and stand-ups, by their names or by their slots."""


@cache
def known(robot: str) -> tuple[tuple[Joint, ...], tuple[Motion, ...], HumanoidWorldSettings]:
    """Return a robot's joints, its motions, and how it is simulated, as its rows say."""
    database = sqlite3.connect(":memory:")
    database.row_factory = sqlite3.Row
    database.executescript(shipped.sql())

    def read(table: str, kind: Any) -> list[Any]:
        found = database.execute(f"SELECT * FROM {table} WHERE robot = ?", (robot,)).fetchall()
        rows = [{name: row[name] for name in row.keys() if name != "robot"} for row in found]  # noqa: SIM118
        for row in rows:
            if "positions" in row:
                row["positions"] = msgspec.json.decode(row["positions"])
        return [msgspec.convert(row, kind, strict=False) for row in rows]

    query = "SELECT settings FROM capability WHERE robot = ? AND kind = 'humanoid_world'"
    settings = msgspec.json.decode(database.execute(query, (robot,)).fetchone()[0], type=HumanoidWorldSettings)
    motions = motions_of(read("motion", MotionRow), read("motion_step", MotionStep))
    return tuple(read("joint", Joint)), motions, replace(settings, balls={}, hand_s=0.1)


class Robot:
    """A body, its servos and the kernel that moves them; `stepping`: it knows where it stands."""

    def __init__(self, robot: str, dice: Random, *, stepping: bool) -> None:
        self.rows, motions, settings = known(robot)
        self.motions = {motion.name: motion for motion in motions}
        self.slots = {motion.slot: motion for motion in motions if motion.slot is not None}
        self.stepping = stepping
        self.dice = dice
        self.engine = HumanoidEngine(settings, self.rows, "/nonexistent")
        self.now = 100.0
        self.askew = {row.device_id: dice.gauss(0.0, ASKEW_RAD) for row in self.rows}
        self.board = MainBoard() if self.slots else None
        self.state = first_state(JointsSettings(), body(self.rows))
        self.told: list[ServoSetpoint | None] = [None] * dice.randint(*LATE_TICKS)
        self.goals: dict[int, float] = {}
        self.sweep = 0
        self.stored: StoredState | None = None
        self.halt: int | None = None
        self.gives_up_at = self.passes_at = -1.0

    @property
    def on_feet(self) -> bool:
        """Say whether it is upright, and touches the floor with its feet alone."""
        pose = self.engine.pose()
        return pose.upright and set(pose.on_floor) <= {*self.engine.body.feet}

    def warm_up(self, seconds: float, drives: Mapping[int, ServoDrive] | None = None) -> None:
        """Let time pass before the kernel has the servos."""
        for _ in range(round(seconds / TICK_S)):
            self.now += TICK_S
            if self.board is not None and drives is None:
                self.engine.step(self.board.drives(self.now), TICK_S)
                self.board.feel(self.engine.felt(), self.engine.battery.voltage_v, self.now)
            else:
                self.engine.step(drives or {}, TICK_S)

    def press(self, slot: int, rest_s: float = 0.6) -> None:
        """Have the main board play something to its end."""
        assert self.board is not None
        self.board.press(slot, self.now)
        self.warm_up(self.board.programmes[slot].duration_s + rest_s)

    def begin(self) -> None:
        """Have the kernel find the servos with torque, where they are."""
        self.goals = {row.device_id: self._servo_rad(row, self.engine.pose().joints[row.name]) for row in self.rows}
        self.run(0.05)
        self.give(Torque(command=TorqueCommand(on=True), source="feet", received=self.now))
        self.run(0.1)

    def command(self, command: JointsCommand) -> str:
        """Ask for a motion; return its lease."""
        for output in self.give(
            Command(command=command, source="feet", new_lease="l" + str(self.now), new_goal="g", received=self.now)
        ):
            reply = getattr(output, "message", None)
            if getattr(reply, "accepted", None) is not None:
                assert reply.accepted, reply.reason
                return str(reply.lease)
        raise AssertionError("there was no answer")

    def play(
        self, frames: tuple[KeyFrame, ...], seconds: float, stored: StoredMotion | None = None, *, mirror: bool = False
    ) -> None:
        """Play for a while, its lease renewed."""
        if not self.stepping:
            frames = tuple(replace(frame, stable=False) for frame in frames)
            stored = None if stored is None else replace(stored, stable=False)
        lease = self.command(JointsCommand(frames=frames, stored=stored, mirror=mirror))
        self.run(seconds, lease)

    def run(self, seconds: float, lease: str = "") -> None:
        """Let time pass."""
        for tick in range(round(seconds / TICK_S)):
            self.now = round(self.now + TICK_S, 6)
            self._move()
            self.give(ServosSeen(servos=self._seen(), arrived=self.now))
            if lease and tick % 10 == 0 and self.state.leases.live is not None:
                self.command(JointsCommand(lease=lease))
            self.give(Tick())

    def stop(self) -> str:
        """Say `s`, and return what is answered."""
        said = self.give(Stop(source="console", received=self.now, whole=True))
        return next(
            str(output.message.code) for output in said if hasattr(getattr(output, "message", None), "accepted")
        )

    def lapse(self) -> str:
        """Let its lease lapse, and return what follows."""
        while self.state.leases.live is not None:
            self.run(TICK_S)
        return "to_feet" if self.state.feet is not None else ""

    def give(self, event: Any) -> tuple[Any, ...]:
        """Have an event decided."""
        self.state, outputs = decide(self.state, event, self.now)
        for output in outputs:
            if isinstance(output, Setpoint):
                self._obey(output.message)
        return outputs

    def _obey(self, setpoint: ServoSetpoint) -> None:
        """As the driver: begin what the board plays, and have it give that up when all are to hold."""
        if self.halt is not None and setpoint.halt != self.halt and self.stored is not None:
            self.gives_up_at = self.now + self.dice.uniform(*GIVES_UP_S)
            self.passes_at = self.gives_up_at + self.dice.uniform(*PASSES_S)
            self.stored = None
        self.halt = setpoint.halt
        asked = setpoint.stored
        if self.board is not None and asked is not None and self.stored is None and self.now > self.passes_at:
            self.board.press(asked.slot, self.now)
            self.stored = StoredState(slot=asked.slot, count=asked.count, phase="playing")
        self.setpoint = setpoint

    def _move(self) -> None:
        if self.board is not None and (self.stored is not None or self.now < self.gives_up_at):
            self.engine.step(self.board.drives(self.now), TICK_S)
            self.board.feel(self.engine.felt(), self.engine.battery.voltage_v, self.now)
            here = self.engine.pose().joints
            self.goals = {row.device_id: self._servo_rad(row, here[row.name]) for row in self.rows}
            self.told = [None] * len(self.told)
            return
        self.told.append(getattr(self, "setpoint", None) if self.now > self.passes_at else None)
        due = self.told.pop(0)
        for goal in due.goals if due is not None else ():
            if goal.torque > 0.0 and goal.position_rad is not None:
                self.goals[goal.id] = goal.position_rad + self.askew[goal.id]
        self.engine.step({n: ServoDrive(goal_rad=goal, torque=1.0) for n, goal in self.goals.items()}, TICK_S)

    def _servo_rad(self, row: Joint, angle: float) -> float:
        return row.zero_rad + row.sign * angle

    def _seen(self) -> ServosState:
        self.sweep += 1
        pose = self.engine.pose().joints
        servos = tuple(
            ServoState(
                id=row.device_id,
                position_rad=self._servo_rad(row, pose[row.name]) + self.dice.uniform(-0.5, 0.5) * JITTER_RAD,
                torque=1.0,
                age_s=0.0,
            )
            for row in self.rows
        )
        return ServosState(
            sweep=self.sweep,
            measured_s=self.now,
            armed=True,
            phase="following",
            servos=servos,
            stores=self.board is not None,
            stored=self.stored,
            mode="taking" if self.now < self.passes_at else "pc" if self.board is not None else "",
        )


def stopped(robot: str, what: str | int, seed: int, *, stepping: bool = True, lapse: bool = False) -> tuple[bool, str]:
    """Stop a motion at a random moment; return whether it is on its feet afterwards, and what was answered."""
    dice = Random(seed)
    one = Robot(robot, dice, stepping=stepping)
    frames, seconds, stored = _way(one, what)
    one.play(frames, dice.uniform(0.0, seconds), stored)
    code = one.lapse() if lapse else one.stop()
    one.run(WATCHED_S)
    return one.on_feet, code


def _way(one: Robot, what: str | int) -> tuple[tuple[KeyFrame, ...], float, StoredMotion | None]:
    """Bring a robot to where a motion begins; return its key frames, how long it takes, or what the board plays."""
    if isinstance(what, int):
        one.warm_up(0.2)
        if what != STAND:
            one.press(STAND)
            one.press(STANCE)
        one.begin() if what != STAND else one.run(0.1)
        motion = one.slots[what]
        pose = motion.frames[-1].positions if motion.frames else {}
        stable = bool(motion.frames) and motion.frames[-1].stable
        seconds = motion.slot_s or 0.0
        return (), seconds, StoredMotion(slot=what, duration_s=seconds, pose=pose, stable=stable)
    zero = {row.device_id: ServoDrive(goal_rad=row.zero_rad, torque=1.0) for row in one.rows}
    one.warm_up(0.5, zero)
    one.begin()
    motion = one.motions[what]
    before = one.motions[motion.lead_in].frames if motion.lead_in else one.motions["sit"].frames
    one.play(before, sum(frame.duration_s for frame in before) + 0.8)
    frames = motion.frames * (ROUNDS if motion.lead_in else 1)
    return frames, sum(frame.duration_s for frame in frames), None


def promises() -> dict[str, Promise]:
    """Return a figure for each motion."""
    found = {}
    for robot, what in pairs():
        about = f"{robot}, {_name(robot, what)}"
        found[figure(robot, what)] = Promise(
            what=f"{about}: stopped in mid-step, not on its feet", unit="%", target=4.0
        )
        found[f"{figure(robot, what)} held"] = Promise(what=f"{about}: held at once instead", unit="%")
    return found


def pairs() -> Iterator[tuple[str, str | int]]:
    """Yield every walk and stand-up of both robots."""
    yield from ((robot, what) for robot, all_of_it in KEPT.items() for what in all_of_it)


def figure(robot: str, what: str | int) -> str:
    """Return what its figure is called."""
    return f"{robot} {_name(robot, what)}"


def _name(robot: str, what: str | int) -> str:
    return next(motion.name for motion in known(robot)[1] if what in (motion.name, motion.slot))


def measure(n: int, seed: int, only: str = "", *, beside: bool = True, lapse: bool = False) -> tuple[Results, str]:
    """Stop each motion so often; `beside` has it held at once as well, at the same moments."""
    results, lines = Results(promises()), []
    for robot, what in pairs():
        if only not in figure(robot, what):
            continue
        counts, codes = [], 0
        for stepping in (True, False) if beside else (True,):
            ends = [stopped(robot, what, seed * 1000 + at, stepping=stepping, lapse=lapse) for at in range(n)]
            name = figure(robot, what) + ("" if stepping else " held")
            fallen = sum(not stands for stands, _ in ends)
            results.sample(name, 100.0 * fallen / n)
            counts.append(n - fallen)
            codes = codes or sum(code == "to_feet" for _, code in ends)
        held = f", held at once {counts[1]}" if beside else ""
        lines.append(f"{figure(robot, what)}: on its feet {counts[0]} of {n}{held}; stepped {codes} times")
        print(lines[-1], file=sys.stderr, flush=True)
    return results, "\n".join(lines)
