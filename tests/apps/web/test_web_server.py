import asyncio
import gzip
import select
import socket
import ssl
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from starlette.responses import Response
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from lbr import disk, home, qr
from lbr.apps.http import slots
from lbr.apps.web import application
from lbr.apps.web.addresses import url
from lbr.apps.web.advertised_address import AdvertisedAddress
from lbr.apps.web.announce import Announcer
from lbr.apps.web.face import Face, get, text
from lbr.apps.web.guards import TOO_OFTEN_S
from lbr.apps.web.kind import WebSettings
from lbr.console.printable import wrapped
from lbr.errors import DeviceError
from lbr.messages.faces import EditReply, Motor
from lbr.messages.joints import JointsState
from lbr.messages.leases import CommandReply
from tests.apps.web.web_stage import UPGRADE, Served, ending, serving
from tests.support.waiting import HANG_S, until

JOINTS = JointsState(sequence=1, measured_s=0.0, moving=False, phase="ready", joints={})


class Plain(Face):
    """A face that answers, moves, breaks and hangs."""

    name = "plain"

    def __init__(self) -> None:
        self.stops: list[str] = []

    def stopped(self, reason: str) -> None:
        self.stops.append(reason)

    def state(self) -> dict[str, int]:
        return {"jobs": 0}

    @get("/", role=None, page=True)
    async def _ok(self) -> Response:
        return text("OK")

    @get("/move", role="operate")
    async def _move(self) -> Response:
        return text("moved")

    @get("/broken")
    async def _broken(self) -> Response:
        raise ZeroDivisionError


@pytest.fixture(scope="module")
def face() -> Plain:
    return Plain()


@pytest.fixture(scope="module")
def served(face) -> Iterator[Served]:
    with serving(face, cors=("http://app:8081",), names=("robot.example.org",), requests_per_s=4000.0) as found:
        yield found


def test_pages_and_states_are_served(served):
    served.stage.say("joints", JOINTS)
    assert served.ask("GET", "/").body == b"OK"
    state = until(lambda: (found := served.ask("GET", "/state").json)["joints"] and found)
    assert state["robot"] == "uxa90"
    assert state["joints"]["phase"] == "ready"
    assert state["age_s"]["joints"] >= 0
    assert state["faces"] == {"plain": {"jobs": 0}}
    assert "server" not in served.ask("GET", "/").headers


def test_a_large_answer_comes_compressed_to_who_takes_that_and_says_the_same(served):
    plain = served.ask("GET", "/openapi.json")
    packed = served.ask("GET", "/openapi.json", headers={"Accept-Encoding": "gzip"})
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert int(packed.headers["content-length"]) == len(packed.body) < len(plain.body) / 2
    assert gzip.decompress(packed.body) == plain.body
    refused = served.ask("GET", "/openapi.json", headers={"Accept-Encoding": "gzip;q=0"})
    assert refused.body == plain.body


def test_what_there_is_not_is_told_as_express_does(served):
    answer = served.ask("GET", "/nope/%3Cscript%3E?x=1")
    assert answer.status == 404
    assert b"<pre>Cannot GET /nope/%3Cscript%3E</pre>" in answer.body
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert served.ask("POST", "/move").status == 404
    assert b"Cannot POST /move" in served.ask("POST", "/move").body


def test_head_is_a_get_without_its_body(served):
    answer = served.ask("HEAD", "/")
    assert (answer.status, answer.body, answer.headers["content-length"]) == (200, b"", "2")


def test_a_broken_answer_is_an_answer_and_an_event(served, capfd):
    assert served.ask("GET", "/broken").status == 500
    until(lambda: any(kind == "web_fault" and "ZeroDivisionError" in text for kind, text, _ in served.stage.events))
    assert served.ask("GET", "/").status == 200
    assert "ZeroDivisionError" in capfd.readouterr().err


def test_stop_reaches_whatever_is_wired_and_the_faces(served, face):
    served.stage.asked.clear()
    assert served.ask("POST", "/stop").json == {"message": "stopped"}
    assert {request for request, _ in served.stage.asked} == {"halt", "stop_motion"}
    assert face.stops[-1] == "stopped by 127.0.0.1"


def test_a_refused_stop_says_why(served):
    served.stage.answer = lambda _request, _message: CommandReply(accepted=False, reason="no bus")
    try:
        answer = served.ask("POST", "/stop")
        assert (answer.status, answer.said) == (409, "no bus")
    finally:
        served.stage.answer = lambda _request, _message: CommandReply(accepted=True)


