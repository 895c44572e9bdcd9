"""The pages whose requests are allowed, by the headers that browsers send. Pure."""

import re
from collections.abc import Iterable, Mapping
from urllib.parse import urlsplit

ANY = "*"
_OWN = frozenset({"none", "same-origin"})
_AHEAD = re.compile(r"prefetch|prerender|preview", re.IGNORECASE)
_PURPOSES = ("sec-purpose", "purpose", "x-purpose", "x-moz")


class Pages:
    """The pages whose scripts may send requests: the server's own, and those of the row's origins."""

    def __init__(self, cors: Iterable[str] = ()) -> None:
        self._allowed = frozenset(cors)

    def allows(self, origin: str) -> bool:
        """Return whether an origin is among the row's."""
        return ANY in self._allowed or origin in self._allowed

    def stranger(self, headers: Mapping[str, str], scheme: str) -> str:
        """Return the foreign page behind a request; empty for own pages, allowed pages, and unknown senders.

        Browsers send `Origin` with the requests of scripts, and with every method but GET and HEAD. If the address is
        https or of the loopback, they send `Sec-Fetch-Site` with every request, links and pictures included. Elsewhere
        a page without referrer is unknown: see `proven`.
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
            return "" if known and (site in {"", *_OWN} or referrer != own) else referrer
        return "" if site in {"", *_OWN} else "another page"

    def proven(self, headers: Mapping[str, str]) -> bool:
        """Return whether the headers prove that no foreign page sent a request which `stranger` admits.

        No page can make a browser send false values of these headers; a missing header proves nothing.
        """
        return (
            ANY in self._allowed
            or bool(headers.get("origin"))
            or bool(_origin(headers.get("referer", "")))
            or headers.get("sec-fetch-site", "") in _OWN
        )


def is_visit(headers: Mapping[str, str]) -> bool:
    """Return whether a user follows a link, whose page cannot read the answer."""
    return "origin" not in headers and headers.get("sec-fetch-mode", "navigate") == "navigate"


def is_ahead(headers: Mapping[str, str]) -> bool:
    """Return whether a browser loads ahead of its user, as for an address that is still being typed."""
    return any(_AHEAD.search(headers.get(one, "")) for one in _PURPOSES)


def _origin(url: str) -> str:
    try:
        parts = urlsplit(url)
    except ValueError:
        return "an address that cannot be read"
    return f"{parts.scheme}://{parts.netloc}" if parts.scheme and parts.netloc else ""
