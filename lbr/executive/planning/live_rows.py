"""The rows in force: the plan that runs, and its changes by edits and by learnt rows."""

import contextlib
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

import msgspec
from msgspec import Raw

from lbr.database import edits
from lbr.database.edits import RowKey
from lbr.database.reading import Problem
from lbr.database.rows import RobotRows
from lbr.database.store import Database
from lbr.errors import LbrError
from lbr.executive.planning import plan as plans
from lbr.executive.planning.console_lines import vocabulary
from lbr.executive.planning.last_good_copy import LastGoodCopy
from lbr.executive.planning.plan import Change, Plan
from lbr.executive.planning.process_specs import read_by
from lbr.executive.planning.trials import Trials
from lbr.executive.planning.watch import RowWatch
from lbr.executive.processes.plugging import Plugging
from lbr.executive.processes.robot_processes import RobotProcesses
from lbr.executive.service.journal import Journal
from lbr.executive.services import Service
from lbr.messages.calibration import CalibrationValue
from lbr.messages.codes import Code
from lbr.messages.rows import Row, by_table
from lbr.messages.schema import JsonObject
from lbr.messages.unreadable import UNREADABLE

LOOK_S, WAITS_S = 0.1, 0.1
"""The pause after a look at the rows, and the wait for a turn that comes anyway."""
LOOK_SHARE = 5.0
"""Reading takes at most a fifth of the main thread's time: slow reads are less frequent."""
PROBLEMS_TOLD = 3
"""The number of problems of an edit that are reported; a joint's limit alone may conflict with a dozen key frames."""


