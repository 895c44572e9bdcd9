"""Finds the robots of lbr and of other packages; an unusable one is named with its package, and does not affect
others."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from msgspec import Struct

from lbr import plugins
from lbr.plugins import Plugin, PluginError
from lbr.robot.declaration import Robot
from lbr.robot.motion_file import Formats, MotionFormat
from lbr.robot.old_data import OldFormat

_SUFFIX = re.compile(r"\.[a-z0-9]{1,10}")
_FORMAT = re.compile(r"[a-z][a-z0-9-]{0,39}")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


class Found(Struct, frozen=True, kw_only=True):
    """A robot of a package, or why it is unusable; `name` is that in its component."""

    name: str
    package: str
    robot: Robot | None = None
    fault: str = ""


def names() -> tuple[str, ...]:
    """Return the names of all robots that packages declare, without importing any."""
    return tuple(sorted(plugins.installed("robots")))


def every() -> tuple[Found, ...]:
    """Return all robots, lbr's own first, and those that are refused."""
    return tuple(map(_loaded, plugins.every("robots")))


def find(name: str) -> Found | None:
    """Return the robot of a name, or why it is unusable; None if no package declares it."""
    point = plugins.find("robots", name)
    return _loaded(point) if point is not None else None


def of_profile(profile: str) -> Iterator[Found]:
    """Yield the robots whose launch profile may have that name, the longest name first; no others are imported."""
    known = plugins.installed("robots")
    for name in sorted(_begin(profile), key=len, reverse=True):
        yield _loaded(known[name])


def profiles(robot: Robot) -> dict[str, Path]:
    """Return a robot's launch profiles, by name."""
    files = robot.profiles.glob("*.toml") if robot.profiles is not None else ()
    return {path.stem: path for path in sorted(files, key=lambda path: path.stem)}


def plain(name: str) -> str:
    """Return a name of a robot or profile for comparison: dashes and underscores are equal."""
    return name.replace("-", "_")


def bodies() -> dict[str, Path]:
    """Return the bodies of robots, by the robots' names."""
    return {found.name: found.robot.body for found in every() if found.robot is not None and found.robot.body}


def motion_formats() -> Formats:
    """Return the formats of makers' motion files by suffix; lbr's own has priority over others with the same suffix."""
    robots = [found.robot for found in every() if found.robot is not None]
    return {one.suffix: one for robot in reversed(robots) for one in robot.motion_formats}


def old_formats() -> dict[str, OldFormat]:
    """Return the formats of former programs' files by name; lbr's own has priority over others with the same name."""
    robots = [found.robot for found in every() if found.robot is not None]
    return {one.name: one for robot in reversed(robots) for one in robot.old_formats}


@plugins.remembered
def _loaded(point: Plugin) -> Found:
    try:
        return Found(name=point.name, package=point.package, robot=_whole(point, point.load()))
    except PluginError as err:
        return Found(name=point.name, package=point.package, fault=f"robot {err}")


def _whole(point: Plugin, declared: object) -> Robot:
    """Return a declared robot, if it is faultless."""
    robot = point.checked(declared, Robot)
    if faults := tuple(_faults(point, robot)) or tuple(_taken_names(point, robot)):
        raise PluginError(point, "; ".join(faults))
    return robot


def _faults(point: Plugin, robot: Any) -> Iterator[str]:
    if not isinstance(robot.name, str) or not _NAME.fullmatch(robot.name):
        yield f"'name' is {robot.name!r}: small letters, digits, underscores; at most 40"
        return
    if not isinstance(robot.summary, str):
        yield f"'summary' is {robot.summary!r}, and must be a text"
    for field in ("rows", "body", "profiles"):
        path = getattr(robot, field)
        if path is None:
            continue
        if not isinstance(path, Path):
            yield f"'{field}' is {path!r}, and must be a pathlib.Path"
        elif not (path.is_dir() if field == "profiles" else path.is_file()):
            yield f"'{field}' is {path}, which is not there"
        elif field == "profiles":
            yield from _misnamed(robot.name, path)
    yield from _unreadable(robot)
    if robot.rows is None and not point.ours:
        yield "'rows' is missing: the file of SQL that inserts its rows"


def _unreadable(robot: Robot) -> Iterator[str]:
    for one in robot.motion_formats:
        if not isinstance(one, MotionFormat) or not _SUFFIX.fullmatch(one.suffix) or one.suffix == ".json":
            yield f"'motion_formats' has {one!r}: each is a MotionFormat(suffix='.abc', …), and none is '.json'"
    for old in robot.old_formats:
        if not isinstance(old, OldFormat) or not _FORMAT.fullmatch(old.name):
            form = "OldFormat(name='my-program', …), of small letters, digits and dashes"
            yield f"'old_formats' has {old!r}: each is an {form}"


def _taken_names(point: Plugin, robot: Robot) -> Iterator[str]:
    """Yield those of its profiles that belong to a robot with a shorter name: `arm-left` may be that of `arm`."""
    mine = {plain(name) for name in (robot.name, *profiles(robot))}
    for name in () if point.ours else _begin(robot.name):
        holder = _loaded(plugins.installed("robots")[name]) if name != robot.name else None
        if holder is None or holder.robot is None:
            continue
        for profile in profiles(holder.robot):
            if plain(profile) in mine:
                yield f"robot '{name}' of package '{holder.package}' has a launch profile '{profile}' already"


def _begin(said: str) -> list[str]:
    """Return the robots whose name is the beginning of a text, as whole words."""
    text = plain(said)
    return [name for name in names() if text == name or text.startswith(f"{name}_")]


def _misnamed(name: str, folder: Path) -> Iterator[str]:
    for path in sorted(folder.glob("*.toml")):
        said = plain(path.stem)
        if said != name and not said.startswith(f"{name}_"):
            yield f"launch profile {path.name} must be called {name}.toml, or {name}-….toml"
