"""Opening a database for the commands that read rows."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lbr import home
from lbr.commands.options import DEFAULT_PROFILE
from lbr.database import store
from lbr.database.reading import Problem
from lbr.database.rows import RobotRows
from lbr.errors import InputError
from lbr.executive.planning import planner, profile
from lbr.executive.planning.hints import hints
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.home import Running

if TYPE_CHECKING:
    from lbr.database.store import Database
    from lbr.executive.planning.plan import Plan


def opened(path: Path | None = None) -> "Database":
    """Open an existing database, by default the home's, for changes in this command's name; otherwise InputError names
    `lbr db init`."""
    path = path or home.default_database()
    if not path.exists():
        raise InputError(f"there is no database {path}; 'lbr db init' makes one", "unknown_name")
    context = click.get_current_context(silent=True)
    said = context.command_path.split()[1:] if context is not None else ()
    return store.Database.open(path, program=" ".join(["lbr", *said]))


def robot_in(database: "Database", named: str | None = None) -> str:
    """Return the named robot, the only one in a database, or of several the default one of `lbr run`."""
    if named is not None:
        return database.robots(named)[0]
    names = database.robots()
    usual = profile.load(DEFAULT_PROFILE).robot
    if len(names) != 1 and usual not in names:
        raise InputError(f"{database.path} has {len(names)} robots ({', '.join(names)}); say which with --robot NAME")
    return usual if usual in names else names[0]


def robot_meant(database: "Database", named: str | None = None) -> str:
    """Return the named robot, the only one that runs from a database, or else as `robot_in` does."""
    running = [*running_here(database.path)]
    return robot_in(database, running[0] if named is None and len(running) == 1 else named)


def running_here(path: Path) -> dict[str, Running]:
    """Return the robots that run from a database, by name."""
    return {one.robot: one for one in home.running() if _is_same(Path(one.database), path)}


def _is_same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return False


def with_words(rows: RobotRows) -> RobotRows:
    """Return a robot's rows with the verbs of its kinds; unchanged if they make no robot."""
    made, _ = planned(rows)
    return made.rows if made is not None else rows


def problems_of(rows: RobotRows) -> tuple[Problem, ...]:
    """Return the problems that a start would find in a robot's rows."""
    return planned(rows)[1]


def judged(rows: RobotRows) -> tuple[list[str], list[str]]:
    """Return the problems that a start would find in a robot's rows, and the oddities of good rows."""
    made, problems = planned(rows)
    return [str(problem) for problem in problems], list(hints(made, home.home())) if made is not None else []


def wiring_of(rows: RobotRows, kind: str) -> frozenset[str] | None:
    """Return the wired inputs and requests of a kind on a robot; None if no capability of that kind would run."""
    made, _ = planned(rows)
    units = [one for one in made.units.values() if one.kind == kind] if made is not None else []
    return frozenset((*units[0].config.wiring, *units[0].config.requests)) if units else None


def planned(
    rows: RobotRows, profile: Profile | None = None, before: RobotRows | None = None
) -> "tuple[Plan | None, tuple[Problem, ...]]":
    """Return the plan of a robot's rows, None if they make no plan, and the problems of these rows.

    Without a profile, the plan is of a simulation. For a running robot, `before` are its present rows.
    """
    site = RunIdentity(home=str(home.home()), endpoints=(), secret=bytes(32))
    return planner.make(rows, profile or Profile(robot=rows.robot.name, simulate=True), site, before=before)
