"""Edits of single rows that come from outside: what they make of the tables, and why not; pure but for `write`."""

import json
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import msgspec
from sqlalchemy import Connection, Table, delete
from sqlalchemy.dialects.sqlite import insert

from lbr.database.models import BUTTON, MOTION, MOTION_STEP, MOTOR
from lbr.database.rows import RevisionRow
from lbr.database.tables import KEYS, RawRow, RawTables
from lbr.errors import InputError
from lbr.messages.codes import Code
from lbr.messages.faces import Button, EditCommand, Motor
from lbr.messages.joints import Motion

Key = tuple[str, ...]


class _Kind(NamedTuple):
    """How rows of one table are named and written."""

    table: str
    label: Callable[[Any], str]
    raw: Callable[[Any], dict[str, Any]]


def describe(edit: EditCommand) -> str:
    """Return which rows an edit is about, for people."""
    return ", ".join(kind.label(row) for kind, rows in _parts(edit) for row in rows)


def applied(tables: RawTables, robot: str, edit: EditCommand, since: Iterable[RevisionRow] = ()) -> RawTables:
    """Return the tables as they are after an edit; InputError if it may not be made, in one sentence.

    `since` are the changes after the revision that the edit goes by.
    """
    changed = set(_changed(since, robot))
    after: dict[str, Sequence[RawRow]] = dict(tables)
    if not any(rows for _, rows in _parts(edit)):
        raise InputError("this edit has no rows")
    for kind, rows in _parts(edit):
        there = {_key_of(kind.table, row)[1:]: row for row in tables.get(kind.table, ()) if row.get("robot") == robot}
        seen: set[Key] = set()
        for row in rows:
            new = {"robot": robot, **kind.raw(row)}
            key = _key_of(kind.table, new)[1:]
            if key in seen:
                raise InputError(f"{kind.label(row)} is there twice")
            seen.add(key)
            _refuse(row, kind.label(row), there.get(key), edit, newer=(kind.table, *key) in changed)
            after[kind.table] = [*_others(after, kind.table, robot, key), new]
    for motion in edit.motions:
        kept = [
            row for row in after.get("motion_step", ()) if (row.get("robot"), row.get("motion")) != (robot, motion.name)
        ]
        after["motion_step"] = [*kept, *_steps(robot, motion)]
    return after


def write(connection: Connection, robot: str, edit: EditCommand) -> None:
    """Write an edit's rows over those that are there; rows that stay as they are make no revision."""
    for table, (kind, rows) in zip((MOTOR, MOTION, BUTTON), _parts(edit), strict=True):
        _upsert(connection, table, [{"robot": robot, **kind.raw(row)} for row in rows])
    for motion in edit.motions:
        of_motion = MOTION_STEP.c.robot == robot, MOTION_STEP.c.motion == motion.name
        connection.execute(delete(MOTION_STEP).where(*of_motion, MOTION_STEP.c.step > len(motion.frames)))
        _upsert(connection, MOTION_STEP, list(_steps(robot, motion)))


def _refuse(row: Any, label: str, there: RawRow | None, edit: EditCommand, *, newer: bool) -> None:
    """Raise InputError if a row may not be written."""
    stored = isinstance(row, Motion) and (row.slot, row.slot_s, row.limp) != (None, None, False)
    whys: dict[tuple[str, Code], bool] = {
        (f"{label} is there already", "exists"): edit.create and there is not None,
        (f"there is no {label}", "unknown_name"): not edit.create and there is None,
        (f"{label} is built in, and stays as it is", "read_only"): row.builtin
        or (there is not None and there.get("builtin") != 0),
        (
            f"{label} would be in a slot: what the controller keeps is entered at the robot itself",
            "not_possible",
        ): stored,
        (f"{label} is in a slot, kept by the controller: its row is edited at the robot itself", "read_only"): (
            there is not None and there.get("slot") is not None
        ),
        (f"{label} has no key frames", "bad_value"): isinstance(row, Motion) and not row.frames,
        (f"{label} has changed since revision {edit.revision}: look at it again", "changed"): newer,
    }
    if why := next((why for why, holds in whys.items() if holds), None):
        raise InputError(*why)


def _parts(edit: EditCommand) -> tuple[tuple[_Kind, Sequence[Any]], ...]:
    return (_MOTORS, edit.motors), (_MOTIONS, edit.motions), (_BUTTONS, edit.buttons)


def _changed(since: Iterable[RevisionRow], robot: str) -> Iterable[Key]:
    """Return table and key, without the robot, of rows that were changed; key frames count as their motion."""
    for row in since:
        if row.row_key[:1] == (robot,):
            table, key = (row.table, row.row_key[1:]) if row.table != "motion_step" else ("motion", row.row_key[1:2])
            yield (table, *key)


def _others(tables: RawTables, table: str, robot: str, key: Key) -> list[RawRow]:
    return [row for row in tables.get(table, ()) if _key_of(table, row) != (robot, *key)]


def _key_of(table: str, row: RawRow) -> Key:
    return tuple(str(row.get(column)) for column in KEYS[table])


def _motor(row: Motor) -> dict[str, Any]:
    return msgspec.structs.asdict(row) | {"inverted": int(row.inverted), "builtin": int(row.builtin)}


def _motion(row: Motion) -> dict[str, Any]:
    found = msgspec.structs.asdict(row) | {"limp": int(row.limp), "builtin": int(row.builtin)}
    del found["frames"]
    return found


def _button(row: Button) -> dict[str, Any]:
    return msgspec.structs.asdict(row) | {"motion": row.motion or "", "builtin": int(row.builtin)}


def _steps(robot: str, motion: Motion) -> Iterable[dict[str, Any]]:
    for step, frame in enumerate(motion.frames, 1):
        positions = json.dumps(frame.positions)
        yield {
            "robot": robot,
            "motion": motion.name,
            "step": step,
            "duration_s": frame.duration_s,
            "positions": positions,
        }


def _upsert(connection: Connection, table: Table, rows: list[dict[str, Any]]) -> None:
    if not rows:
        return
    statement = insert(table)
    others = {column.name: statement.excluded[column.name] for column in table.columns if not column.primary_key}
    keys = [column.name for column in table.primary_key]
    connection.execute(statement.on_conflict_do_update(index_elements=keys, set_=others), rows)


_MOTORS = _Kind("motor", lambda row: f"motor {row.id} of layer '{row.layer}'", _motor)
_MOTIONS = _Kind("motion", lambda row: f"motion '{row.name}'", _motion)
_BUTTONS = _Kind("button", lambda row: f"button {row.id}", _button)
