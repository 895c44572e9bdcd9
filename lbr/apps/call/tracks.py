"""Tracks from which aiortc takes the next frame: the camera's newest picture, sound, and the caller's frames.

All of it is for the event loop of the media. A track that is asked late misses pictures, as only the newest counts.
"""

import asyncio
import contextlib
import fractions
import time
from collections import deque

import av
from aiortc import MediaStreamTrack
from aiortc.mediastreams import MediaStreamError

from lbr.apps.call.sound import RATE_HZ, SAMPLES, Source

CLOCK_HZ = 90_000
VIDEO_BASE = fractions.Fraction(1, CLOCK_HZ)
SOUND_BASE = fractions.Fraction(1, RATE_HZ)
OLD_S = 1.0
"""The age of a camera's picture after which it is replaced by a dark one: the camera is off or away."""
DARK = (640, 360)
MOST_SOUND = 25
"""The packets of the caller's sound by which a display may lag: half a second."""


class Pictures:
    """The newest picture, decoded once for all viewers; dark without one."""

    def __init__(self) -> None:
        self.broken = ""
        self._decoder: av.VideoCodecContext | None = None
        self._frame: av.VideoFrame | None = None
        self._number = 0
        self._news = asyncio.Event()
        self._size = DARK
        self._pts = -1
        self._shown_s = -OLD_S

    def show(self, jpeg: bytes, taken_s: float) -> None:
        """Replace the picture; a broken one is skipped."""
        try:
            frame = self._decoded(jpeg)
        except (av.error.FFmpegError, ValueError) as err:
            self.broken = f"a picture of the camera cannot be read: {err}"
            self._decoder = None
            return
        if frame is None:
            return
        self.broken = ""
        self._size = frame.width, frame.height
        self._set(frame, taken_s)
        self._shown_s = time.monotonic()

    async def next(self, after: int) -> tuple[av.VideoFrame | None, int]:
        """Return a picture newer than a number, and its number; a dark one if the camera shows nothing."""
        while self._number <= after:
            news = self._news
            try:
                async with asyncio.timeout(OLD_S):
                    await news.wait()
            except TimeoutError:
                if self._number <= after and time.monotonic() - self._shown_s >= OLD_S:
                    self._set(dark(*self._size), time.monotonic())
        return self._frame, self._number

    def _set(self, frame: av.VideoFrame, taken_s: float) -> None:
        self._pts = max(self._pts + 1, int(taken_s * CLOCK_HZ))  # the time only increases, whatever a camera reports
        frame.pts, frame.time_base = self._pts, VIDEO_BASE
        self._frame, self._number = frame, self._number + 1
        news, self._news = self._news, asyncio.Event()
        news.set()

    def _decoded(self, jpeg: bytes) -> av.VideoFrame | None:
        if self._decoder is None:
            self._decoder = av.CodecContext.create("mjpeg", "r")
            self._decoder.thread_count = 1  # with more threads each picture comes out one later
        found = self._decoder.decode(av.Packet(jpeg))
        return found[-1].reformat(format="yuv420p", dst_color_range="MPEG") if found else None


def dark(width: int, height: int) -> av.VideoFrame:
    """Return a dark picture."""
    frame = av.VideoFrame(width - width % 2, height - height % 2, "yuv420p")
    for plane, value in zip(frame.planes, (16, 128, 128), strict=True):
        plane.update(bytes([value]) * plane.buffer_size)
    return frame


class CameraTrack(MediaStreamTrack):  # type: ignore[misc]
    """The camera's pictures for one page."""

    kind = "video"

    def __init__(self, pictures: Pictures) -> None:
        super().__init__()
        self._pictures = pictures
        self._number = 0

    async def recv(self) -> av.VideoFrame | None:
        """Return the next picture."""
        if self.readyState != "live":
            raise MediaStreamError
        frame, self._number = await self._pictures.next(self._number)
        return frame


class SoundTrack(MediaStreamTrack):  # type: ignore[misc]
    """The sound for the caller: a packet each 20 ms."""

    kind = "audio"

    def __init__(self, source: Source) -> None:
        super().__init__()
        self._source = source
        self._began: float | None = None
        self._n = 0

    async def recv(self) -> av.AudioFrame:
        """Return the next packet at its time."""
        if self.readyState != "live":
            raise MediaStreamError
        now = time.monotonic()
        if self._began is None:
            self._began = now
        due = self._began + self._n * SAMPLES / RATE_HZ
        if due > now:
            await asyncio.sleep(due - now)
        elif now - due > 1.0:  # the machine slept, or was too busy: skip the unsent packets
            self._n += int((now - due) * RATE_HZ / SAMPLES)
        frame = av.AudioFrame(format="s16", layout="mono", samples=SAMPLES)
        frame.planes[0].update(self._source.next())
        frame.sample_rate, frame.pts, frame.time_base = RATE_HZ, self._n * SAMPLES, SOUND_BASE
        self._n += 1
        return frame


class Fan:
    """The caller's sound and picture, for all displays; without displays they are dropped."""

    def __init__(self) -> None:
        self._displays: set[RelayTrack] = set()
        self.count = 0

    def track(self, kind: str) -> "RelayTrack":
        """Return a track for one display."""
        made = RelayTrack(kind, self)
        self._displays.add(made)
        return made

    def leave(self, track: "RelayTrack") -> None:
        """Remove a display's track."""
        self._displays.discard(track)

    async def take(self, track: MediaStreamTrack) -> None:
        """Pass on the frames of a caller's track, until it ends."""
        with contextlib.suppress(MediaStreamError):
            while True:
                frame = await track.recv()
                self.count += 1
                for display in list(self._displays):
                    if display.kind == track.kind:
                        display.give(frame)


class RelayTrack(MediaStreamTrack):  # type: ignore[misc]
    """The caller's picture or sound for one display."""

    def __init__(self, kind: str, fan: Fan) -> None:
        super().__init__()
        self.kind = kind
        self._fan = fan
        self._frames: deque[av.VideoFrame | av.AudioFrame] = deque(maxlen=1 if kind == "video" else MOST_SOUND)
        self._news = asyncio.Event()

    def give(self, frame: av.VideoFrame | av.AudioFrame) -> None:
        """Add a frame."""
        self._frames.append(frame)
        self._news.set()

    async def recv(self) -> av.VideoFrame | av.AudioFrame:
        """Return the next frame."""
        while self.readyState == "live":
            if self._frames:
                return self._frames.popleft()
            self._news.clear()
            await self._news.wait()
        raise MediaStreamError

    def stop(self) -> None:
        """End the track."""
        super().stop()
        self._fan.leave(self)
        self._news.set()
