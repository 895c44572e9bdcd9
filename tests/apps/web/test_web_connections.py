"""Connections that ask nothing, half of something or too slowly, and who wants to stop the robot meanwhile."""

import gc
import socket
import ssl
import time
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from lbr.apps.http import slots
from lbr.apps.http.slots import LIMIT_S
from lbr.apps.http.turns import MOST_OF_ONE
from lbr.apps.web import guards, viewing
from tests.apps.web.test_web_access import FINGERPRINT, SECRET, user
from tests.apps.web.test_web_server import Plain
from tests.apps.web.web_stage import UPGRADE, Served, serving
from tests.support.waiting import HANG_S, until

STOP = b"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
CHUNKED = b"POST %s HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
VIEW = UPGRADE % b"/ws" + b"\r\n"
PING = b"\x89\x80\0\0\0\0"
MANY = slots.MOST + 16
BURDENS = {
    "idle": b"",
    "half a line": b"GE",
    "half a head": b"GET /state HTTP/1.1\r\nHost: localhost\r\nX-",
    "half a body": b"POST /estop/reset HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{",
    "half a stop": b"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{",
    "half an estop": b"POST /estop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{",
    "answered, and kept open": b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "pieces of a byte": CHUNKED % b"/estop/reset" + 1500 * b"1\r\nx\r\n",
    "pieces behind a stop": CHUNKED % b"/stop" + 1500 * b"1\r\nx\r\n",
    "not a WebSocket": VIEW.replace(b"Version: 13", b"Version: 1"),
}


@pytest.fixture
def served() -> Iterator[Served]:
    with serving(Plain(), requests_per_s=4000.0) as found:
        yield found


@contextmanager
def burdened(port: int, sent: bytes, count: int) -> Iterator[list[socket.socket]]:
    with ExitStack() as stack:
        held = [
            stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=HANG_S)) for _ in range(count)
        ]
        for one in held:
            with suppress(ConnectionError):
                one.sendall(sent)
        yield held


def stopped(port: int) -> bytes:
    with socket.create_connection(("127.0.0.1", port), timeout=HANG_S) as client:
        client.sendall(STOP)
        return client.recv(4096)


@pytest.mark.parametrize("first", [b"", b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"], ids=["alone", "second"])
def test_nothing_is_taken_for_a_request_behind_one_of_two_lengths(served, first):
    doubtful = (
        b"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", served.port), timeout=HANG_S) as client:
        client.sendall(first + doubtful + b"GET /state HTTP/1.1\r\nHost: localhost\r\n\r\n")
        answers = b""
        while said := client.recv(65536):
            answers += said
    assert answers.count(b"HTTP/1.1 200") == 1 + bool(first)
    assert answers.count(b"HTTP/1.1") == 1 + bool(first)


@pytest.mark.parametrize("sent", BURDENS.values(), ids=BURDENS)
def test_whoever_wants_to_stop_is_answered_whatever_others_hold_open(served, sent):
    with burdened(served.port, sent, MANY):
        for _ in range(5):
            assert stopped(served.port).startswith(b"HTTP/1.1 200")
        until(lambda: served.connections <= slots.MOST + 1)


def test_forty_idle_connections_of_one_address_are_no_reason_to_refuse_anything(served):
    with burdened(served.port, b"", 40):
        assert served.ask("GET", "/move").status == 200
        assert served.ask("POST", "/stop").status == 200


def test_half_a_head_is_given_up_after_two_seconds_and_a_byte_now_and_then_does_not_help(served):
    with burdened(served.port, b"GET / HTTP/1.1\r\nX: ", 1) as (slow,):
        began = time.monotonic()
        slow.settimeout(0.1)

        def is_cut() -> bool:
            try:
                slow.sendall(b"y")
                return slow.recv(1) == b""
            except TimeoutError:
                return False
            except ConnectionError:
                return True

        until(is_cut)
        assert time.monotonic() - began >= LIMIT_S["head"]


def test_what_is_idle_is_closed(served, monkeypatch):
    monkeypatch.setitem(slots.LIMIT_S, "idle", 0.05)
    assert served.raw(b"") == b""


def test_requests_under_way_are_bounded_for_one_asker_and_stops_are_not(served):
    with burdened(served.port, BURDENS["half a body"], MOST_OF_ONE):
        until(lambda: served.ask("GET", "/state").status == 503, what="an asker with too much under way")
        assert served.ask("POST", "/stop").status == 200
        assert served.ask("POST", "/estop").json["engaged"]


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"%x\r\n%s\r\n0\r\n\r\n" % (70_000, 70_000 * b" "), b"413"),
        (1500 * b"1\r\n \r\n" + b"0\r\n\r\n", b"400"),
        (b"zz\r\n", b"400"),
    ],
    ids=["too large", "too many pieces", "not framed"],
)
def test_a_body_that_is_too_much_is_refused_and_is_no_fault_of_the_server(served, body, status, capfd):
    for path in (b"/estop/reset", b"/docs"):
        with socket.create_connection(("127.0.0.1", served.port), timeout=HANG_S) as client:
            client.sendall(CHUNKED % path + body)
            assert client.recv(65536).startswith(b"HTTP/1.1 ")
    with socket.create_connection(("127.0.0.1", served.port), timeout=HANG_S) as client:
        client.sendall(CHUNKED % b"/estop/reset" + body)
        assert client.recv(65536).startswith(b"HTTP/1.1 " + status)
    assert not [event for event in served.stage.events if event[0] == "web_fault"]
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize("more", [b"zz\r\n", 50 * b"1\r\n \r\n", b"8000\r\n" + bytes(0x8000) + b"\r\n"])
def test_a_stop_is_done_and_answered_and_what_its_body_goes_on_with_is_bounded(served, more, capfd):
    with socket.create_connection(("127.0.0.1", served.port), timeout=HANG_S) as client:
        client.sendall(CHUNKED % b"/stop")
        assert client.recv(65536).startswith(b"HTTP/1.1 200")

        def is_cut() -> bool:
            try:
                client.sendall(more)
            except OSError:
                return True
            return False

        until(is_cut)
    assert "halt" in {request for request, _ in served.stage.asked}
    assert "Traceback" not in capfd.readouterr().err


