"""What packages bring to lbr by entry points: kinds, robots, twins and faces; who brings it, and why it cannot be used.

    pyproject.toml of a package ──► installed(group) ──► Plugin(name, package) ──► load(): the declared object, or why not

lbr's own keep their names; a name that several other packages claim is none of theirs, until one is uninstalled.
"""

import contextlib
import importlib
import sys
import threading
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from importlib.metadata import Distribution, EntryPoint, EntryPoints, entry_points, version
from pathlib import Path
from typing import Any, TypeVar

from lbr.errors import LbrError

CORE = "lbr"
LONGEST_TEXT = 300
_CHECKOUT = Path(__file__).resolve().parent.parent / "pyproject.toml"
_REMEMBERED: list[Callable[[], None]] = []
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Plugin:
    """One entry point: `value` is `module:object`, `package` whose it is, `requires` what that package asks for.

    `refusal` says why it has not the name that it claims; empty if it has.
    """

    group: str
    name: str
    value: str
    package: str
    requires: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def ours(self) -> bool:
        """Say whether it came with lbr."""
        return self.package == CORE

    @property
    def label(self) -> str:
        """Which it is, for people."""
        return f"'{self.name}' of package '{self.package}' ({self.group})"

    def load(self) -> Any:
        """Import and return the declared object; PluginError says why that cannot be. What it prints goes to stderr."""
        if why := self.refusal or contradiction(self.requires):
            raise PluginError(self, why)
        found, err = (_tried if self.ours else _tried_aside)(EntryPoint(self.name, self.value, self.group).load)
        if err is not None:
            raise PluginError(self, f"it does not load: {told(err)}") from err
        return found

    def checked(self, found: object, wanted: type[T], name: str = "name") -> T:
        """Return what was declared if it is what its group has, and its field `name` says the entry point's name."""
        if not isinstance(found, wanted):
            raise PluginError(self, f"{self.value} is no {wanted.__name__}(…), but of type {type(found).__name__}")
        if (said := getattr(found, name)) != self.name:
            text = f"the name of the entry point and {wanted.__name__}.{name} agree"
            raise PluginError(self, f"it calls itself {said!r}: {text}")
        return found


class PluginError(LbrError):
    """Something of a package that cannot be used; the text names the package, and `why` is the rest of it."""

    def __init__(self, plugin: Plugin, why: str) -> None:
        super().__init__(f"{plugin.label}: {why}")
        self.why = why


def installed(group: str) -> Mapping[str, Plugin]:
    """Return what there is in a group, by name; one that several packages claim is there, and does not load."""
    return {one.name: one for one in reversed(_all(group))}


def every(group: str) -> tuple[Plugin, ...]:
    """Return all that packages declare in a group, lbr's own first, those without the name that they claim too."""
    return _all(group)


def fresh(group: str, name: str) -> str:
    """Return the package that brings a name and was installed since this program first looked; empty if none does."""
    known = {(one.name, one.package) for one in _all(group)}
    now = _declared(group, entry_points().select)
    found = (one.package for one in now if one.name == name and (one.name, one.package) not in known)
    return next(found, "")


def contradiction(requires: tuple[str, ...]) -> str:
    """Return why a package that requires this does not go with this version of lbr; empty if it does."""
    asking = [text for text in requires if text.lower().startswith(CORE)]
    if not asking:
        return ""
    from packaging.requirements import InvalidRequirement, Requirement  # noqa: PLC0415 - packages of others only
    from packaging.utils import canonicalize_name  # noqa: PLC0415

    for text in asking:
        try:
            wanted = Requirement(text)
        except InvalidRequirement as err:
            return f"it requires {text!r}, which cannot be read: {' '.join(str(err).split())}"
        if canonicalize_name(wanted.name) != CORE or (wanted.marker is not None and not wanted.marker.evaluate()):
            continue
        here = version(CORE)
        if not wanted.specifier.contains(here, prereleases=True):
            return f"it requires lbr {wanted.specifier}, and this is lbr {here}: install versions that go together"
    return ""


