"""One trial of a humanoid's table: its body stands or has fallen, and the joints, motions and tables are its own."""

from math import hypot, pi
from random import Random
from typing import Any

from lbr.capability.stage import Stage
from lbr.messages.joints import Joint, TorqueCommand
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.settings import StartPose
from lbr.simulation.trials.body import BodyInstruments, standing_angles
from lbr.simulation.trials.faults import NONE, Faults
from lbr.simulation.trials.trial import BY, WORLD, Setup, TableTrial, rows_of

AS_THEY_ARE = frozenset({"joints", "motions", "behaviour"})
"""Kinds that run here unchanged; instruments publish in place of the others, or nothing does."""
LEANS: dict[str, tuple[float, float]] = {
    "face": (0.0, 1.1),
    "back": (0.0, -1.1),
    "right side": (1.1, 0.0),
    "left side": (-1.1, 0.0),
}
"""Roll and pitch from which it falls, by the side on which it then lies; too far to recover."""
LEAN_RAD, POSE_RAD, DROP_M = 0.1, 0.05, 0.01
MOVES_RPS = 0.3
"""A joint that is faster than this, some seconds after the end, is being moved."""


class HumanoidTrial(TableTrial):
    """A humanoid in its world with a fault, by random numbers that are the same for a seed and a number."""

    def __init__(self, setup: Setup, number: int, *, seed: int = 1, fault: str = "", faults: Faults = NONE) -> None:
        self.number, self.fault, self.start = number, fault, StartPose()
        random = Random(f"{seed}/{number}/{fault}")
        super().__init__(setup, Stage(setup.robot))
        world = setup.humanoid or HumanoidWorldSettings(model=setup.robot)
        rows = rows_of(setup.units[WORLD])(Joint)
        self.engine = HumanoidEngine(world, rows, setup.home)
        self.began = _placed(self.engine, setup.begins, number, random)
        others = self._begin(AS_THEY_ARE, random)
        self._joints = next(name for name, member in self.board.members.items() if member.ctx.kind.name == "joints")
        self.instruments = BodyInstruments(self.board, others, self.engine, rows, random, faults)
        self.falls = 0
        self._upright = self.engine.pose().upright

    def warm_up(self) -> None:
        """Let it fall if that is its start, and switch its torque on, as a person does before a table."""
        super().warm_up()
        asked = self.board.command(self._joints, "torque", TorqueCommand(on=True), BY)
        while asked.answers() is None:
            self.round()

    def round(self) -> None:
        """Let one round pass, and watch the robot."""
        self.board.round()
        before = self.instruments.pose
        self.instruments.round()
        pose = self.instruments.pose
        self.moved_m += hypot(pose.x_m - before.x_m, pose.y_m - before.y_m)
        if self._upright and not pose.upright:
            self.falls += 1
        self._upright = pose.upright

    def _seen(self) -> dict[str, Any]:
        fastest = self.instruments.fastest_rps()
        return {
            "began": self.began,
            "falls": self.falls,
            "stands": self.instruments.pose.stands,
            "unsafe": (f"a joint moves on at {fastest:.1f} rad/s",) if fastest > MOVES_RPS else (),
        }


def _placed(engine: HumanoidEngine, begins: str, number: int, random: Random) -> str:
    """Put the body at its start; return that in words."""
    askew = POSE_RAD if number and begins == "fallen" else 0.0
    angles = [angle + random.gauss(0.0, askew) for angle in standing_angles(engine)]
    engine.put(angles)
    if begins == "standing":
        engine.turn(0.0, 0.0, random.uniform(-pi, pi) if number else 0.0, 0.0)
        return "standing"
    side = random.choice(list(LEANS)) if number else "face"
    roll, pitch = LEANS[side]
    lean = random.gauss(0.0, LEAN_RAD) if number else 0.0
    engine.turn(roll + (lean if roll else 0.0), pitch + (lean if pitch else 0.0), random.uniform(-pi, pi), DROP_M)
    return f"lying on its {side}"
