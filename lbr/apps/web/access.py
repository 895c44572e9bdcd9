"""Identifies the client of a request: this machine, its owner, trusted networks, tokens and their roles."""

import ipaddress
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from lbr.apps.http import names, peers
from lbr.apps.web.face import Client, Refused
from lbr.bus import tokens
from lbr.bus.door import LanUser
from lbr.errors import InputError
from lbr.messages.system import Role

if TYPE_CHECKING:
    from lbr.apps.web.login import Login

HERE: Role = "view"
"""The role of every program on this machine, of any user; it includes stops."""
OWNER: Role = "admin"
TRUSTED: Role = "operate"
OLD_SCHEME, NONE = "TOK:", "none"


class Access:
    """The trusted networks and the tokens; a token is checked against its row's hash at its first use.

    `legacy`: programs of this machine operate, and a GET from here or from a trusted network may move. `login` knows
    the cookies, whose clients may look in addition to the rights of their place.
    """

    def __init__(
        self, trusted: Iterable[str], users: Iterable[LanUser], *, legacy: bool = False, login: "Login | None" = None
    ) -> None:
        self._login = login
        self._networks = [ipaddress.ip_network(network, strict=False) for network in trusted]
        self._users = {user.name: user for user in users}
        self._legacy = legacy
        self._proven: dict[str, bool] = {}

    def use(self, users: Iterable[LanUser]) -> None:
        """Use these tokens only; what clients opened by others ends. From any thread."""
        known = {user.name: user for user in users}
        if known == self._users:
            return
        self._users = known
        if self._login is not None:
            self._login.sessions.use({user.name: user.secret for user in self._users.values()})

    def client(
        self,
        address: str,
        headers: Mapping[str, str],
        token: str = "",
        *,
        port: int = 0,
        owner: bool = False,
        whose: str | None = None,
    ) -> Client:
        """Return the client at `port`; raise Refused (401) for an invalid token.

        `token` is one from outside the headers.

        A proxy's claims about its clients are ignored, but it proves that the client is not a user of this machine.
        `owner`: the kernel reports that the client's program is of this robot's own user; `whose` is the user it
        reports.
        """
        if not token and "authorization" in headers:
            token = self._token(headers["authorization"].strip())
        if token:
            return self._by_token(address, token)
        client = self._by_place(address, headers, port, owner=owner)
        session = self._login.session(headers, whose) if self._login is not None else ""
        return replace(client, session=session, role=client.role or "view") if session else client

    def _token(self, authorization: str) -> str:
        """Return the token in a header: Bearer, or `TOK:` of the robot lbr's old clients. Raise Refused (401) for any
        other.

        A token of the old robot is not valid here. With `legacy` it is ignored, so that programs that still send it go
        on.
        """
        if authorization.startswith(OLD_SCHEME):
            token = authorization.removeprefix(OLD_SCHEME).strip()
            return "" if self._legacy and not tokens.is_one(token) else token or NONE
        scheme, _, token = authorization.partition(" ")
        if scheme.lower() != "bearer" or not token.strip():
            raise _no_token("'Authorization' must be 'Bearer NAME.SECRET.FINGERPRINT'")
        return token

    def _by_place(self, address: str, headers: Mapping[str, str], port: int, *, owner: bool) -> Client:
        is_here = names.is_loopback(address)
        if peers.is_relayed(headers, port) or (is_here and not names.means_loopback(headers.get("host", ""))):
            return Client(address)
        trusted = self._is_trusted(address)
        if is_here:
            operates = trusted or self._legacy
            return Client(address, role=OWNER if owner else TRUSTED if operates else HERE, legacy=self._legacy)
        return Client(address, role=TRUSTED if trusted else None, legacy=trusted and self._legacy)

    def _by_token(self, address: str, shown: str) -> Client:
        try:
            token = tokens.parse(shown)
        except InputError as err:
            raise _no_token(str(err)) from None
        user = self._users.get(token.name)
        right = secrets.compare_digest(token.secret.encode(), (user.secret if user else "").encode())
        if user is None or not right or not self._is_proven(user):
            raise _no_token(
                "this token is not known here, was revoked, or is not for the web (`lbr token add NAME --for web`)"
            )
        return Client(address, name=user.name, role="view" if user.role == "host" else user.role)

    def _is_proven(self, user: LanUser) -> bool:
        """Return whether a row's hash belongs to its secret; takes about 25 ms, once."""
        if user.hash not in self._proven:
            self._proven[user.hash] = tokens.fits(user.secret, user.hash)
        return self._proven[user.hash]

    def _is_trusted(self, address: str) -> bool:
        found = names.plain(address)
        return found is not None and any(found in network for network in self._networks)


def _no_token(why: str) -> Refused:
    return Refused(401, why, {"WWW-Authenticate": 'Bearer realm="lbr"'})
