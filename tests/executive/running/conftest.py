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
    until(lambda: as_ever(base), what="the robot is as it was before the module")
    for file in (base.home / "capabilities").iterdir():
        file.unlink()


def as_ever(robot: Robot) -> bool:
    status = robot.status()
    ready = not status["problems"] and all(one["phase"] == "ready" for one in status["capabilities"])
    return ready and status["revision"] == databases.newest(robot.home)
