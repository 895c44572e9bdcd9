"""Messages on `web/*`: where the robot is served over HTTP, and to whom."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class WebState(Struct, frozen=True, kw_only=True):
    """Where the server listens (`urls`, the most useful one first), what it serves, and how busy it is."""

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
    """Say where the server listens, with a QR code to hold a phone's camera at."""


class AddressReply(Struct, frozen=True, kw_only=True):
    """The address, and the QR code in characters, for a terminal; whether other machines reach it, and by TLS.

    `local` is the address by the name that multicast DNS finds, empty if the server is not announced.
    """

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    url: str = ""
    local: str = ""
    open: bool = False
    tls: bool = False