@pytest.mark.parametrize("path", ["/stop", "/estop/reset"])
def test_a_robot_that_does_not_answer_is_told(served, monkeypatch, path):
    monkeypatch.setattr(served.stage, "answer", lambda _request, _message: None)
    answer = served.ask("POST", path)
    assert (answer.status, answer.said) == (503, "'joints' does not answer")


def test_the_emergency_stop_is_engaged_and_released(served, face):
    served.stage.say("joints", replace(JOINTS, estop=True))
    answer = served.ask("POST", "/estop", {"reason": "smoke"})
    assert (answer.json["engaged"], answer.json["noticed"]) == (True, True)
    assert served.stage.engaged == ["smoke (127.0.0.1)"]
    assert face.stops[-1].startswith("emergency stop")
    assert served.ask("POST", "/estop/reset").status == 200
    assert served.stage.asked[-1][0] == "estop_reset"


@pytest.mark.parametrize(
    ("body", "headers", "said"),
    [
        (b"{", {"Content-Type": "application/json"}, ""),
        (b'{"reason": 5}', {"Content-Type": "application/json"}, ""),
        (b'{"why": "x"}', {"Content-Type": "application/json"}, ""),
        (b"\xff", {"Content-Type": "application/json; charset=utf-8"}, ""),
        (b'{"reason": "x"}', {"Content-Type": "text/plain"}, "x"),
        (b"x" * 70_000, {"Content-Type": "application/json"}, ""),
    ],
)
def test_the_emergency_stop_is_engaged_whatever_its_body_is(served, body, headers, said):
    served.stage.say("joints", replace(JOINTS, estop=True))
    assert served.ask("POST", "/estop", body, headers).json["engaged"]
    assert served.stage.engaged[-1] == (f"{said} (127.0.0.1)" if said else "by 127.0.0.1")


@pytest.mark.parametrize("chunked", [False, True])
def test_the_sender_of_a_stop_with_a_large_body_reads_the_answer(served, chunked):
    served.stage.asked.clear()
    body = b"x" * 5_000_000
    length = b"Transfer-Encoding: chunked" if chunked else b"Content-Length: %d" % len(body)
    with socket.create_connection(("127.0.0.1", served.port), timeout=20) as client:
        client.sendall(b"POST /stop HTTP/1.1\r\nHost: localhost\r\n" + length + b"\r\n\r\n")
        client.sendall(b"%x\r\n%b\r\n0\r\n\r\n" % (len(body), body) if chunked else body)
        client.shutdown(socket.SHUT_WR)
        answer = b"".join(iter(lambda: client.recv(65536), b""))
    assert answer.startswith(b"HTTP/1.1 200")
    assert "halt" in {request for request, _ in served.stage.asked}


@pytest.mark.parametrize(
    ("target", "host", "status"),
    [
        (b"http://127.0.0.1:%d/stop", b"127.0.0.1:%d", b"200"),
        (b"HTTP://localhost:%d/stop?why=1", b"localhost:%d", b"200"),
        (b"https://localhost:%d/stop", b"localhost:%d", b"200"),
        (b"http://localhost:%d", b"localhost:%d", b"404"),
        (b"http://localhost:%d?x=/stop", b"localhost:%d", b"404"),
        (b"http://localhost:%d/stop", b"evil.example:%d", b"421"),
        (b"http://evil.example:%d/stop", b"localhost:%d", b"404"),
        (b"http://evil.example:%d/stop", b"evil.example:%d", b"421"),
        (b"http://me@localhost:%d/stop", b"localhost:%d", b"404"),
        (b"ftp://localhost:%d/stop", b"localhost:%d", b"404"),
    ],
)
def test_an_address_as_proxies_are_asked_is_the_same_request_to_the_host_it_names(served, target, host, status):
    """An address as proxies are asked is the same request, to the host it names"""
    head = b"POST " + target % served.port + b" HTTP/1.1\r\nHost: " + host % served.port + b"\r\n"
    assert served.raw(head + b"Content-Length: 0\r\nConnection: close\r\n\r\n")[9:12] == status


