"""The emergency stop of each healthy robot is acknowledged, at rest and in the middle of a motion: an alarm would be none."""

import threading
from contextlib import suppress
from pathlib import Path

import pytest

from lbr.testing.robot import NoAnswerError
from tests.support.robot import Robot, prepare, running, until

MOTIONS = {
    "lbr": ("stop", "/r/0.3/0"),
    "bioloid": ("/torque/on", "/play/wave"),
    "uxa90": ("stop", "/play/walk_forward_6step"),
}


@pytest.mark.timeout(60)
@pytest.mark.parametrize("name", MOTIONS)
def test_the_emergency_stop_is_acknowledged_at_rest_and_in_mid_motion(name: str, tmp_path: Path) -> None:
    first, motion = MOTIONS[name]
    with running(prepare(tmp_path / "h", "behaviour"), profile=f"{name}-sim", limit_s=20.0) as robot:
        acknowledged(robot)
        until(lambda: robot.line(first)["code"] == 0, what=first)
        until(lambda: robot.line(motion)["hold"], what=motion)
        keeping = threading.Thread(target=keep, args=(robot, motion))
        keeping.start()
        until(lambda: moves(robot), what="it moves")
        acknowledged(robot)
        keeping.join()
        kinds = [event["kind"] for event in robot.events() if event["kind"].startswith("estop")]
        assert kinds == ["estop", "estop_acknowledged", "estop_reset"] * 2


def acknowledged(robot: Robot) -> None:
    answer = robot.line("estop")
    assert answer["code"] == 0, answer["text"]
    state = robot.ask("@estop")
    assert (state["waiting"], state["overdue"], state["text"]) == ([], [], answer["text"])
    assert {"motors", "servos"} & set(state["acknowledged"])
    until(lambda: robot.line("reset")["code"] == 0, what="it is released")


def moves(robot: Robot) -> bool:
    states = [robot.ask(f"{name}/state") for name in ("drive", "joints")]
    return any(state and state["moving"] for state in states)


def keep(robot: Robot, motion: str) -> None:
    with suppress(NoAnswerError, AssertionError):
        robot.move(motion)
