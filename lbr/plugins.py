"""The contents of packages by their components: kinds, commands, faces, ports, robots and twins; and their faults.

    entry points of `lbr.components` ──► entries() ──► Component ──► find(field, name): Plugin ──► load(): the object

lbr's own keep their names. If several other packages claim a name, none gets it until the others are uninstalled. lbr's
own names are found without importing other packages.
"""

import contextlib
import importlib
import os
import re
import sys
import threading
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial, reduce
from itertools import chain, takewhile
from pathlib import Path
from typing import Any, Literal, TypeVar

from lbr.component import CliCommand, CommandGroup, Component
from lbr.errors import LbrError, told

CORE = "lbr"
"""The package lbr, and its component `core`, whose commands come first."""
GROUP = "lbr.components"
Field = Literal["kinds", "commands", "faces", "ports", "robots", "twins", "checks"]
FIELDS: tuple[Field, ...] = ("kinds", "commands", "faces", "ports", "robots", "twins", "checks")
_CHECKOUT = Path(__file__).resolve().parent.parent / "pyproject.toml"
_INFO = (".dist-info", ".egg-info")
_ENTRY = re.compile(r"[\w.]+:[\w.]+")
_COMMAND = re.compile(r"[a-z][a-z0-9-]*")
_REMEMBERED: list[Callable[[], None]] = []
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry point of a component: `value` is `module:attribute`, `package` its package, which `requires` others."""

    name: str
    value: str
    package: str
    requires: tuple[str, ...] = ()

    @property
    def ours(self) -> bool:
        """Return whether it belongs to lbr."""
        return self.package == CORE

    @property
    def label(self) -> str:
        """Return its description for people."""
        return f"component '{self.name}' of package '{self.package}'"


@dataclass(frozen=True, slots=True)
class Plugin:
    """One name in one field of a component; `value` is its object, as `module:attribute`.

    `help` and `group` are a command's line and heading in `lbr --help`. `refusal` is why the name is refused, or empty.
    """

    field: Field
    name: str
    value: str
    entry: Entry
    help: str = ""
    group: CommandGroup | None = None
    refusal: str = ""

    @property
    def package(self) -> str:
        """Return its package, for people."""
        return self.entry.package

    @property
    def ours(self) -> bool:
        """Return whether it belongs to lbr."""
        return self.entry.ours

    @property
    def label(self) -> str:
        """Return its description for people."""
        return f"'{self.name}' of package '{self.package}' ({self.field} of component '{self.entry.name}')"

    def load(self) -> Any:
        """Import and return the declared object, with its output on stderr; raise PluginError if it fails."""
        if why := self.refusal or contradiction(self.entry.requires):
            raise PluginError(self, why)
        found, err = _imported(self.value, self.entry)
        if err is not None:
            raise PluginError(self, f"it does not load: {told(err)}{_lacking(self.entry)}") from err
        return found

    def checked(self, found: object, wanted: type[T], name: str = "name") -> T:
        """Return the declared object if it has the type of its field, and its own field `name` has the component's
        name."""
        if not isinstance(found, wanted):
            raise PluginError(self, f"{self.value} is no {wanted.__name__}(…), but of type {type(found).__name__}")
        if (said := getattr(found, name)) != self.name:
            text = f"the name in the component and {wanted.__name__}.{name} agree"
            raise PluginError(self, f"it calls itself {said!r}: {text}")
        return found


class PluginError(LbrError):
    """A part of a package that is unusable; the text names the package, and `why` is the rest of it."""

    def __init__(self, plugin: Plugin, why: str) -> None:
        super().__init__(f"{plugin.label}: {why}")
        self.why = why


def find(field: Field, name: str) -> Plugin | None:
    """Return the plugin of a name in a field, or None; one that several packages claim exists, and does not load."""
    own = next((one for entry in _own() for one in _of(entry, field) if one.name == name), None)
    return own or installed(field).get(name)


def own(field: Field) -> tuple[Plugin, ...]:
    """Return lbr's own plugins in a field, those of `core` first."""
    return tuple(one for entry in _own() for one in _of(entry, field))


@cache
def installed(field: Field) -> Mapping[str, Plugin]:
    """Return the plugins in a field, by name; one that several packages claim exists, and does not load."""
    return {one.name: one for one in reversed(every(field))}


@cache
def every(field: Field) -> tuple[Plugin, ...]:
    """Return all plugins in a field, lbr's own first, including those that lack the name that they claim."""
    claims: dict[str, list[Plugin]] = {}
    for one in chain.from_iterable(_of(entry, field) for entry in entries()):
        claims.setdefault(one.name, []).append(one)
    return tuple(_settled(one, claims[one.name]) for entry in entries() for one in _of(entry, field))


def entries() -> tuple[Entry, ...]:
    """Return the entry points of all components, lbr's own first; no component is imported."""
    return (*_own(), *_others())