def _tried(load: Callable[[], Any]) -> tuple[Any, BaseException | None]:
    try:
        with contextlib.redirect_stdout(sys.stderr):
            return load(), None
    except (Exception, SystemExit) as err:  # noqa: BLE001 - it is told with the package that raised it
        return None, err


def _tried_aside(load: Callable[[], Any]) -> tuple[Any, BaseException | None]:
    """Import what another has written on a thread of its own, which lets it set no signals; threads that it starts keep no
    program from its end, and whatever it raises is its own, as Ctrl-C comes to the main thread alone."""
    tried: list[tuple[Any, BaseException | None]] = []

    def run() -> None:
        try:
            tried.append(_tried(load))
        except BaseException as err:  # noqa: BLE001 - it may raise anything
            tried.append((None, err))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join()
    return tried[0]


def told(err: BaseException) -> str:
    """Return an exception as one short line; one that cannot even be told is one all the same."""
    try:
        text = "".join(c if c.isprintable() else "?" for c in " ".join(str(err).split()))
    except Exception:  # noqa: BLE001 - its `__str__` is another's
        text = ""
    return f"{type(err).__name__}: {text[:LONGEST_TEXT]}" if text else type(err).__name__


def remembered(judge: Callable[[Plugin], T]) -> Callable[[Plugin], T]:
    """Have a judgement of a plugin made once, until all is forgotten."""
    found = cache(judge)
    _REMEMBERED.append(found.cache_clear)
    return found


def forget() -> None:
    """Look again at what is installed when that is asked next."""
    importlib.invalidate_caches()
    _all.cache_clear()
    _points.cache_clear()
    for clear in _REMEMBERED:
        clear()


@cache
def _all(group: str) -> tuple[Plugin, ...]:
    claims: dict[str, dict[str, Plugin]] = {}
    for one in sorted(_declared(group, _points()), key=lambda one: (not one.ours, one.package, one.value)):
        claims.setdefault(one.name, {}).setdefault(one.package, one)
    found = [_settled(one, tuple(of_name)) for of_name in claims.values() for one in of_name.values()]
    return tuple(sorted(found, key=lambda one: (not one.ours, one.package, one.name)))


def _settled(one: Plugin, packages: tuple[str, ...]) -> Plugin:
    """Return a plugin with why it has not its name: lbr's own keep theirs, and of several others none is preferred."""
    if one.ours or len(packages) == 1:
        return one
    if packages[0] == CORE:
        return replace(one, refusal=f"lbr has its own '{one.name}': choose another name")
    return replace(one, refusal=f"packages {' and '.join(packages)} bring it: uninstall all but one")


def _declared(group: str, select: Callable[..., EntryPoints]) -> Iterator[Plugin]:
    """Yield all entry points; those of a checkout are what its project says now, not when it was installed."""
    own = _of_checkout()
    for name, value in (own or {}).get(group, {}).items():
        yield Plugin(group, name, value, CORE)
    for point in select(group=group):
        package, requires = _brought_by(point.dist)
        if package != CORE or own is None:
            yield Plugin(group, point.name, point.value, package, requires)


@cache
def _points() -> Callable[..., EntryPoints]:
    """Return what selects among the entry points of all packages; to read them anew takes 50 ms."""
    return entry_points().select


@lru_cache(maxsize=64)
def _brought_by(dist: Distribution | None) -> tuple[str, tuple[str, ...]]:
    """Return a package as it is told, and what it asks for; of lbr itself no more than its name."""
    if dist is None:
        return "unknown", ()
    name = dist.name
    return (CORE, ()) if name == CORE else (f"{name} {dist.version}", tuple(dist.requires or ()))


@cache
def _of_checkout() -> Mapping[str, Mapping[str, str]] | None:
    """Return the entry points that the project's file in a checkout declares; None in an installation."""
    try:
        project = tomllib.loads(_CHECKOUT.read_text(encoding="utf-8")).get("project", {})
    except (OSError, tomllib.TOMLDecodeError):
        return None
    return project.get("entry-points", {}) if project.get("name") == CORE else None
