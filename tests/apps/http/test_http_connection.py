"""HTTP/1.1 as the server speaks it, byte for byte, for an app that is nothing but its paths."""

import asyncio
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.types import Receive, Scope, Send

from lbr.apps.http import listening
from lbr.apps.http import serving as serving_
from lbr.apps.http.serving import Server
from tests.support.waiting import HANG_S, until


class App:
    """Echoes; `go_on` is what slow answers wait for."""

    def __init__(self) -> None:
        self.go_on = threading.Event()
        self.left: list[str] = []

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        request = Request(scope, receive)
        await (await getattr(self, request.url.path.strip("/") or "echo")(request))(scope, receive, send)

    async def echo(self, request: Request) -> Response:
        body = await request.body()
        return PlainTextResponse(f"{request.method} {request.url.query} {len(body)};")

    async def late(self, request: Request) -> Response:
        await asyncio.to_thread(self.go_on.wait)
        return await self.echo(request)

    async def unread(self, _request: Request) -> Response:
        return PlainTextResponse("unread;")

    async def chunks(self, _request: Request) -> Response:
        return StreamingResponse(iter([b"a" * 100_000, b"b" * 100_000]))

    async def broken(self, _request: Request) -> Response:
        raise ZeroDivisionError

    async def half(self, _request: Request) -> Response:
        return PlainTextResponse("half", headers={"content-length": "9"})

    async def waits(self, request: Request) -> Response:
        try:
            await request.body()
        except ClientDisconnect:
            self.left.append(request.url.query)
            raise
        return PlainTextResponse("whole;")


@contextmanager
def serving() -> Iterator[tuple[App, Server, int]]:
    app, (sock, *more) = App(), listening.listen("127.0.0.1", 0)
    server, port = Server(app, tls=False), sock.getsockname()[1]
    thread = threading.Thread(target=lambda: asyncio.run(server.serve([sock, *more])))
    thread.start()
    try:
        yield app, server, port
    finally:
        app.go_on.set()
        server.leave()
        thread.join(5.0)
        assert not thread.is_alive()


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[App, Server, int]]:
    with serving() as found:
        yield found


def said(port: int, sent: bytes) -> bytes:
    with socket.create_connection(("127.0.0.1", port), timeout=8) as client:
        client.sendall(sent)
        return b"".join(iter(lambda: client.recv(65536), b""))


def request(method: bytes, target: bytes, *headers: bytes, body: bytes = b"") -> bytes:
    lines = [method + b" " + target + b" HTTP/1.1", b"Host: x", *headers]
    return b"\r\n".join([*lines, *([b"Content-Length: %d" % len(body)] if body else []), b"", body])


END = b"Connection: close"


@pytest.mark.parametrize(
    ("sent", "status", "answer"),
    [
        (request(b"GET", b"/?a", END), b"200", b"GET a 0;"),
        (request(b"HEAD", b"/", END), b"200", b"content-length: 8"),
        (request(b"POST", b"/", END, body=b"x" * 400_000), b"200", b"POST  400000;"),
        (request(b"GET", b"http://x/?a", END), b"200", b"GET a 0;"),
        (b"GET / HTTP/1.0\r\n\r\n", b"200", b"GET  0;"),
        (request(b"POST", b"/", b"Transfer-Encoding: chunked", END) + b"3\r\nabc\r\n0\r\n\r\n", b"200", b"POST  3;"),
        (request(b"POST", b"/", b"Transfer-Encoding: chunked", END) + b"nonsense\r\n", b"400", b"Invalid HTTP request"),
        (b"nonsense\r\n\r\n", b"400", b"Invalid HTTP request"),
        (b"GET / HTTP/1.1\r\nX: " + b"y" * 20_000, b"400", b"Invalid HTTP request"),
    ],
)
def test_a_request_is_answered_once(served, sent, status, answer):
    found = said(served[2], sent)
    assert found.count(b"HTTP/1.1 ") == 1
    assert found.startswith(b"HTTP/1.1 " + status)
    assert answer in found
    assert b"date: " in found or status == b"400"


def test_requests_that_come_at_once_are_answered_in_their_order(served):
    sent = request(b"POST", b"/?1", body=b"abc") + request(b"GET", b"/unread?2") + request(b"GET", b"/?3", END)
    found = said(served[2], sent)
    assert [found.find(one) > 0 for one in (b"POST 1 3;", b"unread;", b"GET 3 0;")] == [True, True, True]
    assert found.find(b"POST 1 3;") < found.find(b"unread;") < found.find(b"GET 3 0;")


def test_an_answer_of_unknown_length_comes_in_chunks(served):
    found = said(served[2], request(b"GET", b"/chunks", END))
    assert b"transfer-encoding: chunked" in found.lower()
    assert (found.count(b"a" * 1000), found.count(b"b" * 1000)) == (100, 100)
    assert found.endswith(b"0\r\n\r\n")


@pytest.mark.parametrize(("path", "begins"), [(b"/broken", b""), (b"/half", b"HTTP/1.1 200")])
def test_an_answer_that_is_not_whole_is_cut_off(served, path, begins):
    found = said(served[2], request(b"GET", path))
    assert found.startswith(begins)
    assert bool(found) is bool(begins)


@pytest.mark.parametrize(("path", "invited"), [(b"/", True), (b"/unread", False)])
def test_a_body_is_invited_once_the_app_reads_it(served, path, invited):
    with socket.create_connection(("127.0.0.1", served[2]), timeout=8) as client:
        client.sendall(request(b"POST", path, b"Expect: 100-continue", b"Content-Length: 3", END))
        assert client.recv(4096).startswith(b"HTTP/1.1 100" if invited else b"HTTP/1.1 200")


def test_who_leaves_before_the_body_is_whole_is_told_to_the_app(served):
    app, _, port = served
    with socket.create_connection(("127.0.0.1", port), timeout=8) as client:
        client.sendall(request(b"POST", b"/waits?gone", b"Content-Length: 9") + b"abc")
    until(lambda: app.left == ["gone"])


def test_a_server_that_ends_finishes_what_it_answers_and_closes_what_is_idle(monkeypatch):
    monkeypatch.setattr(serving_, "GRACE_S", HANG_S)
    with serving() as (app, server, port), socket.create_connection(("127.0.0.1", port), timeout=8) as busy:
        busy.sendall(request(b"GET", b"/late"))
        with socket.create_connection(("127.0.0.1", port), timeout=8) as idle:
            until(lambda: len(server.slots) == 2)
            server.leave()
            assert idle.recv(10) == b""
        app.go_on.set()
        found = b"".join(iter(lambda: busy.recv(65536), b""))
        assert b"GET  0;" in found
