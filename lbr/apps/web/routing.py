"""Which route answers a request, and what it takes out of it. Pure.

Paths are found as widespread servers do: letters in either case, and with or without a slash at the end.
"""

import re
from collections.abc import Iterable
from typing import Any
from urllib.parse import parse_qsl, unquote_to_bytes

import msgspec
from msgspec import Struct

from lbr.apps.web.face import Refused, Route
from lbr.messages.units import NAME_PATTERN

MOST_PARAMETERS = 64
LONGEST_URL = 4096
_KEY = re.compile(r"\{([a-z_]+)\}")
_NO_NAME = "names are small letters, digits and _, a letter first"
_PLACE = re.compile(r" - at `\$(?:\.([^`]*))?`$")


class Table:
    """Routes, of which the first that fits answers."""

    def __init__(self, routes: Iterable[Route]) -> None:
        self.routes = tuple(routes)
        self._patterns = [(_pattern(route.path), route) for route in self.routes]

    def find(self, method: str, path: str) -> tuple[Route, dict[str, str]] | None:
        """Return the route of a path as it came, percent signs and all, and the keys in it; HEAD is answered as GET."""
        wanted = "GET" if method == "HEAD" else method
        for pattern, route in self._patterns:
            if route.method == wanted and (found := pattern.fullmatch(path)) is not None:
                return route, {name: _decoded(value) for name, value in found.groupdict().items()}
        return None

    def methods(self, path: str) -> tuple[str, ...]:
        """Return the methods that a path has."""
        there = {route.method for pattern, route in self._patterns if pattern.fullmatch(path) is not None}
        return tuple(sorted(there | ({"HEAD"} if "GET" in there else set())))


def parameters(query_string: bytes) -> tuple[tuple[str, str], ...]:
    """Return the query's parameters in order; Refused (400) if there are too many."""
    try:
        text = query_string.decode("ascii", "replace")
        return tuple(parse_qsl(text, keep_blank_values=True, max_num_fields=MOST_PARAMETERS, errors="replace"))
    except ValueError:
        raise Refused(400, f"a query may have {MOST_PARAMETERS} parameters") from None


def converted(query: Iterable[tuple[str, str]], kind: type[Struct]) -> Any:
    """Return a query's parameters as a Struct; Refused (400) says which one does not fit, or came twice."""
    fields = {field.encode_name for field in msgspec.structs.fields(kind)}
    given: dict[str, str] = {}
    for name, value in query:
        if name in given and name in fields:
            raise Refused(400, f"'{name}' may be given once")
        given[name] = value
    try:
        return msgspec.convert(given, kind, strict=False)
    except msgspec.ValidationError as err:
        raise Refused(400, plain(err)) from None


def decoded(body: bytes, kind: type[Struct]) -> Any:
    """Return a JSON body as a Struct; Refused (400) says where it does not fit."""
    try:
        return msgspec.json.decode(body, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError) as err:
        raise Refused(400, plain(err)) from None
    except RecursionError:
        raise Refused(400, "the JSON is nested too deeply") from None


def plain(err: Exception) -> str:
    """Return what is wrong with some data, the place first."""
    text = str(err).replace(f"Expected `str` matching regex {NAME_PATTERN!r}", _NO_NAME)
    found = _PLACE.search(text)
    if found is None:
        return text
    said = text[: found.start()].replace("`", "'")
    return f"{found[1]}: {said}" if found[1] else said


def _pattern(path: str) -> re.Pattern[str]:
    parts = _KEY.split(path.rstrip("/"))
    joined = "".join(re.escape(part) if at % 2 == 0 else f"(?P<{part}>[^/]+)" for at, part in enumerate(parts))
    return re.compile(f"{joined}/?", re.IGNORECASE)


def _decoded(text: str) -> str:
    try:
        return unquote_to_bytes(text).decode()
    except UnicodeDecodeError:
        raise Refused(400, "the path is not valid UTF-8") from None
