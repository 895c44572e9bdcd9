"""The messages of the world and the process that draws, over a socket that keeps messages apart."""

from msgspec import Struct

from lbr.simulation.devices.camera import CameraFaults

LONGEST_BYTES = 200_000


class Begin(Struct, frozen=True, tag=True):
    """The first one, with the descriptors of the shared memory and of the packed model, and whether OpenGL is to be
    tried."""

    view_bytes: int
    use_gl: bool


class Watch(Struct, frozen=True, tag=True):
    """A client has connected to a device: the descriptor of that connection comes with it, and where it looks from."""

    device: str
    mount: str


class SetFaults(Struct, frozen=True, tag=True):
    """A device's faults as they now are; those that watch an unplugged one are cut off."""

    device: str
    faults: CameraFaults


class Drawing(Struct, frozen=True, tag=True):
    """The answer to `Begin`: what draws, and why it is not OpenGL; or, if nothing draws, why."""

    renderer: str
    note: str = ""


Order = Begin | Watch | SetFaults
