"""The application: its routes behind their guards, and for each request its client, rights, and response."""

import asyncio
from collections.abc import Callable, Coroutine, Iterable, Iterator, Mapping
from dataclasses import replace
from html import escape
from math import inf
from typing import Any, Protocol
from urllib.parse import quote

from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect
from starlette.requests import Request as Received
from starlette.responses import Response
from starlette.routing import BaseRoute, Match, Router
from starlette.types import Receive, Scope, Send

from lbr.apps.http import names, peers
from lbr.apps.http.connection import connection_of
from lbr.apps.http.pages import Pages, is_visit
from lbr.apps.http.rates import Rates
from lbr.apps.web import routing
from lbr.apps.web.contract import Contract, contract, response
from lbr.apps.web.face import HTML, Client, Refused, Request, Route, refuse_unknown, refuse_without, text
from lbr.apps.web.guards import CAME, Answering, Counts, Hosts, Limits, address_of, headers_of
from lbr.apps.web.page.files import pack, takes_gzip
from lbr.apps.web.routing import Path, asked_path

LARGEST_BODY = 64 * 1024
BODY_S = 10.0
REGARDLESS_S = 0.2
"""The wait for the body of a stop, which is done without it: a stop does not wait for a reason."""
NO_ROUTE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Error</title>
</head>
<body>
<pre>{}</pre>
</body>
</html>
"""
_PREFLIGHT = {
    "Access-Control-Allow-Headers": "Authorization, Content-Type, If-Match",
    "Access-Control-Max-Age": "600",
}
InLoop = Callable[..., Coroutine[Any, Any, Response]]


class Knows(Protocol):
    """Identifies clients."""

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
        """Return the client; raise Refused (401) for an invalid token."""


class Gate:
    """Identifies the client of a request, and admits or refuses it."""

    def __init__(self, access: Knows, pages: Pages) -> None:
        self._access = access
        self._pages = pages

    def refuse_strangers(self, scope: Scope, headers: Mapping[str, str], *, visit: bool = False) -> None:
        """Raise Refused (403) for a request by a foreign page; a `visit`, a link that a user follows, is allowed."""
        scheme = "https" if scope["scheme"] in {"https", "wss"} else "http"
        stranger = self._pages.stranger(headers, scheme)
        if stranger and not visit:
            raise Refused(
                403, f"{stranger} may not ask; origins that may are the setting 'cors' of the row", code="denied"
            )

    def allows(self, origin: str) -> bool:
        """Return whether pages of an origin may send requests."""
        return self._pages.allows(origin)

    async def client(
        self, scope: Scope, headers: Mapping[str, str], token: str = "", *, owner: bool = False, signs_in: bool = False
    ) -> Client:
        """Return the client; raise Refused (401) for an invalid token.

        With `owner`, a program of the robot's own user on this machine is its owner, unless it sends a token. With
        `signs_in`, the program's user is looked up even without a cookie.
        """
        address, port = address_of(scope), (scope.get("server") or ("", 0))[1] or 0
        owner = owner and not token and "authorization" not in headers and names.is_loopback(address)
        whose = await _whose(scope) if owner or signs_in or "cookie" in headers else None
        owner = owner and peers.is_own(whose)
        client = self._access.client(address, headers, token, port=port, owner=owner, whose=whose)
        return replace(client, whose=whose)

    async def arguments(self, endpoint: "Endpoint", scope: Scope, receive: Receive) -> dict[str, object]:
        """Return the handler's arguments for an allowed request; raise Refused for any other."""
        route, promised, headers = endpoint.route, endpoint.contract, headers_of(scope)
        self.refuse_strangers(scope, headers, visit=route.page and is_visit(headers))
        signs_in = route.role == "known" or "whose" in promised.takes
        client = await self._client_of(route, scope, headers, signs_in=signs_in)
        if not (route.stops is True and names.is_loopback(client.address)):
            refuse_without(client, route.least)
        if route.role == "known":
            refuse_unknown(client)
        body, data = await _content(endpoint, scope, receive, headers)
        query = routing.parameters(scope["query_string"])
        request = Request(
            method=scope["method"],
            path=asked_path(scope),
            client=client,
            came_s=scope.get(CAME, inf),
            proven=bool(client.name) or self._pages.proven(headers),
            query=query,
            headers=headers,
            body=body,
        )
        given = {"request": request, "client": client, "whose": client.whose, "query": query, **scope["path_params"]}
        given["body"] = data if promised.decodes else body
        if promised.reads and promised.params is not None:
            given["params"] = routing.converted(query, promised.params)
        if route.least is not None and route.stops is not True:
            request.require(route.least)
        return {name: given[name.removesuffix("_")] for name in promised.takes}

    async def _client_of(self, route: Route, scope: Scope, headers: Mapping[str, str], *, signs_in: bool) -> Client:
        """Return the client.

        An invalid token is ignored if the route is for everybody, as stops on this machine are.
        """
        address = address_of(scope)
        everybody = route.role is None or (route.stops is True and names.is_loopback(address))
        try:
            return await self.client(scope, headers, owner=not everybody, signs_in=signs_in)
        except Refused:
            if not everybody:
                raise
            return Client(address)


