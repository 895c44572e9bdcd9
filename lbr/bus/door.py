"""Grants of the executive to those that let others in: who may come, and with which rights."""

from msgspec import Struct

from lbr.bus.access import Credentials, Rights
from lbr.messages.rows import Row
from lbr.messages.system import Role, TokenRole


class LanUser(Row, frozen=True, kw_only=True):
    """A user who may come in from another machine; `hash` is of the secret, and must fit it. A kind reads it as a
    row."""

    TABLE = "user_token"
    KEY = ("name",)

    name: str
    role: TokenRole
    secret: str
    hash: str


class TokenRight(Row, frozen=True, kw_only=True):
    """The rights of a token's holder, without the proof: for a kind that acts in its name."""

    TABLE = "user_token"
    KEY = ("name",)

    name: str
    role: TokenRole


class LanGuest(Struct, frozen=True, kw_only=True):
    """A process of this robot that runs on another machine: who it is at the door, and what its rows wire."""

    credentials: Credentials
    rights: Rights


class LanConfig(Struct, frozen=True, kw_only=True):
    """The private document of kind `lan`: what only the door to other machines needs to know.

    `link` is how its router proves itself to the one it hangs on, whose id is `upstream`; `inside` is where its relay
    comes in. `streams` may be read by all, `subscribed` are they and the setpoints, `stops` be used by all, and `commands`
    maps every other command to the role it needs. `private_key` and `certificate` are files. `guests` are processes on
    other machines; what they take themselves, by role, is in `theirs` and not in `commands`.
    """

    listen: tuple[str, ...]
    link: Credentials
    users: tuple[LanUser, ...]
    streams: tuple[str, ...]
    stops: tuple[str, ...]
    commands: dict[str, Role]
    private_key: str
    certificate: str
    guests: tuple[LanGuest, ...] = ()
    theirs: dict[str, Role] = {}
    subscribed: tuple[str, ...] = ()
    upstream: str = ""
    inside: str = ""
