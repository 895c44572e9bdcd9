"""The common part of all robots' worlds: time in a thread of its own, a twin for each device, faults and pictures."""

import sys
from collections.abc import Callable
from typing import Any, TypeVar

from msgspec.structs import replace

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.loop import SWITCH_S, Physics, WorldLoop
from lbr.simulation.messages import HumanoidPose, WorldPose
from lbr.simulation.painter import Painter
from lbr.simulation.plugged import Plugged, report_drawing
from lbr.simulation.requests import FaultRequest, PlugRequest
from lbr.simulation.settings import WorldSettings
from lbr.simulation.stepped import SteppedEngine
from lbr.simulation.twins import Surroundings, Twin

S = TypeVar("S", bound=WorldSettings | HumanoidWorldSettings)
P = TypeVar("P", bound=Physics[Any])

SAME_POSE_S = 0.5
"""The interval of reports for a robot that does not move."""


class SimulatedWorld(Capability[S]):
    """Serves the devices from a thread of its own; `tell_pose` is called at the rate of the row."""

    def __init__(self, ctx: Context[S]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.pose_hz
        self._loop: WorldLoop | None = None
        self._plugged: Plugged | None = None
        self._cameras: CameraHost | None = None
        self._painter = Painter(ctx)
        self._pose_at = self._posed_at = 0.0
        self._still: WorldPose | HumanoidPose | None = None
        self._switch_s = sys.getswitchinterval()

    def begin(self, engine: SteppedEngine, physics: Callable[[tuple[Twin, ...], CameraHost], P], **around: Any) -> P:
        """Plug the twins in and start time; `around` are further arguments for the twins."""
        sys.setswitchinterval(SWITCH_S)
        self._pose_at, self._still = self.ctx.clock(), None
        self._painter = Painter(self.ctx)
        cameras = self._cameras = CameraHost(engine.packed(), len(engine.view()))
        plugged = self._plugged = Plugged(
            self.ctx, Surroundings(self.ctx.settings.seed, self._pose_at, cameras=cameras, **around)
        )
        made = physics(plugged.twins, cameras)
        self._loop = WorldLoop(made, plugged.twins, self.ctx.clock)
        self._loop.open()
        plugged.report_missing()
        return made

    def step(self) -> None:
        """Publish what is due; raise the error that ended the world's thread."""
        loop, _ = self._begun()
        if loop.failure is not None:
            raise loop.failure
        self._painter.finish()
        if self._cameras is not None:
            report_drawing(self.ctx, self._cameras.serve())
        now, period_s = self.ctx.clock(), 1 / self.ctx.settings.pose_hz
        if now >= self._pose_at - period_s / 4:
            self._pose_at = max(self._pose_at + period_s, now)
            self.tell_pose(now)

    def tell_pose(self, now: float) -> None:
        """Publish where the robot is."""

    def publish_pose(self, pose: WorldPose | HumanoidPose, now: float, **restless: float) -> None:
        """Publish a pose, less often while nothing moves but these fields, which never stand still."""
        still = replace(pose, **restless)
        if still != self._still or now - self._posed_at >= SAME_POSE_S:
            self._still, self._posed_at = still, now
            self.ctx.publish("pose", pose)

    def command(self, call: Call) -> None:
        """Answer `fault` and `plug`."""
        loop, plugged = self._begun()
        if isinstance(call.message, FaultRequest):
            plugged.fault(call, call.message)
        elif isinstance(call.message, PlugRequest):
            plugged.add(call, call.message, loop.add)
        else:
            super().command(call)

    def close(self) -> None:
        """Stop time and pull the twins out."""
        self._painter.close()
        if self._loop is not None:
            self._loop.close()
            self._loop = None
        if self._cameras is not None:
            self._cameras.close()
            self._cameras = None
        sys.setswitchinterval(self._switch_s)

    def _begun(self) -> tuple[WorldLoop, Plugged]:
        if self._loop is None or self._plugged is None:
            raise RuntimeError("the world is not open")
        return self._loop, self._plugged
