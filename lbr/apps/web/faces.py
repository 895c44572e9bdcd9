"""Which faces are shown: those that the row names, out of installed packages. What cannot be shown is refused in words."""

from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points, version
from typing import Any

from packaging.requirements import InvalidRequirement, Requirement
from starlette.responses import Response

from lbr.apps.web import openapi
from lbr.apps.web.face import Face, Refused, Request, Route
from lbr.apps.web.robot import Robot
from lbr.apps.web.routing import Path
from lbr.errors import InputError

GROUP = "lbr.faces"
CORE = "lbr"


class Shown:
    """A face behind a guard: whatever breaks in it ends this face and no other. `broken` says what did."""

    def __init__(self, face: Face, routes: Iterable[Route], told: str) -> None:
        self.name = face.name
        self.broken = ""
        self._told = told
        self._face = face
        self.routes = tuple(replace(route, handle=self._guarded(route.handle)) for route in routes)

    @property
    def jobs(self) -> int:
        """How many jobs wait or are under way."""
        return int(self._run(lambda: self._face.jobs, 0))

    def step(self, now: float) -> None:
        """Do one round of work."""
        self._run(lambda: self._face.step(now), None)

    def stopped(self, reason: str) -> None:
        """Forget what waits."""
        self._run(lambda: self._face.stopped(reason), None)

    def close(self) -> None:
        """End what goes on by itself."""
        self._run(self._face.close, None)

    def state(self) -> dict[str, Any]:
        """Return what belongs into the stream of states."""
        return dict(self._run(self._face.state, {}))

    def _run(self, work: Callable[[], Any], otherwise: Any) -> Any:
        if self.broken:
            return otherwise
        try:
            return work()
        except Exception as err:  # noqa: BLE001 - one face must not end the others
            self.broken = f"{self._told}: it broke, and is shown no more ({type(err).__name__}: {err})"
            return otherwise

    def _guarded(
        self, handle: Callable[[Request], Response | Coroutine[Any, Any, Response]]
    ) -> Callable[[Request], Response | Coroutine[Any, Any, Response]]:
        def guarded(request: Request) -> Response | Coroutine[Any, Any, Response]:
            if self.broken:
                raise Refused(503, self.broken)
            return handle(request)

        return guarded


class Faces:
    """The faces of one row: `shown`, and in `trouble` why others are not."""

    def __init__(self, names: Sequence[str], robot: Robot, row: str) -> None:
        self.shown: list[Shown] = []
        self._refused: list[str] = []
        self._row = row
        self._taken: dict[tuple[str, str], str] = {}
        self._loaded: list[tuple[str, str, Face]] = []
        for name in dict.fromkeys(names):
            package = "no package"
            try:
                (point, *others), package = _chosen(name)
                for other in others:
                    self._refuse(name, _package(other), f"the name is taken by {package}")
                self._loaded.append((name, package, _made(point, robot)))
            except InputError as err:
                self._refuse(name, package, str(err))

    def add(self, face: Face) -> None:
        """Have a face shown that no package brings."""
        self._loaded.append((face.name, "this process", face))

    def open(self, builtin: Iterable[Route]) -> list[Route]:
        """Return the routes of all faces that fit beside the server's own and one another's."""
        builtin = tuple(builtin)
        self.shown, self._taken = [], dict.fromkeys(map(_claim, builtin), "the server")
        for name, package, face in self._loaded:
            try:
                routes = self._fitting(face, builtin)
            except InputError as err:
                self._refuse(name, package, str(err))
                continue
            self._taken |= dict.fromkeys(map(_claim, routes), f"face '{name}'")
            self.shown.append(Shown(face, routes, self._named(name, package)))
        self._loaded = [one for one in self._loaded if one[0] in {shown.name for shown in self.shown}]
        return [route for shown in self.shown for route in shown.routes]

    @property
    def trouble(self) -> str:
        """What is not shown, and why; empty if all is."""
        return "; ".join([*self._refused, *(one.broken for one in self.shown if one.broken)])

    @property
    def names(self) -> tuple[str, ...]:
        """What is shown."""
        return tuple(one.name for one in self.shown if not one.broken)

    @property
    def jobs(self) -> int:
        """How many jobs wait or are under way."""
        return sum(one.jobs for one in self.shown)

    def step(self, now: float) -> None:
        """Let each do a round of work."""
        for one in self.shown:
            one.step(now)

    def stopped(self, reason: str) -> None:
        """Have each forget what waits: somebody stopped the robot by way of this server, or it ends."""
        for one in self.shown:
            one.stopped(reason)

    def close(self) -> None:
        """Have each end what goes on by itself."""
        for one in self.shown:
            one.close()

    def states(self) -> dict[str, dict[str, Any]]:
        """Return what each adds to the stream of states."""
        return {one.name: one.state() for one in self.shown}

    def _fitting(self, face: Face, builtin: tuple[Route, ...]) -> tuple[Route, ...]:
        """Return a face's routes; raise InputError if they are none, taken, or cannot be described."""
        try:
            routes = tuple(face.routes())
            for route in routes:
                Path(route.path)
            openapi.document([*builtin, *routes], title="", description="", version="")
        except Exception as err:
            raise InputError(f"its routes cannot be described ({type(err).__name__}: {err})") from err
        for route in routes:
            if (owner := self._taken.get(_claim(route))) is not None:
                raise InputError(f"{route.method} {route.path} is taken by {owner}")
        return routes

    def _refuse(self, name: str, package: str, why: str) -> None:
        self._refused.append(f"{self._named(name, package)}: {why}")

    def _named(self, name: str, package: str) -> str:
        return f"face '{name}' of {package}, in the setting 'faces' of capability '{self._row}'"


