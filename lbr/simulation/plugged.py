"""The devices of a world: a twin for each device row that has one, and what is made to go wrong with them."""

import json
from collections.abc import Iterable

from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.simulation.cameras.orders import Drawing
from lbr.simulation.requests import FaultReply, FaultRequest
from lbr.simulation.twins import TWINS, WITHOUT_TWIN, Surroundings, Twin

_LOCAL = ("/", "unix:/")


def tell_of_drawing(ctx: Context, said: Iterable[Drawing]) -> None:  # type: ignore[type-arg]  # any world's
    """Say what draws the cameras' pictures, or why nothing does."""
    for drawing in said:
        if not drawing.renderer:
            ctx.warn(f"the emulated cameras show nothing: {drawing.note}")
            continue
        note = f", because {drawing.note}" if drawing.note else ""
        ctx.event("cameras_drawn", f"the cameras' pictures are drawn by {drawing.renderer}{note}")


class Plugged:
    """The twins by name; those of devices elsewhere, and of types without one, are not there."""

    def __init__(self, ctx: Context, around: Surroundings) -> None:  # type: ignore[type-arg]  # any world's
        self._ctx = ctx
        here = [device for device in ctx.devices if device.address.startswith(_LOCAL)]
        self._by_name = {device.name: TWINS[device.type](device, around) for device in here if device.type in TWINS}
        self.twins: tuple[Twin, ...] = tuple(self._by_name.values())

    def warn_of_missing(self) -> None:
        """Say which devices have no twin."""
        wanted = (device for device in self._ctx.devices if device.type not in WITHOUT_TWIN)
        devices = (device for device in wanted if device.name not in self._by_name)
        without = [f"{device.name} ({device.type} at {device.address or 'no address'})" for device in devices]
        if without:
            allowed = f"devices of type {', '.join(TWINS)} whose address is a path"
            self._ctx.warn(f"no emulated twin for {', '.join(without)}; there are twins for {allowed}")

    def fault(self, call: Call, request: FaultRequest) -> None:
        """Set a fault of a device, and answer."""
        twin = self._by_name.get(request.device)
        if twin is None:
            call.refuse(
                f"no emulated device '{request.device}'; there are: {', '.join(self._by_name) or 'none'}",
                "unknown_name",
            )
            return
        try:
            faults = twin.fault(request.name, request.value)
        except InputError as err:
            call.refuse(str(err), "bad_value")
            return
        now = "as it was" if request.value is None else json.dumps(request.value)
        said = f"{request.device}: {request.name} is now {now}"
        self._ctx.event("fault_injected", said, level="warning", code="done", about=call.source)
        call.reply(FaultReply(accepted=True, reason=said, faults=faults))
