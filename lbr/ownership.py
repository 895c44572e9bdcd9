"""The check for other users who could change a path: for the home, its keys, the database with its logs, capability
files.

A path is ours if it belongs to us or to root, and no other user may write it. The same must hold for each folder and
link on the way to it. Everybody may write to a folder with the sticky bit, if the entry that we use in it is ours.
"""

import grp
import os
import pwd
import shlex
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

from msgspec import Struct

from lbr.errors import InputError

SIDE_FILES = ("-wal", "-shm", "-journal")
"""The files of SQLite beside a database, from which it applies changes when it opens it."""
LINKS_FOLLOWED = 40  # as many as Linux follows
OTHERS = stat.S_IWGRP | stat.S_IWOTH
WHOLE_MAP = "0 0 4294967295"


class Fault(Struct, frozen=True, kw_only=True):
    """The reason why others could change a file or folder: its owner or mode, and the command that mends it."""

    path: Path
    text: str
    do: str

    def __str__(self) -> str:
        return f"{self.path} {self.text}: {self.do}"


class _Step(Struct, frozen=True):
    """A folder or link on the way to a path, or the path itself."""

    path: Path
    found: os.stat_result


def faults(path: Path, *, secret: bool = False, owners: Iterable[int] = ()) -> tuple[Fault, ...]:
    """Return the faults of a file or folder that is not ours alone; of a missing one, those of the way to it.

    A secret must not be readable for others either. `owners` are users who may own it besides us and root.
    """
    trusted = {0, os.geteuid(), *owners}
    found: list[Fault] = []
    steps = list(_way(path))
    folder = len(steps) - 1 - path.exists()
    for at, step in enumerate(steps):
        last = at > folder
        right_above = at == folder or (not last and stat.S_ISLNK(steps[at + 1].found.st_mode))
        found += _of_owner(step, trusted, last=last)
        if stat.S_ISLNK(step.found.st_mode):
            continue
        if last:
            found += _of_mode(step, secret=secret)
        elif _may_be_filled_by_others(step, strictly=right_above):
            mode = stat.S_IMODE(step.found.st_mode)
            text = f"is a folder where others may replace what is in it (mode {mode:04o})"
            found.append(Fault(path=step.path, text=text, do=f"`chmod go-w {_quoted(step.path)}`"))
    return tuple(found)


def database_faults(path: Path) -> tuple[Fault, ...]:
    """Return the faults of a database: those of the file, the way to it, its other names, and SQLite's files beside
    it."""
    found = list(faults(path))
    real = Path(os.path.realpath(path))
    if _has_further_names(real):
        own, name = _quoted(real.with_name(f"{real.name}.own")), _quoted(real)
        text = "has a second name (a hard link), and SQLite would keep a log for each"
        found.append(Fault(path=real, text=text, do=f"`cp {name} {own} && mv {own} {name}`"))
    return (*found, *side_file_faults(real))


def side_file_faults(path: Path) -> tuple[Fault, ...]:
    """Return the faults of the files that SQLite opens with a database; `path` must not be a link."""
    found = []
    for name in (path.with_name(path.name + end) for end in SIDE_FILES):
        try:
            seen = name.lstat()
        except OSError:
            continue
        mode, text, sudo = f"mode {stat.S_IMODE(seen.st_mode):04o}", "", ""
        if not stat.S_ISREG(seen.st_mode):
            text = f"is not a plain file ({mode})"
        elif seen.st_uid not in {0, os.geteuid()}:
            text, sudo = f"belongs to {_user(seen.st_uid)} ({mode})", "sudo "
        elif seen.st_mode & OTHERS:
            text = f"may be changed by others ({mode})"
        elif seen.st_nlink > 1:
            text = f"has a second name (a hard link, {mode})"
        if text:
            text += ", and SQLite would read it"
            found.append(Fault(path=name, text=text, do=f"look where it came from, then `{sudo}rm {_quoted(name)}`"))
    return tuple(found)