class LiveRows(Service):
    """The rows in force: `plan` runs, and `vocabulary` are its words.

    `problems` and their `code` explain why an edit is not in force. While the rows are `held`, edits wait. `processes`
    carry out a new plan, and keep the rows that they learnt. `plugging` gives them more emulated devices, or other
    rows. `publish(plan)` publishes how to reach the robot.
    """

    def __init__(
        self,
        database: Database,
        watch: RowWatch,
        plan: Plan,
        journal: Journal,
        processes: RobotProcesses,
        plugging: Plugging,
        publish: Callable[[Plan], None],
    ) -> None:
        self._database = database
        self._watch = watch
        self._keeper = LastGoodCopy(database.path, journal.trouble)
        self._happened = journal.happened
        self._processes = processes
        self._plugging = plugging
        self._publish = publish
        self._trials = Trials(database, processes.capabilities, journal.happened)
        self.problems: tuple[str, ...] = ()
        self.code: Code = "bad_value"
        self.held = False
        self.plan = plan
        self.vocabulary = vocabulary(plan.rows, plan.kinds)
        self._look_at = 0.0

    def step(self, now: float) -> float:
        """Look at the rows when due, and copy good ones; return when to call again."""
        self._keeper.step(now, self.plan.rows.digest)
        if now >= self._look_at:
            self.look()
            self._look_at = now + max(LOOK_S, LOOK_SHARE * (time.monotonic() - now))
        return self._look_at + WAITS_S

    def soon(self) -> None:
        """Look at the rows in the next turn, because this process has written some."""
        self._look_at = 0.0

    def well(self) -> None:
        """Note that the robot runs well: its rows are copied after some seconds."""
        self._keeper.touched(time.monotonic())

    def planned(self, rows: RobotRows) -> tuple[Plan | None, tuple[Problem, ...]]:
        """Return the plan for rows that are not written yet, and their problems; may be called from any thread."""
        return self._watch.planned(rows, self.plan)

    def judge(self, rows: RobotRows) -> tuple[Problem, ...]:
        """Return the problems of rows that are not written yet; may be called from any thread."""
        return self.planned(rows)[1]

    def look(self) -> None:
        """Adopt an edit, or report why not; wait while an edit is being written on request. Judge rows on trial."""
        self._look()
        on = self._trials.on
        self._trials.look(self.plan.robot, self.plan.rows.revision, self.problems)
        if self._trials.on:
            self._keeper.not_well()
        elif on:
            self.well()

    def _look(self) -> None:
        news = None if self.held else self._watch.look(self.plan)
        if news is None:
            return
        if news.plan is None or news.problems:
            self._keeper.not_well()
            if news.problems != self.problems:
                self.problems = news.problems
                self.code = "failed" if news.unreadable else "bad_value"
                what = "the rows cannot be read" if news.unreadable else "the edit is not applied"
                text = f"{what}, the robot goes on as it was: {_first(news.problems)}"
                self._happened("rows_refused", "executive", text, "error", code=self.code)
        if news.plan is None:
            return
        if not news.problems:
            self.well()
        if self.problems and not news.problems:
            self.problems = ()
            self._happened("rows_good", "executive", "the rows are good again")
        if news.edited or news.change != Change():
            self._adopt(news.plan, news.change, news.edited or "a capability's file")

    def adopted(self) -> dict[str, object]:
        """Record that the plan's rows run, and return their revision and digest."""
        rows = self.plan.rows
        with contextlib.suppress(LbrError):
            self._database.adopt(rows)
        return {"revision": rows.revision, "rows": rows.digest}

    def learnt(self, name: str, told: Mapping[str, Raw]) -> None:
        """Store the rows that a capability has learnt. It uses them already, so it is not restarted."""
        rows = self._may_learn(name, told) if name in self.plan.units else ()
        if not rows:
            return
        try:
            edits.learn(self._database, self.plan.robot, rows, self._known(name), by=name)
        except LbrError as err:
            what = ", ".join(dict.fromkeys(row.full_name for row in rows))
            text = f"the {what} holds until the next restart only, it could not be written down: {err}"
            self._happened("learnt_lost", name, text, "error")
            return
        self._keep(plans.learnt(self.plan, name, by_table(rows)), name)

    def _may_learn(self, name: str, learnt: Mapping[str, Raw]) -> tuple[Row, ...]:
        """Return the learnt rows that the capability's kind may write; report a refusal if they are unreadable."""
        kind, config, known = self.plan.kinds[name], self.plan.units[name].config, self._known(name)
        allowed: list[Row] = []
        try:
            for read in kind.reads:
                if read.row in kind.learns and read.row.TABLE in learnt:
                    rows = _whole(read.row, learnt[read.row.TABLE], known)
                    allowed += read_by(read, kind.parse(bytes(config.settings)), rows)
        except UNREADABLE as err:
            self._happened("refused", name, f"what it has learnt cannot be written down: {err}", "warning")
            return ()
        return tuple(allowed)

    def knows(self, name: str, rows: Collection[Row]) -> None:
        """Note stored rows that a running capability has already, so that it is not restarted for them."""
        if name in self.plan.units:
            self._keep(plans.learnt(self.plan, name, by_table(rows)), name)

    def look_again(self) -> None:
        """Read the rows at the next look: this process has written some."""
        self._watch.look_again()

    def _known(self, name: str) -> dict[RowKey, Any]:
        """Return the rows of a capability by table and key, except those that its profile replaces."""
        measured = {value.device for value in self.plan.rows.of(CalibrationValue)}
        return {
            (table, tuple(row[column] for column in row_set.key)): row
            for table, row_set in self.plan.units[name].config.rows.items()
            for row in msgspec.json.decode(row_set.rows)
            if table != CalibrationValue.TABLE or row["measured_at"] or row["device"] in measured
        }

    def _adopt(self, plan: Plan, change: Change, edited: str) -> None:
        self.vocabulary = vocabulary(plan.rows, plan.kinds)
        before, self.plan = self.plan, plan
        steps = (
            ("stop", change.stop),
            ("restart", change.restart),
            ("start", change.start),
            ("tell of a device", change.plug),
            ("tell of its rows", change.follow),
        )
        done = "; ".join(f"{what} {', '.join(names)}" for what, names in steps if names)
        old, new = before.rows.verbs, plan.rows.verbs
        asked = sorted({verb.target_end[0] for verb in (*old, *new) if (verb in old) != (verb in new)})
        touched = list(dict.fromkeys([*(name for _, names in steps for name in names), *asked]))
        text = f"{edited}: {done or 'no process is touched'}"
        self._happened("rows_changed", "executive", text, data={**self.adopted(), "touched": touched})
        self._trials.touching(change)
        self._processes.take_over(plan, change)
        with contextlib.suppress(OSError):
            self._publish(plan)
        for name in change.plug:
            self._plugging.ask(name, plans.added_devices(before.units[name], plan.units[name]))
        for name in change.follow:
            told = plans.changed_rows(before.units[name], plan.units[name])
            if told is not None:
                self._plugging.tell(name, told)

    def _keep(self, plan: Plan, name: str) -> None:
        self.plan = plan
        self._processes.keep(plan, name)
        self._watch.look_again()


def _whole(row: type[Row], told: Raw, known: Mapping[RowKey, Any]) -> Iterator[Row]:
    """Yield learnt rows as whole rows: only changes of known rows are reported, and deleted rows stay deleted."""
    for one in msgspec.json.decode(told, type=list[JsonObject]):
        before = known.get((row.TABLE, tuple(one.get(column) for column in row.KEY)), {})
        if before or one.keys() >= set(row.__struct_fields__):
            yield msgspec.convert({**before, **one}, row)


def _first(problems: tuple[str, ...]) -> str:
    more = len(problems) - PROBLEMS_TOLD
    rest = f"; and {more} more, which `lbr db check` lists" if more > 0 else ""
    return "; ".join(problems[:PROBLEMS_TOLD]) + rest
