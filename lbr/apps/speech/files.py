"""The files below `$LBR_HOME`: recordings in `sounds`, of any format; songs in `music`, WAV files; both by name."""

from contextlib import suppress
from pathlib import Path

from lbr.apps.sound import formats, names, wav
from lbr.apps.sound.wav import Wav
from lbr.errors import InputError

MOST_RECORDINGS = 200
_SUFFIXES = (formats.WAV, *formats.OTHERS)
_PCM = b"\x01\x00"
"""As the head of a WAV file names it."""


def recording(home: Path, name: str) -> Wav | Path:
    """Return a recording, or the file that has to be decoded first; raise InputError naming which it may have been."""
    folder, name = home / "sounds", names.checked(name.lower(), "recording")
    path = next((path for suffix in _SUFFIXES if (path := folder / f"{name}{suffix}").is_file()), None)
    if path is None:
        raise names.unknown(folder, name, "recording", *_SUFFIXES)
    if path.suffix != formats.WAV:
        formats.ensure_decodable(path)
        return path
    return path if _compressed(path) and formats.decodes() else wav.read(path)


def song(home: Path, name: str) -> Wav:
    """Return a song; raise InputError naming which it may have been."""
    folder = home / "music"
    path = folder / f"{names.checked(name, 'song')}{formats.WAV}"
    if not path.is_file():
        raise names.unknown(folder, name, "song", formats.WAV)
    return wav.read(path)


def place_for(home: Path, name: str) -> Path:
    """Return where a recording is to be kept; one of the same name is replaced."""
    folder = home / "sounds"
    path = folder / f"{names.checked(name.lower(), 'recording')}.wav"
    known = names.stems(folder, ".wav")
    if path.stem not in known and len(known) >= MOST_RECORDINGS:
        raise InputError(f"there are {MOST_RECORDINGS} recordings already; remove some from {folder}")
    return path


def _compressed(path: Path) -> bool:
    """Return whether a file is WAV, but of another coding than PCM."""
    with suppress(OSError), path.open("rb") as file:
        head = file.read(22)
        return head[:4] == b"RIFF" and head[12:16] == b"fmt " and head[20:22] != _PCM
    return False