def refuse(found: Iterable[Fault]) -> None:
    """Raise InputError with the sentence of each fault, if there is any."""
    if told := [str(fault) for fault in found]:
        raise InputError("\n".join(told))


def _of_owner(step: _Step, trusted: set[int], *, last: bool) -> Iterator[Fault]:
    uid = step.found.st_uid
    if uid in trusted or (not last and _is_unmapped(uid)):
        return
    mode = f"mode {stat.S_IMODE(step.found.st_mode):04o}"
    whose = "is a link of" if stat.S_ISLNK(step.found.st_mode) else "belongs to"
    text = f"{whose} {_user(uid)} ({mode}), who could put anything {'into it' if last else 'there'}"
    do = f"`sudo chown -h {_me()} {_quoted(step.path)}`, having checked what is in it, or use a place of your own"
    yield Fault(path=step.path, text=text, do=do)


def _of_mode(step: _Step, *, secret: bool) -> Iterator[Fault]:
    mode, name = stat.S_IMODE(step.found.st_mode), _quoted(step.path)
    if mode & OTHERS:
        text = f"may be changed by others (mode {mode:04o})"
        yield Fault(path=step.path, text=text, do=f"`chmod go-w {name}`, having checked what is in it")
    elif secret and mode & 0o077:
        text = f"could be read by others (mode {mode:04o})"
        do = f"`chmod go= {name}`; if others may have read it, remove it, and a new one is made"
        yield Fault(path=step.path, text=text, do=do)


def _may_be_filled_by_others(step: _Step, *, strictly: bool) -> bool:
    mode = step.found.st_mode
    if mode & stat.S_ISVTX:
        return False
    if mode & stat.S_IWOTH:
        return True
    return bool(mode & stat.S_IWGRP) and (strictly or _has_others(step.found.st_gid))


def _way(path: Path) -> Iterator[_Step]:
    """Yield each folder and link from the root to a path; it ends before a missing one."""
    at = Path("/")
    ahead = list(reversed(path.absolute().parts[1:]))
    yield _Step(at, at.lstat())
    links = 0
    while ahead:
        part = ahead.pop()
        if part == "..":
            at = at.parent
            continue
        try:
            step = _Step(at / part, (at / part).lstat())
        except OSError:
            return
        yield step
        if not stat.S_ISLNK(step.found.st_mode):
            at = step.path
            continue
        links += 1
        if links > LINKS_FOLLOWED:
            return
        target = step.path.readlink()
        at = Path("/") if target.is_absolute() else at
        ahead += reversed(target.parts[target.is_absolute() :])


def _has_further_names(path: Path) -> bool:
    """Return whether a file has other names than its temporary one, which is removed by itself."""
    try:
        if path.lstat().st_nlink < 2:
            return False
        built = sum(other.samefile(path) for other in path.parent.glob(f"{path.name}.new-*"))
        return path.lstat().st_nlink - built > 1
    except OSError:
        return False


def _has_others(gid: int) -> bool:
    """Return whether a group has members besides us and root; a group of ours alone shares nothing."""
    try:
        members = set(grp.getgrgid(gid).gr_mem) | {one.pw_name for one in pwd.getpwall() if one.pw_gid == gid}
    except KeyError:
        return True
    return bool(members - {_me(), "root"})


def _is_unmapped(uid: int) -> bool:
    """Return whether an owner is outside of this user namespace, so that no user inside can be it."""
    try:
        overflow = int(Path("/proc/sys/kernel/overflowuid").read_text())
        return uid == overflow and " ".join(Path("/proc/self/uid_map").read_text().split()) != WHOLE_MAP
    except OSError:
        return False


def _me() -> str:
    return _named(os.geteuid()) or str(os.geteuid())


def _user(uid: int) -> str:
    name = _named(uid)
    return f"user {name} ({uid})" if name else f"user {uid}"


def _named(uid: int) -> str:
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return ""


def _quoted(path: Path) -> str:
    return shlex.quote(str(path))
