"""Messages on `web/*`: the address of the robot's HTTP server, and its users."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class WebState(Struct, frozen=True, kw_only=True):
    """The server's addresses (`urls`, the most useful first), its content, and its load."""

    listening: bool
    urls: tuple[str, ...] = ()
    faces: tuple[str, ...] = ()
    announced: str = ""
    clients: int = 0
    requests: int = 0
    refused: int = 0
    jobs: int = 0
    reason: str = ""


class AddressCommand(Struct, frozen=True, kw_only=True):
    """Show where the server listens, with a QR code for a phone."""


class AddressReply(Struct, frozen=True, kw_only=True):
    """The address, its QR code in characters, whether other machines reach it, and by TLS.

    `local`: the address by multicast DNS; empty if not announced.
    """

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    url: str = ""
    local: str = ""
    open: bool = False
    tls: bool = False
