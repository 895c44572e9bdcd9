"""The earlier versions of a motion, from the changes of every row in the database. Pure."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import TypeVar

import msgspec

from lbr.database.past import HistoryEntry
from lbr.database.rows import RevisionRow
from lbr.messages.joints import Motion, MotionRow, MotionStep, motions_of
from lbr.messages.motion_work import MotionVersion
from lbr.messages.unreadable import UNREADABLE

R = TypeVar("R", MotionRow, MotionStep)
MOST = 50
TABLES = frozenset((MotionRow.TABLE, MotionStep.TABLE))
Values = dict[tuple[str, ...], dict[str, object]]
"""Rows of a motion by table and key."""


def versions(now: Motion | None, changes: Sequence[HistoryEntry], robot: str, name: str) -> tuple[MotionVersion, ...]:
    """Return the versions of a motion, newest first, with the one of `now`; those without key frames are left out.

    A change that only undoes the version before is not a version of its own.
    """
    known: list[MotionVersion] = []
    for version in islice(_backwards(now, changes, robot, name), 4 * MOST):
        if version.motion.frames and (not known or known[-1].motion != version.motion):
            known.append(version)
    return tuple(known[:MOST])


def _backwards(now: Motion | None, changes: Sequence[HistoryEntry], robot: str, name: str) -> Iterator[MotionVersion]:
    values = {(row.TABLE, *map(str, row.key)): msgspec.to_builtins(row) for row in (now.rows if now else ())}
    for change in reversed(changes):
        mine = [row for row in reversed(change.rows) if row.table in TABLES and row.row_key[:2] == (robot, name)]
        if mine and (motion := _motion(values, name)) is not None:
            yield MotionVersion(revision=mine[0].id, since=mine[0].changed_at, motion=motion)
        for revision in mine:
            _undo(values, revision)
    if (motion := _motion(values, name)) is not None:
        yield MotionVersion(revision=0, since="", motion=motion)


def _undo(values: Values, revision: RevisionRow) -> None:
    key = revision.row_key[1:]
    values.pop((revision.table, *key), None)
    if revision.before is not None:
        values[(revision.table, *key)] = revision.before


def _motion(values: Mapping[tuple[str, ...], dict[str, object]], name: str) -> Motion | None:
    """Return the motion of these rows; None if it is missing or incomplete."""
    try:
        rows = [_row(value, MotionRow) for (table, *_), value in values.items() if table == MotionRow.TABLE]
        steps = [_row(value, MotionStep) for (table, *_), value in values.items() if table == MotionStep.TABLE]
    except UNREADABLE:
        return None
    found = motions_of(rows, sorted(steps, key=lambda step: step.step))
    return next((one for one in found if one.name == name), None)


def _row(value: Mapping[str, object], kind: type[R]) -> R:
    told = {field: value[field] for field in kind.__struct_fields__ if value.get(field) is not None}
    if isinstance(positions := told.get("positions"), str):
        told["positions"] = msgspec.json.decode(positions)
    return msgspec.convert(told, kind, strict=False)
