"""The way of a package's robot into a database: at the database's making, at the robot's first run, or by command."""

from collections.abc import Iterator
from pathlib import Path

from lbr import home
from lbr.database import packaged, shipped, store
from lbr.database.rows import RobotRows
from lbr.database.store import Database
from lbr.errors import RowError
from lbr.executive.planning import planner, profile
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.robot import registry
from lbr.robot.registry import Found


def judge(rows: RobotRows) -> Iterator[str]:
    """Yield what a start would find wrong with rows, on any machine; what is not installed here is no fault of
    theirs."""
    site = RunIdentity(home=str(home.home()), endpoints=(), secret=bytes(32))
    _, problems = planner.make(rows, Profile(robot=rows.robot.name, only=()), site)
    yield from map(str, problems)


def create(path: Path, sql: Path | None = None) -> tuple[str, ...]:
    """Build a new database with all robots that there are; return why some are left out."""
    return store.create(path, sql, judge)


def add(database: Database, robot: str) -> dict[str, int]:
    """Add what a robot brings and is not there yet; return how many rows of each table."""
    return shipped.add(database, robot, judge)


def fault(installed: Found) -> str:
    """Return why a start would refuse the robot of a package, by what it declares, its rows or its launch profiles;
    empty if it would not."""
    if installed.robot is None or installed.robot.rows is None:
        return installed.fault
    problems: tuple[str, ...] = ()
    try:
        packaged.rows_of(installed, judge)
    except RowError as err:
        problems = err.problems
    return "; ".join((*problems, *profile.faults(installed)))


def join(database: Database, robot: str) -> str:
    """Let a robot of a package in that is not in a database yet; return what was done, for people, or nothing."""
    if robot in database.robots() or (found := registry.find(robot)) is None:
        return ""
    add(database, robot)
    return f"the rows of robot '{robot}' (package '{found.package}') are in {database.path} now"