@pytest.mark.parametrize(
    "head",
    [
        b"POST /nowhere HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 90000\r\n\r\n",
        b"POST /estop/reset HTTP/1.1\r\nHost: localhost\r\nContent-Length: 90000\r\n\r\n",
        b"POST /estop/reset HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nnonsense\r\n",
        b"nonsense\r\n\r\n",
    ],
)
def test_who_is_refused_before_all_was_said_reads_why_and_is_not_cut(served, head):
    """A sender that is refused before all was said reads why, and is not cut"""
    with socket.create_connection(("127.0.0.1", served.port), timeout=8) as client:
        client.sendall(head)
        said = client.recv(65536)
        assert said.startswith(b"HTTP/1.1 4")
        for _ in range(20):
            client.sendall(1000 * b"x")
            select.select([client], [], [], 0.01)
        while part := client.recv(65536):
            said += part
        client.shutdown(socket.SHUT_WR)
    assert b"\r\n\r\n" in said


def test_who_goes_on_after_the_answer_is_cut_in_time(served, monkeypatch):
    """A sender that goes on after the answer is cut in time"""
    monkeypatch.setitem(slots.LIMIT_S, "leaving", 0.05)
    with socket.create_connection(("127.0.0.1", served.port), timeout=8) as client:
        client.sendall(b"nonsense\r\n\r\n")
        assert client.recv(65536).startswith(b"HTTP/1.1 400")

        def cut() -> bool:
            try:
                client.sendall(b"x")
            except OSError:
                return True
            return False

        until(cut, what="it is cut")


def test_an_address_that_is_too_long_is_refused(served):
    assert served.ask("GET", "/" + "x" * 5000).status == 414


def test_foreign_pages_may_not_move_the_robot_and_may_link_to_pages(served):
    browser = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
    assert served.ask("GET", "/move", headers=browser).status == 403
    assert served.ask("GET", "/", headers=browser).status == 200
    assert served.ask("GET", "/", headers=browser | {"Sec-Fetch-Mode": "cors"}).status == 403
    assert served.ask("POST", "/stop", headers={"Origin": "http://evil.example"}).status == 403
    assert served.ask("GET", "/move", headers={"Sec-Fetch-Site": "none"}).status == 200


def test_allowed_pages_are_told_so_and_others_are_not(served):
    allowed = served.ask("GET", "/move", headers={"Origin": "http://app:8081"})
    assert (allowed.status, allowed.headers["access-control-allow-origin"]) == (200, "http://app:8081")
    assert allowed.headers["vary"] == "Origin"
    asked = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Private-Network": "true"}
    preflight = served.ask("OPTIONS", "/stop", headers={"Origin": "http://app:8081"} | asked)
    assert (preflight.status, preflight.headers["access-control-allow-methods"]) == (204, "POST")
    assert preflight.headers["access-control-allow-private-network"] == "true"
    refused = served.ask("OPTIONS", "/stop", headers={"Origin": "http://evil.example"} | asked)
    assert refused.status == 403
    assert "access-control-allow-origin" not in refused.headers
    assert served.ask("OPTIONS", "/move").headers["allow"] == "GET,HEAD"


def test_states_stream_and_the_newest_wins(served):
    with connect(f"ws://127.0.0.1:{served.port}/ws?rate_hz=50") as viewer:
        viewer.recv(timeout=HANG_S)
        served.stage.say("joints", JointsState(sequence=77, measured_s=0.0, moving=True, phase="ready", joints={}))
        until(lambda: b'"sequence":77' in viewer.recv(timeout=HANG_S).encode())


@pytest.mark.parametrize(("path", "status"), [("/ws?rate_hz=0", 400), ("/nope", 404)])
def test_a_stream_is_refused_with_a_status(served, path, status):
    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://127.0.0.1:{served.port}{path}")
    assert refused.value.response.status_code == status


def test_whoever_talks_on_a_stream_is_shown_out(served):
    with connect(f"ws://127.0.0.1:{served.port}/ws?rate_hz=50") as viewer:
        for _ in range(100):
            with suppress(ConnectionClosed):
                viewer.send("hello")
        assert ending(viewer)[0] == 1008


def test_a_reader_that_never_reads_costs_nothing_and_stops_nobody(served):
    with socket.create_connection(("127.0.0.1", served.port)) as lazy:
        lazy.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        lazy.sendall(UPGRADE % b"/ws?rate_hz=50" + b"\r\n")
        big = {f"j{n}": {"id": n, "reason": "x" * 200} for n in range(25)}
        for n in range(20):
            served.stage.say("joints", JointsState(sequence=n, measured_s=0.0, moving=False, phase="ready", joints=big))
            assert served.ask("GET", "/").status == 200
    served.stage.say("joints", JOINTS)


