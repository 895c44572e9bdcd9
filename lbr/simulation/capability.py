"""The capability `world`: a room, a robot in it, and an emulated twin for each device row that has one."""

import json
import sys
from collections import deque
from pathlib import Path
from typing import Any

import msgspec

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.sensing import Ranges, RangeStatus
from lbr.messages.simulation import WorldBox, WorldScene
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.cameras.orders import Drawing
from lbr.simulation.engine import Engine
from lbr.simulation.loop import WorldLoop
from lbr.simulation.painter import Painter, picture_path
from lbr.simulation.requests import (
    FaultReply,
    FaultRequest,
    PictureRequest,
    PlaceRequest,
    RemoveRequest,
    ThingsReply,
)
from lbr.simulation.settings import WorldSettings
from lbr.simulation.topdown import image
from lbr.simulation.trace import OutputTrace
from lbr.simulation.twins import TWINS, WITHOUT_TWIN, Surroundings, Twin

_SWITCH_S = 0.0005
"""How soon the world's thread gets its turn; the usual 5 ms would show in the devices' answers."""

_TRAIL_EVERY_M = 0.03
_LOCAL = ("/", "unix:/")


class World(Capability[WorldSettings]):
    """Serves the devices from a thread of its own, and tells the bus where the robot is."""

    def __init__(self, ctx: Context[WorldSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.pose_hz
        self._engine: Engine | None = None
        self._loop: WorldLoop | None = None
        self._trace: OutputTrace | None = None
        self._cameras: CameraHost | None = None
        self._twins: dict[str, Twin] = {}
        self._painter = Painter()
        self._scene: WorldScene | None = None
        self._scene_at = self._pose_at = 0.0
        self._trail: deque[tuple[float, float]] = deque(maxlen=5000)
        self._switch_s = sys.getswitchinterval()

    def open(self) -> None:
        """Build the world, plug the twins in and let time run."""
        sys.setswitchinterval(_SWITCH_S)
        now = self.ctx.clock()
        self._painter = Painter()
        engine = self._engine = Engine(self.ctx.settings)
        self._trace = OutputTrace(self.ctx.settings.trace)
        cameras = self._cameras = CameraHost(self.ctx.settings, len(engine.view()))
        mounts = tuple(self.ctx.settings.cameras)
        self._twins = self._plugged_in(Surroundings(self.ctx.settings.seed, now, self._trace, cameras, mounts))
        self._scene = engine.scene()
        self._scene_at = self._pose_at = now
        self._loop = WorldLoop(engine, tuple(self._twins.values()), self.ctx.clock, cameras)
        self._loop.open()
        self._warn_of_devices_without_twin()

    def step(self) -> None:
        """Publish what is due; raise what ended the world's thread."""
        _, loop, scene = self._running()
        if loop.failure is not None:
            raise loop.failure
        self._painter.finish()
        if self._cameras is not None:
            self._tell(self._cameras.serve())
        now, period_s = self.ctx.clock(), 1 / self.ctx.settings.pose_hz
        if now >= self._pose_at - period_s / 4:
            self._pose_at = max(self._pose_at + period_s, now)
            self.ctx.publish("pose", loop.pose)
            self._remember((loop.pose.x_m, loop.pose.y_m))
        if now >= self._scene_at:
            self._scene_at = now + self.ctx.settings.scene_every_s
            self.ctx.publish("scene", scene)

    def command(self, call: Call) -> None:
        """Answer `fault`, `place`, `remove` and `picture`."""
        drawn = isinstance(call.message, PictureRequest)
        if call.role == "view" and not (drawn and not call.message.path):
            call.refuse(f"{call.name} needs the role operate{', unless no path is named' if drawn else ''}")
        elif isinstance(call.message, FaultRequest):
            self._fault(call, call.message)
        elif isinstance(call.message, PlaceRequest | RemoveRequest):
            self._change(call, call.message)
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

    def _running(self) -> tuple[Engine, WorldLoop, WorldScene]:
        if self._engine is None or self._loop is None or self._scene is None:
            raise RuntimeError("the world is not open")
        return self._engine, self._loop, self._scene

    def _plugged_in(self, around: Surroundings) -> dict[str, Twin]:
        here = [device for device in self.ctx.devices if device.address.startswith(_LOCAL)]
        return {device.name: TWINS[device.type](device, around) for device in here if device.type in TWINS}

    def _warn_of_devices_without_twin(self) -> None:
        wanted = (device for device in self.ctx.devices if device.type not in WITHOUT_TWIN)
        devices = (device for device in wanted if device.name not in self._twins)
        without = [f"{device.name} ({device.type} at {device.address or 'no address'})" for device in devices]
        if without:
            allowed = f"devices of type {', '.join(TWINS)} whose address is a path"
            self.ctx.warn(f"no emulated twin for {', '.join(without)}; there are twins for {allowed}")

    def _tell(self, said: list[Drawing]) -> None:
        for drawing in said:
            if not drawing.renderer:
                self.ctx.warn(f"the emulated cameras show nothing: {drawing.note}")
                continue
            note = f", because {drawing.note}" if drawing.note else ""
            self.ctx.event("cameras_drawn", f"the cameras' pictures are drawn by {drawing.renderer}{note}")

    def _remember(self, place: tuple[float, float]) -> None:
        if not self._trail or sum(abs(a - b) for a, b in zip(place, self._trail[-1], strict=True)) > _TRAIL_EVERY_M:
            self._trail.append(place)

    def _fault(self, call: Call, request: FaultRequest) -> None:
        twin = self._twins.get(request.device)
        if twin is None:
            call.refuse(f"no emulated device '{request.device}'; there are: {', '.join(self._twins) or 'none'}")
            return
        try:
            faults = twin.fault(request.name, request.value)
        except InputError as err:
            call.refuse(str(err))
            return
        now = "as it was" if request.value is None else json.dumps(request.value)
        said = f"{request.device}: {request.name} is now {now}"
        self.ctx.event("fault_injected", said, level="warning")
        call.reply(FaultReply(accepted=True, reason=said, faults=faults))

    def _change(self, call: Call, request: PlaceRequest | RemoveRequest) -> None:
        engine, _, _ = self._running()
        try:
            if isinstance(request, PlaceRequest):
                engine.place(WorldBox(**msgspec.structs.asdict(request)))
            else:
                engine.remove(request.name)
        except InputError as err:
            call.refuse(str(err))
            return
        self._scene, self._scene_at = engine.scene(), self.ctx.clock()
        said = f"'{request.name}' {'stands in the world' if isinstance(request, PlaceRequest) else 'has vanished'}"
        self.ctx.event("world_changed", said)
        known = {wall.name for wall in self.ctx.settings.walls}
        things = tuple(wall.name for wall in self._scene.walls if wall.name not in known)
        call.reply(ThingsReply(accepted=True, reason=said, things=things))

    def _picture(self, call: Call, request: PictureRequest) -> None:
        _, loop, scene = self._running()
        path = Path(request.path).expanduser() if request.path else picture_path(self.ctx.robot)
        pose, ranges, trail = loop.pose, _as_ranges(loop.ranges_m), tuple(self._trail)
        size = {"width": request.width_px, "height": request.height_px}
        self._painter.ask(call, path, lambda: image(scene, pose, ranges, trail=trail, **size))


def _as_ranges(ranges_m: dict[str, float | None]) -> Ranges:
    status: dict[str, RangeStatus] = {
        side: "over_range" if range_m is None else "ok" for side, range_m in ranges_m.items()
    }
    values: dict[str, Any] = {f"{side}_m": range_m for side, range_m in ranges_m.items()}
    return Ranges(**values, bottom_m=None, status={**status, "bottom": "missing"})
