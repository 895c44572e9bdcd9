"""The messages between the world and its drawing process, over a socket that separates messages."""

from msgspec import Struct

from lbr.simulation.devices.camera import CameraFaults

LONGEST_BYTES = 200_000


class Begin(Struct, frozen=True, tag=True):
    """The first order, with the descriptors of the shared memory and of the packed model; whether to try OpenGL."""

    view_bytes: int
    use_gl: bool


class Watch(Struct, frozen=True, tag=True):
    """A client has connected to a device: the descriptor of its connection, and its place of view."""

    device: str
    mount: str


class SetFaults(Struct, frozen=True, tag=True):
    """The present faults of a device; viewers of an unplugged one are disconnected."""

    device: str
    faults: CameraFaults


class Drawing(Struct, frozen=True, tag=True):
    """The answer to `Begin`: the renderer, and why it is not OpenGL; or, without one, the reason."""

    renderer: str
    note: str = ""


Order = Begin | Watch | SetFaults
