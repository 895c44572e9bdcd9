"""Events and changes: the tables `event` and `revision`."""

import json
from collections.abc import Iterable, Sequence
from typing import Any

import msgspec

from lbr.database.connection import Connection, insert, selected
from lbr.database.past import ChangeRow
from lbr.database.rows import RevisionRow
from lbr.messages.system import Event

EVENTS_KEPT = 20_000
LEVELS = ("info", "warning", "error")
LONGEST = 300
"""In characters of the text of a change."""
MOST_LOOKED_THROUGH = 500
"""Enough for the changes while a form is open."""
_REVISIONS = """
SELECT id, table_name, row_key, operation, old_row, new_row, changed_at FROM revision WHERE id > ? ORDER BY id
"""


def append_events(connection: Connection, events: Iterable[Event], now_ns: int) -> None:
    """Write events, and delete the oldest beyond the kept number."""
    rows = [_stored(event, now_ns) for event in events]
    if not rows:
        return
    insert(connection, "event", rows)
    connection.execute("DELETE FROM event WHERE id <= (SELECT max(id) FROM event) - ?", (EVENTS_KEPT,))


def newest_events(
    connection: Connection, limit: int, *, subject: str = "", levels: Sequence[str] = LEVELS
) -> tuple[Event, ...]:
    """Return the newest events, oldest first; optionally of one subject, or of some levels."""
    where = f"level IN ({', '.join('?' * len(levels))}) AND (? = '' OR subject = ?) ORDER BY id DESC LIMIT ?"
    rows = selected(connection, "event", where, *levels, subject, subject, limit)
    columns = ("kind", "subject", "text", "level", "wall_ns")
    return tuple(
        Event(**{name: row[name] for name in columns}, data=_object(row["data"]) or {}) for row in reversed(rows)
    )


def revisions(connection: Connection, since: int, *, whole: bool = True) -> tuple[RevisionRow, ...]:
    """Return the changes after revision `since`, oldest first; unless `whole`, without the rows' content."""
    rows = connection.execute(_REVISIONS if whole else _REVISIONS.replace("old_row, new_row", "NULL, NULL"), (since,))
    return tuple(
        RevisionRow(
            id=id_,
            table=table,
            row_key=_key(key),
            operation=change,
            before=_row(before),
            after=_row(after),
            changed_at=at,
        )
        for id_, table, key, change, before, after, at in rows
    )


def made(connection: Connection, change: ChangeRow) -> None:
    """Record the author and the way of some revisions."""
    texts = {name: storable(getattr(change, name))[:LONGEST] for name in ("source", "program", "text")}
    insert(connection, "change", [msgspec.structs.asdict(change) | texts])


def makers(connection: Connection) -> tuple[ChangeRow, ...]:
    """Return the authors and ways of revisions; those of other SQLite clients are unknown."""
    return tuple(ChangeRow(**row) for row in selected(connection, "change", "1 ORDER BY first_revision"))


def last_change(
    connection: Connection, table: str, names: Sequence[Iterable[object]], program: str
) -> tuple[str, str] | None:
    """Return the time of a row's newest change, and its author if that was this program.

    `names` are the sets of values that may be the row's key.
    """
    keys = [sorted(map(str, one)) for one in names]
    newest = selected(connection, "revision", "table_name = ? ORDER BY id DESC LIMIT ?", table, MOST_LOOKED_THROUGH)
    for row in newest:
        if sorted(_key(row["row_key"])) in keys:
            made_by = "SELECT source FROM change WHERE ? BETWEEN first_revision AND last_revision AND program = ?"
            return row["changed_at"], connection.scalar(made_by, (row["id"], program)) or ""
    return None


def outdo(connection: Connection, revision: int) -> None:
    """Record an edit of every row that is newer than `revision` and than all others."""
    newest = max(revision, connection.scalar("SELECT max(id) FROM revision") or 0)
    row = {"id": newest + 1, "table_name": "robot", "row_key": '["every row"]', "operation": "update"}
    insert(connection, "revision", [row])


def storable(text: str) -> str:
    """Return a text in which all but valid UTF-8 is replaced."""
    return text.encode(errors="replace").decode()


def _stored(event: Event, now_ns: int) -> dict[str, str | int]:
    return {
        "wall_ns": event.wall_ns if 0 < event.wall_ns < 2**63 else now_ns,
        "kind": storable(event.kind),
        "subject": storable(event.subject),
        "level": event.level if event.level in ("info", "warning", "error") else "error",
        "text": storable(event.text),
        "data": storable(msgspec.json.encode(event.data).decode(errors="replace")),
    }


def _row(text: str | None) -> dict[str, Any] | None:
    """Return a revision's row as in its table: in a trigger, a column set by `json_set` is JSON, not text."""
    found = _object(text)
    return {name: _as_text(value) for name, value in found.items()} if found is not None else None


def _as_text(value: object) -> object:
    if isinstance(value, dict | list):
        return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return value


def _object(text: str | None) -> dict[str, Any] | None:
    found = _decoded(text)
    return found if isinstance(found, dict) else None


def _key(text: str) -> tuple[str, ...]:
    found = _decoded(text)
    return tuple(str(part) for part in found) if isinstance(found, list) else (text,)


def _decoded(text: str | None) -> object:
    try:
        return json.loads(text or "null")
    except (ValueError, RecursionError):
        return None
