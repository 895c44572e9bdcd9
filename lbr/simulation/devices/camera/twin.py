"""An emulated camera: a socket whose clients are passed to the drawing process."""

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.simulation.devices.camera import CameraFaults, CameraRow
from lbr.simulation.faults import FaultValue
from lbr.simulation.socket_port import SocketPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class CameraTwin(PortTwin[SocketPort, CameraFaults]):
    """Shows the view from one of the robot's mounts."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, CameraRow)
        super().__init__(device.name, SocketPort(device.address), settings.faults)
        self._mount = _mount(device, settings.mount, around.mounts)
        if around.cameras is None:
            raise InputError(f"device '{device.name}' ({device.type}): this world has no cameras")
        self._cameras = around.cameras
        if settings.faults != CameraFaults():
            self._cameras.set_faults(device.name, settings.faults)

    def fault(self, name: str, value: FaultValue) -> dict[str, object]:
        """Set a fault and return them all; raise InputError with the permitted ones."""
        faults = super().fault(name, value)
        self._cameras.set_faults(self.name, self._faults)
        return faults

    def service(self, now: float) -> None:  # noqa: ARG002
        """Do all that is due: the cable, and new connections."""
        plug(self.port, present=not self._faults.unplug)
        for client, _ in self.port.receive():
            connection = self.port.hand_over(client)
            if connection is not None:
                self._cameras.watch(self.name, self._mount, connection)


def _mount(device: Device, wanted: str, mounts: tuple[str, ...]) -> str:
    """Return the mount of a camera: by its row, by the end of its name, or the first one."""
    if wanted and wanted not in mounts:
        known = ", ".join(mounts) or "none"
        raise InputError(f"device '{device.name}' ({device.type}): mount '{wanted}': the world's cameras are: {known}")
    named = (mount for mount in mounts if device.name.endswith(mount))
    chosen = wanted or next(named, "") or next(iter(mounts), "")
    if not chosen:
        raise InputError(f"device '{device.name}' ({device.type}): the world's setting `cameras` has no place for it")
    return chosen