def broken() -> tuple[str, ...]:
    """Return one sentence for each unusable component, with its name, the reason and the cure."""
    return tuple(why for entry in entries() if (why := _component(entry)[1]))


def perhaps_broken() -> str:
    """Return the addition to a sentence about a missing part: the unusable components that may bring it."""
    return "".join(f"; it may be of the {why}" for why in broken())


def messages() -> tuple[str, ...]:
    """Return the modules of message types that components declare for others."""
    components = (_component(entry)[0] for entry in entries())
    return tuple(name for one in components if one is not None for name in one.messages)


def fresh(field: Field, name: str) -> str:
    """Return the package that brings a name and was installed since this program first looked; empty if none does."""
    known = set(entries())
    new = (entry for entry in _declared() if entry not in known)
    return next((entry.package for entry in new if any(one.name == name for one in _of(entry, field))), "")


def contradiction(requires: tuple[str, ...]) -> str:
    """Return why a package with these requirements does not fit this version of lbr; empty if it does."""
    asking = [text for text in requires if text.lower().startswith(CORE)]
    if not asking:
        return ""
    from packaging.requirements import InvalidRequirement, Requirement
    from packaging.utils import canonicalize_name

    for text in asking:
        try:
            wanted = Requirement(text)
        except InvalidRequirement as err:
            return f"it requires {text!r}, which cannot be read: {' '.join(str(err).split())}"
        if canonicalize_name(wanted.name) != CORE or (wanted.marker is not None and not wanted.marker.evaluate()):
            continue
        if not wanted.specifier.contains(version(), prereleases=True):
            return f"it requires lbr {wanted.specifier}, and this is lbr {version()}: install versions that go together"
    return ""


@cache
def version() -> str:
    """Return the installed version of lbr."""
    folder = next(folder for name, folder, _ in _metadata() if name == CORE)
    return _described(folder)[0].rpartition(" ")[2]


def load(value: str) -> Any:
    """Import and return an object by its name `module:attribute`."""
    module, _, attribute = value.partition(":")
    return reduce(getattr, attribute.split("."), importlib.import_module(module))


def remembered(judge: Callable[[Plugin], T]) -> Callable[[Plugin], T]:
    """Cache the judgements of plugins, until `forget`."""
    found = cache(judge)
    _REMEMBERED.append(found.cache_clear)
    return found


def forget() -> None:
    """Forget the installed packages, to be read again on the next request."""
    importlib.invalidate_caches()
    for known in (installed, every, _of, _component, _own, _others):
        known.cache_clear()
    for clear in _REMEMBERED:
        clear()


# -- components -------------------------------------------------------------------------------------------------------


@cache
def _of(entry: Entry, field: Field) -> tuple[Plugin, ...]:
    """Return the plugins of a component in a field, empty if it is unusable."""
    component, _ = _component(entry)
    if component is None:
        return ()
    if field == "commands":
        return tuple(
            Plugin(field, name, one.entry, entry, one.help, one.group) for name, one in component.commands.items()
        )
    return tuple(Plugin(field, name, value, entry) for name, value in getattr(component, field).items())


def _settled(one: Plugin, claims: list[Plugin]) -> Plugin:
    """Return a plugin, with the reason if it does not get its name: lbr's own keep theirs, several others lose it."""
    if one.ours or len(claims) == 1:
        return one
    if claims[0].ours:
        return replace(one, refusal=f"lbr has its own '{one.name}': choose another name")
    packages = list(dict.fromkeys(each.package for each in claims))
    if len(packages) > 1:
        return replace(one, refusal=f"packages {' and '.join(packages)} bring it: uninstall all but one")
    components = " and ".join(f"'{each.entry.name}'" for each in claims)
    return replace(one, refusal=f"components {components} of it bring it: it may have one of that name")


def _lacking(entry: Entry) -> str:
    """Return which required components are missing, as the end of a sentence."""
    component, _ = _component(entry)
    there = {one.name for one in entries() if _component(one)[0] is not None}
    lacking = sorted(set(component.needs) - there) if component is not None else []
    return f"; it needs {', '.join(lacking)}, which is not here" if lacking else ""


@cache
def _component(entry: Entry) -> tuple[Component | None, str]:
    """Import a component; return it, or the reason why it is unusable, with the cure."""
    found, err = _imported(entry.value, entry)
    why = f"it does not load: {told(err)}" if err is not None else ""
    if not entry.ours and not why:
        why = next(_faults(found), "")
    if not why:
        return found, ""
    why = contradiction(entry.requires) or f"{why}; repair it, or uninstall the package"
    return None, f"{entry.label} ({entry.value}): {why}"


