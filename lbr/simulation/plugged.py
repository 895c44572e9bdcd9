"""The devices of a world: a twin for each device row of a known type, and their faults."""

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from lbr.capability import twins
from lbr.capability.context import Call, Context, Device
from lbr.capability.twins import TwinError
from lbr.errors import InputError
from lbr.messages.leases import CommandReply
from lbr.simulation.cameras.orders import Drawing
from lbr.simulation.requests import FaultReply, FaultRequest, PlugRequest
from lbr.simulation.twins import Surroundings, Twin, make

_LOCAL = ("/", "unix:/")


def report_drawing(ctx: Context, said: Iterable[Drawing]) -> None:  # type: ignore[type-arg]  # any world's
    """Report what draws the cameras' pictures, or why nothing does."""
    for drawing in said:
        if not drawing.renderer:
            ctx.warn(f"the emulated cameras show nothing: {drawing.note}", "not_possible")
            continue
        note = f", because {drawing.note}" if drawing.note else ""
        ctx.event("cameras_drawn", f"the cameras' pictures are drawn by {drawing.renderer}{note}")


class Plugged:
    """The twins by name, except for devices elsewhere, of unknown types and of broken packages."""

    def __init__(self, ctx: Context, around: Surroundings) -> None:  # type: ignore[type-arg]  # any world's
        self._ctx = ctx
        self._around = replace(
            around,
            apart=frozenset(str(device.settings["sensor"]) for device in ctx.devices if "sensor" in device.settings),
        )
        self._by_name: dict[str, Twin] = {}
        types = sorted({device.type for device in ctx.devices})
        self._refused: list[str] = [said for one in types for said in twins.refused(one)]
        self._devices: tuple[Device, ...] = tuple(ctx.devices)
        for device in self._devices:
            if _emulated(device):
                self._plug(device)
        self.twins: tuple[Twin, ...] = tuple(self._by_name.values())

    def _plug(self, device: Device) -> None:
        try:
            self._by_name[device.name] = make(device, self._around)
        except InputError:
            raise
        except Exception as err:  # noqa: BLE001  a twin of a foreign package must not take the world with it
            why = str(err) if isinstance(err, TwinError) else f"{type(err).__name__}: {err}"
            self._refused.append(f"device '{device.name}' ({device.type}) is not emulated: {why}")

    def report_missing(self) -> None:
        """Report the devices without a twin, and refused twins."""
        refused, self._refused = self._refused, []
        for said in refused:
            self._ctx.warn(said, "not_possible")
            self._ctx.event("twin_refused", said, level="warning")
        self._report([device for device in self._devices if device.name not in self._by_name])

    def _report(self, others: list[Device]) -> None:
        """Report the devices without a twin, and those whose twin has another address."""
        stand_ins = f"/{self._ctx.robot}-devices/"
        alone = (row for row in others if row.type not in twins.names() and stand_ins not in row.address)
        own = [_placed(row) for row in alone]
        if own:
            self._ctx.event("no_twin", f"without a twin, and so used at their own address: {', '.join(own)}")
        away = [_placed(row) for row in others if row.type in twins.names() and not row.address.startswith(_LOCAL)]
        if away:
            text = f"no emulated twin for {', '.join(away)}: there are twins for addresses that are paths"
            self._ctx.warn(text, "not_possible")

    def add(self, call: Call, request: PlugRequest, plug_in: Callable[[Twin], str]) -> None:
        """Emulate one more device while time runs, and answer; `plug_in` returns why its twin cannot be added now."""
        device = Device(request.device, request.type, request.address, request.settings)
        if any(one.name == device.name for one in self._devices):
            call.refuse(f"there is a device '{device.name}' already", "exists")
            return
        if _emulated(device):
            if why := self._out_of_place(device):
                call.refuse(why, "denied")
                return
            try:
                twin = make(device, self._around)
            except (InputError, TwinError) as err:
                call.refuse(str(err), "bad_value")
                return
            if why := plug_in(twin):
                call.refuse(why, "not_possible")
                return
            self._by_name[device.name] = twin
        self._devices = (*self._devices, device)
        self._around = replace(self._around, now=self._ctx.clock())
        if device.name in self._by_name:
            self._ctx.event("plugged_in", f"device '{device.name}' ({device.type}) is emulated, too", code="done")
        else:
            self._report([device])
        call.reply(CommandReply(accepted=True))

    def _out_of_place(self, device: Device) -> str:
        """Return why nothing is emulated at an address; so no request makes a file in another place."""
        place = Path(self._ctx.home) / "run" / f"{self._ctx.robot}-devices" / device.name
        return "" if device.address.removeprefix("unix:") == str(place) else f"new devices are emulated at {place}"

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


def _emulated(device: Device) -> bool:
    return device.type in twins.names() and device.address.startswith(_LOCAL)


def _placed(device: Device) -> str:
    return f"{device.name} ({device.type} at {device.address or 'no address'})"
