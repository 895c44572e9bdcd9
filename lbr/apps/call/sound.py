"""The sound for a caller: the robot's microphone by `arecord`, a test tone, or silence."""

import math
import shutil
import subprocess
import tempfile
import threading
from array import array
from collections import deque
from collections.abc import Callable
from itertools import chain, repeat

from lbr.apps.call.messages import Hears
from lbr.capability.die_with_parent import dying_with_parent

RATE_HZ = 48_000
SAMPLES = RATE_HZ // 50
"""The samples of a packet: 20 ms, as in Opus."""
BYTES = SAMPLES * 2
SILENCE = bytes(BYTES)
MOST_WAITING = 5
"""The packets by which a slow caller may lag; older ones are dropped."""
TONE = "tone"
TONE_HZ, TONE_LEVEL, TONE_PACKETS, TONE_EVERY = 440.0, 900, 10, 100
"""A soft tone for a fifth of a second, every two seconds."""
AGAIN_S = 5.0
END_S = 2.0
_WORDS = 500


def tone() -> tuple[bytes, ...]:
    """Return the packets of one period of the test tone."""
    count = SAMPLES * TONE_PACKETS
    wave = array("h", (int(_fade(n, count) * math.sin(2 * math.pi * TONE_HZ * n / RATE_HZ)) for n in range(count)))
    data = wave.tobytes()
    heard = (data[at : at + BYTES] for at in range(0, len(data), BYTES))
    return tuple(chain(heard, repeat(SILENCE, TONE_EVERY - TONE_PACKETS)))


def _fade(n: int, count: int) -> float:
    return TONE_LEVEL * min(1.0, n / SAMPLES, (count - n) / SAMPLES)


class Source:
    """The present sound, packet by packet; `text` describes it, `hears` names its kind."""

    def __init__(self, device: str, *, simulated: bool) -> None:
        self._device = device
        self._packets: deque[bytes] = deque(maxlen=MOST_WAITING)
        self._recorder: _Recorder | None = None
        self._tone = tone() if device == TONE or (simulated and device) else ()
        self._n = 0
        self.hears: Hears = "tone" if self._tone else "silence"
        if self._tone:
            self.text = "a test tone in the place of a microphone" + (": the robot is simulated" if simulated else "")
        elif device:
            self.text = f"silence: the microphone '{device}' has not begun"
        else:
            self.text = "silence: this robot's row names no microphone"

    def begin(self) -> None:
        """Open the microphone, if there is one; it is open only during a call."""
        if self._recorder is None and self._device and not self._tone:
            self._recorder = _Recorder(self._device, self._receive, self._lose)

    def next(self) -> bytes:
        """Return 20 ms of sound; silence without sound."""
        if self._tone:
            self._n = (self._n + 1) % len(self._tone)
            return self._tone[self._n]
        try:
            return self._packets.popleft()
        except IndexError:
            return SILENCE

    def end(self) -> None:
        """Close the microphone."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            recorder.end()
            self._lose("there is no call")

    def _receive(self, packet: bytes) -> None:
        self._packets.append(packet)
        self.hears, self.text = "microphone", f"the microphone '{self._device}'"

    def _lose(self, why: str) -> None:
        self._packets.clear()
        self.hears, self.text = "silence", f"silence: no microphone at '{self._device}' ({why})"


class _Recorder:
    """A thread that reads the sound of `arecord`, and restarts it when it ends."""

    def __init__(self, device: str, receive: Callable[[bytes], None], lose: Callable[[str], None]) -> None:
        self._device = device
        self._receive = receive
        self._lose = lose
        self._over = threading.Event()
        self._popen: subprocess.Popen[bytes] | None = None
        self._thread = threading.Thread(target=self._run, name="microphone", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Close the microphone."""
        self._over.set()
        popen = self._popen
        if popen is not None:
            popen.kill()
        self._thread.join(END_S)

    def _run(self) -> None:
        while not self._over.is_set():
            why = self._recorded()
            if not self._over.is_set():
                self._lose(why)
            self._over.wait(AGAIN_S)

    def _recorded(self) -> str:
        """Record until arecord ends; return the reason."""
        program = shutil.which("arecord")
        if program is None:
            return "`sudo apt install alsa-utils` brings arecord"
        argv = (program, "-q", "-t", "raw", "-f", "S16_LE", "-r", str(RATE_HZ), "-c", "1", "-D", self._device)
        with tempfile.TemporaryFile() as words:
            try:
                popen = subprocess.Popen(
                    dying_with_parent(argv), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=words
                )
            except OSError as err:
                return f"arecord cannot be started: {err.strerror}"
            self._popen = popen
            assert popen.stdout is not None
            with popen:
                while not self._over.is_set() and len(packet := popen.stdout.read(BYTES)) == BYTES:
                    self._receive(packet)
                popen.kill()
            words.seek(0)
            said = words.read(_WORDS).decode("utf-8", "replace").strip().split("\n")[-1]
        return "".join(char if char.isprintable() else "?" for char in said[:160]) or "arecord ended"
