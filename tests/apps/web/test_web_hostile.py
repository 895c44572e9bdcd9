"""What web pages, other users of the machine and odd requests may not do, as tables over every route there is."""

import http.client
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from lbr.apps.web.access import Access
from lbr.messages.faces import EditCommand, EditReply
from lbr.messages.leases import CommandReply
from lbr.messages.system import RANKS
from tests.apps.web.api_stage import StageBus
from tests.apps.web.test_web_access import bearer, user
from tests.apps.web.web_stage import Served, serving
from tests.robots.uxa90.uxa90_bench import SHIPPED
from tests.support.waiting import HANG_S, until

METHODS = ("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "PROPFIND")
HIDDEN = ("/docs", "/docs.js", "/docs.css", "/demo.js", "/demo.css", "/ws", "/api/live", "/nothing")
PAGES = {"/", "/qr", "/qr.svg", "/openapi.json", "/docs", "/docs.js", "/docs.css", "/demo", "/demo.js", "/demo.css"}
MOVING_GETS = ("/motor?id=23&pos=100&torq=2", "/motion/4", "/motion/reset", "/MOTION/4/", "/motion/%34")
OTHER_USER = 1234
HOSTS = [
    "evil.example", "evil.example:50000", "127.0.0.1.evil.example", "localhost.evil.example", "0.0.0.0", "0.0.0.0:50000",
    "0:50000", "0x0", "[::]", "[::]:50000", "[::ffff:0:0]", "[::ffff:127.0.0.1]", "[::1%25lo]", "[fe80::1%25eth0]",
    "user@localhost", "user:secret@127.0.0.1:50000", "localhost.", "127.0.0.1.", "LOCALHOST.", "127.1", "2130706433",
    socket.gethostname(), f"{socket.gethostname()}.local", "192.168.1.5", "localhost, evil.example", "xn--lcalhost-8qf",
]  # fmt: skip


FOREIGN_PAGES = [
    {"Origin": "http://evil.example"},
    {"Origin": "null"},
    {"Origin": ""},
    {"Origin": "http://localhost:1"},
    {"Origin": "https://localhost"},
    {"Origin": "http://127.0.0.1.evil.example"},
    {"Origin": "file://"},
    {"Origin": "http://evil.example", "Content-Type": "text/plain"},
    {"Origin": "http://evil.example", "Content-Type": "application/x-www-form-urlencoded"},
    {"Origin": "http://evil.example", "Content-Type": "multipart/form-data; boundary=x"},
    {"Sec-Fetch-Site": "cross-site"},
    {"Sec-Fetch-Site": "same-site"},
    {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors", "Sec-Fetch-Dest": "image"},
    {"Sec-Fetch-Site": "none, cross-site"},
    {"Referer": "http://evil.example/"},
    {"Referer": "http://["},
]


@contextmanager
def uxa90(**options: Any) -> Iterator[Served]:
    bus = StageBus()
    with serving(rows=SHIPPED, faces=("uxa90",), requests_per_s=10_000.0, bus=bus, **options) as found:
        found.bus = bus  # type: ignore[attr-defined]
        until(lambda: "/api/drive/command" in found.ask("GET", "/openapi.json").json["paths"])
        accepted = CommandReply(accepted=True, lease="1", goal="1")
        read = EditReply(accepted=True, revision=1)
        found.stage.answer = lambda request, _message: read if request == "edit" else accepted
        yield found


@pytest.fixture(scope="module")
def simulated() -> Iterator[Served]:
    with uxa90(users=(user("ann", "operate"), user("eve", "view")), cors=("http://app:8081",)) as found:
        yield found


@pytest.fixture(scope="module")
def real() -> Iterator[Served]:
    with uxa90(users=(user("ann", "operate"), user("eve", "view")), simulated=False) as found:
        yield found


@pytest.fixture(params=["simulated", "real"])
def served(request) -> Served:
    return request.getfixturevalue(request.param)


def paths(served: Served) -> list[str]:
    documented = served.ask("GET", "/openapi.json").json["paths"]
    keys = {"{key}": "4", "{id}": "23", "{job}": "1"}
    found = []
    for path in documented:
        name = next((key for key in keys if key in path), "")
        found.append(path.replace(name, keys[name]) if name else path)
    return [*found, *HIDDEN, "/motor?id=23&pos=100"]


def each_two(served: Served, number: int) -> Iterator[tuple[str, str]]:
    """Yield every path, with another method for each of nine numbers.

    Of path, method and what is numbered, any two meet; all three of them would be 30,000 requests for one gate.
    """
    for place, path in enumerate(paths(served)):
        yield path, METHODS[(place + number) % len(METHODS)]


class Asker:
    """Asks what no well-behaved client would, on one connection for as long as that stands."""

    def __init__(self, served: Served) -> None:
        self._served = served
        self._connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=8)

    def ask(self, method: str, target: str, headers: dict[str, str], body: bytes = b"") -> int:
        connection = self._connection
        connection.putrequest(method, target, skip_host="Host" in headers, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        if body or method in {"POST", "PUT", "PATCH"}:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        response = connection.getresponse()
        response.read()
        if response.will_close:
            connection.close()
        return response.status


@contextmanager
def nothing_happens(served: Served) -> Iterator[Asker]:
    """Ask, and find that nobody was asked for anything by it."""
    served.stage.asked.clear()
    served.stage.engaged.clear()
    served.bus.asked.clear()  # type: ignore[attr-defined]
    asker = Asker(served)
    try:
        yield asker
    finally:
        asker._connection.close()
    assert [one for one in served.stage.asked if one != ("edit", EditCommand())] == []  # an empty edit only reads
    assert served.stage.engaged == []
    asked = served.bus.asked  # type: ignore[attr-defined]
    assert [(key, what, who) for key, what, who in asked if not only_looks(key, what)] == []


def only_looks(key: str, what: Any) -> bool:
    """Say whether a question changes nothing, whatever is answered."""
    if "/@console/" in key:
        return what == "why" or what.startswith("/why/")
    return key.endswith("/state") or (
        key.endswith("/@manage") and what.get("ask") in {"rows", "tokens", "log", "events"}
    )


@pytest.mark.parametrize("host", HOSTS)
def test_every_route_is_refused_to_who_asks_for_another_host(simulated, host):
    with nothing_happens(simulated) as asker:
        for path, method in each_two(simulated, HOSTS.index(host)):
            assert asker.ask(method, path, {"Host": host}) == 421, (method, path)


@pytest.mark.parametrize(
    "head",
    [
        "GET /motion/4 HTTP/1.1\r\nHost: localhost\r\nHost: evil.example",
        "GET /motion/4 HTTP/1.1\r\nHost: localhost\r\nHost: localhost",
        "GET /motion/4 HTTP/1.1\r\nHost : localhost",
        "GET /motion/4 HTTP/1.1",
        "GET /motion/4 HTTP/1.0",
        "GET http://127.0.0.1/motion/4 HTTP/1.1\r\nHost: evil.example",
        "GET http://127.0.0.1/motion/4 HTTP/1.1\r\nHost: localhost",
        "GET http://evil.example/motion/4 HTTP/1.1\r\nHost: localhost",
        "GET //localhost/motion/4 HTTP/1.1\r\nHost: localhost",
        "OPTIONS * HTTP/1.1\r\nHost: localhost",
        "CONNECT 127.0.0.1:50000 HTTP/1.1\r\nHost: localhost",
        "GET /motion/4 HTTP/1.1\r\n Host: localhost",
        "GET /motion/4 HTTP/1.1\r\nX: y\r\n Host: localhost",
        "POST /motion/4 HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nContent-Length: 5",
    ],
)
def test_requests_that_two_servers_could_read_in_two_ways_do_nothing(served, head):
    with nothing_happens(served):
        answer = served.raw(f"{head}\r\nConnection: close\r\n\r\n".encode())
        assert answer.split(b" ", 2)[1][:1] == b"4", answer[:80]


@pytest.mark.parametrize("page", FOREIGN_PAGES)
def test_every_route_is_refused_to_a_foreign_page(served, page):
    with nothing_happens(served) as asker:
        for path, method in each_two(served, FOREIGN_PAGES.index(page)):
            status = asker.ask(method, path, page, b"{}" if method == "POST" else b"")
            visit = method in {"GET", "HEAD"} and path in PAGES and "Origin" not in page
            allowed = {200, 404} if visit or method == "OPTIONS" else {403, 404}
            assert status in allowed or (visit and status == 403), (method, path)


@pytest.mark.parametrize("method", ["HEAD", "OPTIONS", "TRACE", "PATCH", "PROPFIND"])
def test_methods_that_only_ask_what_there_is_do_nothing(served, method):
    with nothing_happens(served) as asker:
        for path in (*paths(served), *MOVING_GETS):
            asker.ask(method, path, bearer("ann"))


@pytest.mark.parametrize("header", ["X-HTTP-Method-Override", "X-HTTP-Method", "X-Method-Override", "_method"])
@pytest.mark.parametrize("path", ["/stop", "/estop", "/multimotor", "/motion", "/motors", "/motors/23?_method=PUT"])
def test_a_header_or_parameter_makes_no_other_method_of_a_get(served, header, path):
    with nothing_happens(served) as asker:
        for method in ("POST", "PUT", "DELETE"):
            asker.ask("GET", path, {header: method})


@pytest.mark.parametrize(
    "path",
    [
        "/%6dotion/4", "/motion%2f4", "//motion/4", "/./motion/4", "/motion/../motion/4", "/motion/4%00", "/motion/%ff",
        "/motion//4", "/motion/4//", "/motion/4/..", "/%2e/motion/4", "\\motion\\4", "/motion;/4", "/motion/\N{FULLWIDTH DIGIT FOUR}",
        "/%73top", "/stop/../motion/4",
    ],
)  # fmt: skip
def test_a_path_is_read_as_it_is_written(served, path):
    with nothing_happens(served):
        answer = served.raw(f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
        assert answer.split(b" ", 2)[1][:1] == b"4", answer[:80]


@pytest.mark.parametrize("path", MOVING_GETS)
def test_a_get_moves_the_real_robot_only_if_no_web_page_can_have_sent_it(real, path):
    with nothing_happens(real) as asker:
        assert asker.ask("GET", path, {}) == 403
        assert asker.ask("GET", path, {"Sec-Fetch-Site": ""}) == 403
        assert asker.ask("GET", path, bearer("eve")) == 403
    for proof in ({"Sec-Fetch-Site": "none"}, {"Origin": f"http://127.0.0.1:{real.port}"}, bearer("ann")):
        real.stage.asked.clear()
        real.ask("GET", path, headers=proof)
        assert {name for name, _ in real.stage.asked} & {"move", "play"}
        real.ask("POST", "/stop")


@pytest.mark.parametrize("path", MOVING_GETS)
def test_the_old_api_moves_a_simulated_robot_as_it_always_did(simulated, path):
    simulated.ask("POST", "/stop")
    simulated.stage.asked.clear()
    simulated.ask("GET", path)
    assert {name for name, _ in simulated.stage.asked} & {"move", "play"}
    simulated.ask("POST", "/stop")  # else what is played is renewed while the next test asks


class AsAnother(http.client.HTTPConnection):
    """A connection whose socket is another user's of this machine."""

    def connect(self) -> None:
        if os.geteuid() != 0:
            pytest.skip("only root can be somebody else")
        super().connect()
        os.fchown(self.sock.fileno(), OTHER_USER, -1)  # to be that user, if for a moment, all threads would have to be


def asked_as_another(served: Served, method: str, path: str, **headers: str) -> int:
    connection = AsAnother("127.0.0.1", served.port, timeout=8)
    try:
        connection.request(method, path, headers=headers)
        return connection.getresponse().status
    finally:
        connection.close()


LOOKING = [("GET", "/state"), ("GET", "/motor"), ("GET", "/motor?id=23"), ("GET", "/motion"), ("GET", "/motions/1")]
STOPPING = [("POST", "/stop"), ("POST", "/estop")]
OPERATING = [("GET", "/motor?id=23&pos=100"), ("GET", "/motion/4"), ("POST", "/motion/4"), ("POST", "/estop/reset")]
CHANGING = [("POST", "/motors"), ("PUT", "/motors/20"), ("POST", "/motions"), ("PUT", "/motions/100")]


@pytest.mark.parametrize(("method", "path"), LOOKING + STOPPING)
def test_another_user_of_the_machine_looks_and_stops(served, method, path):
    assert asked_as_another(served, method, path) == 200


@pytest.mark.parametrize(("method", "path"), OPERATING + CHANGING)
def test_another_user_of_the_machine_needs_a_token_for_more(real, method, path):
    with nothing_happens(real):
        assert asked_as_another(real, method, path, **{"Sec-Fetch-Site": "none"}) == 401


@pytest.mark.parametrize(("method", "path"), CHANGING)
def test_another_user_changes_no_rows_of_a_simulated_robot_either(simulated, method, path):
    with nothing_happens(simulated):
        assert asked_as_another(simulated, method, path) == 401


PASSED_ON = [
    {"X-Forwarded-For": "8.8.8.8"},
    {"X-Real-IP": "127.0.0.1"},
    {"Forwarded": "for=127.0.0.1"},
    {"Via": "1.1 x"},
    {"CF-Ray": "x"},
    {"Host": "localhost:1"},
]


@pytest.mark.parametrize("passed_on", PASSED_ON)
def test_what_a_proxy_of_the_owners_passes_on_is_not_the_owners_and_stops_all_the_same(served, passed_on):
    assert asked_of(served, passed_on, *CHANGING, *OPERATING, *LOOKING) == {401}
    for method, path in STOPPING:
        assert served.ask(method, path, headers=passed_on).status == 200


def asked_of(served: Served, headers: dict[str, str], *requests: tuple[str, str]) -> set[int]:
    with nothing_happens(served) as asker:
        return {asker.ask(method, path, headers) for method, path in requests}


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "https://localhost"}, 403),
        ({"Host": "evil.example"}, 421),
        ({"Host": "0.0.0.0"}, 421),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
        ({"X-Forwarded-For": "127.0.0.1"}, 401),
        ({"Authorization": "Bearer nonsense"}, 401),
    ],
)
@pytest.mark.parametrize("path", ["/ws", "/api/live"])
def test_a_stream_is_refused_to_foreign_pages_and_strangers(served, path, headers, status):
    with socket.create_connection(("127.0.0.1", served.port), timeout=8) as client:
        lines = {"Host": "localhost", "Connection": "Upgrade", "Upgrade": "websocket"} | headers
        lines |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
        head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
        client.sendall(f"GET {path} HTTP/1.1\r\n{head}\r\n".encode())
        assert client.recv(4096).startswith(f"HTTP/1.1 {status} ".encode())


