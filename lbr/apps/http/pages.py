"""Which pages of browsers may ask, by what browsers say of them. Pure."""

import re
from collections.abc import Iterable, Mapping
from urllib.parse import urlsplit

ANY = "*"
_OWN = frozenset({"none", "same-origin"})
_AHEAD = re.compile(r"prefetch|prerender|preview", re.IGNORECASE)
_PURPOSES = ("sec-purpose", "purpose", "x-purpose", "x-moz")


class Pages:
    """Which pages' scripts may ask: our own, and those of the origins in the row."""

    def __init__(self, cors: Iterable[str] = ()) -> None:
        self._allowed = frozenset(cors)

    def allows(self, origin: str) -> bool:
        """Return whether an origin is among those of the row."""
        return ANY in self._allowed or origin in self._allowed

    def stranger(self, headers: Mapping[str, str], scheme: str) -> str:
        """Return the foreign page that makes a browser ask this; empty for our own, allowed ones, and unknown ones.

        Browsers send `Origin` with what scripts ask and with every method but GET and HEAD, and `Sec-Fetch-Site` with
        everything, links and pictures too, where the address is https or of the loopback. Elsewhere a page that leaves
        out the referrer says nothing: see `proven`.
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
        """Say whether what is said proves that no foreign page asks, of a request that `stranger` has nothing against.

        No page can make a browser send these headers with other values than are true; one that is missing proves
        nothing.
        """
        return (
            ANY in self._allowed
            or bool(headers.get("origin"))
            or bool(_origin(headers.get("referer", "")))
            or headers.get("sec-fetch-site", "") in _OWN
        )


def is_visit(headers: Mapping[str, str]) -> bool:
    """Return whether a user follows a link to a page, so that the page that has the link learns nothing."""
    return "origin" not in headers and headers.get("sec-fetch-mode", "navigate") == "navigate"


def is_ahead(headers: Mapping[str, str]) -> bool:
    """Say whether a browser only guesses that its user may go there, as with an address that is still being typed."""
    return any(_AHEAD.search(headers.get(one, "")) for one in _PURPOSES)


def _origin(url: str) -> str:
    try:
        parts = urlsplit(url)
    except ValueError:
        return "an address that cannot be read"
    return f"{parts.scheme}://{parts.netloc}" if parts.scheme and parts.netloc else ""
