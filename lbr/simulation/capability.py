"""The capability `world`: a room, a robot in it, and an emulated twin for each device row of a known type."""

from collections import deque
from collections.abc import Sequence
from functools import partial

import msgspec

from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.kinematics import TWO
from lbr.messages.sensing import Ranges, RangeStatus, ranges
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.engine import Engine, body_of
from lbr.simulation.loop import Physics
from lbr.simulation.measured import Sensed
from lbr.simulation.messages import WorldBox, WorldScene
from lbr.simulation.requests import BallRequest, PictureRequest, PlaceRequest, RemoveRequest, ThingsReply
from lbr.simulation.settings import WorldSettings
from lbr.simulation.topdown import image
from lbr.simulation.trace import OutputTrace
from lbr.simulation.twins import MotorDrive, Twin, WheelDrive
from lbr.simulation.world import SimulatedWorld


class WheeledPhysics(Physics[Engine]):
    """The physics with its twins. `pose` and `ranges_m` are the newest."""

    def __init__(self, engine: Engine, twins: Sequence[Twin], cameras: CameraHost) -> None:
        super().__init__(engine, cameras)
        self.pose, self.ranges_m = engine.pose(), engine.ranges_m
        self._pairs = [twin for twin in twins if isinstance(twin, WheelDrive)]
        self._motors = [twin for twin in twins if isinstance(twin, MotorDrive) and not isinstance(twin, WheelDrive)]

    def advance(self, now: float, dt_s: float) -> None:
        """Run for `dt_s` with the power of the motor controllers."""
        self._engine.drive(self._powers(now), dt_s)

    def resting(self, now: float) -> bool:
        """Return whether nothing moves or is about to."""
        return self._engine.resting and self.at_rest(now)

    def look(self, now: float) -> Sensed:
        """Look around, also through the cameras."""
        sensed = self._engine.sensed()
        self.pose, self.ranges_m = self._engine.pose(), sensed.ranges_m
        if self._cameras.running:
            self._cameras.show(self._engine.view(), now)
        return sensed

    def moved_by(self, twin: Twin) -> bool:
        """Return whether a twin turns wheels."""
        return isinstance(twin, WheelDrive | MotorDrive)

    def at_rest(self, now: float) -> bool:
        """Return whether no wheel has power."""
        return not any(self._powers(now).values())

    def _powers(self, now: float) -> dict[str, float]:
        """Return the power of each motor."""
        powers: dict[str, float] = {}
        for pair in self._pairs:
            powers |= dict(zip(TWO, pair.wheels(now), strict=True))
        for twin in self._motors:
            powers |= twin.motors(now)
        return powers


_TRAIL_EVERY_M = 0.03


class World(SimulatedWorld[WorldSettings]):
    """A room with a robot on wheels; publishes the robot's pose."""

    def __init__(self, ctx: Context[WorldSettings]) -> None:
        super().__init__(ctx)
        self._engine: Engine | None = None
        self._trace: OutputTrace | None = None
        self._physics: WheeledPhysics | None = None
        self._scene: WorldScene | None = None
        self._scene_at = 0.0
        self._trail: deque[tuple[float, float]] = deque(maxlen=5000)

    def open(self) -> None:
        """Build the world, plug the twins in and start time."""
        settings = self.ctx.settings
        sensors, wheels, rollers = body_of(settings, self.ctx.rows)
        engine = self._engine = Engine(settings, sensors, wheels, rollers=rollers)
        self._trace = OutputTrace(settings.trace)
        self._scene, self._scene_at = engine.scene(), self.ctx.clock()
        self._physics = self.begin(
            engine, partial(WheeledPhysics, engine), trace=self._trace, mounts=tuple(settings.cameras), sensors=sensors
        )

    def step(self) -> None:
        """Publish what is due; raise the error that ended the world's thread."""
        super().step()
        _, _, scene = self._running()
        if (now := self.ctx.clock()) >= self._scene_at:
            self._scene_at = now + self.ctx.settings.scene_every_s
            self.ctx.publish("scene", scene)

    def tell_pose(self, now: float) -> None:
        """Publish the pose of the robot, and remember its trail."""
        pose = self._running()[0].pose
        self.publish_pose(pose, now, battery_v=0.0, time_s=0.0)
        self._remember((pose.x_m, pose.y_m))

    def command(self, call: Call) -> None:
        """Answer `ball`, `fault`, `plug`, `place`, `remove` and `picture`."""
        if isinstance(call.message, PlaceRequest | RemoveRequest):
            self._change(call, call.message)
        elif isinstance(call.message, BallRequest):
            self._put(call, call.message)
        elif isinstance(call.message, PictureRequest):
            self._picture(call, call.message)
        else:
            super().command(call)

    def close(self) -> None:
        """Stop time, pull the twins out and end the trace."""
        super().close()
        if self._trace is not None:
            self._trace.close(self.ctx.clock())
            self._trace = None

    def _running(self) -> tuple[WheeledPhysics, Engine, WorldScene]:
        if self._physics is None or self._engine is None or self._scene is None:
            raise RuntimeError("the world is not open")
        return self._physics, self._engine, self._scene

    def _remember(self, place: tuple[float, float]) -> None:
        if not self._trail or sum(abs(a - b) for a, b in zip(place, self._trail[-1], strict=True)) > _TRAIL_EVERY_M:
            self._trail.append(place)

    def _change(self, call: Call, request: PlaceRequest | RemoveRequest) -> None:
        _, engine, _ = self._running()
        try:
            if isinstance(request, PlaceRequest):
                engine.place(WorldBox(**msgspec.structs.asdict(request)))
            else:
                engine.remove(request.name)
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        self._scene, self._scene_at = engine.scene(), self.ctx.clock()
        text = f"'{request.name}' {'stands in the world' if isinstance(request, PlaceRequest) else 'has vanished'}"
        self.ctx.event("world_changed", text, code="done", about=call.source)
        known = {wall.name for wall in self.ctx.settings.walls}
        things = tuple(wall.name for wall in self._scene.walls if wall.solid and wall.name not in known)
        call.reply(ThingsReply(accepted=True, reason=text, things=things))

    def _put(self, call: Call, request: BallRequest) -> None:
        _, engine, _ = self._running()
        engine.balls.answer(self.ctx, call, request)
        self._scene, self._scene_at = engine.scene(), self.ctx.clock()

    def _picture(self, call: Call, request: PictureRequest) -> None:
        physics, _, scene = self._running()
        pose, around, trail = physics.pose, _as_ranges(physics.ranges_m), tuple(self._trail)
        size = {"width": request.width_px, "height": request.height_px}
        self._painter.ask(call, request.path, lambda: image(scene, pose, around, trail=trail, **size))


def _as_ranges(ranges_m: dict[str, float | None]) -> Ranges:
    status: dict[str, RangeStatus] = {
        name: "over_range" if range_m is None else "ok" for name, range_m in ranges_m.items()
    }
    return ranges(ranges_m, {"bottom": "missing", **status})
