"""Messages on `mqtt/*`: how it stands with a broker outside."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class MqttState(Struct, frozen=True, kw_only=True):
    """The state of the broker, and the reason if it is away; how much was reported, asked for and refused, and the last
    answer.

    `version` is the newest of the shadow that was heard of.
    """

    connected: bool
    broker: str
    reason: str = ""
    connections: int = 0
    reported: int = 0
    asked: int = 0
    refused: int = 0
    answer: str = ""
    code: ReasonCode = ""
    doing: str = ""
    version: int | None = None
