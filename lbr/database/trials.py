"""Changes of rows on trial: begun in the transaction of the change, then kept, or undone row by row."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from lbr.database import audit, changes, history, past
from lbr.database.connection import Connection, insert, selected, short_values
from lbr.database.store import Database
from lbr.database.tables import read_tables
from lbr.errors import InputError, LbrError
from lbr.messages.rows import Row

KEPT = 20
"""The number of ended trials that are kept, so that their results can be shown."""
_OLDER_GO = "DELETE FROM trial WHERE revision NOT IN (SELECT revision FROM trial ORDER BY revision DESC LIMIT ?)"


class Trial(Row, frozen=True, kw_only=True):
    """Changes of rows on trial (`lbr db apply --within`), written by lbr. The robot goes back to the rows before,
    unless all changed parts are ready in time. Only the newest row counts."""

    TABLE = "trial"
    KEY = ("revision",)
    SHARED = True

    revision: Annotated[int, "the last revision that is on trial"]
    back: Annotated[int, Meta(ge=0), "the revision to go back to"]
    robot: Annotated[str, "the robot whose executive judges"]
    within_s: Annotated[float, Meta(gt=0, le=600), "the time limit"]
    state: Annotated[Literal["running", "kept", "back", "lost"], "its result"] = "running"
    text: Annotated[str, "the reason, in one sentence"] = ""


def begin(connection: Connection, trial: Trial) -> None:
    """Store a trial of the rows just written."""
    insert(connection, "trial", [msgspec.structs.asdict(trial)])
    connection.execute(_OLDER_GO, (KEPT,))


def refuse_running(connection: Connection) -> None:
    """Raise InputError while rows are on trial: only the rows on trial may be undone."""
    trial = _newest(connection)
    if trial is not None and trial.state == "running":
        raise InputError(
            f"revision {trial.revision} is on trial by '{trial.robot}' for {trial.within_s:g} s: wait for what becomes "
            "of it; if that robot does not run any more, its next start goes back, as does `lbr db undo`",
            "busy",
        )


def newest(database: Database) -> Trial | None:
    """Return the newest trial, running or ended."""
    with database.reading() as connection:
        return _newest(connection)


def judge(database: Database, trial: Trial, *, good: bool, text: str) -> Trial:
    """End a running trial: keep its rows, or roll them back. Return the ended trial. Rows that others have changed
    since stay. If rows cannot be rolled back, the trial's text has the reason."""
    with database.writing(durable=True) as connection:
        now = _newest(connection)
        if now is None or (now.revision, now.state) != (trial.revision, "running"):
            return now or trial
        if good:
            return _end(connection, trial, "kept", text)
        back = f"went back to revision {trial.back}: {text}"
        try:
            connection.execute("SAVEPOINT going_back")
            with database.noted(connection, text=back):
                _take_back(connection, trial)
        except LbrError as err:
            connection.execute("ROLLBACK TO going_back")
            return _end(connection, trial, "lost", f"{text}; and it cannot be taken back: {err}")
        audit.append(connection, [database.edit_entry(back)])
        return _end(connection, trial, "back", text)


def _newest(connection: Connection) -> Trial | None:
    rows = selected(connection, "trial", "1 ORDER BY revision DESC LIMIT 1")
    return Trial(**rows[0]) if rows else None


def _end(connection: Connection, trial: Trial, state: str, text: str) -> Trial:
    """Store the result of a trial."""
    ended = msgspec.structs.replace(trial, state=state, text=history.storable(text))
    connection.execute("UPDATE trial SET state = ?, text = ? WHERE revision = ?", (state, ended.text, trial.revision))
    return ended


def _take_back(connection: Connection, trial: Trial) -> None:
    """Restore the rows before a trial, except those that others have changed since."""
    now, schema = read_tables(connection)
    with short_values(connection):
        since = history.revisions(connection, trial.back)
    before, tried = past.around(now, schema, since, trial.revision)
    others = {(change.table, change.key) for change in changes.between(tried, now, schema)}
    back = [one for one in changes.between(tried, before, schema) if (one.table, one.key) not in others]
    changes.write_exactly(connection, back, schema)
