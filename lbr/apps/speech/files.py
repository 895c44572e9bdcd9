"""What is kept below `$LBR_HOME`: recordings in `sounds`, songs in `music`; WAV files by name."""

from pathlib import Path

from lbr.apps.sound import names, wav
from lbr.apps.sound.wav import Wav
from lbr.capability.did_you_mean import did_you_mean
from lbr.errors import InputError

MOST_RECORDINGS = 200


def recording(home: Path, name: str) -> Wav:
    """Return a recording; raise InputError naming which it may have been."""
    return _known(home / "sounds", names.checked(name.lower(), "recording"), "recording")


def song(home: Path, name: str) -> Wav:
    """Return a song; raise InputError naming which it may have been."""
    return _known(home / "music", names.checked(name, "song"), "song")


def place_for(home: Path, name: str) -> Path:
    """Return where a recording is to be kept; one of the same name is replaced."""
    folder = home / "sounds"
    path = folder / f"{names.checked(name.lower(), 'recording')}.wav"
    known = names.stems(folder, ".wav")
    if path.stem not in known and len(known) >= MOST_RECORDINGS:
        raise InputError(f"there are {MOST_RECORDINGS} recordings already; remove some from {folder}")
    return path


def _known(folder: Path, name: str, what: str) -> Wav:
    path = folder / f"{name}.wav"
    if not path.is_file():
        raise InputError(
            f"there is no {what} '{name}' in {folder}; {did_you_mean(name, names.stems(folder, '.wav'))}",
            "unknown_name",
        )
    return wav.read(path)
