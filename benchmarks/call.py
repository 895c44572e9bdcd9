"""The age of a camera's picture on the page, by a call and by MJPEG; the cost of a call; the effect of a kill.

`python -m benchmarks call --seconds 30 --calls 10`. A clock is drawn in the pictures, 640x360 with noise and 15 a
second, and read from the pixels that Chromium shows. Its timers come each 4 ms; that is in the figures. Without
Chromium or the extra `telepresence` it reports that and measures nothing.
"""

import argparse
import importlib.util
import shutil
import signal
import socket
import struct
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from benchmarks import Measured
from tests.support.bench import temporary_home
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, only, running
from tests.support.waiting import until

SMOKE = "--seconds 1 --calls 1"

FPS, WIDTH, HEIGHT = 15, 640, 360
BITS, BAR_HIGH = 32, 24
CAMERA = "camera_front"
FRAME_MS = 1000 / FPS
WAIT_MS = 30_000
BACK_S = 10.0
PROMISES = {
    "V1": Promise(what="age of a picture in the page, by a call", target=round(FRAME_MS + 60, 1), statistic="p99"),
    "V2": Promise(what="age of a picture in the page, by MJPEG", target=round(FRAME_MS + 20, 1), statistic="p99"),
    "V3": Promise(what="a call whose process is killed is told as over by its page, and can be made again"),
    "V4": Promise(what="the picture of a call is VP8, which costs a sixth of H264"),
}
ARGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--use-fake-ui-for-media-stream",
    "--use-fake-device-for-media-stream",
    "--allow-loopback-in-peer-connection",
    "--autoplay-policy=no-user-gesture-required",
)
READ = (
    """([chosen, seconds]) => new Promise((done) => {
  const canvas = document.createElement("canvas"), width = WIDTH, height = HIGH, bits = BITS;
  canvas.width = width; canvas.height = 1;
  const at = canvas.getContext("2d", {willReadFrequently: true}), ages = [], until = performance.now() + seconds * 1000;
  let last = -1;
  const look = () => {
    const shown = document.querySelector(chosen);
    if (shown && (shown.videoWidth || shown.naturalWidth)) {
      at.drawImage(shown, 0, height / 2, width, 1, 0, 0, width, 1);
      const now = performance.timeOrigin + performance.now(), row = at.getImageData(0, 0, width, 1).data;
      let read = 0;
      for (let bit = 0; bit < bits; bit++) read = read * 2 + (row[4 * Math.floor((bit + 0.5) * width / bits)] > 127 ? 1 : 0);
      const ms = Math.floor(read / 256), check = read % 256;
      if (ms !== last && ((ms ^ (ms >> 8) ^ (ms >> 16)) & 255) === check) {
        let age = (now - ms) % 16777216;
        if (age < 0) age += 16777216;
        if (age < 60000) ages.push(age);
        last = ms;
      }
    }
    performance.now() < until ? setTimeout(look, 4) : done(ages);
  };
  look();
})""".replace("WIDTH", str(WIDTH))
    .replace("HIGH", str(BAR_HIGH))
    .replace("BITS", str(BITS))
)
PLAYS = "(chosen) => { const one = document.querySelector(chosen); return one && (one.videoWidth || one.naturalWidth) > 0; }"
CODEC = """async () => {
  const found = [...(await window.seen.getStats()).values()];
  const video = found.find((one) => one.type === "inbound-rtp" && one.kind === "video");
  return found.find((one) => one.id === video?.codecId)?.mimeType ?? "none";
}"""
KEEP = """const made = window.RTCPeerConnection;
window.RTCPeerConnection = function (...given) { return (window.seen = new made(...given)); };"""
FILM, PICTURE = ".call-stage video.drive-picture", ".call-stage img.drive-picture"


def options(parser: argparse.ArgumentParser) -> None:
    """Add durations and amounts."""
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="how long each way is watched (default %(default)s)"
    )
    parser.add_argument(
        "--calls", type=int, default=10, help="how many calls the memory is watched over (default %(default)s)"
    )


def measure(given: argparse.Namespace) -> Measured:
    """Call a robot whose camera shows a clock."""
    lacking = [name for name in ("aiortc", "playwright", "cv2") if importlib.util.find_spec(name) is None]
    if lacking or shutil.which("chromium") is None:
        return Measured(text=f"nothing measured: {', '.join(lacking) or 'chromium'} is not installed")
    from playwright.sync_api import sync_playwright

    results, figures = Results(PROMISES), {}
    with _robot() as robot, sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=list(ARGS))
        try:
            context = browser.new_context(viewport={"width": 1280, "height": 800}, permissions=["camera", "microphone"])
            context.add_init_script(KEEP)
            page = context.new_page()
            page.set_default_timeout(WAIT_MS)
            page.goto(f"{robot.web}/#call")
            figures = watch(results, robot, page, given)
            _kill(results, robot, page)
        finally:
            browser.close()
    return Measured(results=results.ordered(), figures=figures)


