"""The audit trail: rows chained by their hashes, which reveal a change, a gap or a missing end."""

from collections.abc import Callable, Iterable
from hashlib import blake2b

import msgspec
from msgspec.structs import replace

from lbr.database.connection import Connection, insert, selected
from lbr.database.history import storable
from lbr.database.rows import AuditRow
from lbr.messages.plain import one_line

KEPT = 20_000
"""The same number as in the trigger `audit_delete`."""

_TEXTS = ("kind", "subject", "source", "text")
_SEQUENCE = "SELECT seq FROM sqlite_sequence WHERE name = 'audit'"


def append(connection: Connection, entries: Iterable[AuditRow]) -> None:
    """Append entries to the trail, each as a line of plain text, and delete the oldest beyond the kept number."""
    number = _highest(connection)
    previous = connection.scalar("SELECT hash FROM audit ORDER BY id DESC LIMIT 1") or ""
    rows = []
    for entry in entries:
        number += 1
        # strangers choose names and reasons, which must not forge lines or control a terminal
        row = chained(_with_texts(entry, one_line), number, previous)
        previous = row.hash
        rows.append(msgspec.structs.asdict(row))
    if rows:
        insert(connection, "audit", rows)
        connection.execute("DELETE FROM audit WHERE id <= ?", (number - KEPT,))


def newest(connection: Connection, limit: int) -> tuple[AuditRow, ...]:
    """Return the newest entries, oldest first."""
    return tuple(
        AuditRow(**row) for row in reversed(selected(connection, "audit", "1 ORDER BY id DESC LIMIT ?", limit))
    )


def fault(connection: Connection) -> str:
    """Return the fault in the trail, or an empty text."""
    last: AuditRow | None = None
    count = 0
    for values in selected(connection, "audit", "1 ORDER BY id"):
        row = AuditRow(**values)
        if last is not None and (row.id, row.previous) != (last.id + 1, last.hash):
            return f"after {last.id} rows are missing or were changed"
        if row != chained(row, row.id, row.previous):
            return f"row {row.id} was changed"
        if last is None and (row.id == 1) != (row.previous == ""):
            return f"row {row.id} is not where the trail begins"
        last, count = row, count + 1
    first = last.id - count + 1 if last is not None else 1
    if (last.id if last is not None else 0) != _highest(connection):
        return "its newest rows are missing"
    return "" if first == 1 or count >= KEPT else f"the rows before {first} are missing"


def chained(entry: AuditRow, number: int, previous: str) -> AuditRow:
    """Return an entry for the trail: numbered, with its hash over the hash `previous`."""
    entry = _with_texts(entry, storable)
    content = msgspec.json.encode([number, entry.wall_ns, *(getattr(entry, name) for name in _TEXTS), previous])
    return replace(entry, id=number, previous=previous, hash=blake2b(content, digest_size=32).hexdigest())


def _with_texts(entry: AuditRow, made: Callable[[str], str]) -> AuditRow:
    return replace(entry, **{name: made(getattr(entry, name)) for name in _TEXTS})


def _highest(connection: Connection) -> int:
    """Return the highest number ever used, including rows that are gone."""
    return int(connection.scalar(_SEQUENCE) or 0)
