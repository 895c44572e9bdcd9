"""The row sets that ran: rows that differ from one with the same revision have changed without an edit."""

from hashlib import blake2b

from lbr.database.connection import Connection
from lbr.database.reading import Problem, RawTables
from lbr.database.tables import WRITTEN_BY_LBR

KEPT = 100
_CHANGED = (
    "the rows are not those that ran before, and no edit explains it: the file is damaged, or was changed with"
    " its triggers off; `lbr db restore` puts the last good copy in its place, any edit approves the rows as they are"
)


def digest(tables: RawTables) -> str:
    """Return the hash of the rows that make robots, without the columns that lbr itself writes."""
    hasher = blake2b(digest_size=16)
    for table, rows in sorted(tables.items()):
        names = sorted(name for name in next(iter(rows), {}) if (table, name) not in WRITTEN_BY_LBR)
        for row in rows:
            hasher.update(repr((table, [(name, row[name]) for name in names])).encode(errors="surrogateescape"))
    return hasher.hexdigest()


def revision(connection: Connection) -> int:
    """Return the number of the last change of rows; 0 without one."""
    return connection.scalar("SELECT max(id) FROM revision") or 0


def remember(connection: Connection, number: int, digest: str, wall_ns: int) -> None:
    """Record that a row set runs."""
    connection.execute(
        "INSERT OR IGNORE INTO adopted (revision, hash, wall_ns) VALUES (?, ?, ?)", (number, digest, wall_ns)
    )
    connection.execute("DELETE FROM adopted WHERE revision <= ?", (number - KEPT,))


def problems(connection: Connection, number: int, digest: str) -> tuple[Problem, ...]:
    """Return the problem with rows that differ from those that ran as this revision, if they do."""
    ran = connection.scalar("SELECT hash FROM adopted WHERE revision = ?", (number,))
    return () if ran is None or ran == digest else (Problem("adopted", str(number), "hash", _CHANGED),)
