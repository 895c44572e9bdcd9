"""Matches requests to routes, and converts their parameters and bodies. Pure.

Paths match as in most servers: in either case, and with or without a slash at the end. They are compared as sent, so a
percent-encoded path is another path.
"""

import re
from collections.abc import Iterable
from typing import TypeVar
from urllib.parse import parse_qsl, unquote_to_bytes

import msgspec
from msgspec import Struct
from starlette.routing import compile_path
from starlette.types import Scope

from lbr.apps.web.face import Query, Refused
from lbr.messages.in_words import in_words
from lbr.messages.unreadable import UNREADABLE, keyed_once

MOST_PARAMETERS = 64
S = TypeVar("S", bound=Struct)
T = TypeVar("T")
_PLACE = re.compile(r" - at `\$(?:\.([^`]*))?`\Z")


class Path:
    """A path in Starlette's syntax, such as `/motion/{key}`, to match percent-encoded paths.

    A key such as `{rest:path}` matches the whole rest with its slashes, and may be empty.
    """

    def __init__(self, path: str) -> None:
        written = compile_path(path.rstrip("/"))[0].pattern.removesuffix("$")
        self._pattern = re.compile(f"{written}/?", re.IGNORECASE)

    def fits(self, path: str) -> bool:
        """Return whether a requested path matches."""
        return self._pattern.fullmatch(path) is not None

    def keys(self, path: str) -> dict[str, str]:
        """Return the keys in a requested path; raise Refused (400) if one is not UTF-8."""
        match = self._pattern.fullmatch(path)
        return {} if match is None else {name: _decoded(value) for name, value in match.groupdict().items()}


def asked_path(scope: Scope) -> str:
    """Return a request's path as it was sent."""
    raw: bytes = scope.get("raw_path") or b"/"
    return raw.decode("ascii", "replace")


def parameters(query_string: bytes) -> Query:
    """Return the query's parameters in order; raise Refused (400) if there are too many."""
    try:
        text = query_string.decode("ascii", "replace")
        return tuple(parse_qsl(text, keep_blank_values=True, max_num_fields=MOST_PARAMETERS, errors="replace"))
    except ValueError:
        raise Refused(400, f"a query may have {MOST_PARAMETERS} parameters") from None


def converted(query: Iterable[tuple[str, str]], kind: type[S]) -> S:
    """Convert a query's parameters to a Struct; raise Refused (400) for a bad or repeated one."""
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


def decoded(body: bytes, kind: type[T]) -> T:
    """Convert a JSON body to a route's type; raise Refused (400) with the faulty field."""
    try:
        return msgspec.json.decode(keyed_once(body), type=kind)
    except msgspec.ValidationError as err:
        raise Refused(400, plain(err)) from None
    except RecursionError:
        raise Refused(400, "the JSON is nested too deeply") from None
    except UNREADABLE as err:
        raise Refused(400, f"the body is not JSON: {err}") from None


def plain(err: Exception) -> str:
    """Return the fault in some data, its place first."""
    text = in_words(str(err)).replace("$(?!\\\\n)", "$")
    place = _PLACE.search(text)
    if place is None:
        return text
    said = text[: place.start()].replace("`", "'")
    return f"{place[1]}: {said}" if place[1] else said


def _decoded(text: str) -> str:
    try:
        return unquote_to_bytes(text).decode()
    except UnicodeDecodeError:
        raise Refused(400, "the path is not valid UTF-8") from None
