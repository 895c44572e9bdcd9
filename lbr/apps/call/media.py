"""The WebRTC connections: a thread with its own event loop, in which aiortc encodes and decodes.

Any thread may call the methods; results are in `news`. No server is asked for addresses: browser and robot find each
other within their network, or not at all.
"""

import asyncio
import ctypes
import gc
import threading
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

import aioice.ice
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcrtpsender import RTCRtpSender

from lbr.apps.call.desk import without_names
from lbr.apps.call.messages import Hears, Purpose
from lbr.apps.call.sound import Source
from lbr.apps.call.tracks import CameraTrack, Fan, Pictures, SoundTrack
from lbr.capability.border import border
from lbr.errors import told

CLOSE_S = 3.0
SPOKEN = {"video/VP8", "video/rtx"}
_libc = ctypes.CDLL(None)
_addresses = aioice.ice.get_host_addresses


def _or_loopback(*, use_ipv4: bool, use_ipv6: bool) -> list[str]:
    """Return this machine's addresses; without any, the loopback address, for browsers here that allow it."""
    return _addresses(use_ipv4=use_ipv4, use_ipv6=use_ipv6) or (["127.0.0.1"] if use_ipv4 else [])


aioice.ice.get_host_addresses = _or_loopback


@dataclass(frozen=True, slots=True)
class PeerNews:
    """The result of a connection; `text` is the answer to the offer, or the reason without one."""

    id: str
    outcome: Literal["answer", "refused", "connected", "lost"]
    text: str = ""


class Media:
    """The connections by guest. `wake` is called for each piece of news."""

    def __init__(self, wake: Callable[[], None], microphone: str, *, simulated: bool) -> None:
        self.news: deque[PeerNews] = deque()
        self._wake = wake
        self._loop = asyncio.new_event_loop()
        self._source = Source(microphone, simulated=simulated)
        self._peers: dict[str, _Peer] = {}
        self._working: set[asyncio.Task[None]] = set()
        self._newest: tuple[bytes, float] | None = None
        self._pictures: Pictures | None = None
        self._fan = Fan()
        self._thread = threading.Thread(target=self._run, name="media", daemon=True)
        self._thread.start()

    @property
    def sound(self) -> str:
        """The sound for a caller, in words."""
        return self._source.text

    @property
    def hears(self) -> Hears:
        """The sound for a caller, in a word."""
        return self._source.hears

    @property
    def broken(self) -> str:
        """Why the newest picture cannot be shown; empty if it can."""
        return self._pictures.broken if self._pictures is not None else ""

    @property
    def received(self) -> int:
        """The number of frames received from callers, of picture and sound."""
        return self._fan.count

    def connect(self, id: str, purpose: Purpose, offer: str) -> None:
        """Answer an offer."""
        self._soon(lambda: self._start(self._connect(id, purpose, offer)))

    def close(self, id: str) -> None:
        """Close a connection, if there is one."""
        self._soon(lambda: self._start(self._close(id)))

    def show(self, jpeg: bytes, taken_s: float) -> None:
        """Replace the newest picture."""
        self._newest = jpeg, taken_s
        self._soon(self._show)

    def stop(self) -> None:
        """Close everything, and end the thread."""
        if self._thread.is_alive():
            self._soon(lambda: self._start(self._end()))
            self._thread.join(CLOSE_S + 1.0)

    def _soon(self, then: Callable[[], object]) -> None:
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(then)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._pictures = Pictures()
        try:
            self._loop.run_forever()
            while left := asyncio.all_tasks(self._loop):  # a connection that is cut short closes itself in tasks
                for task in left:
                    task.cancel()
                self._loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
        finally:
            self._loop.close()

    def _start(self, work: Coroutine[object, object, None]) -> asyncio.Task[None]:
        task = self._loop.create_task(work)
        self._working.add(task)
        task.add_done_callback(self._working.discard)
        return task

    def _show(self) -> None:
        newest, self._newest = self._newest, None
        if newest is not None and self._pictures is not None and self._peers:
            self._pictures.show(*newest)

    def _emit(self, news: PeerNews) -> None:
        self.news.append(news)
        self._wake()

    async def _connect(self, id: str, purpose: Purpose, offer: str) -> None:
        assert self._pictures is not None
        peer = self._peers[id] = _Peer(id, self._emit, self._start)
        peer.begun = asyncio.current_task()
        faults: list[Exception] = []
        with border(faults.append):  # a page's bad offer must not end the calls of others
            if purpose == "display":
                peer.send(self._fan.track("video"))
                peer.send(self._fan.track("audio"))
            else:
                peer.send(CameraTrack(self._pictures))
            if purpose == "talk":
                peer.send(SoundTrack(self._source))
                peer.take(self._fan)
                self._source.begin()
            self._emit(PeerNews(id, "answer", await peer.answer(offer)))
        for err in faults:
            await self._close(id)
            self._emit(PeerNews(id, "refused", f"the offer cannot be answered: {told(err)}"))

    async def _close(self, id: str) -> None:
        peer = self._peers.pop(id, None)
        if peer is None:
            return
        if peer.begun is not None and peer.begun is not asyncio.current_task():
            await asyncio.wait({peer.begun}, timeout=CLOSE_S)  # else sockets being opened now would stay open
        if peer.talks and not any(one.talks for one in self._peers.values()):
            await asyncio.to_thread(self._source.end)
        await peer.close()
        gc.collect()  # connections are reference cycles, with encoders of some megabytes
        with suppress(AttributeError):  # a C library that is not glibc
            _libc.malloc_trim(0)  # each thread of a codec leaves a heap behind

    async def _end(self) -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(CLOSE_S):
                for name in list(self._peers):
                    await self._close(name)
                while closing := self._working - {asyncio.current_task()}:
                    await asyncio.wait(closing)
        self._loop.stop()


