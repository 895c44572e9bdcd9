"""WAV files: their length, their loudness, and writing small ones. Only PCM, which every sink can play."""

import stat
import wave
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from msgspec import Struct

from lbr import disk
from lbr.errors import InputError

SILENT_PEAK = 0.002
LONGEST_S = 4 * 3600.0
_BLOCK_FRAMES = 1 << 16


class Wav(Struct, frozen=True):
    """The header of a WAV file, checked against the size of the file."""

    path: Path
    duration_s: float


def read(path: Path) -> Wav:
    """Read a header; raise InputError with the file unless it is PCM WAV with sound in it."""
    with _opened(path) as sound:
        rate, frames = sound.getframerate(), sound.getnframes()
        held = path.stat().st_size // max(1, sound.getnchannels() * sound.getsampwidth())
    if rate <= 0 or min(frames, held) <= 0:
        raise InputError(f"{path} holds no sound")
    duration_s = min(frames, held) / rate
    if not duration_s <= LONGEST_S:
        raise InputError(f"{path} would play for {duration_s:.0f} s; {LONGEST_S:.0f} s are allowed")
    return Wav(path, duration_s)


def peak(path: Path) -> float:
    """Return the largest amplitude in a file, 0 to 1; reads all of it."""
    with _opened(path) as sound:
        blocks = iter(lambda: sound.readframes(_BLOCK_FRAMES), b"")
        return max((_peak(block, sound.getsampwidth()) for block in blocks), default=0.0)


def samples(path: Path) -> bytes:
    """Return all samples of a file, unchanged."""
    with _opened(path) as sound:
        return sound.readframes(sound.getnframes())


def write(path: Path, samples: bytes, rate_hz: int, width: int = 1) -> None:
    """Write mono samples, as a whole file or not at all; bytes are unsigned, around 128."""
    with disk.replacing(path) as draft, wave.open(str(draft), "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(width)
        sound.setframerate(rate_hz)
        sound.writeframes(samples)


@contextmanager
def _opened(path: Path) -> Iterator[wave.Wave_read]:
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise InputError(f"{path} is not a file")
        with path.open("rb") as file, wave.open(file) as sound:
            yield sound
    except OSError as err:
        raise InputError(f"{path} cannot be read ({err.strerror or err})") from err
    except (wave.Error, EOFError, ValueError, ArithmeticError, RuntimeError) as err:  # the errors of `wave`
        if isinstance(err, InputError):
            raise
        why = str(err) or "it ends too soon"
        raise InputError(
            f"{path} is not a PCM WAV file ({why}); `ffmpeg -i FILE -c:a pcm_s16le OUT.wav` makes one"
        ) from err


def _peak(block: bytes, width: int) -> float:
    if width == 1:
        return max(max(block) - 128, 128 - min(block)) / 128
    block = block[: len(block) // width * width]
    top = bytearray(len(block) // width * 2)  # the two highest bytes of each sample, little endian
    top[0::2], top[1::2] = block[width - 2 :: width], block[width - 1 :: width]
    samples = array("h", bytes(top))
    loudest, lowest = max(samples), min(samples)
    return max(loudest, -lowest) / 32768