def test_edited_rows_are_the_robots_at_once(served):
    motor = Motor(layer="mine", id=23, name="neck", initial=127, lowest=1, highest=254, rest=127)
    served.stage.answer = lambda _request, _message: EditReply(accepted=True, revision=3)
    robot = served.web._robot
    try:
        edited = served.web._front.bridge.call(robot.edit((motor,)))
        assert asyncio.run(edited).revision == 3
        assert robot.motors == (motor,)
    finally:
        served.stage.given = ()
        served.stage.answer = lambda _request, _message: CommandReply(accepted=True)


def test_the_address_is_told_honestly(served):
    assert " reaches http://127.0.0.1" in served.web._front.place.text()
    assert "&#x27;phone&#x27;" in served.ask("GET", "/qr").body.decode()
    assert served.ask("GET", "/qr.svg").status == 404


def test_whoever_asks_too_often_waits_and_may_stop_all_the_same():
    with serving(Plain(), requests_per_s=20.0) as served:
        begun = time.monotonic()
        refused = next(answer for _ in range(500) if (answer := served.ask("GET", "/")).status == 429)
        assert refused.headers["retry-after"] == "1"
        assert time.monotonic() - begun >= TOO_OFTEN_S
        assert served.ask("POST", "/stop").status == 200


def test_a_port_that_is_taken_is_told_with_the_row():
    with ExitStack() as stack:
        port = stack.enter_context(serving()).port
        with pytest.raises(DeviceError, match=r"lbr set web\.port"):
            stack.enter_context(serving(port=port))


def test_streams_end_with_a_reason_when_the_server_does():
    with ExitStack() as stack:
        with serving() as served:
            viewer = stack.enter_context(connect(f"ws://127.0.0.1:{served.port}/ws?rate_hz=50"))
            viewer.recv(timeout=HANG_S)
        code, reason = ending(viewer)
    assert code == 1001
    assert "the server ends" in reason


def test_it_may_be_served_encrypted_and_to_everybody(monkeypatch, tmp_path):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    with serving(Plain(), host="0.0.0.0") as served:
        context = ssl._create_unverified_context()
        with socket.create_connection(("127.0.0.1", served.port)) as plain, context.wrap_socket(plain) as secure:
            secure.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
            assert secure.recv(100).startswith(b"HTTP/1.1 200")
        named = ssl.create_default_context(cafile=str(tmp_path / "credentials" / "bus.crt"))
        with (
            socket.create_connection(("127.0.0.1", served.port)) as plain,
            named.wrap_socket(plain, server_hostname="robot.lbr") as secure,
        ):
            secure.sendall(b"GET / HTTP/1.1\r\nHost: robot.lbr:50000\r\nConnection: close\r\n\r\n")
            assert secure.recv(100).startswith(b"HTTP/1.1 200")
        assert served.ask("GET", "/").status == 200, "this machine itself is served as before"
        assert not any(kind == "exposed" for kind, _, _ in served.stage.events)


def test_it_is_said_aloud_when_others_may_move_the_robot():
    with serving(
        host="0.0.0.0", clear_text=True, trusted=("127.0.0.0/8", "192.168.0.0/16"), cors=("*",), legacy="on"
    ) as served:
        said = [text for kind, text, level in served.stage.events if kind == "exposed" and level == "warning"]
    assert any("in clear text" in text for text in said)
    assert any("192.168.0.0/16" in text for text in said)
    assert any("cors" in text for text in said)
    assert any("legacy" in text for text in said)


def test_many_who_stop_at_once_are_answered_together_and_none_is_refused(served, monkeypatch):
    """What stops takes this many commands at once and refuses more; a stop that is refused is none."""
    asked, heard = [], threading.Event()

    class Late:
        def answers(self):
            return {"drive": CommandReply(accepted=True)} if heard.is_set() else None

    monkeypatch.setattr(served.stage, "ask", lambda request, *_: (asked.append(request), Late())[1])
    statuses: list[int] = []
    threads = [threading.Thread(target=lambda: statuses.append(served.ask("POST", "/stop").status)) for _ in range(30)]
    for thread in threads:
        thread.start()
    until(lambda: len(served.web._front.bridge._under_way) == 30)
    assert asked.count("halt") == 1
    heard.set()
    for thread in threads:
        thread.join()
    assert statuses == [200] * 30
    assert asked.count("halt") == 2  # the first, and one for all who came after it had begun


OPEN = WebSettings(host="0.0.0.0", port=50000, clear_text=True)


