"""What happened and what was changed: the tables `event` and `revision`."""

import json
from collections.abc import Iterable
from typing import Any

import msgspec

from lbr.database.connection import Connection, insert, selected
from lbr.database.rows import RevisionRow
from lbr.messages.system import Event

EVENTS_KEPT = 20_000


def append_events(connection: Connection, events: Iterable[Event], now_ns: int) -> None:
    """Write events down, and let the oldest go beyond those kept."""
    rows = [_stored(event, now_ns) for event in events]
    if not rows:
        return
    insert(connection, "event", rows)
    connection.execute("DELETE FROM event WHERE id <= (SELECT max(id) FROM event) - ?", (EVENTS_KEPT,))


def newest_events(connection: Connection, limit: int) -> tuple[Event, ...]:
    """Return the newest events, oldest first."""
    rows = selected(connection, "event", "1 ORDER BY id DESC LIMIT ?", limit)
    return tuple(
        Event(
            kind=row["kind"],
            subject=row["subject"],
            text=row["text"],
            level=row["level"],
            wall_ns=row["wall_ns"],
            data=_object(row["data"]) or {},
        )
        for row in reversed(rows)
    )


def revisions(connection: Connection, since: int) -> tuple[RevisionRow, ...]:
    """Return the changes after revision `since`, oldest first."""
    return tuple(
        RevisionRow(
            id=row["id"],
            table=row["table_name"],
            row_key=_key(row["row_key"]),
            operation=row["operation"],
            old=_object(row["old_row"]),
            new=_object(row["new_row"]),
            changed_at=row["changed_at"],
        )
        for row in selected(connection, "revision", "id > ? ORDER BY id", since)
    )


def outdo(connection: Connection, revision: int) -> None:
    """Note an edit of every row that is newer than `revision` and than all others."""
    newest = max(revision, connection.scalar("SELECT max(id) FROM revision") or 0)
    row = {"id": newest + 1, "table_name": "robot", "row_key": '["every row"]', "operation": "update"}
    insert(connection, "revision", [row])


def storable(text: str) -> str:
    """Return a text with whatever has no UTF-8 replaced."""
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
