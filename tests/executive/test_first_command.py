"""Ready is a promise: the first motion that a person asks for is obeyed; where it would not be, the ready line says why."""

from pathlib import Path

import pytest

from tests.scenarios.first_command import FIRST, ask_at_ready
from tests.support.robot import prepare, running
from tests.support.waiting import until


@pytest.mark.timeout(60)
@pytest.mark.parametrize("name", FIRST)
def test_a_robot_that_says_it_is_ready_obeys_the_first_command(name: str) -> None:
    why, _ = ask_at_ready(name, FIRST[name][0])
    assert not why


@pytest.mark.timeout(60)
def test_a_robot_that_starts_latched_is_ready_and_its_line_says_by_what_it_is_held(tmp_path: Path) -> None:
    home = prepare(tmp_path / "h")
    with running(home) as robot:
        robot.line("estop")
    with running(home) as robot:
        assert robot.ready["ready"]
        assert list(robot.ready["degraded"]) == ["drive"]
        assert robot.capability("drive")["code"] == "estop"
        assert robot.line("reset")["code"] == 0
        until(lambda: robot.capability("drive")["phase"] == "ready")
        assert robot.line("/r/0.2/0")["code"] == 0