class Endpoint(BaseRoute):
    """A declared route as a route of Starlette. HEAD is treated as GET."""

    def __init__(self, route: Route, gate: Gate, in_loop: InLoop) -> None:
        self.route = route
        self.path = Path(route.path)
        self.contract = contract(route)
        self._methods = {"GET", "HEAD"} if route.method == "GET" else {route.method}
        self._accept = route.accept.encode()
        self._gate = gate
        self._in_loop = in_loop

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Return whether a request matches this route, and the keys of its path."""
        if scope["type"] != "http" or scope["method"] not in self._methods or not self.path.fits(asked_path(scope)):
            return Match.NONE, {}
        if self._accept and not _accepts(scope, self._accept):
            return Match.NONE, {}
        return Match.FULL, {"path_params": self.path.keys(asked_path(scope))}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        try:
            answer = await self._answer(await self._gate.arguments(self, scope, receive))
        except Refused as err:
            answer = self.route.refused(err)
        if scope["method"] == "GET" and takes_gzip(headers_of(scope).get("accept-encoding", "")):
            pack(answer)
        await answer(scope, receive, send)

    async def _answer(self, arguments: Mapping[str, object]) -> Response:
        async def answer() -> Response:
            return response(await self.route.handle(**arguments))

        if self.contract.waits:
            return await self._in_loop(answer(), timeout_s=self.route.within_s)
        return response(self.route.handle(**arguments))


def application(
    routes: Iterable[Route],
    *sockets: BaseRoute,
    gate: Gate,
    pages: Pages,
    rates: Rates,
    own_names: frozenset[str],
    counts: Counts,
    in_loop: InLoop,
    names_are: str = "in the setting 'names' of its row",
) -> Router:
    """Return the application: all routes behind their guards. `in_loop` runs the handlers that are coroutines."""

    async def otherwise(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket":
            raise Refused(404, f"there is no WebSocket at {scope['path'][:80]}")
        found = _options(scope, endpoints, gate) if scope["method"] == "OPTIONS" else no_route(scope, endpoints)
        await found(scope, receive, send)

    closest = sorted(_also_for_all(routes), key=lambda route: (not route.accept, route.path.count("{")))
    endpoints = [Endpoint(route, gate, in_loop) for route in closest]
    stops = [endpoint for endpoint in endpoints if endpoint.route.stops is True]
    return Router(
        [*endpoints, *sockets],
        redirect_slashes=False,
        default=otherwise,
        middleware=[
            Middleware(Answering, pages=pages, counts=counts),
            Middleware(
                Limits, rates=rates, is_stop=lambda scope: any(s.matches(scope)[0] is Match.FULL for s in stops)
            ),
            Middleware(Hosts, own=own_names, where=names_are),
        ],
    )


def methods(endpoints: Iterable[Endpoint], path: str) -> tuple[str, ...]:
    """Return the methods of a path, sorted."""
    declared = {endpoint.route.method for endpoint in endpoints if endpoint.path.fits(path)}
    return tuple(sorted(declared | ({"HEAD"} if "GET" in declared else set())))


def _accepts(scope: Scope, media: bytes) -> bool:
    """Return whether a request names a media type itself; `*/*` does not count."""
    values = (value.lower() for name, value in scope["headers"] if name.lower() == b"accept")
    return any(part.partition(b";")[0].strip() == media for value in values for part in value.split(b","))


def _also_for_all(routes: Iterable[Route]) -> Iterator[Route]:
    """Yield the routes; a route for a media type serves every client if its path has no other."""
    every = list(routes)
    taken = {(route.method, route.path) for route in every if not route.accept}
    for route in every:
        yield route
        if route.accept and (route.method, route.path) not in taken:
            yield replace(route, accept="")


def no_route(scope: Scope, endpoints: Iterable[Endpoint]) -> Response:
    """Return Express's page for an unknown path; raise Refused below `/api`."""
    if f"{asked_path(scope).lower()}/".startswith("/api/"):
        allowed = methods(endpoints, asked_path(scope))
        instead = f"it takes {', '.join(allowed)}" if allowed else "GET /api and /openapi.json name what there is"
        raise Refused(404, f"there is no {scope['method']} {asked_path(scope)[:80]}; {instead}")
    path = quote(asked_path(scope), safe="/%:@!$&()*+,;=~-._")
    shown = escape(f"Cannot {scope['method']} {path}", quote=True)
    return text(NO_ROUTE.format(shown), 404, HTML, **{"Content-Security-Policy": "default-src 'none'"})


