"""Decodes a sound file to PCM WAV, in a process of its own: `python -m lbr.apps.sound.decode FROM TO`.

People put any file into a folder, so it is read by a process that may crash, hang and be killed. The library may read
the file only: no network, and no formats that name other files. Without sound in the file the exit code is 1, with one
sentence on the standard error.
"""

import resource
import sys
import wave
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lbr.apps.sound import formats
from lbr.capability.border import border
from lbr.errors import InputError, LbrError, told

RATE_HZ = 44_100
LONGEST_S = 1800.0
MEMORY_BYTES = 2 << 30
CONTAINERS = "wav,w64,aiff,caf,au,mp3,flac,ogg,amr,aac,asf,matroska,webm,mov,mp4,m4a,3gp,3g2,mj2"
"""The formats that FFmpeg may detect, by its own names; none of them opens other files."""
OPTIONS = {"format_whitelist": CONTAINERS, "protocol_whitelist": "none"}


def decode(source: Path, target: Path) -> None:
    """Write a file's sound, as mono PCM WAV; raise InputError with the fault of the file."""
    formats.ensure_decodable(source)
    import av

    try:
        with source.open("rb") as file, av.open(file, "r", options=OPTIONS, **_whatever_its_tags(av)) as container:
            if not container.streams.audio:
                raise InputError(f"{source} has no sound in it")
            written = _write(target, _sound(av, container), source)
    except av.error.FFmpegError as err:
        why = f"{err.strerror or err}"
        raise InputError(f"{source} cannot be decoded ({why}); is it a sound file, and whole?") from err
    except OSError as err:
        raise InputError(f"{source} cannot be read ({err.strerror or err})") from err
    if not written:
        raise InputError(f"{source} holds no sound that can be decoded; is it damaged?")


def _whatever_its_tags(av: Any) -> dict[str, str]:
    """Return the options for files whose tags have no known encoding, which PyAV needs before 19."""
    return {"metadata_errors": "ignore"} if int(av.__version__.partition(".")[0]) < 19 else {}


def _sound(av: Any, container: Any) -> Iterator[bytes]:
    """Yield the samples, piece by piece; damaged pieces are left out."""
    resampler = av.AudioResampler(format="s16", layout="mono", rate=RATE_HZ)
    for packet in container.demux(container.streams.audio[0]):
        try:
            frames = packet.decode()
        except av.error.InvalidDataError:
            continue
        for frame in frames:
            yield from _samples(resampler.resample(frame))
    yield from _samples(resampler.resample(None))


def _samples(frames: Any) -> Iterator[bytes]:
    for frame in frames:
        yield bytes(frame.planes[0])[: frame.samples * 2]


def _write(target: Path, pieces: Iterator[bytes], source: Path) -> int:
    written = 0
    with wave.open(str(target), "wb") as recording:
        recording.setparams((1, 2, RATE_HZ, 0, "NONE", ""))
        for piece in pieces:
            written += len(piece)
            if written > LONGEST_S * RATE_HZ * 2:
                raise InputError(f"{source} would play for more than {LONGEST_S:.0f} s; cut it")
            recording.writeframesraw(piece)
    return written


def main(argv: list[str]) -> int:
    """Decode one file."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    source, target = argv
    faults: list[Exception] = []
    with border(faults.append):
        decode(Path(source), Path(target))
    for err in faults:
        print(err if isinstance(err, LbrError) else f"{source} cannot be decoded ({told(err)})", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
