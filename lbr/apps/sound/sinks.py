"""The sinks of sound: a sound card by `aplay`, whose exit code is reliable, or a folder that takes as long."""

import contextlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from lbr.apps.sound.wav import Wav
from lbr.capability.die_with_parent import dying_with_parent
from lbr.errors import DeviceError

ALSA = "alsa:"
FILES_KEPT = 50
GRACE_S = 5.0
"""The time beyond its sound after which a player counts as stuck."""
_WORDS_BYTES = 4000
Clock = Callable[[], float]


class Playback(Protocol):
    """One sound being played, since `began` on our clock."""

    began: float

    def poll(self) -> str | None:
        """Return None while it plays, then an empty text at its end, or the reason why it failed."""

    def stop(self) -> None:
        """End it now."""


class Sink(Protocol):
    """A sink; `immediate` if a sound counts as played as soon as it has begun."""

    address: str
    immediate: bool

    def start(self, sound: Wav) -> Playback:
        """Begin to play; raise DeviceError with the cure if that fails."""


def sink_at(address: str, clock: Clock) -> Sink:
    """Return the sink of a device row's address."""
    if address.startswith(ALSA) and len(address) > len(ALSA):
        return AlsaSink(address, clock)
    if address.startswith("/"):
        return FolderSink(address, clock)
    raise DeviceError(f"'{address}' is no place for sound; alsa:DEVICE, such as alsa:default, or a folder is")


class AlsaSink:
    """A sound card, by the program aplay."""

    immediate = False

    def __init__(self, address: str, clock: Clock) -> None:
        self.address = address
        self._clock = clock

    def start(self, sound: Wav) -> Playback:
        """Start aplay, which dies with this process."""
        player = shutil.which("aplay")
        if player is None:
            raise DeviceError("there is no program to play sound with; `sudo apt install alsa-utils` brings aplay")
        argv = [player, "-q", "-D", self.address.removeprefix(ALSA), str(sound.path)]
        return _Aplay(self.address, argv, sound.duration_s, self._clock)


class _Aplay:
    def __init__(self, address: str, argv: list[str], duration_s: float, clock: Clock) -> None:
        self._address = address
        self._clock = clock
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the playback
        try:
            self._popen = subprocess.Popen(
                dying_with_parent(tuple(argv)), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._words
            )
        except OSError as err:
            self._words.close()
            raise DeviceError(f"aplay cannot be started: {err.strerror}") from err
        self.began = clock()
        self._until = self.began + duration_s + GRACE_S
        self._result: str | None = None

    def poll(self) -> str | None:
        if self._result is None:
            code = self._popen.poll()
            if code is not None:
                self._end("" if code == 0 else self._failure(code))
            elif not self._clock() < self._until:
                self.stop()
                self._result = f"aplay did not come to its end at {self._address}; is another program using the card?"
        return self._result

    def stop(self) -> None:
        if self._result is None:
            self._popen.kill()
            self._popen.wait()
            self._end("")

    def _end(self, result: str) -> None:
        self._result = result
        self._words.close()

    def _failure(self, code: int) -> str:
        self._words.seek(0)
        lines = self._words.read(_WORDS_BYTES).decode("utf-8", "replace").split("\n")
        said = next((line.strip() for line in reversed(lines) if line.strip()), f"aplay ended with {code}")
        readable = "".join(char if char.isprintable() else "?" for char in said[:200])
        return f"no sound at {self._address} ({readable}); `aplay -L` lists what there is, the device row names one"


class FolderSink:
    """A folder of numbered WAV files, the newest fifty: the emulated speaker."""

    immediate = True

    def __init__(self, address: str, clock: Clock) -> None:
        self.address = address
        self._folder = Path(address)
        self._clock = clock

    def start(self, sound: Wav) -> Playback:
        """Copy the sound into the folder under the next number."""
        try:
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            numbers = sorted(int(path.stem) for path in self._folder.glob("*.wav") if path.stem.isdecimal())
            target = self._folder / f"{(numbers or [0])[-1] + 1:06}.wav"
            _copy(sound.path, target)
            for number in numbers[: -FILES_KEPT + 1]:
                (self._folder / f"{number:06}.wav").unlink(missing_ok=True)
        except OSError as err:
            why = f"the folder {self.address} takes no sound ({err.strerror or err}); check that it can be written"
            raise DeviceError(why) from err
        return _Pretended(sound.duration_s, self._clock)


class _Pretended:
    def __init__(self, duration_s: float, clock: Clock) -> None:
        self.began = clock()
        self._until = self.began + duration_s
        self._clock = clock

    def poll(self) -> str | None:
        return None if self._clock() < self._until else ""

    def stop(self) -> None:
        self._until = self.began


def _copy(source: Path, target: Path) -> None:
    with contextlib.suppress(OSError):
        os.link(source, target)
        return
    shutil.copyfile(source, target)
