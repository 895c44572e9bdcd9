"""The ways of a package's robot into a database: when that is created, at the robot's first run, or by a command."""

from collections.abc import Iterator
from pathlib import Path

from lbr import home, plugins
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
    """Yield the faults that a start would find in rows, on any machine; a missing installation is not a fault."""
    site = RunIdentity(home=str(home.home()), endpoints=(), secret=bytes(32))
    _, problems = planner.make(rows, Profile(robot=rows.robot.name, only=()), site)
    yield from map(str, problems)


def create(path: Path, sql: Path | None = None) -> tuple[str, ...]:
    """Create a database with all installed robots; return why some are left out. Tests judge lbr's own."""
    own = {point.name for point in plugins.own("robots")}
    return store.create(path, sql, lambda rows: () if rows.robot.name in own else judge(rows))


def add(database: Database, robot: str) -> dict[str, int]:
    """Add the rows of a robot that are missing in the database; return their number by table."""
    return shipped.add(database, robot, judge)


def fault(installed: Found) -> str:
    """Return why a start would refuse a package's robot: its declaration, rows or launch profiles; empty if it is
    fine."""
    if installed.robot is None or installed.robot.rows is None:
        return installed.fault
    problems: tuple[str, ...] = ()
    try:
        packaged.rows_of(installed, judge)
    except RowError as err:
        problems = err.problems
    return "; ".join((*problems, *profile.faults(installed)))


def join(database: Database, robot: str) -> str:
    """Add a package's robot to a database that lacks it; return a report for people, empty if nothing was added."""
    if robot in database.robots() or (found := registry.find(robot)) is None:
        return ""
    add(database, robot)
    return f"the rows of robot '{robot}' (package '{found.package}') are in {database.path} now"