def test_a_page_of_the_row_may_and_no_other(simulated):
    allowed = {"Origin": "http://app:8081", "Sec-Fetch-Site": "cross-site"}
    assert simulated.ask("POST", "/stop", headers=allowed).status == 200
    assert simulated.ask("GET", "/motor", headers=allowed).status == 200
    with connect(f"ws://127.0.0.1:{simulated.port}/ws", additional_headers={"Origin": "http://app:8081"}) as viewer:
        viewer.recv(timeout=HANG_S)
    for origin in ("http://app:8082", "https://app:8081", "http://app:8081.evil.example", "HTTP://APP:8081", "null"):
        with nothing_happens(simulated):
            assert simulated.ask("POST", "/stop", headers={"Origin": origin}).status == 403
        with pytest.raises(InvalidStatus):
            connect(f"ws://127.0.0.1:{simulated.port}/ws", additional_headers={"Origin": origin})


def test_who_owns_the_other_end_is_looked_up_once_for_a_connection(real, monkeypatch):
    looked = []
    whole = Access.client

    def client(self, *arguments, **options):
        looked.append(options.get("owner"))
        return whole(self, *arguments, **options)

    monkeypatch.setattr(Access, "client", client)
    assert real.ask("GET", "/jobs").status == 200
    assert looked == [True]


