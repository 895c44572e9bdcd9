"""A caller without a browser: the other end of a connection, in an event loop of its own."""

import asyncio
import io
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any

from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.mediastreams import AudioStreamTrack, MediaStreamError, VideoStreamTrack
from PIL import Image

from lbr.apps.call.media import Media
from tests.support.waiting import HANG_S

GREY, WHITE = 90, 250


def jpeg(level: int, size: tuple[int, int] = (64, 48)) -> bytes:
    """Return a picture of one grey."""
    kept = io.BytesIO()
    Image.new("RGB", size, (level,) * 3).save(kept, "JPEG", quality=90)
    return kept.getvalue()


class Caller:
    """`levels` are the mean brightness of each picture that came, `sound` the loudest sample of each packet."""

    def __init__(self) -> None:
        self.levels: list[float] = []
        self.sizes: set[tuple[int, int]] = set()
        self.sound: list[int] = []
        self.codecs: list[str] = []
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        self._tasks: set[Any] = set()
        self._connection: RTCPeerConnection | None = None

    def offer(self, purpose: str = "talk") -> str:
        """Return an offer, complete with addresses."""
        return self._run(self._offer(purpose))

    def take(self, answer: str) -> None:
        """Take the robot's answer."""
        self._run(self._take(answer))

    def close(self) -> None:
        """Hang up, without a word."""
        self._run(self._close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5.0)
        self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()

    def _run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(HANG_S)

    async def _offer(self, purpose: str) -> str:
        connection = self._connection = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        connection.on("track", lambda track: self._start(self._watch(track)))
        if purpose == "talk":
            connection.addTrack(VideoStreamTrack())
            connection.addTrack(AudioStreamTrack())
        else:
            connection.addTransceiver("video", direction="recvonly")
            if purpose == "display":
                connection.addTransceiver("audio", direction="recvonly")
        await connection.setLocalDescription(await connection.createOffer())
        return str(connection.localDescription.sdp)

    async def _take(self, answer: str) -> None:
        assert self._connection is not None
        self.codecs = [line.split(" ")[1] for line in answer.splitlines() if line.startswith("a=rtpmap")]
        await self._connection.setRemoteDescription(RTCSessionDescription(answer, "answer"))

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _watch(self, track: Any) -> None:
        try:
            while True:
                frame = await track.recv()
                if track.kind == "video":
                    self.levels.append(float(frame.to_ndarray(format="gray").mean()))
                    self.sizes.add((frame.width, frame.height))
                else:
                    self.sound.append(int(abs(frame.to_ndarray().astype(int)).max()))
        except MediaStreamError:
            return

    async def _close(self) -> None:
        if self._connection is not None:
            await self._connection.close()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.sleep(0)  # for sockets, which close in the round after


class Camera:
    """Shows a picture of one grey, fifteen a second, until it is closed or unplugged."""

    def __init__(self, show: Callable[[bytes, float], None]) -> None:
        self.level: int | None = GREY
        self.raw = b""
        self._show = show
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        """Show no more."""
        self._over.set()
        self._thread.join(5.0)

    def _run(self) -> None:
        while not self._over.wait(1 / 15):
            if self.raw:
                self._show(self.raw, time.monotonic())
            elif self.level is not None:
                self._show(jpeg(self.level), time.monotonic())


def news(media: Media, what: str, name: str) -> str | None:
    """Return the text of what happened to a connection, once it has; what else happened is passed over."""
    while media.news:
        found = media.news.popleft()
        if (found.id, found.outcome) == (name, what):
            return found.text
    return None
