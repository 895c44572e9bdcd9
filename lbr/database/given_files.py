"""Files that a person names, read as a whole: only regular ones, none too large, and those of a folder in order."""

import os
import stat
from contextlib import suppress
from pathlib import Path

from lbr.errors import InputError

MOST_FILES = 500
"""The files in a folder; more are not a robot's data."""
UTF_16 = {b"\xff\xfe", b"\xfe\xff"}
"""The marks at the beginning of a UTF-16 file."""


def read(path: Path, largest_bytes: int) -> bytes:
    """Return the content of a file; raise InputError if it is unreadable, not a regular file, or too large."""
    try:
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # a pipe without a writer must not block
    except OSError as err:
        raise InputError(f"{path} cannot be read: {err.strerror}") from err
    status = os.fstat(number)
    if not stat.S_ISREG(status.st_mode):
        os.close(number)
        raise InputError(f"{path} is no file that could be read to its end: name a regular file")
    with open(number, "rb") as file:  # noqa: PTH123 - by its number
        if status.st_size > largest_bytes:
            raise InputError(f"{path} has {status.st_size} bytes, and {largest_bytes} are the most that is read")
        try:
            content = file.read(largest_bytes + 1)
        except OSError as err:
            raise InputError(f"{path} cannot be read: {err.strerror}") from err
    if len(content) > largest_bytes:
        raise InputError(f"{path} grows while it is read, beyond {largest_bytes} bytes")
    return content


def listed(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the files of a folder by name, and its other entries: folders, links, pipes."""
    try:
        entries = sorted(folder.iterdir())
    except OSError as err:
        raise InputError(f"{folder} cannot be read: {err.strerror}") from err
    if len(entries) > MOST_FILES:
        raise InputError(f"{folder} has {len(entries)} entries, and {MOST_FILES} are the most that is looked at")
    files = [path for path in entries if path.is_file() and not path.is_symlink()]
    return files, [path for path in entries if path not in files]


def sql_text(content: bytes, path: Path) -> str:
    """Return the SQL in a file's content; raise InputError for other content."""
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as err:
        raise InputError(f"{path} is not SQL, but other bytes: at byte {err.start}") from err
    if "\0" in text:
        raise InputError(f"{path} is not SQL: it has a NUL character in it")
    return text


def unicode_text(content: bytes) -> str:
    """Return a file's text: UTF-16 by its mark, otherwise UTF-8; raise UnicodeDecodeError for other files."""
    return content.decode("utf-16" if content[:2] in UTF_16 else "utf-8-sig")


def decoded(content: bytes) -> str | None:
    """Return a file's text: UTF-8 or UTF-16 by its mark, UTF-8, Korean or Western; None if it is not text."""
    if b"\0" in content and content[:2] not in UTF_16:
        return None
    with suppress(UnicodeDecodeError):
        return unicode_text(content)
    if content[:2] in UTF_16:
        return None
    with suppress(UnicodeDecodeError):
        return content.decode("cp949")
    return content.decode("latin-1")
