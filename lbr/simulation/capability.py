"""The capability `world`: a room, a robot in it, and an emulated twin for each device row that has one."""

import sys
from collections import deque
from pathlib import Path

import msgspec

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.sensing import Ranges, RangeStatus, ranges
from lbr.messages.simulation import WorldBox, WorldPose, WorldScene
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.engine import Engine, body_of
from lbr.simulation.loop import SWITCH_S, WorldLoop
from lbr.simulation.painter import Painter, picture_path
from lbr.simulation.plugged import Plugged, tell_of_drawing
from lbr.simulation.requests import (
    BallRequest,
    FaultRequest,
    PictureRequest,
    PlaceRequest,
    PlugRequest,
    RemoveRequest,
    ThingsReply,
)
from lbr.simulation.settings import WorldSettings
from lbr.simulation.topdown import image
from lbr.simulation.trace import OutputTrace
from lbr.simulation.twins import Surroundings
from lbr.simulation.wheeled import WheeledPhysics

_TRAIL_EVERY_M = 0.03
SAME_POSE_S = 0.5
"""How often a robot that stands still is told of."""


class World(Capability[WorldSettings]):
    """Serves the devices from a thread of its own, and tells the bus where the robot is."""

    def __init__(self, ctx: Context[WorldSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.pose_hz
        self._engine: Engine | None = None
        self._loop: WorldLoop | None = None
        self._trace: OutputTrace | None = None
        self._cameras: CameraHost | None = None
        self._physics: WheeledPhysics | None = None
        self._plugged: Plugged | None = None
        self._painter = Painter()
        self._scene: WorldScene | None = None
        self._scene_at = self._pose_at = self._posed_at = 0.0
        self._still: WorldPose | None = None
        self._trail: deque[tuple[float, float]] = deque(maxlen=5000)
        self._switch_s = sys.getswitchinterval()

    def open(self) -> None:
        """Build the world, plug the twins in and let time run."""
        sys.setswitchinterval(SWITCH_S)
        now = self.ctx.clock()
        self._painter = Painter()
        sensors, wheels, rollers = body_of(self.ctx.settings, self.ctx.rows)
        engine = self._engine = Engine(self.ctx.settings, sensors, wheels, rollers=rollers)
        self._trace = OutputTrace(self.ctx.settings.trace)
        cameras = self._cameras = CameraHost(engine.packed(), len(engine.view()))
        mounts = tuple(self.ctx.settings.cameras)
        around = Surroundings(self.ctx.settings.seed, now, self._trace, cameras, mounts, sensors)
        plugged = self._plugged = Plugged(self.ctx, around)
        self._scene = engine.scene()
        self._scene_at = self._pose_at = now
        physics = self._physics = WheeledPhysics(engine, plugged.twins, cameras)
        self._loop = WorldLoop(physics, plugged.twins, self.ctx.clock)
        self._loop.open()
        plugged.tell_of_missing()

    def step(self) -> None:
        """Publish what is due; raise what ended the world's thread."""
        loop, physics, _, scene = self._running()
        if loop.failure is not None:
            raise loop.failure
        self._painter.finish()
        if self._cameras is not None:
            tell_of_drawing(self.ctx, self._cameras.serve())
        now, period_s = self.ctx.clock(), 1 / self.ctx.settings.pose_hz
        if now >= self._pose_at - period_s / 4:
            self._pose_at = max(self._pose_at + period_s, now)
            pose = physics.pose
            still = msgspec.structs.replace(pose, battery_v=0.0)  # which always sinks a little
            if still != self._still or now - self._posed_at >= SAME_POSE_S:
                self._still, self._posed_at = still, now
                self.ctx.publish("pose", pose)
                self._remember((pose.x_m, pose.y_m))
        if now >= self._scene_at:
            self._scene_at = now + self.ctx.settings.scene_every_s
            self.ctx.publish("scene", scene)

    def command(self, call: Call) -> None:
        """Answer `ball`, `fault`, `plug`, `place`, `remove` and `picture`."""
        if isinstance(call.message, FaultRequest) and self._plugged is not None:
            self._plugged.fault(call, call.message)
        elif isinstance(call.message, PlugRequest) and self._plugged is not None and self._loop is not None:
            self._plugged.add(call, call.message, self._loop.add)
        elif isinstance(call.message, PlaceRequest | RemoveRequest):
            self._change(call, call.message)
        elif isinstance(call.message, BallRequest):
            self._put(call, call.message)
        elif isinstance(call.message, PictureRequest):
            self._picture(call, call.message)
        else:
            super().command(call)

    def close(self) -> None:
        """Stop time, pull the twins out and end the trace."""
        self._painter.close()
        if self._loop is not None:
            self._loop.close()
            self._loop = None
        if self._cameras is not None:
            self._cameras.close()
            self._cameras = None
        if self._trace is not None:
            self._trace.close(self.ctx.clock())
            self._trace = None
        sys.setswitchinterval(self._switch_s)

    def _running(self) -> tuple[WorldLoop, WheeledPhysics, Engine, WorldScene]:
        if self._engine is None or self._loop is None or self._physics is None or self._scene is None:
            raise RuntimeError("the world is not open")
        return self._loop, self._physics, self._engine, self._scene

    def _remember(self, place: tuple[float, float]) -> None:
        if not self._trail or sum(abs(a - b) for a, b in zip(place, self._trail[-1], strict=True)) > _TRAIL_EVERY_M:
            self._trail.append(place)

    def _change(self, call: Call, request: PlaceRequest | RemoveRequest) -> None:
        _, _, engine, _ = self._running()
        try:
            if isinstance(request, PlaceRequest):
                engine.place(WorldBox(**msgspec.structs.asdict(request)))
            else:
                engine.remove(request.name)
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        self._scene, self._scene_at = engine.scene(), self.ctx.clock()
        said = f"'{request.name}' {'stands in the world' if isinstance(request, PlaceRequest) else 'has vanished'}"
        self.ctx.event("world_changed", said, code="done", about=call.source)
        known = {wall.name for wall in self.ctx.settings.walls}
        things = tuple(wall.name for wall in self._scene.walls if wall.solid and wall.name not in known)
        call.reply(ThingsReply(accepted=True, reason=said, things=things))

    def _put(self, call: Call, request: BallRequest) -> None:
        _, _, engine, _ = self._running()
        engine.balls.answer(self.ctx, call, request)
        self._scene, self._scene_at = engine.scene(), self.ctx.clock()

    def _picture(self, call: Call, request: PictureRequest) -> None:
        _, physics, _, scene = self._running()
        try:
            path = Path(request.path).expanduser() if request.path else picture_path(self.ctx.home, self.ctx.robot)
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        pose, around, trail = physics.pose, _as_ranges(physics.ranges_m), tuple(self._trail)
        size = {"width": request.width_px, "height": request.height_px}
        self._painter.ask(call, path, lambda: image(scene, pose, around, trail=trail, **size), named=bool(request.path))


def _as_ranges(ranges_m: dict[str, float | None]) -> Ranges:
    status: dict[str, RangeStatus] = {
        name: "over_range" if range_m is None else "ok" for name, range_m in ranges_m.items()
    }
    return ranges(ranges_m, {"bottom": "missing", **status})