def test_an_address_is_shown_as_a_code_that_a_terminal_keeps_as_it_is():
    place = AdvertisedAddress(OPEN, 50000, own_addresses=lambda: ("192.168.1.5", "10.0.0.2", "fd00::2"))
    told = place.text()
    assert place.url == "http://192.168.1.5:50000/"
    assert "Also at http://10.0.0.2:50000/" in told
    assert "need a token" in told
    code = qr.characters(place.url)
    assert told.startswith(code)
    assert wrapped(code, 80) == code
    assert all(set(line) <= set("█▀▄ ") for line in code.splitlines())


def test_an_address_follows_the_network():
    here: list[str] = []
    place = AdvertisedAddress(OPEN, 50000, own_addresses=lambda: tuple(here))
    assert "in no network now" in place.text()
    here.append("192.168.1.5")
    assert place.look() == ("192.168.1.5",)
    assert "192.168.1.5" in place.text()


@pytest.mark.parametrize(("files", "host"), [((), "192.168.1.5"), (("web.crt", "web.key"), "robot.example.org")])
def test_a_code_has_the_name_that_the_owners_certificate_is_for(files, host, tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    for name in files:
        disk.write(home.directory("credentials") / name, b"PEM")
    settings = replace(OPEN, clear_text=False, names=("robot.example.org",))
    place = AdvertisedAddress(settings, 50000, own_addresses=lambda: ("192.168.1.5",))
    assert place.url == f"https://{host}:50000/"
    assert place.urls == ("https://192.168.1.5:50000/",)


def test_who_needs_no_token_is_said():
    place = AdvertisedAddress(replace(OPEN, trusted=("192.168.1.0/24",)), 1, own_addresses=lambda: ("192.168.1.5",))
    assert "Clients in 192.168.1.0/24 need no token" in place.text()
    assert url("fd00::2", 1, tls=True) == "https://[fd00::2]:1/"


@pytest.mark.parametrize(
    ("settings_", "tls"),
    [
        ({}, False),
        ({"host": "localhost"}, False),
        ({"host": "::1"}, False),
        ({"tls": True}, True),
        ({"clear_text": True}, False),
        ({"host": "0.0.0.0"}, True),
        ({"host": "::"}, True),
        ({"host": "192.168.1.5"}, True),
        ({"host": "robot.example.org"}, True),
        ({"host": "0.0.0.0", "clear_text": True}, False),
    ],
)
def test_where_other_machines_reach_it_it_speaks_tls_unless_the_row_says_clear_text(settings_, tls):
    assert AdvertisedAddress(WebSettings(**settings_), 50000, own_addresses=tuple).tls is tls


def test_a_row_says_tls_or_clear_text():
    with pytest.raises(ValueError, match="only one of them"):
        WebSettings(tls=True, clear_text=True)


def test_an_announcement_is_told_and_followed():
    async def announced() -> tuple[str, str]:
        announcer = Announcer("uxa90 test", 50000, lambda: ("127.0.0.1",), lambda: {"path": "/"})
        running = asyncio.ensure_future(announcer.run())
        for _ in range(400):
            if announcer.said or announcer.trouble:
                break
            await asyncio.sleep(0.01)
        told = announcer.said, announcer.trouble
        running.cancel()
        await asyncio.wait([running])
        return told

    said, trouble = asyncio.run(announced())
    assert said.startswith("uxa90 test") or "announcement" in trouble


def test_without_a_network_nothing_is_announced(wording):
    async def announced() -> str:
        announcer = Announcer("uxa90 test", 50000, tuple, dict)
        running = asyncio.ensure_future(announcer.run())
        await asyncio.sleep(0)
        running.cancel()
        await asyncio.wait([running])
        return announcer.trouble

    wording(asyncio.run(announced()))


def test_a_body_that_does_not_come_is_given_up(monkeypatch):
    monkeypatch.setattr(application, "BODY_S", 0.05)
    with serving() as served:
        head = b"POST /estop/reset HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n{"
        assert served.raw(head).startswith(b"HTTP/1.1 408")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.one_of(
        st.binary(max_size=200), st.binary(max_size=80).map(lambda b: b"GET /" + b + b" HTTP/1.1\r\nHost: a\r\n\r\n")
    )
)
def test_bytes_by_chance_end_nothing(served, sent):
    with socket.create_connection(("127.0.0.1", served.port), timeout=8) as client:
        client.sendall(sent)
        client.shutdown(socket.SHUT_WR)
        with suppress(ConnectionError):
            answer = client.recv(65536)
            assert not answer or answer.startswith(b"HTTP/1.1 4")
    assert served.web._front._serving._thread.is_alive()
