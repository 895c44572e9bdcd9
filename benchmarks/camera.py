"""The age of a picture when it arrives: at a subscriber of the bus, and in a browser that navcam serves.

`python -m benchmarks camera --seconds 30 --json FILE`. The pictures come at 640x360 and 15 a second from a program on
a socket, 30 kB each; with `--simulated` they are those of the simulated world, which has to draw them first. Exit code
1 if one of the promises is broken.
"""

import argparse
import http.client
import itertools
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from benchmarks import Measured
from lbr.bus import keys, stamp, wire
from tests.support import programs
from tests.support.bench import temporary_home
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, environment, running
from tests.support.waiting import until

SMOKE = "--seconds 1"

FPS, WIDTH, HEIGHT, BYTES = 15, 640, 360, 30_000
CAMERA = "camera_front"
LIMIT_MS = round(1000 / FPS + 10, 1)
PROMISES = {
    "C1": Promise(what="age of a picture at a subscriber of the bus", target=LIMIT_MS, statistic="p99"),
    "C2": Promise(what="age of a picture in a browser's hands, by navcam", target=LIMIT_MS, statistic="p99"),
    "C3": Promise(what="no picture that was published is lost on the bus"),
}
PART = b"\r\n--FRAME\r\nContent-Type: image/jpeg\r\n\r\n"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration, and the source."""
    parser.add_argument("--seconds", type=float, default=30.0, help="how long (default %(default)s)")
    parser.add_argument("--simulated", action="store_true", help="take the pictures of the simulated world")


def measure(given: argparse.Namespace) -> Measured:
    """Watch the pictures of a robot."""
    results = Results(PROMISES)
    with _robot(simulated=given.simulated) as robot:
        watch(results, robot, given.seconds)
    return Measured(results=results.ordered())


def watch(results: Results, robot: Robot, seconds: float) -> None:
    """Watch the camera by both ways at the same time."""
    heard = Pictures(robot)
    until(lambda: heard.count, what="a first picture")
    with _navcam(robot) as url:
        seen: list[tuple[bytes, int]] = []
        over = threading.Event()
        viewer = threading.Thread(target=_watch, args=(url, seen, over))
        viewer.start()
        until(lambda: seen, what="a first picture in the browser")
        heard.restart()
        time.sleep(seconds)
        pictures = heard.take()
        over.set()
        viewer.join()
    for _, taken_ns, arrived_ns, _ in pictures:
        results.sample("C1", (arrived_ns - taken_ns) * 1e-6)
    for payload, arrived_ns in seen:
        same = [taken_ns for data, taken_ns, _, _ in pictures if data == payload and taken_ns < arrived_ns]
        if same:  # pictures of a world at rest are equal: this is the last of them
            results.sample("C2", (arrived_ns - max(same)) * 1e-6)
    numbers = [number for _, _, _, number in pictures]
    missed = [f"after picture {a} came {b}" for a, b in itertools.pairwise(numbers) if b != a + 1]
    results.check("C3", missed)


class Pictures:
    """Every message on the camera's key: bytes, times of taking and arrival, its number."""

    def __init__(self, robot: Robot) -> None:
        self._came: list[tuple[bytes, int, int, int]] = []
        self._subscriber = robot.bus.declare_subscriber(keys.port(robot.name, CAMERA, "frame"), wire.direct(self._hear))

    @property
    def count(self) -> int:
        return len(self._came)

    def restart(self) -> None:
        self._came = []

    def take(self) -> list[tuple[bytes, int, int, int]]:
        self._subscriber.undeclare()
        return self._came

    def _hear(self, sample: Any) -> None:
        arrived_ns = time.monotonic_ns()
        found = stamp.read(sample.attachment.to_bytes())
        if found is not None:
            self._came.append((sample.payload.to_bytes(), found.mono_ns, arrived_ns, found.seq))


class Source:
    """A camera of almost no cost: it sends the same bytes with another number, at its rate."""

    def __init__(self, path: Path) -> None:
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                with client, suppress(OSError):
                    self._send(client)

    @staticmethod
    def _send(client: socket.socket) -> None:
        number, due = 0, time.monotonic()
        header = b"\xff\xd8\xff\xc0" + struct.pack(">HBHHB", 8, 8, HEIGHT, WIDTH, 0) + b"\xff\xda"
        while True:
            taken_ns = time.monotonic_ns()
            picture = header + struct.pack("<I", number) + bytes(BYTES - len(header) - 6) + b"\xff\xd9"
            client.sendall(struct.pack("<IQ", len(picture), taken_ns) + picture)
            number, due = number + 1, due + 1 / FPS
            time.sleep(max(0.0, due - time.monotonic()))


@contextmanager
def _robot(*, simulated: bool) -> Iterator[Robot]:
    """Run a robot with a camera: beside the simulated base, or only a camera at a socket of ours."""
    on = f"UPDATE capability SET enabled = 1, settings = json_set(settings, '$.on', json('true')) WHERE name = '{CAMERA}'"
    if simulated:
        with temporary_home(edits=(on,)) as home, running(home) as robot:
            yield robot
        return
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        path = Path(folder) / "pictures"
        Source(path)
        alone = f"UPDATE capability SET enabled = 0 WHERE name <> '{CAMERA}'"
        here = f"UPDATE device SET address = 'unix:{path}' WHERE type = 'camera'"
        with temporary_home(edits=(on, alone, here)) as home, running(home, profile="lbr") as robot:
            yield robot


@contextmanager
def _navcam(robot: Robot) -> Iterator[str]:
    popen = programs.start(
        [sys.executable, "-P", "-m", "lbr.apps.navcam", "--port", "0"],
        env=environment(robot.home) | {"LBR_ROBOT": robot.name},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert popen.stdout is not None
    with popen.stdout:
        try:
            yield popen.stdout.readline().split()[3]
        finally:
            popen.terminate()
            popen.wait(5.0)


def _watch(url: str, seen: list[tuple[bytes, int]], over: threading.Event) -> None:
    """Act like a browser: a picture is complete once the header of the next one comes."""
    where = urlsplit(url)
    token = where.fragment.partition("=")[2]
    connection = http.client.HTTPConnection(where.netloc, timeout=10)
    connection.request("GET", "/stream.mjpg", headers={"Authorization": f"Bearer {token}"})
    with connection.getresponse() as response:
        held = b"\r\n" + response.read(len(PART) - 2)
        assert held == PART, held
        held = b""
        while not over.is_set():
            held += response.read1()
            arrived_ns = time.monotonic_ns()
            *pictures, held = held.split(PART)
            seen += [(picture, arrived_ns) for picture in pictures]
    connection.close()
