"""The file formats of recordings besides PCM WAV, and whether this computer can decode them."""

from importlib.util import find_spec
from pathlib import Path

from lbr.errors import InputError

WAV = ".wav"
OTHERS = (
    ".mp3", ".flac", ".ogg", ".oga", ".opus", ".m4a", ".mp4", ".aac", ".amr", ".awb", ".3gp", ".webm", ".mka",
    ".aif", ".aiff", ".caf", ".wma",
)  # fmt: skip
"""In the order in which files of one name count. PCM WAV, which needs no decoding, comes before them."""
LIBRARY = "av"
INSTALL = "`pip install 'lbr[recordings]'` brings what decodes it"


def decodes() -> bool:
    """Return whether the library that decodes files is installed."""
    return find_spec(LIBRARY) is not None


def ensure_decodable(path: Path) -> None:
    """Raise InputError with the missing package if no library decodes files."""
    if not decodes():
        raise InputError(f"{path} is not a PCM WAV file, and nothing here decodes it; {INSTALL}", "not_possible")
