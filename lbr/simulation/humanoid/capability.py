"""The capability `humanoid_world`: a body on a floor, and an emulated twin for each device row that has one."""

import sys
from math import degrees
from pathlib import Path

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.joints import Joint
from lbr.messages.leases import CommandReply
from lbr.messages.simulation import HumanoidPose
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.moved import HumanoidPhysics
from lbr.simulation.humanoid.portrait import portrait
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.loop import SWITCH_S, WorldLoop
from lbr.simulation.painter import Painter, picture_path
from lbr.simulation.plugged import Plugged, tell_of_drawing
from lbr.simulation.requests import (
    BallRequest,
    FaultRequest,
    HandRequest,
    PickUpReply,
    PickUpRequest,
    PictureRequest,
    PlugRequest,
)
from lbr.simulation.twins import Surroundings


class HumanoidWorld(Capability[HumanoidWorldSettings]):
    """Serves the devices from a thread of its own, and tells the bus how the robot stands."""

    def __init__(self, ctx: Context[HumanoidWorldSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.pose_hz
        self._engine: HumanoidEngine | None = None
        self._physics: HumanoidPhysics | None = None
        self._plugged: Plugged | None = None
        self._loop: WorldLoop | None = None
        self._cameras: CameraHost | None = None
        self._painter = Painter()
        self._pose_at = 0.0
        self._was: HumanoidPose | None = None
        self._switch_s = sys.getswitchinterval()

    def open(self) -> None:
        """Put the body where it begins, plug the twins in and let time run."""
        sys.setswitchinterval(SWITCH_S)
        settings, self._pose_at, self._was = self.ctx.settings, self.ctx.clock(), None
        self._painter = Painter()
        engine = self._engine = HumanoidEngine(settings, self.ctx.rows(Joint), self.ctx.home)
        cameras = self._cameras = CameraHost(engine.packed(), len(engine.view()))
        around = Surroundings(settings.seed, self._pose_at, cameras=cameras, mounts=engine.body.cameras)
        self._plugged = Plugged(self.ctx, around)
        self._physics = HumanoidPhysics(engine, self._plugged.twins, cameras)
        self._loop = WorldLoop(self._physics, self._plugged.twins, self.ctx.clock)
        self._loop.open()
        self._plugged.tell_of_missing()

    def step(self) -> None:
        """Publish what is due; raise what ended the world's thread."""
        loop, physics, _, _ = self._running()
        if loop.failure is not None:
            raise loop.failure
        self._painter.finish()
        if self._cameras is not None:
            tell_of_drawing(self.ctx, self._cameras.serve())
        now, period_s = self.ctx.clock(), 1 / self.ctx.settings.pose_hz
        if now >= self._pose_at - period_s / 4:
            self._pose_at = max(self._pose_at + period_s, now)
            self.ctx.publish("pose", physics.pose)
            self._tell(physics.pose)

    def command(self, call: Call) -> None:
        """Answer `ball`, `fault`, `hand`, `pick_up`, `picture` and `plug`."""
        loop, physics, plugged, engine = self._running()
        if isinstance(call.message, FaultRequest):
            plugged.fault(call, call.message)
        elif isinstance(call.message, PlugRequest):
            plugged.add(call, call.message, loop.add)
        elif isinstance(call.message, PictureRequest):
            self._picture(call, call.message)
        elif isinstance(call.message, PickUpRequest):
            physics.pick_up = True
            call.reply(PickUpReply(accepted=True, reason=f"{self.ctx.robot} is {self._as_it_began()}"))
        elif isinstance(call.message, BallRequest):
            engine.balls.answer(self.ctx, call, call.message)
        elif isinstance(call.message, HandRequest):
            try:
                call.reply(CommandReply(accepted=True, reason=engine.grip.take(call.message)))
            except InputError as err:
                call.refuse(str(err), err.code)
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

    def _running(self) -> tuple[WorldLoop, HumanoidPhysics, Plugged, HumanoidEngine]:
        if self._loop is None or self._physics is None or self._plugged is None or self._engine is None:
            raise RuntimeError("the world is not open")
        return self._loop, self._physics, self._plugged, self._engine

    def _tell(self, pose: HumanoidPose) -> None:
        """Say what a bystander would."""
        was, self._was = self._was, pose
        if was is None:
            return
        robot, rests = self.ctx.robot, bool(self.ctx.settings.rests)
        if was.held and not pose.held:
            self.ctx.event("let_go", f"the helper's hand has released it: {robot} {_stance(pose)} by itself")
        if was.upright and not pose.upright:
            lean = f"rolled {degrees(pose.roll_rad):.0f} and pitched {degrees(pose.pitch_rad):.0f} degrees"
            again = "as it began" if rests else "back on its feet"
            self.ctx.event("fallen", f"{robot} has fallen, {lean}; pick_up puts it {again}", level="warning")
        elif rests and pose.upright and was.stands != pose.stands:
            self.ctx.event(_stance(pose), f"{robot} {_stance(pose)}")

    def _as_it_began(self) -> str:
        """Say what picking it up makes of it; only the world's thread knows whether a servo has torque."""
        if not self.ctx.settings.rests:
            return "in a helper's hand, on its feet"
        return "back as it began, or in a helper's hand if it has torque"

    def _picture(self, call: Call, request: PictureRequest) -> None:
        _, physics, _, engine = self._running()
        path = Path(request.path).expanduser() if request.path else picture_path(self.ctx.home, self.ctx.robot)
        pose, view, body = physics.pose, physics.view, engine.body
        size = (request.width_px, request.height_px)
        self._painter.ask(call, path, lambda: portrait(body, view, pose, size), named=bool(request.path))


def _stance(pose: HumanoidPose) -> str:
    return "stands" if pose.stands else "sits"
