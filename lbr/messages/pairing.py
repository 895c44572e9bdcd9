"""Messages by which a phone or browser gets a token: it sends the digits that a person read at the console."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.system import Role

DIGITS = 6
Digits = Annotated[str, Meta(pattern="^[0-9]{6}$(?!\\n)", description="six digits of the console's `pair`")]


class PairCommand(Struct, frozen=True, kw_only=True):
    """Give a token for these digits to a device of that name and address."""

    digits: Digits
    address: Annotated[str, Meta(min_length=1, max_length=64)]
    name: Annotated[str, Meta(max_length=80)] = ""


class PairReply(Struct, frozen=True, kw_only=True):
    """The token and its row's fields; or a refusal, in the same words for every wrong code."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    token: str = ""
    name: str = ""
    role: Role = "view"
    hash: str = ""
