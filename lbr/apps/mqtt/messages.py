"""Messages on `mqtt/*`: the state of the connection to a broker."""

from msgspec import Struct

from lbr.messages.codes import ReasonCode


class MqttState(Struct, frozen=True, kw_only=True):
    """The broker's state, the reason if it is away, the counts of reports, requests and refusals, and the last answer.

    `version`: the shadow's newest.
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
