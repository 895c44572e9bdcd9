"""Checks the names of songs and recordings, which become names of files."""

import re
from pathlib import Path

from lbr.errors import InputError
from lbr.names import did_you_mean

_ALLOWED = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")


def checked(name: str, subject: str) -> str:
    """Return a name that cannot lead out of its folder; raise InputError with the allowed characters."""
    if not _ALLOWED.fullmatch(name):
        readable = "".join(char if char.isprintable() else "?" for char in name[:40])
        raise InputError(f"{subject} '{readable}': letters, digits, _ and - are allowed, 64 at most")
    return name


def stems(folder: Path, *suffixes: str) -> list[str]:
    """Return the names of a folder's files with these suffixes, in order; empty without the folder."""
    try:
        return sorted({path.stem for path in folder.iterdir() if path.suffix in suffixes and path.is_file()})
    except OSError:
        return []


def unknown(folder: Path, name: str, subject: str, *suffixes: str) -> InputError:
    """Return the refusal of a name without a file, with similar names."""
    meant = did_you_mean(name, stems(folder, *suffixes))
    return InputError(f"there is no {subject} '{name}' in {folder}; {meant}", "unknown_name")
