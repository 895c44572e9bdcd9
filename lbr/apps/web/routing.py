"""Finds the route that answers a request, and what it takes out of it. Pure.

Paths are found as widespread servers do: letters in either case, and with or without a slash at the end. They are
compared as they were written: what is hidden behind percent signs is another path.
"""

import re
from collections.abc import Awaitable, Callable, Iterable
from typing import Any
from urllib.parse import parse_qsl, unquote_to_bytes

import msgspec
from msgspec import Struct
from starlette.responses import Response
from starlette.routing import BaseRoute, Match, compile_path
from starlette.types import Receive, Scope, Send

from lbr.apps.web.contract import contract
from lbr.apps.web.face import Query, Refused, Route
from lbr.messages.in_words import in_words
from lbr.messages.unreadable import UNREADABLE, keyed_once

MOST_PARAMETERS = 64
_PLACE = re.compile(r" - at `\$(?:\.([^`]*))?`\Z")


class Path:
    """A path in Starlette's language, such as `/motion/{key}`, as it came: percent signs and all.

    A key such as `{rest:path}` is all that follows, slashes too, or nothing.
    """

    def __init__(self, path: str) -> None:
        written = compile_path(path.rstrip("/"))[0].pattern.removesuffix("$")
        self._pattern = re.compile(f"{written}/?", re.IGNORECASE)

    def fits(self, path: str) -> bool:
        """Say whether an asked path is this one."""
        return self._pattern.fullmatch(path) is not None

    def keys(self, path: str) -> dict[str, str]:
        """Return the keys in an asked path; Refused (400) for what is no text."""
        match = self._pattern.fullmatch(path)
        return {} if match is None else {name: _decoded(value) for name, value in match.groupdict().items()}


class Endpoint(BaseRoute):
    """A declared route among Starlette's: `answer` is asked whatever fits it. HEAD is answered as GET."""

    def __init__(self, route: Route, answer: "Answer") -> None:
        self.route = route
        self.path = Path(route.path)
        self.contract = contract(route)
        self._methods = {"GET", "HEAD"} if route.method == "GET" else {route.method}
        self._accept = route.accept.encode()
        self._answer = answer

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Say whether a request is for this route, and which keys its path has."""
        if scope["type"] != "http" or scope["method"] not in self._methods or not self.path.fits(asked_path(scope)):
            return Match.NONE, {}
        if self._accept and not _accepts(scope, self._accept):
            return Match.NONE, {}
        return Match.FULL, {"path_params": self.path.keys(asked_path(scope))}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        response = await self._answer(self, scope, receive)
        await response(scope, receive, send)


Answer = Callable[[Endpoint, Scope, Receive], Awaitable[Response]]


def _accepts(scope: Scope, media: bytes) -> bool:
    """Say whether a request names a media type itself; `*/*` names none."""
    said = (value.lower() for name, value in scope["headers"] if name.lower() == b"accept")
    return any(part.partition(b";")[0].strip() == media for value in said for part in value.split(b","))


def asked_path(scope: Scope) -> str:
    """Return a request's path as it came."""
    raw: bytes = scope.get("raw_path") or b"/"
    return raw.decode("ascii", "replace")


def methods(endpoints: Iterable[Endpoint], path: str) -> tuple[str, ...]:
    """Return the methods that a path has."""
    there = {endpoint.route.method for endpoint in endpoints if endpoint.path.fits(path)}
    return tuple(sorted(there | ({"HEAD"} if "GET" in there else set())))


def parameters(query_string: bytes) -> Query:
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


def decoded(body: bytes, kind: Any) -> Any:
    """Return a JSON body as what a route takes; Refused (400) says where it does not fit."""
    try:
        return msgspec.json.decode(keyed_once(body), type=kind)
    except msgspec.ValidationError as err:
        raise Refused(400, plain(err)) from None
    except RecursionError:
        raise Refused(400, "the JSON is nested too deeply") from None
    except UNREADABLE as err:
        raise Refused(400, f"the body is not JSON: {err}") from None


def plain(err: Exception) -> str:
    """Return what is wrong with some data, the place first."""
    text = in_words(str(err)).replace("$(?!\\\\n)", "$")
    found = _PLACE.search(text)
    if found is None:
        return text
    said = text[: found.start()].replace("`", "'")
    return f"{found[1]}: {said}" if found[1] else said


def _decoded(text: str) -> str:
    try:
        return unquote_to_bytes(text).decode()
    except UnicodeDecodeError:
        raise Refused(400, "the path is not valid UTF-8") from None
