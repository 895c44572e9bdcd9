"""Messages on `foxglove/*`: where Foxglove finds the robot, and how many look at it."""

from msgspec import Struct


class FoxgloveState(Struct, frozen=True, kw_only=True):
    """Where the bridge listens (`urls`, the most useful one first), how many are connected, and what was refused."""

    listening: bool
    urls: tuple[str, ...] = ()
    clients: int = 0
    refused: int = 0
    reason: str = ""
