"""Whatever process is killed while the robot drives, the motors stand and stay so."""

from collections.abc import Callable

import pytest

from tests.safety.limits import holds
from tests.scenarios import kills
from tests.support.bench import Bench
from tests.support.figures import Results


@pytest.mark.parametrize(("name", "figure"), [("motors", "S1"), ("drive", "S3")])
def test_a_killed_motor_driver_and_killed_drive_operations_leave_the_motors_standing(
    held: Callable[[Callable[[Bench], None]], Results], name: str, figure: str
):
    def scenario(under_test: Bench) -> None:
        under_test.forget_deaths(name)
        kills.kill_process(under_test, name, figure)

    results = held(lambda under_test: under_test.once_it_moves(scenario))
    assert (results.of(figure).n, results.of("S14").n >= 1) == (1, True)


def test_drive_operations_with_a_process_of_their_own_leave_the_motors_standing():
    results = holds(lambda results: kills.hurt_drive_apart(results, 2))
    assert (results.of("S3").n, results.of("S4").n) == (2, 1)


def test_a_killed_executive_leaves_the_motors_standing_and_no_process():
    results = holds(lambda results: kills.kill_executive(results, 1))
    assert (results.of("S6").n, results.of("S6 gone").n) == (1, 1)
