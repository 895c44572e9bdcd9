"""The earlier versions of a motion, from the revisions of every row in the database. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from itertools import islice
from typing import TypeVar

import msgspec

from lbr.database.rows import RevisionRow
from lbr.messages.joints import Motion, MotionRow, MotionStep, motions_of
from lbr.messages.motion_work import MotionVersion
from lbr.messages.unreadable import UNREADABLE

R = TypeVar("R", MotionRow, MotionStep)
MOST = 50
TOGETHER_S = 1.0
"""The time within which one edit writes its rows; a person who saves again takes longer."""
TABLES = frozenset((MotionRow.TABLE, MotionStep.TABLE))
Values = dict[tuple[str, ...], dict[str, object]]
"""Rows of a motion by table and key."""


def versions(now: Motion | None, revisions: Iterable[RevisionRow], robot: str, name: str) -> tuple[MotionVersion, ...]:
    """Return the versions of a motion, newest first, with the one of `now`; those without key frames are left out.

    A change that only undoes the version before is not a version of its own.
    """
    known: list[MotionVersion] = []
    for version in islice(_backwards(now, revisions, robot, name), 4 * MOST):
        if version.motion.frames and (not known or known[-1].motion != version.motion):
            known.append(version)
    return tuple(known[:MOST])


def _backwards(now: Motion | None, revisions: Iterable[RevisionRow], robot: str, name: str) -> Iterator[MotionVersion]:
    mine = [revision for revision in revisions if revision.table in TABLES and revision.row_key[:2] == (robot, name)]
    values = {(row.TABLE, *map(str, row.key)): msgspec.to_builtins(row) for row in (now.rows if now else ())}
    while mine:
        edit = _last_edit(mine)
        if (motion := _motion(values, name)) is not None:
            yield MotionVersion(revision=edit[-1].id, since=edit[-1].changed_at, motion=motion)
        for revision in reversed(edit):
            _undo(values, revision)
        del mine[-len(edit) :]
    if (motion := _motion(values, name)) is not None:
        yield MotionVersion(revision=0, since="", motion=motion)


def _last_edit(revisions: list[RevisionRow]) -> list[RevisionRow]:
    """Return the newest changes that were written together, oldest first."""
    first = len(revisions) - 1
    while first > 0 and _apart_s(revisions[first - 1], revisions[first]) <= TOGETHER_S:
        first -= 1
    return revisions[first:]


def _apart_s(revision: RevisionRow, next_: RevisionRow) -> float:
    """Return the time between two changes; NaN if it is unknown, so that they count as apart."""
    try:
        return abs(
            (datetime.fromisoformat(next_.changed_at) - datetime.fromisoformat(revision.changed_at)).total_seconds()
        )
    except (ValueError, TypeError):
        return float("nan")


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