VIEWERS_POSTS = {"/stop", "/estop", "/api/console", "/api/drive/stop", "/session", "/sessions", "/api/pair"}
"""What changes something and yet is for all who may look, or have shown a code: stops, what one is known by, and lines,
which the executive holds against the role."""


@pytest.mark.parametrize("who", ["eve", "ann"])
def test_every_documented_route_is_refused_to_who_has_a_lower_role_than_it_says(served, who):
    role = {"eve": "view", "ann": "operate"}[who]
    documented = served.ask("GET", "/openapi.json").json["paths"]
    asked, open_to_viewers = 0, set()
    with nothing_happens(served) as asker:
        for path, methods in documented.items():
            target = path.replace("{key}", "4").replace("{id}", "23").replace("{job}", "1").replace("{part}", "drive")
            for method, said in methods.items():
                needed = said["x-role"]
                if method != "get" and needed in {"anybody", "view"}:
                    open_to_viewers.add(path)
                if needed == "anybody" or RANKS[needed] <= RANKS[role]:
                    continue
                asked += 1
                headers = bearer(who) | {"Content-Type": "application/json"}
                status = asker.ask(method.upper(), target, headers, b"{}" if method != "get" else b"")
                assert status == 403, (method, path, needed)
    assert asked, "the document names routes for other roles"
    assert open_to_viewers <= VIEWERS_POSTS, "what changes something is not for all who may look"
