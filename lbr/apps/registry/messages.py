"""Messages on `registrar/*`: whether the service lists the robot."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class RegistrarState(Struct, frozen=True, kw_only=True):
    """The robot's place and name in the service's list, its addresses, and why it is not listed."""

    registered: bool
    url: str
    name: str = ""
    urls: tuple[str, ...] = ()
    endpoints: tuple[str, ...] = ()
    reason: str = ""
    code: ReasonCode = ""
    times: int = 0