@lru_cache(maxsize=1)
def installed() -> Mapping[str, tuple[EntryPoint, ...]]:
    """Return the entry points of faces by name; of one name there should be one."""
    found: dict[str, tuple[EntryPoint, ...]] = {}
    for point in entry_points(group=GROUP):
        found[point.name] = (*found.get(point.name, ()), point)
    return found


def _chosen(name: str) -> tuple[list[EntryPoint], str]:
    """Return the entry points of a face, the chosen first, and its package.

    lbr's own keep their names; of several others none is preferred.
    """
    points = installed().get(name, ())
    if not points:
        there = ", ".join(sorted(installed())) or "none: install lbr again, in a checkout by `pip install -e .`"
        raise InputError(f"no installed package brings it; there are {there}")
    chosen = sorted(points, key=lambda point: not _is_ours(point))
    if len(points) > 1 and not _is_ours(chosen[0]):
        packages = " and ".join(sorted(map(_package, points)))
        raise InputError(f"{packages} all bring a face of that name: uninstall all but one")
    return chosen, _package(chosen[0])


def _is_ours(point: EntryPoint) -> bool:
    return point.dist is not None and point.dist.name == CORE


def _package(point: EntryPoint) -> str:
    return f"package '{point.dist.name} {point.dist.version}'" if point.dist is not None else "an unknown package"


def _made(point: EntryPoint, robot: Robot) -> Face:
    """Import a face and make it; InputError says why that does not work."""
    for wanted in _wanted(point.dist.requires or () if point.dist is not None else ()):
        if not wanted.specifier.contains(version(CORE), prereleases=True):
            raise InputError(f"it needs {CORE}{wanted.specifier}, and this is {version(CORE)}: install what fits")
    try:
        face = point.load()(robot)
    except (Exception, SystemExit) as err:
        raise InputError(f"it does not import ({type(err).__name__}: {err})") from err
    if not isinstance(face, Face):
        raise InputError(f"{point.value} makes no Face, but a {type(face).__name__}")
    if face.name != point.name:
        raise InputError(f"it calls itself '{face.name}': the name of the entry point and Face.name agree")
    return face


def _wanted(requires: Iterable[str]) -> Iterable[Requirement]:
    """Return what a package demands of lbr."""
    for text in requires:
        try:
            wanted = Requirement(text)
        except InvalidRequirement:
            continue  # whoever installed it was told
        if wanted.name.lower() == CORE and (wanted.marker is None or wanted.marker.evaluate({"extra": ""})):
            yield wanted


def _claim(route: Route) -> tuple[str, str]:
    """Return what only one route may answer: a method of a path, whatever its keys are called."""
    parts = route.path.rstrip("/").lower().split("/")
    return route.method, "/".join("{}" if part.startswith("{") else part for part in parts)
