"""The rows' UXA-90 in the engine, moved by its emulated main board; time passes as fast as it can be computed."""

from functools import cache
from typing import Any

import msgspec

from lbr.messages.joints import Joint
from lbr.robots.uxa90.twin.board import MainBoard
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.messages import HumanoidPose
from tests.support import databases

TICK_S = 0.008


def joints() -> tuple[Joint, ...]:
    """Return its joint rows."""
    return databases.of_robot("uxa90").of(Joint)


@cache
def settings() -> HumanoidWorldSettings:
    """Return what the row of its world sets."""
    (world,) = (one for one in databases.of_robot("uxa90").capabilities if one.kind == "humanoid_world")
    return msgspec.json.decode(world.settings, type=HumanoidWorldSettings)


def humanoid(**changed: Any) -> HumanoidEngine:
    """Return an engine with its body, as it begins."""
    return HumanoidEngine(msgspec.structs.replace(settings(), **changed), joints(), "/nonexistent")


class Robot:
    """A body and its main board; `seen` are the poses since the last motion began."""

    def __init__(self) -> None:
        self.engine, self.board, self.now = humanoid(), MainBoard(), 0.0
        self.seen: list[HumanoidPose] = []
        self.run(0.2)

    def play(self, slot: int, rest_s: float = 0.6) -> HumanoidPose:
        """Press a button of the remote control and wait until its motion is over, and a little longer."""
        self.seen = []
        if not self.board.press(slot, self.now):
            raise RuntimeError(f"the main board does not play slot {slot}")
        return self.run(self.board.programmes[slot].duration_s + rest_s)

    def run(self, seconds: float) -> HumanoidPose:
        """Let time pass; return how it is then."""
        for _ in range(round(seconds / TICK_S)):
            self.now += TICK_S
            self.engine.step(self.board.drives(self.now), TICK_S)
            self.board.feel(self.engine.felt(), self.engine.battery.voltage_v, self.now)
            self.seen.append(self.engine.pose())
        return self.seen[-1]
