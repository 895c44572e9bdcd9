"""Rows of a robot as it ships or as SQL has edited them, and what a start would make of rows."""

import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

from lbr.database.rows import RobotRows
from lbr.database.store import Database
from lbr.executive.planning import planner
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from tests.support import databases

SITE = RunIdentity(home="/nowhere", endpoints=("unixsock-stream//nowhere",), secret=b"s" * 32)


def shipped(robot: str, *edits: str) -> RobotRows:
    """Return a robot's rows of a new database, after some statements of SQL."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        path = databases.fresh(Path(place) / "robot.db")
        with closing(sqlite3.connect(path)) as client:
            client.executescript("".join(f"{edit};" for edit in edits))
        with Database.open(path) as database:
            return database.load(robot)


def planned(rows: RobotRows, profile: Profile | None = None, site: RunIdentity = SITE) -> Plan:
    """Return the plan of good rows, of a simulation unless a profile says otherwise."""
    plan, found = planner.make(rows, profile or Profile(robot=rows.robot.name, simulate=True), site)
    assert not found
    assert plan is not None
    return plan


def problems(rows: RobotRows, profile: Profile | None = None) -> list[str]:
    """Return what a start finds wrong with bad rows, in words."""
    plan, found = planner.make(rows, profile or Profile(robot=rows.robot.name, simulate=True), SITE)
    assert plan is None
    return [str(problem) for problem in found]
