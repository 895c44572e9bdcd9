"""Finds all kinds: those of installed components, and the user's own files in `$LBR_HOME/capabilities`."""

import contextlib
import re
from functools import cache, lru_cache
from hashlib import blake2b
from pathlib import Path

from lbr import ownership, plugins
from lbr.capability.kind import Kind, KindError, LackingError
from lbr.messages.rows import Row
from lbr.names import did_you_mean
from lbr.plugins import Plugin, PluginError

_texts: dict[str, str] = {}
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


def user_directory(home: Path) -> Path:
    """Return the directory of the users' own capability files."""
    return home / "capabilities"


def names(home: Path) -> list[str]:
    """Return the names of all kinds, sorted."""
    own = {path.stem for path in user_directory(home).glob("*.py") if _NAME.fullmatch(path.stem)}
    return sorted(own | set(plugins.installed("kinds")))


def find(name: str, home: Path, *, trial: bool = True) -> Kind:
    """Return the kind of that name; raise KindError if it is missing, broken or incomplete.

    A user's own file is tried in a separate process first, which takes a second. Without `trial`, it is imported only
    here. A good file is not tried again until it changes.
    """
    if not _NAME.fullmatch(name):
        raise KindError(f"'{name}' is not a kind's name: kinds are words like 'drive', not paths or code")
    point = plugins.find("kinds", name)
    if point is not None:
        return declared(point)
    path = user_directory(home) / f"{name}.py"
    if not path.is_file():
        if package := plugins.fresh("kinds", name):
            text = f"kind '{name}' of package '{package}' was installed after this robot was started"
            raise KindError(f"{text}: start the robot again")
        text = f"there is no kind '{name}': {did_you_mean(name, names(home))} A new one is {path}"
        if lacking := plugins.perhaps_broken():
            raise LackingError(text + lacking)
        raise KindError(text)
    _refuse_if_others_may_write(path)
    kind, _texts[name] = _from_file(name, path, fingerprint(name, home), trial=trial)
    return kind


def accepted(name: str, home: Path, source: str) -> Kind:
    """Return the kind of a running robot: of a user's own file, by its accepted text, not by its present one."""
    if not source:
        return find(name, home, trial=False)
    from lbr.capability import user_kinds  # noqa: PLC0415 - most processes have no use for it

    return user_kinds.load(name, user_directory(home) / f"{name}.py", source)


def source(name: str) -> str:
    """Return the text of the user's own file from which the kind was loaded last; empty for an installed one."""
    return _texts.get(name, "")


@cache
def tables() -> frozenset[type[Row]]:
    """Return the row types that installed kinds read: they are also checked for robots without such a kind."""
    rows: set[type[Row]] = set()
    for point in plugins.installed("kinds").values():
        with contextlib.suppress(KindError):  # reported to those who name it
            rows |= {read.row for read in declared(point).reads}
    return frozenset(rows)


def shadowed(name: str, home: Path) -> Path | None:
    """Return the user's own file that is ignored because an installed kind has its name."""
    path = user_directory(home) / f"{name}.py"
    return path if plugins.find("kinds", name) is not None and path.is_file() else None


def fingerprint(name: str, home: Path) -> str:
    """Return a text that changes when a user's file is changed or written again; empty for an installed kind."""
    if plugins.find("kinds", name) is not None:
        return ""
    path = user_directory(home) / f"{name}.py"
    try:
        return f"{path.stat().st_mtime_ns}-{blake2b(path.read_bytes(), digest_size=16).hexdigest()}"
    except OSError:
        return ""


def same_content(fingerprint: str, other: str) -> bool:
    """Return whether two files have the same content, whenever and on whichever machine each was written."""
    return fingerprint.rpartition("-")[2] == other.rpartition("-")[2]


def mark(name: str, home: Path) -> str:
    """Return a text that changes with a user's capability file, or its owner and mode; empty for an installed kind."""
    if plugins.find("kinds", name) is not None:
        return ""
    folder = user_directory(home)
    try:
        file, inside = (folder / f"{name}.py").stat(), folder.stat()
    except OSError:
        return ""
    return f"{file.st_mtime_ns}-{file.st_size}-{file.st_ctime_ns}-{inside.st_mode}-{inside.st_uid}"


def _refuse_if_others_may_write(path: Path) -> None:
    for fault in (*ownership.faults(path.parent), *ownership.faults(path)):
        raise KindError(f"{path} could be changed by others: {fault}")


@plugins.remembered
def declared(point: Plugin) -> Kind:
    """Return an installed kind. lbr's tests check its own kinds, so that not every start has to."""
    try:
        kind = point.checked(point.load(), Kind)
    except PluginError as err:
        raise KindError(f"the installed kind {err}") from err
    if not point.ours and (found := _faults(kind)):
        raise KindError(f"the installed kind {PluginError(point, '; '.join(found))}")
    return kind


@lru_cache(maxsize=64)
def _from_file(name: str, path: Path, _fingerprint: str, *, trial: bool) -> tuple[Kind, str]:
    from lbr.capability import user_kinds  # noqa: PLC0415 - most processes have no use for it

    kind = user_kinds.find(name, path) if trial else user_kinds.load(name, path)
    return kind, user_kinds.source(name)


def _faults(kind: Kind) -> tuple[str, ...]:
    from lbr.capability.faults import faults  # noqa: PLC0415 - see above

    return faults(kind)