def test_those_who_ask_to_watch_count_until_they_do(monkeypatch):
    monkeypatch.setattr(guards, "TOO_OFTEN_S", 2.0)
    with serving(Plain(), requests_per_s=1.0) as served, burdened(served.port, VIEW, MANY):
        until(lambda: served.connections >= slots.MOST)
        assert stopped(served.port).startswith(b"HTTP/1.1 200")
        assert served.connections <= slots.MOST + viewing.MOST_OF_ONE


def test_a_viewer_who_sends_nothing_but_pings_is_cut(served):
    with burdened(served.port, VIEW, viewing.MOST_OF_ONE) as viewers:
        for one in viewers:
            assert one.recv(65536).startswith(b"HTTP/1.1 101")
        for one in viewers:
            with suppress(ConnectionError):
                one.sendall(20_000 * PING)
        assert stopped(served.port).startswith(b"HTTP/1.1 200")
        until(lambda: served.connections <= 1, what="they are cut")


def test_one_asker_cannot_take_every_place_to_watch():
    with serving(users=(user("ann", "view"), user("bob", "view"))) as served, ExitStack() as stack:
        url = f"ws://127.0.0.1:{served.port}/ws"

        def watch(name: str = "") -> None:
            protocols = ["lbr.state", f"bearer.{name}.{SECRET}.{FINGERPRINT}"] if name else None
            viewer = stack.enter_context(connect(url, subprotocols=protocols, max_queue=None))
            assert viewer.subprotocol == ("lbr.state" if name else None)
            viewer.recv(timeout=HANG_S)

        for _ in range(viewing.MOST_OF_ONE):
            watch()
        with pytest.raises(InvalidStatus) as refused:
            watch()
        assert refused.value.response.status_code == 503
        for _ in range(viewing.MOST_VIEWERS - viewing.MOST_OF_ONE):
            watch("ann")
        with pytest.raises(InvalidStatus):
            watch("bob")  # all places are taken, by two
        assert served.ask("POST", "/stop").status == 200


def test_where_tls_is_spoken_silence_and_half_a_greeting_deny_nobody(monkeypatch, tmp_path):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    with serving(Plain(), host="0.0.0.0") as served:

        def answer() -> bytes:
            plain = socket.create_connection(("127.0.0.1", served.port), timeout=HANG_S)
            with plain, context.wrap_socket(plain) as secure:
                secure.sendall(STOP)
                return secure.recv(4096)

        for sent in (b"", b"\x16\x03\x01\x02\x00\x01"):
            with burdened(served.port, sent, MANY) as held:
                assert answer().startswith(b"HTTP/1.1 200")
                until(lambda: served.connections <= 1, what="room again")
                assert held[-1].recv(1) == b""
    with warnings.catch_warnings(action="ignore", category=ResourceWarning):
        gc.collect()  # asyncio closes no transport whose greeting was never complete


@pytest.mark.parametrize(("settings", "status"), [({"host": "0.0.0.0"}, 200), ({"tls": True}, 307)])
def test_without_tls_this_machine_is_served_as_before_and_others_are_led_to_https(
    monkeypatch, tmp_path, settings, status
):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    with serving(Plain(), **settings) as served:
        answer = served.ask("GET", "/state?a=b")
        assert answer.status == status
        if status == 307:
            assert answer.headers["location"] == f"https://127.0.0.1:{served.port}/state?a=b"
            with burdened(served.port, VIEW, 1) as (page,):
                assert page.recv(4096).startswith(b"HTTP/1.1 307")