def apart(answer: str) -> str:
    """Return an answer with its sound in another stream than its picture.

    A browser delays pictures until the sound of the same stream arrives, and sound arrives later. A driver needs the
    picture at once.
    """
    before, sound, after = answer.partition("m=audio")
    media, video, rest = after.partition("m=video")
    return before + sound + media.replace("a=msid:", "a=msid:sound-") + video + rest


class _Peer:
    """One connection, with the tracks that it sends and receives."""

    def __init__(
        self,
        id: str,
        emit: Callable[[PeerNews], None],
        start: Callable[[Coroutine[Any, Any, None]], asyncio.Task[None]],
    ) -> None:
        self.talks = False
        self.begun: asyncio.Task[None] | None = None
        self._id = id
        self._emit = emit
        self._start = start
        self._connection = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self._tracks: list[Any] = []
        self._taking: list[asyncio.Task[None]] = []
        self._connection.on("connectionstatechange", self._changed)

    def send(self, track: Any) -> None:
        """Send a track; pictures are always VP8."""
        self._tracks.append(track)
        self._connection.addTrack(track)
        if track.kind == "video":
            codecs = [one for one in RTCRtpSender.getCapabilities("video").codecs if one.mimeType in SPOKEN]
            self._connection.getTransceivers()[-1].setCodecPreferences(codecs)

    def take(self, fan: Fan) -> None:
        """Receive the caller's tracks."""
        self.talks = True
        self._connection.on("track", lambda track: self._taking.append(self._start(fan.take(track))))

    async def answer(self, offer: str) -> str:
        """Return the answer to an offer."""
        connection = self._connection
        await connection.setRemoteDescription(RTCSessionDescription(sdp=without_names(offer), type="offer"))
        answer = await connection.createAnswer()
        await connection.setLocalDescription(answer)
        told = str(connection.localDescription.sdp)
        return apart(told) if self.talks else told

    async def close(self) -> None:
        """Close the connection."""
        self._connection.remove_all_listeners()
        for track in self._tracks:
            track.stop()
        for taking in self._taking:  # tracks of an incomplete connection do not end by themselves
            taking.cancel()
        await self._connection.close()

    def _changed(self) -> None:
        state = self._connection.connectionState
        if state == "connected":
            self._emit(PeerNews(self._id, "connected"))
        elif state in {"failed", "closed"}:
            self._emit(PeerNews(self._id, "lost", "the connection of picture and sound is lost"))
