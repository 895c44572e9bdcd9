"""E1: the emergency stop, from request to motor zero, and what a reset does not do."""

import time
from collections.abc import Callable
from typing import Any

from tests.support.bench import Bench
from tests.support.waiting import HANG_S

PERSISTENT_S = 0.3
PAUSE_S = 0.3


def by_console(under_test: Bench) -> None:
    """The word `estop` as a console line."""
    press(under_test, "E1 console", lambda: under_test.robot.line("estop"))


def by_put(under_test: Bench) -> None:
    """A plain put by any client."""
    robot = under_test.robot
    press(under_test, "E1 put", lambda: robot.bus.put(f"{robot.name}/@estop", '{"engaged": true, "reason": "bench"}'))


def press(under_test: Bench, figure: str, how: Callable[[], Any]) -> None:
    """Press while the robot drives, then reset it under a sender that insists."""
    mover = under_test.drive()
    at_ns = time.monotonic_ns()
    how()
    zero = under_test.stopped_after(figure, at_ns)
    under_test.until(lambda: _acknowledged(under_test), HANG_S, "the emergency stop acknowledged")
    under_test.release()
    under_test.pass_time(PERSISTENT_S)
    mover.cease()
    under_test.stays_at_rest(zero)
    under_test.pass_time(PAUSE_S)


def _acknowledged(under_test: Bench) -> bool:
    state = under_test.robot.ask("@estop")
    return bool(state and state["engaged"] and not state["waiting"])
