"""Each robot as it ships: it obeys the first motion that a person asks for, and acknowledges the emergency stop.

Ready is a promise; where the first motion would not be obeyed, the ready line says why.
"""

import threading
from collections.abc import Iterator
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from lbr.testing.robot import NoAnswerError
from tests.scenarios.first_command import FIRST, Ask, asked_at_ready
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

ASKED: dict[str, Ask] = {name: asks[-1 if name == "lbr" else 0] for name, asks in FIRST.items()}
"""A turn needs every sensor of the lbr; a UXA-90's motors are those that a program asks for first."""
MOTIONS = {
    "lbr": ("stop", "/r/0.3/0"),
    "bioloid": ("/torque/on", "/play/wave"),
    "uxa90": ("stop", "/play/walk_forward_6step"),
}


@pytest.fixture(scope="module", params=MOTIONS)
def asked(request: pytest.FixtureRequest) -> Iterator[tuple[Robot, str]]:
    """A robot, and why it refused what it was asked at its ready line."""
    with asked_at_ready(request.param, ASKED[request.param]) as (robot, why, _):
        yield robot, why


@pytest.mark.timeout(60)
def test_a_robot_that_says_it_is_ready_obeys_the_first_command(asked: tuple[Robot, str]) -> None:
    assert not asked[1]


@pytest.mark.timeout(60)
def test_a_robot_that_starts_latched_is_ready_and_its_line_says_by_what_it_is_held(tmp_path: Path) -> None:
    home = prepare(tmp_path / "h")
    with running(home) as robot:
        robot.line("estop")
    with running(home) as robot:
        assert robot.ready["ready"]
        assert list(robot.ready["degraded"]) == ["drive"]
        assert robot.capability("drive")["code"] == "estop"
        until(lambda: robot.line("reset")["code"] == 0, what="it is released")
        until(lambda: robot.capability("drive")["phase"] == "ready")
        until(lambda: robot.line("/r/0.2/0")["code"] == 0, what="it drives")


@pytest.mark.timeout(60)
def test_the_emergency_stop_is_acknowledged_at_rest_and_in_mid_motion(asked: tuple[Robot, str]) -> None:
    robot, _ = asked
    first, motion = MOTIONS[robot.name]
    until(lambda: not moves(robot), what="it is at rest")
    acknowledged(robot)
    until(lambda: robot.line(first)["code"] == 0, what=first)
    until(lambda: robot.line(motion)["hold"], what=motion)
    over = threading.Event()
    keeping = threading.Thread(target=keep, args=(robot, motion, over))
    keeping.start()
    try:
        until(lambda: moves(robot), what="it moves")
    finally:
        over.set()
    acknowledged(robot)
    keeping.join()
    kinds = [event["kind"] for event in robot.events() if event["kind"].startswith("estop")]
    kinds = [kind for kind, _ in groupby(kind for kind in kinds if kind != "estop_overdue")]
    assert kinds == ["estop", "estop_acknowledged", "estop_reset"] * 2


def acknowledged(robot: Robot) -> None:
    """Press the emergency stop, and wait for all acknowledgements; the answer to the line waits half a second only."""
    answer = robot.line("estop")
    state = until(lambda: engaged_and_acknowledged(robot), what="the acknowledgements")
    assert answer["code"] == 1 or answer["text"] == state["text"]
    assert {"motors", "servos"} & set(state["acknowledged"])
    until(lambda: robot.line("reset")["code"] == 0, what="it is released")


def engaged_and_acknowledged(robot: Robot) -> dict[str, Any]:
    state = robot.ask("@estop")
    return state if state["engaged"] and not state["waiting"] else {}


def moves(robot: Robot) -> bool:
    states = [robot.ask(f"{name}/state") for name in ("drive", "joints")]
    return any(state and state["moving"] for state in states)


def keep(robot: Robot, motion: str, over: threading.Event) -> None:
    """Have it move, and again where a busy machine has ended the motion."""
    while not over.is_set():
        with suppress(NoAnswerError, AssertionError):
            robot.move(motion)
