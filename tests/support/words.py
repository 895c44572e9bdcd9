"""A robot's rows with all that can be said to it: the words of its kinds that are enabled stand among the verbs."""

from pathlib import Path

from msgspec.structs import replace

from lbr.capability import registry
from lbr.database.checks import check
from lbr.database.rows import RobotRows
from lbr.executive.planning.words import words
from tests.support import databases

NOWHERE = Path("/nowhere")


def with_words(rows: RobotRows) -> RobotRows:
    kinds = {row.name: registry.find(row.kind, NOWHERE) for row in rows.capabilities if row.enabled}
    return replace(rows, verbs=words(rows, kinds))


def as_shipped(robot: str) -> RobotRows:
    tables, _ = databases.tables()
    return with_words(check(tables, robot))