def watch(results: Results, robot: Robot, page: Any, given: argparse.Namespace) -> dict[str, Any]:
    """Watch by both ways, one after the other, then make more calls."""
    figures: dict[str, Any] = {}
    page.wait_for_function(PLAYS, arg=PICTURE)
    for age in page.evaluate(READ, [PICTURE, given.seconds]):
        results.sample("V2", age)
    process = psutil.Process(robot.capability("call")["pid"])
    memory = [_megabytes(process)]
    figures["memory_idle_mb"] = memory[0]
    for n in range(given.calls):
        _call(page)
        if n == 0:
            time.sleep(min(2.0, given.seconds))  # the bandwidth is being estimated, and the first pictures are old
            figures |= _one(results, page, process, given.seconds)
        else:
            time.sleep(min(3.0, given.seconds))
        page.get_by_role("button", name="Hang up").click()
        until(lambda: robot.capability("call")["phase"] == "ready")
        page.wait_for_function(PLAYS, arg=PICTURE)
        time.sleep(0.5)
        memory.append(_megabytes(process))
    figures["memory_after_each_call_mb"] = memory[1:]
    figures["memory_grows_mb_a_call"] = round((memory[-1] - memory[1]) / max(1, given.calls - 1), 2)
    return figures


def _one(results: Results, page: Any, process: psutil.Process, seconds: float) -> dict[str, Any]:
    busy, since = _busy_s(process), time.monotonic()
    ages = page.evaluate(READ, [FILM, seconds])
    took = time.monotonic() - since
    for age in ages:
        results.sample("V1", age)
    codec = page.evaluate(CODEC)
    results.check("V4", [] if codec == "video/VP8" else [f"the picture is {codec}"])
    cpu = round(100 * (_busy_s(process) - busy) / took, 1)
    return {"cpu_percent_of_a_core": cpu, "pictures_a_second": round(len(ages) / took, 1)}


def _kill(results: Results, robot: Robot, page: Any) -> None:
    """Kill the call's process in a call; the page must report it and show MJPEG, and a call must be possible again."""
    _call(page)
    pid = robot.capability("call")["pid"]
    psutil.Process(pid).send_signal(signal.SIGKILL)
    problems = []
    try:
        page.wait_for_selector('.call-word[role="alert"]')
        page.wait_for_function(PLAYS, arg=PICTURE)
        until(
            lambda: robot.capability("call")["phase"] == "ready" and robot.capability("call")["pid"] != pid,
            limit_s=BACK_S,
        )
        _call(page)
    except Exception as err:  # noqa: BLE001 - what went wrong is the finding
        problems.append(f"{str(err)[:120]}: {page.locator('.call').inner_text()[:300]}")
    results.check("V3", problems)


def _call(page: Any) -> None:
    """Call repeatedly, as a person would."""
    for last in (False, False, True):
        page.locator(".call-go").click()
        try:
            page.wait_for_function(PLAYS, arg=FILM, timeout=WAIT_MS / 2)
        except Exception:
            if last or not page.locator(".call-go").is_visible():
                raise
        else:
            return


def _busy_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _megabytes(process: psutil.Process) -> float:
    return round(process.memory_info().rss / 1e6, 1)


@contextmanager
def _robot() -> Iterator[Robot]:
    """Run a robot with a camera at a socket of ours, its page, and calls that are answered at once."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        path = Path(folder) / "pictures"
        Clock(path)
        names = (CAMERA, "web", "call")
        edits = (
            *(f"UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = '{name}'" for name in names),
            only("lbr", *names),
            'UPDATE capability SET settings = \'{"answer": "at_once", "microphone": "tone"}\' WHERE name = \'call\'',
            f"UPDATE device SET address = 'unix:{path}' WHERE type = 'camera'",
        )
        with temporary_home(edits=edits) as home, running(home, profile="lbr") as robot:
            until(lambda: robot.capability("call")["phase"] == "ready", limit_s=20.0)
            yield robot


class Clock:
    """A camera with a clock: a bar of 32 fields, dark or bright, before noise that moves."""

    def __init__(self, path: Path) -> None:
        self._noise = (
            np.random.default_rng(1).integers(60, 200, (HEIGHT // 8, WIDTH // 8, 3), np.uint8).repeat(8, 0).repeat(8, 1)
        )
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

    def _send(self, client: socket.socket) -> None:
        n, due = 0, time.monotonic()
        while True:
            taken_ns = time.monotonic_ns()
            picture = self._picture(n, int(time.time() * 1000) & 0xFFFFFF)
            client.sendall(struct.pack("<IQ", len(picture), taken_ns) + picture)
            n, due = n + 1, due + 1 / FPS
            time.sleep(max(0.0, due - time.monotonic()))

    def _picture(self, n: int, ms: int) -> bytes:
        import cv2

        told = ms << 8 | ((ms ^ ms >> 8 ^ ms >> 16) & 255)
        fields = [235 if told >> (BITS - 1 - bit) & 1 else 20 for bit in range(BITS)]
        image = np.roll(self._noise, 3 * n, axis=1).copy()
        image[:BAR_HIGH] = np.repeat(np.array(fields, np.uint8), WIDTH // BITS)[None, :, None]
        return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 80])[1].tobytes()
