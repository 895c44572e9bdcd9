"""The sound files below `$LBR_HOME`, by name: recordings in `sounds`, of any format, and songs in `music`, as WAV."""

from contextlib import suppress
from pathlib import Path

from lbr.apps.sound import formats, names, wav
from lbr.apps.sound.wav import Wav
from lbr.errors import InputError

MOST_RECORDINGS = 200
_SUFFIXES = (formats.WAV, *formats.OTHERS)
_PCM = b"\x01\x00"
"""The format code of PCM in the head of a WAV file."""


def recording(home: Path, name: str) -> Wav | Path:
    """Return a recording, or the file to decode first; raise InputError with similar names."""
    folder, name = home / "sounds", names.checked(name.lower(), "recording")
    path = next((path for suffix in _SUFFIXES if (path := folder / f"{name}{suffix}").is_file()), None)
    if path is None:
        raise names.unknown(folder, name, "recording", *_SUFFIXES)
    if path.suffix != formats.WAV:
        formats.ensure_decodable(path)
        return path
    return path if _compressed(path) and formats.decodes() else wav.read(path)


def song(home: Path, name: str) -> Wav:
    """Return a song; raise InputError with similar names."""
    folder = home / "music"
    path = folder / f"{names.checked(name, 'song')}{formats.WAV}"
    if not path.is_file():
        raise names.unknown(folder, name, "song", formats.WAV)
    return wav.read(path)


def place_for(home: Path, name: str) -> Path:
    """Return the path for a new recording, which may replace an old one."""
    folder = home / "sounds"
    path = folder / f"{names.checked(name.lower(), 'recording')}.wav"
    known = names.stems(folder, ".wav")
    if path.stem not in known and len(known) >= MOST_RECORDINGS:
        raise InputError(f"there are {MOST_RECORDINGS} recordings already; remove some from {folder}")
    return path


def _compressed(path: Path) -> bool:
    """Return whether a WAV file has another coding than PCM."""
    with suppress(OSError), path.open("rb") as file:
        head = file.read(22)
        return head[:4] == b"RIFF" and head[12:16] == b"fmt " and head[20:22] != _PCM
    return False
