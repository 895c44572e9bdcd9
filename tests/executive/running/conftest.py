"""One robot, of the base alone, for all modules here that need no other; each has it as the last one began with it."""

from collections.abc import Iterator

import pytest

from tests.support import databases
from tests.support.commands import here
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until


@pytest.fixture(scope="package")
def base(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    home = prepare(tmp_path_factory.mktemp("h"))
    (home / "capabilities").mkdir(mode=0o700)
    with running(home) as started:
        yield started


@pytest.fixture(scope="module")
def robot(base: Robot) -> Iterator[Robot]:
    """The base, running; what a module has left of rows and files is taken back."""
    before = databases.newest(base.home)
    yield base
    base.line("reset")
    base.line("stop")
    done = here(base.home, "db", "rollback", str(before))
    assert done.returncode == 0, done.stderr
    try:
        until(lambda: not leftovers(base))
    except AssertionError as err:
        raise AssertionError(f"the module left the robot with {leftovers(base)}") from err
    for file in (base.home / "capabilities").iterdir():
        file.unlink()


def leftovers(robot: Robot) -> list[str]:
    """Return what is not yet as it was: problems, capabilities that are not ready, rows that are not read."""
    status = robot.status()
    late = [
        f"{one['name']}: {one['phase']}, {one['reason']}" for one in status["capabilities"] if one["phase"] != "ready"
    ]
    rows = [] if status["revision"] == databases.newest(robot.home) else ["the newest rows"]
    return [*map(str, status["problems"]), *late, *rows]