def _faults(found: object) -> Iterator[str]:
    """Yield the faults in the fields of another package's component."""
    if not isinstance(found, Component):
        yield f"it is no Component(…), but of type {type(found).__name__}"
        return
    for field in FIELDS:
        here = getattr(found, field)
        if not isinstance(here, Mapping):
            yield f"'{field}' is of type {type(here).__name__}: write {{\"name\": …}}"
            continue
        wanted = CliCommand if field == "commands" else str
        for name, what in here.items():
            value = what.entry if isinstance(what, CliCommand) else what
            if not isinstance(what, wanted) or not isinstance(value, str) or not _ENTRY.fullmatch(value):
                form = "module:attribute" if wanted is str else 'CliCommand(entry="module:attribute", help="…")'
                yield f"'{field}' has {name!r} as {what!r}: write {form}"
            elif field == "commands" and not _COMMAND.fullmatch(name):
                yield f"'commands' has {name!r}: what is typed is of small letters, digits and dashes"


# -- imports ----------------------------------------------------------------------------------------------------------


def _imported(value: str, entry: Entry) -> tuple[Any, BaseException | None]:
    """Import `module:attribute`; return it, or the exception."""
    return (_tried if entry.ours else tried_aside)(partial(load, value))


def _tried(load: Callable[[], T]) -> tuple[T | None, BaseException | None]:
    try:
        with contextlib.redirect_stdout(sys.stderr):
            return load(), None
    except (Exception, SystemExit) as err:  # noqa: BLE001 - it is told with the package that raised it
        return None, err


def tried_aside(load: Callable[[], T]) -> tuple[T | None, BaseException | None]:
    """Import another's code on a thread of its own, which cannot set signal handlers.

    Threads that it starts do not delay the program's end. Any exception is the code's own, as Ctrl-C only reaches the
    main thread.
    """
    tried: list[tuple[T | None, BaseException | None]] = []

    def run() -> None:
        try:
            tried.append(_tried(load))
        except BaseException as err:  # noqa: BLE001 - it may raise anything
            tried.append((None, err))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join()
    return tried[0]


# -- entry points -----------------------------------------------------------------------------------------------------


@cache
def _own() -> tuple[Entry, ...]:
    """Return lbr's own entry points; in a checkout, those of its project file, not of its installation."""
    points = _of_checkout()
    if points is None:
        points = dict(chain.from_iterable(_lines(text) for name, _, text in _metadata() if name == CORE))
    return tuple(
        sorted((Entry(*point, CORE) for point in points.items()), key=lambda one: (one.name != "core", one.name))
    )


@cache
def _others() -> tuple[Entry, ...]:
    """Return those of other packages, in the order of their names."""
    return tuple(sorted(_declared(), key=lambda one: (one.package, one.name)))


def _declared() -> Iterator[Entry]:
    for name, folder, text in _metadata():
        if name != CORE:
            package, requires = _described(folder)
            yield from (Entry(*point, package, requires) for point in _lines(text))


def _described(folder: Path) -> tuple[str, tuple[str, ...]]:
    """Return a package's description for people and its requirements, from its metadata."""
    head: dict[str, list[str]] = {}
    for name in ("METADATA", "PKG-INFO"):
        with contextlib.suppress(OSError), (folder / name).open(encoding="utf-8", errors="replace") as file:
            for line in takewhile("\n".__ne__, file):
                field, colon, value = line.partition(":")
                if colon and not field[:1].isspace():
                    head.setdefault(field.lower(), []).append(value.strip())
    label = " ".join((*head.get("name", [folder.name])[:1], *head.get("version", [])[:1]))
    return label, tuple(head.get("requires-dist", ()))


def _metadata() -> Iterator[tuple[str, Path, str]]:
    """Yield the packages on the path that have entry points in the group: plain name, folder, and `entry_points.txt`.

    The search is that of `importlib.metadata`, whose import takes as long as the rest of the help.
    """
    seen: set[str] = set()
    for place in sys.path:
        try:
            folders = sorted(name for name in os.listdir(place or os.curdir) if name.endswith(_INFO))  # noqa: PTH208
        except OSError:
            continue
        for folder in folders:
            name = re.sub(r"[-_.]+", "_", folder.rpartition(".")[0].partition("-")[0]).lower()
            if name in seen:
                continue
            seen.add(name)
            path = Path(place) / folder
            with contextlib.suppress(OSError, UnicodeDecodeError):
                text = (path / "entry_points.txt").read_text(encoding="utf-8")
                if GROUP in text:
                    yield name, path, text


def _lines(text: str) -> Iterator[tuple[str, str]]:
    """Yield the entry points of the group: name and value."""
    group = ""
    for line in map(str.strip, text.splitlines()):
        name, equals, value = map(str.strip, line.partition("="))
        if line.startswith("["):
            group = line
        elif group == f"[{GROUP}]" and equals:
            yield name, value


def _of_checkout() -> Mapping[str, str] | None:
    """Return the entry points in the project file of a checkout; None in an installation."""
    try:
        project = tomllib.loads(_CHECKOUT.read_text(encoding="utf-8")).get("project", {})
    except (OSError, tomllib.TOMLDecodeError):
        return None
    return project.get("entry-points", {}).get(GROUP, {}) if project.get("name") == CORE else None
