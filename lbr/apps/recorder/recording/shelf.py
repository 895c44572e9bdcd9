"""The folders of a robot's recordings, below its home: the box's own files, kept incidents, and recordings on purpose.

    box/lbr/00000017-20261123T155312Z.mcap             the box, oldest first by number, whatever the clock says
    box/lbr/kept/20261123-155410-estop/                links to those files that led there, and why in incident.json
    recordings/lbr/20261123-160000.mcap                made on purpose

Links cost nothing, and a file stays as long as one of its names does.
"""

import contextlib
import os
import re
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import disk
from lbr.messages.unreadable import UNREADABLE

SUFFIX = ".mcap"
INCIDENT = "incident.json"
_NAME = re.compile(r"(\d{8})-(\d{8}T\d{6}Z)\.mcap")
PRIVATE = 0o700


class Incident(Struct, kw_only=True):
    """Why files were kept: the event, its subject and wall time, and how often it repeated."""

    kind: str
    subject: str
    text: str
    wall_ns: int
    again: int = 0

    def __str__(self) -> str:
        return f"{' '.join(filter(None, (self.kind, self.subject)))}: {self.text}"


class Kept(Struct, frozen=True):
    """The files of an incident; `why` is None if it cannot be read."""

    path: Path
    files: tuple[Path, ...]
    why: Incident | None

    @property
    def bytes(self) -> int:
        """The disk space of its files."""
        return size_of(self.files)


class Shelf:
    """The folders of one robot. A missing file is not an error; only writing raises OSError."""

    def __init__(self, home: Path, robot: str) -> None:
        self.box = home / "box" / robot
        self.kept_folder = self.box / "kept"
        self.recordings_folder = home / "recordings" / robot

    def make(self) -> None:
        """Make the folders."""
        for folder in (self.kept_folder, self.recordings_folder):
            folder.mkdir(mode=PRIVATE, parents=True, exist_ok=True)

    def files(self) -> list[Path]:
        """Return the box's own files, oldest first."""
        return sorted(path for path in _in(self.box) if _NAME.fullmatch(path.name))

    def next_file(self) -> Path:
        """Return the path of the next file."""
        files = self.files()
        number = int(files[-1].name[:8]) + 1 if files else 1
        return self.box / f"{number:08d}-{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}{SUFFIX}"

    def incidents(self) -> list[Kept]:
        """Return the kept incidents, oldest first."""
        return [
            Kept(folder, tuple(sorted(path for path in _in(folder) if path.suffix == SUFFIX)), _incident(folder))
            for folder in sorted(_in(self.kept_folder))
            if folder.is_dir()
        ]

    def recordings(self) -> list[Path]:
        """Return the recordings made on purpose, by name."""
        return sorted(path for path in _in(self.recordings_folder) if path.suffix == SUFFIX)

    def keep(self, name: str, why: Incident, files: Iterable[Path]) -> Path:
        """Link files under an incident's name, and write the reason beside them; return the folder."""
        folder = self.kept_folder / name
        folder.mkdir(mode=PRIVATE, parents=True, exist_ok=True)
        for path in files:
            with contextlib.suppress(FileExistsError, FileNotFoundError):
                os.link(path, folder / path.name)
        disk.write(folder / INCIDENT, msgspec.json.encode(why))
        disk.sync(self.kept_folder)
        return folder

    def prune(self, most_bytes: int, oldest_s: float, now: float) -> int:
        """Delete the oldest of the box's own files beyond the bounds; return how many.

        The newest stays. `now` is by the wall clock; 0: ignore ages.
        """
        files = self.files()
        total, deleted = size_of(files), 0
        for path in files[:-1]:
            size, changed = _stat(path)
            old = now > 0 and now - changed > oldest_s
            if total <= most_bytes and not old:
                break
            if _removed(path):
                deleted += 1
            total -= size
        return deleted

    def drop_oldest(self) -> bool:
        """Delete the oldest of the box's own files; return whether one was deleted."""
        files = self.files()
        return bool(files) and _removed(files[0])

    def prune_kept(self, most_bytes: int, oldest_s: float, now: float) -> list[str]:
        """Delete the oldest incidents beyond the bounds; return their names. The newest stays."""
        deleted = []
        kept = self.incidents()
        for index, incident in enumerate(kept[:-1]):
            total = size_of({path for later in kept[index:] for path in later.files})
            at = incident.why.wall_ns / 1e9 if incident.why is not None else _stat(incident.path)[1]
            if total <= most_bytes and not (now > 0 and now - at > oldest_s):
                break
            self.delete(incident.path)
            deleted.append(incident.path.name)
        return deleted

    def delete(self, path: Path) -> bool:
        """Delete a file or a kept incident; False if it is being written or cannot be deleted."""
        if not path.is_dir():
            return not disk.is_locked(path) and _removed(path)
        for one in _in(path):
            _removed(one)
        with contextlib.suppress(OSError):
            path.rmdir()
        return not path.exists()


def robots(home: Path) -> list[str]:
    """Return the robots that have recordings, by name."""
    return sorted({one.name for part in ("box", "recordings") for one in _in(home / part) if one.is_dir()})


def size_of(files: Iterable[Path]) -> int:
    """Return the disk space of files; a file with several names counts once."""
    seen: dict[tuple[int, int], int] = {}
    for path in files:
        with contextlib.suppress(OSError):
            found = path.stat()
            seen[found.st_dev, found.st_ino] = found.st_size
    return sum(seen.values())


def _incident(folder: Path) -> Incident | None:
    try:
        return msgspec.json.decode((folder / INCIDENT).read_bytes(), type=Incident)
    except (OSError, *UNREADABLE):
        return None


def _in(folder: Path) -> Iterator[Path]:
    with contextlib.suppress(OSError):
        yield from folder.iterdir()


def _stat(path: Path) -> tuple[int, float]:
    try:
        found = path.stat()
    except OSError:
        return 0, 0.0
    return found.st_size, found.st_mtime


def _removed(path: Path) -> bool:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return False
    return True
