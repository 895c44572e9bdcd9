"""Grants of the executive to the doors: who may come in, and with which rights."""

from msgspec import Struct

from lbr.bus.access import Credentials, Rights
from lbr.messages.rows import Row
from lbr.messages.system import Role, TokenRole


class LanUser(Row, frozen=True, kw_only=True):
    """A user who may come in from another machine; `hash` is of the user's secret. A kind reads it as a row."""

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
    """A process of this robot on another machine: its user at the door, and its wires."""

    credentials: Credentials
    rights: Rights


class LanConfig(Struct, frozen=True, kw_only=True):
    """The private document of kind `lan`, which only the door to other machines receives.

    `link` are its router's credentials at the router `upstream`, to which it is connected; `inside` is the endpoint of
    its relay. Everybody may read `streams` and use `stops`; `commands` maps every other command to its least role.
    `subscribed` are the streams and the setpoints. `private_key` and `certificate` are files. `guests` are processes on
    other machines; their own commands, by role, are in `theirs` and not in `commands`.
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
