"""Files for their owner alone, that are on the disk as a whole or not at all, and locks between processes."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any


def create(path: Path) -> int:
    """Open a new file for its owner alone; raise FileExistsError if there is one, or a link."""
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)


@contextmanager
def created(path: Path, mode: str = "wb") -> Iterator[IO[Any]]:
    """Open a new file for its owner alone; it is removed if writing it fails."""
    fd = create(path)
    with ExitStack() as failed:
        failed.callback(path.unlink, missing_ok=True)
        with os.fdopen(fd, mode) as file:
            yield file
        failed.pop_all()


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield the path of a hidden draft, which takes the file's place at the end, and is removed on a failure."""
    draft = path.with_name(f".{path.name}.new-{os.getpid()}")
    draft.unlink(missing_ok=True)
    with ExitStack() as failed:
        failed.callback(draft.unlink, missing_ok=True)
        yield draft
        draft.replace(path)
        failed.pop_all()


def write(path: Path, content: bytes, *, synced: bool = True) -> None:
    """Write a file for its owner alone as a whole or not at all; `synced`: it is on the disk on return."""
    with replacing(path) as draft:
        with os.fdopen(create(draft), "wb") as file:
            file.write(content)
        if synced:
            sync(draft)
    if synced:
        sync(path.parent)


def sync(path: Path) -> None:
    """Write the content of a file, or the names in a folder, to the disk."""
    fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Wait until no other process holds the folder, and hold it."""
    fd = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(fd, fcntl.LOCK_EX)
        yield
    finally:
        os.close(fd)


def is_locked(path: Path, *, shared: bool = False) -> bool:
    """Return whether a process holds the lock of a file, a `shared` one perhaps beside others.

    Two processes that look at the same time do not see each other, but for a shared lock.
    """
    access, lock = (os.O_RDWR, fcntl.LOCK_EX) if shared else (os.O_RDONLY, fcntl.LOCK_SH)
    try:
        fd = os.open(path, access | os.O_NONBLOCK | os.O_CLOEXEC)  # opening a pipe without a writer would block
    except OSError:
        return False
    try:
        fcntl.flock(fd, lock | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(fd)
    return False
