"""Messages on `foxglove/*`: the bridge's addresses and clients."""

from msgspec import Struct


class FoxgloveState(Struct, frozen=True, kw_only=True):
    """Where the bridge listens (`urls`, the most useful first), its clients, and its refusals."""

    listening: bool
    urls: tuple[str, ...] = ()
    clients: int = 0
    refused: int = 0
    reason: str = ""
