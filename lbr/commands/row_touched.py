"""What a change of rows would start, stop and restart: of robots that run as they run, of others at their next
start."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from msgspec import Struct

from lbr.commands.rows import planned
from lbr.errors import InputError, LbrError

if TYPE_CHECKING:
    from lbr.database.changes import Change
    from lbr.database.reading import Problem
    from lbr.database.rows import RobotRows
    from lbr.database.store import Database
    from lbr.executive.planning.plan import Plan
    from lbr.home import Running


class Touched(Struct, frozen=True, kw_only=True):
    """What a change of rows does to one robot's processes; `runs` says whether at once, or at its next start."""

    robot: str
    runs: bool
    start: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
    restart: tuple[str, ...] = ()
    tell: tuple[str, ...] = ()

    def __str__(self) -> str:
        steps = (("start", self.start), ("stop", self.stop), ("restart", self.restart), ("tell of its rows", self.tell))
        done = "; ".join(f"{what} {', '.join(names)}" for what, names in steps if names)
        when = "which runs" if self.runs else "at its next start"
        return f"{self.robot}, {when}: {done or 'no process is touched'}"

    @property
    def any(self) -> bool:
        """Say whether any process is touched."""
        return bool(self.start or self.stop or self.restart or self.tell)


class Touching:
    """Judges the rows of robots as their starts would, and remembers what they run before and after."""

    def __init__(self, rows: "Database", running: "Mapping[str, Running]") -> None:
        self._rows = rows
        self._running = running
        self._before: dict[str, Plan | None] = {}
        self._after: dict[str, Plan | None] = {}

    def __call__(self, rows: "RobotRows") -> "tuple[Problem, ...]":
        """Return what a start would find wrong with a robot's rows; those to come are asked for first."""
        made, problems = self._planned(rows)
        self._after.setdefault(rows.robot.name, made)
        return problems

    def look(self, changes: "Iterable[Change]") -> None:
        """Take note of what is to be done; InputError if a robot that runs would be taken out."""
        whose = {change.robot for change in changes}
        for change in changes:
            if change.table == "robot" and change.after is None and change.key[0] in self._running:
                raise InputError(f"robot '{change.key[0]}' runs, and would be taken out: end it first", "not_possible")
        self._after.clear()
        names = [name for name in self._rows.robots() if {name, None} & whose]
        self._before = {name: self._planned(rows)[0] for name, rows in self._rows.load_all(names).items()}

    def judge_of(self, changes: "Iterable[Change]") -> str:
        """Return the robot that says whether changes work: the one that runs, and whose rows they are; else
        InputError."""
        whose = {change.robot for change in changes}
        found = sorted(name for name in self._running if {name, None} & whose)
        if not found or (len(found) > 1 and None not in whose):
            which = (
                f"of several robots that run ({', '.join(found)}): take one with --robot"
                if found
                else "of none that runs"
            )
            raise InputError(f"these rows are {which}; or leave --within out", "not_possible")
        return found[0]

    def told(self) -> tuple[Touched, ...]:
        """Return what becomes of the processes of every robot whose rows are another."""
        from lbr.executive.planning import plan as plans  # noqa: PLC0415 - only who changes rows needs plans

        found = []
        for name, before in self._before.items():
            after = self._after.get(name)
            if before is not None and after is not None:
                change = plans.difference(before, after)
                found.append(
                    Touched(
                        robot=name,
                        runs=name in self._running,
                        start=change.start,
                        stop=change.stop,
                        restart=change.restart,
                        tell=(*change.plug, *change.follow),
                    )
                )
        return tuple(found)

    def _planned(self, rows: "RobotRows") -> "tuple[Plan | None, tuple[Problem, ...]]":
        from lbr import home  # noqa: PLC0415 - see above
        from lbr.executive.planning import planner, profile  # noqa: PLC0415
        from lbr.executive.planning.run_identity import RunIdentity  # noqa: PLC0415

        running = self._running.get(rows.robot.name)
        if running is None:
            return planned(rows)
        try:
            chosen = profile.load(running.profile)
        except LbrError:  # a file that is not there any more, or was named from another folder
            return planned(rows)
        return planner.make(rows, chosen, RunIdentity(home=str(home.home()), endpoints=(), secret=bytes(32)))
