"""Who asks, and from which page: trusted networks, tokens and their roles, and pages that may or may not ask."""

import ipaddress
import secrets
from collections.abc import Iterable, Mapping
from urllib.parse import urlsplit

from lbr.apps.web.face import Client, Refused
from lbr.bus import tokens
from lbr.capability.config import LanUser
from lbr.errors import InputError
from lbr.messages.system import Role

TRUSTED_ROLE: Role = "admin"
FORWARDED = ("forwarded", "x-forwarded-for", "x-real-ip")
ANY = "*"


class Access:
    """Knows the trusted networks and the tokens; a token is proven against its row when it is shown first."""

    def __init__(self, trusted: Iterable[str], users: Iterable[LanUser]) -> None:
        self._networks = [ipaddress.ip_network(network, strict=False) for network in trusted]
        self._users = {user.name: user for user in users}
        self._proven: dict[str, bool] = {}

    def client(self, address: str, headers: Mapping[str, str], shown: str = "") -> Client:
        """Return who asks; Refused (401) for a token that is none. `shown` is a token from elsewhere than the headers.

        What a proxy says of others is not believed, but it says that this is not somebody at this machine.
        """
        if not shown and "authorization" in headers:
            scheme, _, shown = headers["authorization"].partition(" ")
            if scheme.lower() != "bearer" or not shown.strip():
                raise _no_token("'Authorization' must be 'Bearer NAME.SECRET.FINGERPRINT'")
        if shown:
            return self._by_token(address, shown)
        relayed = any(name in headers for name in FORWARDED)
        return Client(address, role=TRUSTED_ROLE if not relayed and self._is_trusted(address) else None)

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
        """Say whether a row's hash is of the secret that belongs to it; takes some 25 ms, once."""
        if user.name not in self._proven:
            self._proven[user.name] = tokens.fits(user.secret, user.hash)
        return self._proven[user.name]

    def _is_trusted(self, address: str) -> bool:
        try:
            found = ipaddress.ip_address(address.partition("%")[0])
        except ValueError:
            return False
        if isinstance(found, ipaddress.IPv6Address) and found.ipv4_mapped is not None:
            found = found.ipv4_mapped
        return any(found in network for network in self._networks if network.version == found.version)


class Pages:
    """Which pages' scripts may ask: our own, and those of the origins in the row."""

    def __init__(self, cors: Iterable[str]) -> None:
        self._allowed = frozenset(cors)

    def allows(self, origin: str) -> bool:
        """Say whether an origin is among those of the row."""
        return ANY in self._allowed or origin in self._allowed

    def stranger(self, headers: Mapping[str, str], scheme: str) -> str:
        """Return which foreign page has a browser ask this; empty for our own, allowed ones, and what is no browser.

        Apps and scripts send none of these headers. Browsers send `Origin` with what scripts and forms ask, and
        `Sec-Fetch-Site` with everything, links and pictures too, where the address is https or this machine's own.
        """
        if ANY in self._allowed:
            return ""
        own = f"{scheme}://{headers.get('host', '')}"
        origin = headers.get("origin")
        if origin is not None:
            return "" if origin == own or self.allows(origin) else origin or "an empty origin"
        referrer = _origin(headers.get("referer", ""))
        site = headers.get("sec-fetch-site", "")
        if referrer:
            known = referrer == own or self.allows(referrer)
            return "" if known and (site in {"", "none", "same-origin"} or referrer != own) else referrer
        return "" if site in {"", "none", "same-origin"} else "another page"


def _origin(url: str) -> str:
    try:
        parts = urlsplit(url)
    except ValueError:
        return "an address that cannot be read"
    return f"{parts.scheme}://{parts.netloc}" if parts.scheme and parts.netloc else ""


def _no_token(why: str) -> Refused:
    return Refused(401, why, {"WWW-Authenticate": 'Bearer realm="lbr"'})
