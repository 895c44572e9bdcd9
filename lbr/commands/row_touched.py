"""The starts, stops and restarts of a change of rows: of running robots at once, of others at their next start."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from msgspec import Struct

from lbr.commands.rows import planned, running_here
from lbr.database import proposals, trials
from lbr.database.changes import Change
from lbr.database.proposals import Proposed, Wanted
from lbr.database.reading import Problem, RawTables
from lbr.database.rows import RobotRows
from lbr.database.store import Database
from lbr.database.tables import Schema
from lbr.errors import InputError, LbrError
from lbr.executive.planning import plan as plans
from lbr.executive.planning import profile
from lbr.executive.planning.trials import go_back

if TYPE_CHECKING:
    from lbr.executive.planning.plan import Plan


class Touched(Struct, frozen=True, kw_only=True):
    """The effect of a change of rows on one robot's processes, at once if it `runs`, otherwise at its next start."""

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
        """Return whether any process is touched."""
        return bool(self.start or self.stop or self.restart or self.tell)


class Touching:
    """Judges the rows of robots as their starts would, and keeps their processes before and after."""

    def __init__(self, rows: Database) -> None:
        self._rows = rows
        self._running = running_here(rows.path)
        self._before: Mapping[str, RobotRows] = {}
        self._after: dict[str, Plan | None] = {}

    def __call__(self, rows: RobotRows) -> tuple[Problem, ...]:
        """Return the problems of rows at a start or in the running robot; a robot's new rows come first."""
        made, problems = self._planned(rows, self._before.get(rows.robot.name))
        self._after.setdefault(rows.robot.name, made)
        return problems

    def look(self, changes: Iterable[Change]) -> None:
        """Note the planned changes; raise InputError if they would remove a running robot."""
        whose = {change.robot for change in changes}
        for change in changes:
            if change.table == "robot" and change.after is None and change.key[0] in self._running:
                raise InputError(f"robot '{change.key[0]}' runs, and would be taken out: end it first", "not_possible")
        self._after.clear()
        self._before = self._rows.load_all([name for name in self._rows.robots() if {name, None} & whose])

    def judge_of(self, changes: Iterable[Change]) -> str:
        """Return the running robot whose rows change, as the judge of a trial; InputError without such a robot."""
        whose = {change.robot for change in changes}
        affected = sorted(name for name in self._running if {name, None} & whose)
        if not affected or (len(affected) > 1 and None not in whose):
            several = f"several robots that run ({', '.join(affected)}): take one with --robot"
            whose_rows = several if affected else "none that runs"
            raise InputError(f"these rows are of {whose_rows}; or leave --within out", "not_possible")
        return affected[0]

    def effects(self) -> tuple[Touched, ...]:
        """Return the effects on the processes of every robot whose rows change."""
        touched = []
        for name, rows in self._before.items():
            before, after = self._planned(rows)[0], self._after.get(name)
            if before is not None and after is not None:
                change = plans.difference(before, after)
                touched.append(
                    Touched(
                        robot=name,
                        runs=name in self._running,
                        start=change.start,
                        stop=change.stop,
                        restart=change.restart,
                        tell=(*change.plug, *change.follow),
                    )
                )
        return tuple(touched)

    def _planned(self, rows: RobotRows, before: RobotRows | None = None) -> "tuple[Plan | None, tuple[Problem, ...]]":
        running = self._running.get(rows.robot.name)
        if running is None:
            return planned(rows)
        try:
            return planned(rows, profile.load(running.profile), before)
        except LbrError:  # the file is gone, or its path was relative to another folder
            return planned(rows)


def change_rows(
    rows: Database,
    wanted: Wanted,
    text: str,
    touching: Touching,
    expected: int | None = None,
    within_s: float | None = None,
    *,
    dry_run: bool,
) -> Proposed:
    """Change the rows for a command; `touching` judges them and keeps the effects on processes."""
    if not dry_run:
        end_left_trial(rows)

    def looked_at(tables: RawTables, schema: Schema) -> tuple[Change, ...]:
        changes = wanted(tables, schema)
        touching.look(changes)
        return changes

    def on_trial(changes: tuple[Change, ...]) -> tuple[str, float]:
        return touching.judge_of(changes), within_s or 0.0

    return proposals.command(
        rows,
        looked_at,
        touching,
        text=text,
        expected=expected,
        dry_run=dry_run,
        on_trial=on_trial if within_s is not None else None,
    )


def end_left_trial(rows: Database) -> str:
    """Roll back the trial of a robot that no longer runs, as its next start would; return a report."""
    trial = trials.newest(rows)
    return "" if trial is None or trial.robot in running_here(rows.path) else go_back(rows, trial.robot)
