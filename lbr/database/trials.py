"""Changes of rows on trial: begun in the transaction of the change, kept, or taken back row by row."""

import msgspec

from lbr.database import history, past
from lbr.database.connection import Connection, insert, selected, short_values
from lbr.database.past import Became, Trial
from lbr.database.tables import read_tables
from lbr.errors import InputError

KEPT = 20
"""Trials that are over, to tell what became of one."""


def begin(connection: Connection, became: Became, robot: str, within_s: float) -> None:
    """Write down that what was just written is on trial."""
    trial = Trial(revision=became.revision, back=became.before, robot=robot, within_s=within_s)
    insert(connection, "trial", [msgspec.structs.asdict(trial)])
    newest = "SELECT revision FROM trial ORDER BY revision DESC LIMIT ?"
    connection.execute(f"DELETE FROM trial WHERE revision NOT IN ({newest})", (KEPT,))  # noqa: S608 - our names


def newest(connection: Connection) -> Trial | None:
    """Return the newest trial, if there ever was one."""
    found = selected(connection, "trial", "1 ORDER BY revision DESC LIMIT 1")
    return Trial(**found[0]) if found else None


def refuse_running(connection: Connection) -> None:
    """Raise InputError while rows are on trial: what is taken back must be what was tried."""
    trial = newest(connection)
    if trial is not None and trial.state == "running":
        raise InputError(
            f"revision {trial.revision} is on trial by '{trial.robot}' for {trial.within_s:g} s: wait for what becomes of it;"
            " if that robot does not run any more, its next start goes back, as does `lbr db undo`",
            "busy",
        )


def end(connection: Connection, trial: Trial, state: str, text: str) -> Trial:
    """Write down what became of a trial."""
    ended = msgspec.structs.replace(trial, state=state, text=history.storable(text))
    connection.execute("UPDATE trial SET state = ?, text = ? WHERE revision = ?", (state, ended.text, trial.revision))
    return ended


def take_back(connection: Connection, trial: Trial) -> None:
    """Write the rows of a trial as they were before, but for those that others have changed since."""
    now, schema = read_tables(connection)
    with short_values(connection):
        since = history.revisions(connection, trial.back)
    tried = past.at(now, schema, [one for one in since if one.id > trial.revision])
    before = past.at(tried, schema, [one for one in since if one.id <= trial.revision])
    changed = {(one.table, one.key) for one in past.steps(tried, now, schema)}
    back = [one for one in past.steps(tried, before, schema) if (one.table, one.key) not in changed]
    past.write(connection, back, schema)
