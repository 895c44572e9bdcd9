"""Upgrades an older database to this version's schema: backup first, then all steps in one transaction."""

from pathlib import Path

from lbr.database import claims
from lbr.database.connection import Connection, pragma, transaction, vacuum_into
from lbr.database.constraints import statements
from lbr.errors import RowError
from lbr.names import first_free

MIGRATIONS = Path(__file__).with_name("migrations")
HEAD = max(step.stem[1:5] for step in MIGRATIONS.glob("versions/v*.py"))
"""The schema of this version: the number of its newest step."""


def bring_up_to_date(connection: Connection, path: Path) -> Path | None:
    """Upgrade an older database and return its backup; None if it is up to date.

    RowError: its schema is unknown, or a robot of an older version runs from it, which could no longer read it.
    """
    stamp = _stamp(connection)
    if stamp == HEAD:
        return None
    _refuse_unknown(stamp, path)
    if claims.any_robot(path):
        text = f"database {path} has the schema '{stamp}', and a robot of the older lbr that made it runs from it"
        raise RowError((f"{text}: end that first (`lbr stop`, or `systemctl stop`), then it is brought to '{HEAD}'",))
    backup_file = backup(connection, path, stamp)
    pragma(connection, "foreign_keys = OFF")  # otherwise rebuilding a table would delete the rows that refer to it
    try:
        with transaction(connection, "IMMEDIATE"):
            if _stamp(connection) != HEAD:
                _upgrade(connection)
    finally:
        pragma(connection, "foreign_keys = ON")
    return backup_file


def backup(connection: Connection, path: Path, stamp: str) -> Path:
    """Copy the whole database to a new file beside it that only its owner may read."""
    name = first_free(f"{path.name}.backup-{stamp}", lambda one: path.with_name(one).exists(), "-")
    vacuum_into(connection, path.with_name(name))
    return path.with_name(name)


def _stamp(connection: Connection) -> str:
    return str(connection.scalar("SELECT min(version_num) FROM alembic_version"))


def _refuse_unknown(stamp: str, path: Path) -> None:
    from alembic.script import ScriptDirectory

    known = {revision.revision for revision in ScriptDirectory(str(MIGRATIONS)).walk_revisions()}
    if stamp in known:
        return
    text = f"database {path} has the schema '{stamp}', which this version of lbr (schema {HEAD}) does not know"
    if stamp.isdigit() and stamp < min(known):
        take_in = "`lbr db init --db NEW.db` and `lbr db import DIR --db NEW.db` of this one"
        do = f"it is older; `lbr db export DIR` of the lbr that made it, then {take_in}"
        raise RowError((f"{text}: {do}",))
    raise RowError((f"{text}: install a newer lbr, or put a backup in its place",))


def _upgrade(connection: Connection) -> None:
    from alembic import command
    from alembic.config import Config
    from sqlalchemy import create_engine
    from sqlalchemy.exc import DBAPIError
    from sqlalchemy.pool import StaticPool

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    dangling = _dangling(connection)
    # The transaction is ours: SQLAlchemy's own transactions end nothing here.
    engine = create_engine("sqlite://", creator=lambda: _Lent(connection), poolclass=StaticPool)
    try:
        with engine.connect() as config.attributes["connection"]:
            command.upgrade(config, HEAD)
    except DBAPIError as err:
        raise (err.orig or err) from None
    connection.execute("DELETE FROM adopted")  # the same rows may have another hash now
    if _dangling(connection) > dangling:
        raise RowError(("the upgrade would leave rows that refer to none; nothing was changed: report this",))


def run(script: str) -> None:
    """Run SQL as a step of an upgrade, statement by statement."""
    from alembic import op

    for _, statement in statements(script):
        op.get_bind().exec_driver_sql(statement)


class _Lent:
    """A connection for the time of a migration: it neither commits, rolls back nor closes."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __getattr__(self, name: str) -> object:
        return getattr(self._connection, name)

    def commit(self) -> None:
        """Do nothing: the caller that began commits."""

    rollback = close = commit


def _dangling(connection: Connection) -> int:
    return len(connection.execute("PRAGMA foreign_key_check").fetchall())
