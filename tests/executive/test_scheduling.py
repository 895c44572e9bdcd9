"""What moves the robot outranks what uses it, as far as this user may say so."""

import os
from pathlib import Path

import pytest

from lbr.executive.processes import scheduling
from tests.support import programs
from tests.support.robot import running
from tests.support.waiting import until


@pytest.fixture
def sleeper():
    process = programs.start(["/bin/sleep", "60"], start_new_session=True)
    yield process
    process.kill()
    process.wait()


def test_niceness_is_given_to_the_process_and_to_its_session(sleeper):
    scheduling.rank(sleeper.pid, scheduling.BACKGROUND)
    assert os.getpriority(os.PRIO_PROCESS, sleeper.pid) == scheduling.BACKGROUND
    autogroup = Path(f"/proc/{sleeper.pid}/autogroup")
    if autogroup.exists() and autogroup.read_text():
        assert autogroup.read_text().split()[-1] == str(scheduling.BACKGROUND)


def test_what_is_gone_or_not_allowed_is_no_error():
    scheduling.rank(2**22 - 1, scheduling.MOTION)


def test_movers_and_drivers_outrank_programs(home):
    with running(home) as robot:
        nice = {unit["name"]: unit["nice"] for unit in robot.status()["capabilities"]}
        if os.geteuid() == 0:
            assert nice["motors"] == nice["drive"] == nice["ranges"] == nice["world"] == scheduling.MOTION
            assert os.getpriority(os.PRIO_PROCESS, robot.popen.pid) == scheduling.MOTION
        threads = Path(f"/proc/{robot.capability('motors')['pid']}/task")
        assert {os.getpriority(os.PRIO_PROCESS, int(task.name)) for task in threads.iterdir()} == {nice["motors"]}
        settings = '{"argv": ["/bin/sleep", "60"]}'
        robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'nap', 'exec', ?)", settings)
        until(lambda: robot.capability("nap").get("nice") == scheduling.BACKGROUND)