def _options(scope: Scope, endpoints: Iterable[Endpoint], gate: Gate) -> Response:
    """Answer a preflight, or return the methods of the path."""
    headers, allowed = headers_of(scope), ",".join(methods(endpoints, asked_path(scope)))
    if not allowed:
        return no_route(scope, endpoints)
    if "access-control-request-method" not in headers:
        return text(allowed, Allow=allowed)
    if not gate.allows(headers.get("origin", "")):
        raise Refused(
            403, f"{headers.get('origin', 'this page')} is not in the setting 'cors' of the row", code="denied"
        )
    answer = {**_PREFLIGHT, "Access-Control-Allow-Methods": allowed}
    if headers.get("access-control-request-private-network", "").lower() == "true":
        answer["Access-Control-Allow-Private-Network"] = "true"
    return Response(status_code=204, headers=answer)


async def _whose(scope: Scope) -> str | None:
    """Return the user of the client's program; looked up once for each connection, on another thread."""
    connection = connection_of(scope)
    if connection is None:
        return None
    if connection.whose is None:
        whose = await asyncio.to_thread(peers.whose, scope["client"], scope["server"])
        connection.whose = whose if connection.is_held else None
    return connection.whose


async def _content(
    endpoint: Endpoint, scope: Scope, receive: Receive, headers: Mapping[str, str]
) -> tuple[bytes, object]:
    """Return a body, as bytes and decoded."""
    promised, stops = endpoint.contract, endpoint.route.stops
    if stops is not True:
        body, left = await _body(scope, receive, headers)
        data = _data(promised, headers, body)
        if left and not (callable(stops) and stops({**scope["path_params"], "body": data})):
            raise ClientDisconnect
        return body, data
    if not promised.decodes:
        return b"", None
    try:
        async with asyncio.timeout(REGARDLESS_S):
            body, _left = await _body(scope, receive, headers)
        return body, routing.decoded(body, promised.body) if body else None
    except (Refused, TimeoutError, ClientDisconnect):
        return b"", None


def _data(promised: Contract, headers: Mapping[str, str], body: bytes) -> object:
    if not promised.decodes:
        return None
    if not body:
        if promised.body_required:
            raise Refused(400, "this needs a body: JSON")
        return None
    media = headers.get("content-type", "").partition(";")[0].strip().lower()
    if media != "application/json":
        raise Refused(415, f"the body must be JSON, 'Content-Type: application/json', not '{media[:80]}'")
    return routing.decoded(body, promised.body)


async def _body(scope: Scope, receive: Receive, headers: Mapping[str, str]) -> tuple[bytes, bool]:
    """Return a whole body, and whether its sender has left; raise ClientDisconnect for an incomplete body."""
    too_much = Refused(413, f"a body may have {LARGEST_BODY} bytes", {"Connection": "close"})
    length = headers.get("content-length", "0")
    if length.isdigit() and int(length[:12]) > LARGEST_BODY:
        raise too_much
    body = bytearray()
    try:
        async with asyncio.timeout(BODY_S):
            async for part in Received(scope, receive).stream():
                body += part
                if len(body) > LARGEST_BODY:
                    raise too_much
    except TimeoutError:
        raise Refused(408, f"the body did not come within {BODY_S:g} s", {"Connection": "close"}) from None
    connection = connection_of(scope)
    return bytes(body), connection is not None and connection.has_left
