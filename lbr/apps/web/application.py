"""What happens to a request, in order: who and from where, which route, what it may, what it says; always answered."""

import asyncio
import sys
import time
import traceback
from collections import deque
from collections.abc import Mapping
from html import escape
from urllib.parse import quote

from starlette.types import ASGIApp, Receive, Scope, Send

from lbr.apps.http import names, peers, serving
from lbr.apps.http.pages import ANY, Pages, is_visit
from lbr.apps.http.rates import Rates
from lbr.apps.http.turns import Turns
from lbr.apps.web import routing
from lbr.apps.web.access import Access
from lbr.apps.web.face import HTML, Ask, Client, Refused, Reply, Route, json, refuse_without, text
from lbr.apps.web.routing import Table

LARGEST_BODY = 64 * 1024
BODY_S = 10.0
REGARDLESS_S = 0.2
"""So long the body of what is done regardless of it is waited for: who stops the robot does not wait for a reason."""
HANDLER_S = 20.0
TOO_OFTEN_S = 0.25
"""So long whoever asks too often waits to hear that, so that a flood leaves time for those who stop the robot."""
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
_SECURITY = {
    "Content-Security-Policy": "default-src 'none'; img-src 'self' data:; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "Referrer-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_PREFLIGHT = {
    "Access-Control-Allow-Headers": "Authorization, Content-Type, If-Match",
    "Access-Control-Max-Age": "600",
}


class Gone(Exception):  # noqa: N818 - nobody is left to answer
    """The client hung up."""


class Counts:
    """What the server counts, and what it has to tell; written by its thread, read by the loop's."""

    def __init__(self) -> None:
        self.requests = 0
        self.refused = 0
        self.clients = 0
        self.news: deque[tuple[str, str]] = deque(maxlen=64)


class Application:
    """Answers HTTP by the table, and hands WebSockets to `sockets`.

    Stops are the routes that are done `regardless`: they are never too often, and everybody at this machine may.
    """

    def __init__(
        self,
        table: Table,
        *,
        access: Access,
        pages: Pages,
        rates: Rates,
        names: frozenset[str],
        sockets: ASGIApp,
        counts: Counts,
    ) -> None:
        self._table = table
        self._access = access
        self._pages = pages
        self._rates = rates
        self._names = names
        self._sockets = sockets
        self._counts = counts
        self._turns = Turns()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, whatever it is."""
        if scope["type"] != "http":
            await self._sockets(scope, receive, send)
            return
        headers = headers_of(scope)
        self._counts.requests += 1
        try:
            reply = await self._answer(scope, headers, receive)
        except Refused as err:
            reply = refusal(err)
        except Gone:
            return
        except Exception as err:  # noqa: BLE001 - a fault in one answer must not silence the others
            traceback.print_exception(err)
            sys.stderr.flush()
            self._counts.news.append(
                ("web_fault", f"{scope['method']} {scope['path'][:80]}: {type(err).__name__}: {err}")
            )
            reply = json({"message": "this answer is broken; the robot's log says how"}, 500)
        self._counts.refused += reply.status >= 400
        await _send(send, reply, self._headers(headers, reply))

    async def _answer(self, scope: Scope, headers: dict[str, str], receive: Receive) -> Reply:
        raw = scope.get("raw_path") or b"/"
        path, method = raw.decode("ascii", "replace"), scope["method"]
        address = scope["client"][0] if scope.get("client") else ""
        found, who = self._table.find(method, path), names.who(address)
        if found is not None and found[0].regardless:
            if (connection := serving.connection_of(scope)) is not None:
                connection.mark("stopping")
            return await self._found(found, path, scope, headers, receive, address)
        if not self._rates.take(who, time.monotonic()):
            await asyncio.sleep(TOO_OFTEN_S)
            raise Refused(429, "too many requests a second from this address", {"Retry-After": "1"})
        if busy := self._turns.why_not(who):
            raise Refused(503, f"{busy} are being answered already", {"Retry-After": "1", "Connection": "close"})
        with self._turns.taken(who):
            return await self._found(found, path, scope, headers, receive, address)

    async def _found(
        self,
        found: tuple[Route, dict[str, str]] | None,
        path: str,
        scope: Scope,
        headers: dict[str, str],
        receive: Receive,
        address: str,
    ) -> Reply:
        refuse_other_hosts(headers, address, self._names)
        raw, method = scope.get("raw_path") or b"/", scope["method"]
        if len(raw) + len(scope["query_string"]) > routing.LONGEST_URL:
            raise Refused(414, f"an address may have {routing.LONGEST_URL} characters")
        if method == "OPTIONS":
            return self._options(path, headers)
        if found is None:
            return no_route(method, path)
        return await self._ask(*found, path, scope, headers, receive, address)

    async def _ask(
        self,
        route: Route,
        keys: dict[str, str],
        path: str,
        scope: Scope,
        headers: dict[str, str],
        receive: Receive,
        address: str,
    ) -> Reply:
        stranger = self._pages.stranger(headers, scope["scheme"])
        if stranger and not (route.page and is_visit(headers)):
            raise Refused(403, f"{stranger} may not ask; origins that may are the setting 'cors' of the row")
        client = await self._client(route, address, headers, scope)
        if not (route.regardless and names.is_loopback(address)):
            refuse_without(client, route.role)
        body, data = await _content(route, receive, headers)
        query = routing.parameters(scope["query_string"])
        ask = Ask(
            method=scope["method"],
            path=path,
            client=client,
            proven=bool(client.name) or self._pages.proven(headers),
            keys=keys,
            query=query,
            headers=headers,
            body=body,
            params=routing.converted(query, route.params) if route.params and not route.lenient else None,
            data=data,
        )
        if route.role is not None and not route.regardless:
            ask.require(route.role)
        try:
            async with asyncio.timeout(HANDLER_S):
                return await route.handle(ask)
        except TimeoutError:
            raise Refused(503, f"this took more than {HANDLER_S:g} s") from None

    async def _client(self, route: Route, address: str, headers: Mapping[str, str], scope: Scope) -> Client:
        """Return who asks; what is for everybody is for who shows a wrong token as well, and stops are at this machine."""
        everybody = route.role is None or (route.regardless and names.is_loopback(address))
        port = (scope.get("server") or ("", 0))[1] or 0
        try:
            owner = not everybody and "authorization" not in headers and await _is_owners(scope, address)
            return self._access.client(address, headers, port=port, owner=owner)
        except Refused:
            if not everybody:
                raise
            return Client(address)

    def _options(self, path: str, headers: Mapping[str, str]) -> Reply:
        """Answer a preflight, or just say which methods there are."""
        methods = self._table.methods(path)
        if not methods:
            return no_route("OPTIONS", path)
        allowed = ",".join(methods)
        if "access-control-request-method" not in headers:
            return text(allowed, Allow=allowed)
        if not self._pages.allows(headers.get("origin", "")):
            raise Refused(403, f"{headers.get('origin', 'this page')} is not in the setting 'cors' of the row")
        found = {**_PREFLIGHT, "Access-Control-Allow-Methods": allowed}
        if headers.get("access-control-request-private-network", "").lower() == "true":
            found["Access-Control-Allow-Private-Network"] = "true"
        return Reply(status=204, headers=found)

    def _headers(self, asked: Mapping[str, str], reply: Reply) -> dict[str, str]:
        found = dict(_SECURITY)
        origin = asked.get("origin", "")
        if origin and self._pages.allows(origin):
            found["Access-Control-Allow-Origin"] = ANY if self._pages.allows(ANY) else origin
            found["Access-Control-Expose-Headers"] = "ETag, Retry-After, WWW-Authenticate"
        if not self._pages.allows(ANY):
            found["Vary"] = "Origin"
        return {**found, **reply.headers}


def headers_of(scope: Scope) -> dict[str, str]:
    """Return a request's headers; of one that came several times, all of its values."""
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key, said = name.decode("latin-1").lower(), value.decode("latin-1")
        found[key] = f"{found[key]}, {said}" if key in found else said
    return found


def refuse_other_hosts(headers: Mapping[str, str], address: str, own: frozenset[str]) -> None:
    """Raise Refused (421) where a request from an address is for another host, or by a name that is not certain."""
    here = names.is_loopback(address)
    if not names.is_ours(headers.get("host", ""), own, loopback=here):
        how = "localhost or 127.0.0.1" if here else "its address or its name"
        raise Refused(421, f"ask for this robot by {how}, or name this host in the setting 'names' of its row")


async def _is_owners(scope: Scope, address: str) -> bool:
    """Say whether the robot's own user asks; looked up once for a connection, beside the server's thread."""
    connection = serving.connection_of(scope)
    if connection is None or not names.is_loopback(address):
        return False
    if connection.owner is None:
        owners = await asyncio.to_thread(peers.is_owners, scope["client"], scope["server"])
        connection.owner = owners and connection.is_held
    return connection.owner


def refusal(err: Refused) -> Reply:
    """Return a refusal as an answer."""
    return json({"message": err.message}, err.status, **err.headers)


def no_route(method: str, path: str) -> Reply:
    """Return the page that Express shows for what it does not know."""
    shown = escape(f"Cannot {method} {quote(path, safe='/%:@!$&()*+,;=~-._')}", quote=True)
    return text(NO_ROUTE.format(shown), 404, HTML, **{"Content-Security-Policy": "default-src 'none'"})


async def _content(route: Route, receive: Receive, headers: Mapping[str, str]) -> tuple[bytes, object]:
    """Return a body, and what it says."""
    if not route.regardless:
        body = await _body(receive, headers)
        return body, _data(route, headers, body)
    if route.body is None:
        return b"", None
    try:
        async with asyncio.timeout(REGARDLESS_S):
            body = await _body(receive, headers)
        return body, routing.decoded(body, route.body) if body else None
    except (Refused, TimeoutError, Gone):
        return b"", None


def _data(route: Route, headers: Mapping[str, str], body: bytes) -> object:
    if route.body is None or route.lenient:
        return None
    if not body:
        if route.body_required:
            raise Refused(400, "this needs a body: JSON")
        return None
    media = headers.get("content-type", "").partition(";")[0].strip().lower()
    if media != "application/json":
        raise Refused(415, f"the body must be JSON, 'Content-Type: application/json', not '{media[:80]}'")
    return routing.decoded(body, route.body)


async def _body(receive: Receive, headers: Mapping[str, str]) -> bytes:
    too_much = Refused(413, f"a body may have {LARGEST_BODY} bytes", {"Connection": "close"})
    length = headers.get("content-length", "0")
    if length.isdigit() and int(length[:12]) > LARGEST_BODY:
        raise too_much
    parts: list[bytes] = []
    size = 0
    try:
        async with asyncio.timeout(BODY_S):
            while True:
                message = await receive()
                if message["type"] == "http.disconnect":
                    raise Gone
                parts.append(message.get("body", b""))
                size += len(parts[-1])
                if size > LARGEST_BODY:
                    raise too_much
                if not message.get("more_body", False):
                    return b"".join(parts)
    except TimeoutError:
        raise Refused(408, f"the body did not come within {BODY_S:g} s", {"Connection": "close"}) from None


async def _send(send: Send, reply: Reply, headers: Mapping[str, str]) -> None:
    media = (
        reply.media if "charset" in reply.media or reply.media.startswith("image/") else f"{reply.media}; charset=utf-8"
    )
    bare = reply.status == 204
    sent = dict(headers) if bare else {"Content-Type": media, "Content-Length": str(len(reply.body)), **headers}
    await send(
        {
            "type": "http.response.start",
            "status": reply.status,
            "headers": [(name.lower().encode("latin-1"), value.encode("latin-1")) for name, value in sent.items()],
        }
    )
    await send({"type": "http.response.body", "body": b"" if bare else reply.body})
