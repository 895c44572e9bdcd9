import http.client
import json
import os
import signal
import socket
import ssl
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from lbr import home
from lbr.bus import session, wire
from lbr.messages.camera import CameraState, JpegFrame
from tests.support import programs
from tests.support.robot import environment
from tests.support.waiting import HANG_S, until

BEGINNING = 1 << 20
PART = b"--FRAME\r\nContent-Type: image/jpeg\r\n\r\n"
STATE = CameraState(on=True, phase="streaming", device="/dev/video0", width_px=640, height_px=360)


def jpeg(mark: int, size: int = 2000) -> bytes:
    return b"\xff\xd8\xff\xda" + struct.pack("<I", mark) + b"\x01" * size + b"\xff\xd9"


class Cameras:
    """Two cameras on the bus of a robot that is nothing but its local door."""

    def __init__(self, folder: Path) -> None:
        endpoint = f"unixsock-stream/{folder / 'door.sock'}"
        self._router = session.open_router(session.Router(listen=(endpoint,)))
        self._bus = session.open_client([endpoint])
        self.lock = home.RunLock("lbr")
        self.lock.publish(
            home.Running(
                robot="lbr", pid=os.getpid(), endpoints=(endpoint,), profile="", database="", core="", password=""
            )
        )
        self.frames, self.states = (
            {
                name: wire.Publisher(self._bus, f"lbr/camera_{name}/{output}", name, pictures=output == "frame")
                for name in ("front", "rear")
            }
            for output in ("frame", "state")
        )
        self.states["front"].put(STATE)
        self.states["rear"].put(CameraState(on=False, phase="off", device="/dev/video2"))

    def show(self, mark: int, camera: str = "front", *, age_s: float = 0.0, size: int = 2000) -> bytes:
        picture = jpeg(mark, size)
        self.frames[camera].put(JpegFrame(picture), taken_s=time.monotonic() - age_s)
        return picture

    def close(self) -> None:
        self.lock.release()
        self._bus.close()
        self._router.close()


