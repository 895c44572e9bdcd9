"""Changes of many rows at once: judged, written in one transaction with who made them, and perhaps on trial."""

from collections.abc import Callable, Iterable
from contextlib import suppress

from msgspec.structs import replace

from lbr.database import adopted, audit, past, trials
from lbr.database.reading import Problem, RawTables
from lbr.database.rows import AuditRow, RobotRows
from lbr.database.seen import Seen
from lbr.database.store import EDIT_TRIES, OTHERS_EDIT, Database, account
from lbr.errors import InputError, LbrError


class _RehearsedError(Exception):
    """A dry run has done all that it would do; its transaction is rolled back."""


def become(
    database: Database,
    wanted: past.Wanted,
    wrong: Callable[[RobotRows], Iterable[Problem]],
    *,
    text: str,
    expected: int | None = None,
    dry_run: bool = False,
    on_trial: Callable[[tuple[past.Step, ...]], tuple[str, float]] | None = None,
) -> past.Became:
    """Have the rows be as `wanted` makes them of those of now, in one transaction, unless that makes new problems.

    InputError if the newest revision is not `expected`, or why it may not be made. On return it is on the disk. The
    checks hold up no other writer; if one comes between, they begin again. A dry run does all of it and then takes
    it back. `on_trial` returns the robot whose executive judges, and the seconds that it may take.
    """
    for _ in range(EDIT_TRIES):
        with database.reading() as connection:
            seen = Seen.by(connection)
            past.refuse_other(seen.revision, expected)
        tables, schema, revision = seen.tables, seen.schema, seen.revision
        steps = wanted(tables, schema, database.tables_at)

        def judged(raw: RawTables, robot: str, seen: Seen = seen) -> Iterable[Problem]:
            return wrong(seen.rows(robot, raw))

        found = past.new_problems(tables, past.done(tables, schema, steps), steps, judged)
        became = past.Became(before=revision, revision=revision, steps=steps, problems=found)
        if found or not steps:
            return became
        with suppress(_RehearsedError), database.writing(durable=not dry_run) as connection:
            if adopted.revision(connection) == revision:
                if not dry_run:
                    trials.refuse_running(connection)
                with database.noted(connection, text=text):
                    past.write(connection, steps, schema)
                if dry_run:
                    raise _RehearsedError
                became = replace(became, revision=adopted.revision(connection))
                if on_trial is not None:
                    trials.begin(connection, became, *on_trial(steps))
                entry = AuditRow(
                    wall_ns=database.wall_ns(),
                    kind="edit",
                    subject="rows",
                    source=database.program,
                    text=f"{account()} {text}",
                )
                audit.append(connection, [entry])
                return became
        if dry_run:
            return became
    raise InputError(OTHERS_EDIT, "busy")


def trial(database: Database) -> past.Trial | None:
    """Return the newest change of rows that was on trial, or still is."""
    with database.reading() as connection:
        return trials.newest(connection)


def judge(database: Database, trial: past.Trial, *, good: bool, text: str) -> past.Trial:
    """End a trial, if it still runs: keep its rows, or take them back; return what became of it.

    What others have changed since in the same rows stays. Rows that cannot be taken back are told in its text.
    """
    with database.writing(durable=True) as connection:
        now = trials.newest(connection)
        if now is None or (now.revision, now.state) != (trial.revision, "running"):
            return now or trial
        if good:
            return trials.end(connection, trial, "kept", text)
        try:
            connection.execute("SAVEPOINT going_back")
            with database.noted(connection, text=f"went back to revision {trial.back}: {text}"):
                trials.take_back(connection, trial)
        except LbrError as err:
            connection.execute("ROLLBACK TO going_back")
            return trials.end(connection, trial, "lost", f"{text}; and it cannot be taken back: {err}")
        entry = AuditRow(
            wall_ns=database.wall_ns(),
            kind="edit",
            subject="rows",
            source=database.program,
            text=f"went back to revision {trial.back}: {text}",
        )
        audit.append(connection, [entry])
        return trials.end(connection, trial, "back", text)
