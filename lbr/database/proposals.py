"""Proposed changes of rows: judged by the rows after them, and written in one transaction.

wanted(tables of now) ──► changes ──► judged beside, without a lock ──► written if the revision is still the same
        ▲                                                                     │
        └──────────────────────── others were faster ─────────────────────────┘
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from typing import Self

from msgspec import Struct
from msgspec.structs import replace

from lbr.database import adopted, audit, changes, trials
from lbr.database.changes import Change
from lbr.database.connection import Connection
from lbr.database.reading import ROBOT, Problem, RawTables
from lbr.database.rows import RobotRows
from lbr.database.seen import Seen
from lbr.database.store import Database, account
from lbr.database.tables import Schema
from lbr.errors import InputError, RowError

TRIES = 5
Wanted = Callable[[RawTables, Schema], tuple[Change, ...]]
"""Returns the changes of the present tables; raises InputError with the reason against them."""
Judge = Callable[[RobotRows], Iterable[Problem]]
"""Returns the problems of a robot's rows."""
Write = Callable[[Connection, Sequence[Change], Schema], None]
OnTrial = Callable[[tuple[Change, ...]], tuple[str, float]]
"""Returns the robot whose executive judges changes on trial, and its time limit in seconds."""


class Proposed(Struct, frozen=True, kw_only=True):
    """The result of a proposal: revisions before and after, and its changes. With problems, nothing was changed."""

    before: int
    revision: int
    changes: tuple[Change, ...] = ()
    problems: tuple[Problem, ...] = ()

    def good(self) -> Self:
        """Return itself; raise RowError if it has problems."""
        if self.problems:
            raise RowError(tuple(map(str, self.problems)))
        return self


class _RehearsedError(Exception):
    """The end of a dry run, which rolls its transaction back."""


def propose(
    database: Database,
    wanted: Wanted,
    judge: Judge,
    *,
    robot: str | None = None,
    mending: bool = True,
    expected: int | None = None,
    by: str = "",
    text: str = "",
    dry_run: bool = False,
    write: Write = changes.write,
) -> Proposed:
    """Write the wanted changes, all or none, unless they have problems. On return they are on the disk.

    With `robot`, only the rows of this robot are judged. With `mending`, old problems do not count. `expected` is the
    revision that the rows must have. `by` and `text` name the author and the change. A dry run rolls everything back at
    the end. The checks delay no other writer. After another write they begin again.
    """
    for _ in range(TRIES):
        with database.reading() as connection:
            seen = Seen.by(connection)
        _refuse_other(seen.revision, expected)
        made = wanted(seen.tables, seen.schema)
        after = changes.applied(seen.tables, seen.schema, made)
        problems = tuple(_in_the_way(seen, after, judge, robot, mending=mending)) if made or not mending else ()
        proposed = Proposed(before=seen.revision, revision=seen.revision, changes=made, problems=problems)
        if problems or not made:
            return proposed
        with suppress(_RehearsedError), database.writing(durable=not dry_run) as connection:
            if adopted.revision(connection) == seen.revision:
                with database.noted(connection, by, text):
                    write(connection, made, seen.schema)
                if dry_run:
                    raise _RehearsedError
                return replace(proposed, revision=adopted.revision(connection))
        if dry_run:
            return proposed
    raise InputError("others edit the rows at the same time: try again", "busy")


def command(
    database: Database,
    wanted: Wanted,
    judge: Judge,
    *,
    text: str,
    expected: int | None = None,
    dry_run: bool = False,
    on_trial: OnTrial | None = None,
) -> Proposed:
    """Propose a person's changes of many rows. No other row changes with them; the audit trail names them."""

    def write(connection: Connection, made: Sequence[Change], schema: Schema) -> None:
        back = adopted.revision(connection)
        if not dry_run:
            trials.refuse_running(connection)
        changes.write_exactly(connection, made, schema)
        if on_trial is not None and not dry_run:
            robot, within_s = on_trial(tuple(made))
            revision = adopted.revision(connection)
            trials.begin(connection, trials.Trial(revision=revision, back=back, robot=robot, within_s=within_s))
        audit.append(connection, [database.edit_entry(f"{account()} {text}")])

    return propose(database, wanted, judge, expected=expected, text=text, dry_run=dry_run, write=write)


def _in_the_way(seen: Seen, after: RawTables, judge: Judge, robot: str | None, *, mending: bool) -> Iterator[Problem]:
    """Yield the problems of the rows `after`, and one for each removed robot whose emergency stop is latched."""
    robots = {row["name"]: row for row in seen.tables.get(ROBOT, ())}
    stays = [row["name"] for row in after.get(ROBOT, ())]
    for name, row in robots.items():
        if name not in stays and row.get("estop_engaged"):
            text = "its emergency stop is latched: 'reset' it before the robot is taken out"
            yield Problem(ROBOT, name, "estop_engaged", text)
    reported: set[Problem] = set()
    for name in stays if robot is None else (robot,):
        now = list(judge(seen.rows(name, after)))
        was = list(judge(seen.rows(name))) if now and mending and name in robots else []
        for problem in now:
            if problem not in was and problem not in reported:
                reported.add(problem)
                yield problem


def _refuse_other(revision: int, expected: int | None) -> None:
    """Raise InputError if the rows no longer have the expected revision."""
    if expected is not None and revision != expected:
        raise InputError(
            f"the rows have revision {revision}, not {expected}: they were changed meanwhile; look at them again",
            "changed",
        )
