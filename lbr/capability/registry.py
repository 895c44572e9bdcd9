"""Which kinds there are: the installed ones by entry point, and the user's own files in `$LBR_HOME/capabilities`."""

import importlib.util
import re
import sys
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from lbr import ownership
from lbr.capability.kind import Kind
from lbr.errors import LbrError

GROUP = "lbr.capabilities"
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


class KindError(LbrError):
    """A kind that does not exist or cannot be loaded; the text says why and what there is instead."""


@lru_cache(maxsize=1)
def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP)}


def user_directory(home: Path) -> Path:
    """Return where users drop capability files of their own."""
    return home / "capabilities"


def names(home: Path) -> list[str]:
    """Return the names of all kinds, sorted."""
    own = {path.stem for path in user_directory(home).glob("*.py") if _NAME.fullmatch(path.stem)}
    return sorted(own | set(_installed()))


def find(name: str, home: Path) -> Kind:
    """Return the kind of that name; raise KindError if there is none or its module is broken."""
    if not _NAME.fullmatch(name):
        raise KindError(f"'{name}' is no kind's name: kinds are words like 'roboteq', not paths or code")
    point = _installed().get(name)
    if point is not None:
        try:
            kind = point.load()
        except Exception as err:
            raise KindError(f"the installed kind '{name}' does not load: {type(err).__name__}: {err}") from err
    else:
        path = user_directory(home) / f"{name}.py"
        if not path.is_file():
            raise KindError(f"there is no kind '{name}': {', '.join(names(home))} exist; a new one is {path}")
        _refuse_if_others_may_write(path)
        kind = _from_file(name, path, fingerprint(name, home))
    if not isinstance(kind, Kind):
        raise KindError(f"kind '{name}' declares no KIND = Kind(…)")
    if kind.name != name:
        raise KindError(
            f"kind '{name}' calls itself '{kind.name}': the name of the file, or entry point, and KIND.name agree"
        )
    return kind


def fingerprint(name: str, home: Path) -> str:
    """Return what changes when a user's capability file does; empty for an installed kind."""
    try:
        found = (user_directory(home) / f"{name}.py").stat()
    except OSError:
        return ""
    return "" if name in _installed() else f"{found.st_mtime_ns}-{found.st_size}"


def _refuse_if_others_may_write(path: Path) -> None:
    for fault in (*ownership.faults(path.parent), *ownership.faults(path)):
        raise KindError(f"{path} could be changed by others: {fault}")


@lru_cache(maxsize=64)
def _from_file(name: str, path: Path, _fingerprint: str) -> object:
    module_name = f"lbr_user_capabilities.{name}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise KindError(f"{path} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as err:
        raise KindError(f"{path} does not load: {type(err).__name__}: {err}") from err
    return getattr(module, "KIND", None)