class Page:
    """A running navcam and what it said about itself."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.folder = folder
        self.popen = programs.start(
            [sys.executable, "-P", "-m", "lbr.apps.navcam", "--port", "0", *arguments],
            env=environment(folder) | {"LBR_ROBOT": "lbr"},
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.popen.stdout is not None
        self.log = self.popen.stdout
        self.said = self.popen.stdout.readline() + self.popen.stdout.readline()
        self.url = self.said.split()[3]
        self.token = self.url.partition("#token=")[2]
        self.port = int(self.url.partition("/index.html")[0].rpartition(":")[2])
        self.tls = self.url.startswith("https:")

    def connect(self) -> http.client.HTTPConnection:
        if not self.tls:
            return http.client.HTTPConnection("127.0.0.1", self.port, timeout=HANG_S)
        trust = ssl.create_default_context(cafile=str(self.folder / "credentials" / "bus.crt"))
        trust.check_hostname = False
        return http.client.HTTPSConnection("127.0.0.1", self.port, timeout=HANG_S, context=trust)

    @contextmanager
    def ask(
        self, path: str, method: str = "GET", *, token: str | None = None, **headers: str
    ) -> Iterator[http.client.HTTPResponse]:
        connection = self.connect()
        try:
            shown = self.token if token is None else token
            proof = {"Authorization": f"Bearer {shown}"} if shown else {}
            connection.request(method, path, headers=proof | headers)
            with connection.getresponse() as response:
                yield response
        finally:
            connection.close()

    def get(self, path: str, **options: str) -> tuple[int, bytes]:
        with self.ask(path, **options) as response:
            return response.status, response.read()

    def end(self) -> int:
        self.popen.send_signal(signal.SIGTERM)
        assert self.popen.stdout is not None
        self.popen.stdout.close()
        return self.popen.wait(HANG_S)


@pytest.fixture(scope="module")
def cameras(tmp_path_factory) -> Iterator[Cameras]:
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("h")
        patch.setenv("LBR_HOME", str(folder))
        cameras = Cameras(folder)
        yield cameras
        cameras.close()


@pytest.fixture(scope="module")
def page(cameras) -> Iterator[Page]:
    page = Page(home.home())
    yield page
    page.end()


@contextmanager
def watching(
    page: Page, cameras: Cameras, path: str = "/stream.mjpg", camera: str = "front"
) -> Iterator[http.client.HTTPResponse]:
    """Open a stream, and show pictures until the first has come: by then navcam listens to the camera."""
    with page.ask(path) as response:
        assert response.status == 200
        assert response.read(len(PART)) == PART
        begun = threading.Event()

        def begin() -> None:
            while not begun.wait(0.02):
                cameras.show(BEGINNING, camera)

        thread = threading.Thread(target=begin)
        thread.start()
        try:
            assert next_mark(response) == BEGINNING
        finally:
            begun.set()
            thread.join()
        yield response


def next_mark(response: http.client.HTTPResponse, size: int = 2000) -> int:
    """Read a picture and the header of the one after it."""
    picture = response.read(len(jpeg(0, size)) + 2 + len(PART))
    assert picture.endswith(b"\xff\xd9\r\n" + PART)
    return struct.unpack_from("<I", picture, 4)[0]


def shown(cameras: Cameras, response: http.client.HTTPResponse, mark: int, camera: str = "front") -> None:
    """Publish a picture, and read it after what was left of the beginning."""
    cameras.show(mark, camera)
    while (seen := next_mark(response)) == BEGINNING:
        pass
    assert seen == mark


def test_a_picture_is_whole_for_the_browser_before_the_next_one_is_taken(cameras, page):
    with watching(page, cameras) as response:
        assert response.headers["Content-Type"] == "multipart/x-mixed-replace; boundary=FRAME"
        assert response.headers["Age"] == "0"
        assert response.headers["Cache-Control"] == "no-cache, private"
        assert response.headers["Pragma"] == "no-cache"
        shown(cameras, response, 1)  # reads up to and with the header that lets a browser show it
        shown(cameras, response, 2)


def test_a_stream_of_one_camera_shows_no_other(cameras, page):
    with watching(page, cameras, "/stream.mjpg?camera=rear", "rear") as response:
        cameras.show(1, "front")
        shown(cameras, response, 2, "rear")


def test_a_stream_of_the_current_camera_goes_over_to_another_when_the_first_is_silent(cameras, page):
    with watching(page, cameras) as response:
        shown(cameras, response, 1, "front")
        cameras.show(2, "rear")
        shown(cameras, response, 3, "front")
        time.sleep(1.1)
        shown(cameras, response, 4, "rear")


def test_a_camera_that_there_is_not_is_told_with_those_there_are(page):
    status, text = page.get("/stream.mjpg?camera=side")
    assert status == 404
    assert b"there are front, rear" in text


def test_a_slow_viewer_misses_pictures_and_delays_nobody(cameras, page):
    slow = page.connect()
    slow.sock = socket.socket()
    slow.sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16384)
    slow.sock.settimeout(HANG_S)
    slow.sock.connect(("127.0.0.1", page.port))
    slow.request("GET", "/stream.mjpg?camera=rear", headers={"Authorization": f"Bearer {page.token}"})
    last, size = 60, 50_000
    with slow.getresponse() as late, watching(page, cameras, "/stream.mjpg?camera=front") as response:
        late.read(len(PART))
        for mark in range(last + 1):
            cameras.show(mark, "rear", size=size)
            shown(cameras, response, mark)
        seen = []
        while not seen or seen[-1] != last:
            seen.append(next_mark(late, size))
    slow.close()
    assert seen == sorted(seen)
    assert len(seen) < last / 2


def test_there_is_a_bound_on_viewers_and_room_again_when_one_leaves(page):
    def opened() -> http.client.HTTPConnection | None:
        connection = page.connect()
        connection.request("GET", "/stream.mjpg", headers={"Authorization": f"Bearer {page.token}"})
        response = connection.getresponse()
        if response.status == 200:
            open_responses.append(response)
            return connection
        assert response.status == 503
        assert response.headers["Retry-After"]
        assert b"4 of one asker are watching already" in response.read()
        connection.close()
        return None

    open_responses: list[http.client.HTTPResponse] = []
    connections = [until(opened, what="room") for _ in range(4)]
    assert opened() is None
    open_responses.pop().close()
    connections.pop().close()
    connections.append(until(opened, what="room again"))
    for one in (*open_responses, *connections):
        one.close()


def test_a_snapshot_is_the_newest_picture(cameras, page):
    picture = cameras.show(9)
    assert page.get("/snapshot.jpg") == (200, picture)
    assert page.get("/snapshot.jpg?camera=front") == (200, picture)
    with page.ask("/snapshot.jpg") as response:
        assert response.headers["Content-Type"] == "image/jpeg"


def test_there_is_no_snapshot_of_what_is_old_or_off(cameras, page):
    cameras.show(1, age_s=2.0)
    for publisher in cameras.frames.values():
        if publisher is not cameras.frames["front"]:
            publisher.forget()
    status, text = page.get("/snapshot.jpg")
    assert status == 503
    assert b"no picture now" in text
    cameras.frames["front"].forget()
    assert page.get("/snapshot.jpg")[0] == 503


def test_the_cameras_are_told_as_json(page):
    status, text = page.get("/cameras")
    told = json.loads(text)
    assert status == 200
    assert (
        told["front"] | {"device": "/dev/video0", "status": "on", "phase": "streaming", "width_px": 640}
        == told["front"]
    )
    assert told["rear"]["status"] == "off"


def test_the_page_is_reached_from_the_root_and_nothing_else_is_there(page):
    with page.ask("/", token="") as response:
        assert (response.status, response.headers["Location"]) == (301, "/index.html")
    status, text = page.get("/index.html")
    assert status == 200
    assert b"<title>lbr Navigation</title>" in text
    for path, kind in (("/page.js", "text/javascript"), ("/page.css", "text/css"), ("/signin.js", "text/javascript")):
        with page.ask(path) as response:
            assert response.headers["Content-Type"].startswith(kind)
    assert page.get("/robot.db")[0] == 404
    assert page.get("/../__init__.py")[0] == 404
    assert page.get("/cameras", method="POST")[0] == 404


@pytest.mark.parametrize("path", ["/stream.mjpg", "/snapshot.jpg", "/cameras", "/page.js"])
@pytest.mark.parametrize("token", ["", "wrong", "é", "x" * 9000])
def test_without_the_token_nothing_is_shown(page, path, token):
    status, text = page.get(path, token=token)
    assert status == 401
    assert b"show the token" in text


def test_the_token_is_exchanged_for_a_cookie_that_scripts_and_other_sites_cannot_use(page):
    with page.ask("/session", "POST") as response:
        assert response.status == 204
        cookie = response.headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert page.token not in cookie
    name = cookie.partition(";")[0]
    assert page.get("/cameras", token="", Cookie=name)[0] == 200
    assert page.get("/index.html", token="", Cookie=name)[0] == 200
    assert page.get("/cameras", token="", Cookie=name[:-1] + "x")[0] == 401
    assert page.get("/cameras", token="", Cookie="\x7f;=;" + name[:9])[0] in {400, 401}
    assert page.get("/session", method="POST", token="wrong")[0] == 401
    assert page.get("/cameras", token=name.partition("=")[2])[0] == 401


def test_another_sites_page_gets_nothing(page):
    with page.ask("/cameras", Origin="https://elsewhere.example") as response:
        assert response.status == 403
        assert not [name for name in response.headers if name.lower().startswith("access-control-")]
        assert response.headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "frame-ancestors 'none'" in response.headers["Content-Security-Policy"]
    status, text = page.get("/cameras", Host="robot.elsewhere.example")
    assert status == 421
    assert b"--name" in text


def test_where_it_is_can_be_read_by_the_owner_alone(page):
    for path in (page.folder / "run" / "lbr-navcam.url", page.folder / "credentials" / "navcam.token"):
        assert path.stat().st_mode & 0o777 == 0o600
        assert page.token in path.read_text()


def test_from_other_machines_it_is_reached_by_tls_alone_and_ends_at_once_while_they_watch(cameras):
    page = Page(home.home(), "--host", "0.0.0.0")
    assert page.tls
    with socket.create_connection(("127.0.0.1", page.port), timeout=HANG_S) as plain:
        plain.sendall(
            f"GET /cameras HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {page.token}\r\n\r\n".encode()
        )
        assert plain.recv(4096).startswith(b"HTTP/1.1 307")
    with page.ask("/session", "POST") as response:
        cookie = response.headers["Set-Cookie"]
    assert cookie.startswith("__Host-")
    assert "Secure" in cookie
    page.log.readline()  # the fingerprint
    with watching(page, cameras) as response:
        assert page.log.readline().endswith("127.0.0.1 watches the camera that is on\n")
        shown(cameras, response, 1)
        assert page.end() == 0
    assert not (page.folder / "run" / "lbr-navcam.url").exists()


def test_a_port_that_is_taken_is_told(cameras):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = programs.run(
            [sys.executable, "-P", "-m", "lbr.apps.navcam", "--port", str(taken.getsockname()[1])],
            env=environment(home.home()),
            capture_output=True,
            text=True,
            timeout=HANG_S,
            check=False,
        )
    assert done.returncode == 2
    assert "choose another by --port" in done.stderr


def cookie_of(page: Page) -> str:
    with page.ask("/session", "POST") as response:
        return response.headers["Set-Cookie"].partition(";")[0]


def test_who_signs_out_sees_nothing_more_and_others_do(cameras, page):
    mine, theirs = cookie_of(page), cookie_of(page)
    with page.ask("/stream.mjpg", token="", Cookie=mine) as stream:
        assert stream.status == 200
        stream.read(len(PART))
        with page.ask("/session", "DELETE", token="", Cookie=mine) as response:
            assert response.status == 204
            assert "Max-Age=0" in response.headers["Set-Cookie"]
        assert stream.read() == b""
    assert page.get("/cameras", token="", Cookie=mine)[0] == 401
    assert page.get("/cameras", token="", Cookie=theirs)[0] == 200
    assert page.get("/sessions", method="DELETE", token="")[0] == 401
    assert page.get("/sessions", method="DELETE")[0] == 204
    assert page.get("/cameras", token="", Cookie=theirs)[0] == 401
    assert page.get("/cameras")[0] == 200
