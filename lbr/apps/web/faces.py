"""Loads the faces that the row names from installed packages; a face that cannot be shown is refused with the
reason."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import wraps
from typing import TypeVar

from lbr import plugins
from lbr.apps.web import openapi
from lbr.apps.web.face import Face, Refused, Route
from lbr.apps.web.robot import Robot
from lbr.apps.web.routing import Path
from lbr.capability.border import border
from lbr.errors import InputError, told
from lbr.plugins import Plugin, PluginError

T = TypeVar("T")


class Shown:
    """A face behind a guard: an error in it ends this face and no other. `broken` names the error."""

    def __init__(self, face: Face, routes: Iterable[Route], label: str) -> None:
        self.name = face.name
        self.broken = ""
        self._label = label
        self._face = face
        self.routes = tuple(replace(route, handle=self._guarded(route.handle)) for route in routes)

    def run(self, work: Callable[[Face], T], otherwise: T) -> T:
        """Return the result of the face's work; `otherwise` once it is broken."""
        if not self.broken:
            with border(self._break):
                return work(self._face)
        return otherwise

    def _break(self, err: Exception) -> None:
        self.broken = f"{self._label}: it failed, and is shown no more: {told(err)}"

    def _guarded(self, handle: Callable[..., T]) -> Callable[..., T]:
        @wraps(handle)
        def guarded(**arguments: object) -> T:
            if self.broken:
                raise Refused(503, self.broken)
            return handle(**arguments)

        return guarded


class Faces:
    """The faces of one row: `shown`, and in `trouble` why others are not."""

    def __init__(self, names: Sequence[str], robot: Robot, row: str) -> None:
        self.shown: list[Shown] = []
        self._refused: list[str] = []
        self._row = row
        self._taken: dict[tuple[str, str, str], str] = {}
        self._loaded: list[tuple[str, Face]] = []
        for name in dict.fromkeys(names):
            points, none = _chosen(name)
            if none:
                self._refuse(f"face '{name}'", none)
            for point in points:
                label = f"face {point.label}"
                try:
                    self._loaded.append((label, _made(point, robot)))
                except PluginError as err:
                    self._refuse(label, err.why)

    def add(self, face: Face) -> None:
        """Add a face that no package brings."""
        self._loaded.append((f"face '{face.name}' of this process", face))

    def open(self, builtin: Iterable[Route]) -> list[Route]:
        """Return the routes of all faces; refuse a face whose routes are taken by the server or another face."""
        builtin = tuple(builtin)
        self.shown, self._taken = [], dict.fromkeys(map(_claim, builtin), "the server")
        loaded, self._loaded = self._loaded, []
        for label, face in loaded:
            try:
                routes = self._fitting(face, builtin)
            except InputError as err:
                self._refuse(label, str(err))
                continue
            self._taken |= dict.fromkeys(map(_claim, routes), f"face '{face.name}'")
            self.shown.append(Shown(face, routes, self._label(label)))
            self._loaded.append((label, face))
        return [route for shown in self.shown for route in shown.routes]

    @property
    def trouble(self) -> str:
        """Return the faces that are not shown, and why; empty if all are."""
        return "; ".join([*self._refused, *(one.broken for one in self.shown if one.broken)])

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the shown faces."""
        return tuple(one.name for one in self.shown if not one.broken)

    @property
    def jobs(self) -> int:
        """Return the number of jobs that wait or are under way."""
        return sum(shown.run(lambda face: int(face.jobs), 0) for shown in self.shown)

    def step(self, now: float) -> None:
        """Do one round of work in each face."""
        for shown in self.shown:
            shown.run(lambda face: face.step(now), None)

    def know(self) -> bool:
        """Return whether all faces have the data that their clients request first."""
        return all(shown.run(lambda face: bool(face.knows()), True) for shown in self.shown)

    def stopped(self, reason: str) -> None:
        """Drop the pending work of each face."""
        for shown in self.shown:
            shown.run(lambda face: face.stopped(reason), None)

    def close(self) -> None:
        """Close each face."""
        for shown in self.shown:
            shown.run(lambda face: face.close(), None)

    def states(self) -> dict[str, dict[str, object]]:
        """Return each face's part of the stream of states."""
        return {shown.name: shown.run(lambda face: dict(face.state()), {}) for shown in self.shown}

    def _fitting(self, face: Face, builtin: tuple[Route, ...]) -> tuple[Route, ...]:
        """Return a face's routes; raise InputError if they are not routes, are taken, or cannot be described."""
        with border(lambda err: InputError(f"its routes cannot be described: {told(err)}")):
            routes = tuple(face.routes())
            for route in routes:
                Path(route.path)
            openapi.document([*builtin, *routes], title="", description="", version="")
        for route in routes:
            if (owner := self._taken.get(_claim(route))) is not None:
                raise InputError(f"{route.method} {route.path} is taken by {owner}")
        return routes

    def _refuse(self, label: str, why: str) -> None:
        self._refused.append(f"{self._label(label)}: {why}")

    def _label(self, label: str) -> str:
        return f"{label}, in the setting 'faces' of capability '{self._row}'"


def _chosen(name: str) -> tuple[list[Plugin], str]:
    """Return the packages with a face of that name, or why it is missing."""
    found = [one for one in plugins.every("faces") if one.name == name]
    if found:
        return found, ""
    there = (
        ", ".join(sorted(plugins.installed("faces"))) or "none: install lbr again, in a checkout by `pip install -e .`"
    )
    return [], f"no installed package brings it; there are {there}"


def _made(point: Plugin, robot: Robot) -> Face:
    """Import a face and make it; raise PluginError with the reason if that fails."""
    make = point.load()
    try:
        face = make(robot)
    except (Exception, SystemExit) as err:
        raise PluginError(point, f"it cannot be made: {told(err)}") from err
    return point.checked(face, Face)


def _claim(route: Route) -> tuple[str, str, str]:
    """Return the claim that only one route may have: the method, the path without its keys' names, and the media
    type."""
    parts = route.path.rstrip("/").lower().split("/")
    return route.method, "/".join("{}" if part.startswith("{") else part for part in parts), route.accept
