"""Whatever stands still instead of dying, or takes its guard along: the motors stand and stay so."""

import os
from collections.abc import Callable

import pytest

from tests.safety.limits import holds
from tests.scenarios import freezes
from tests.support.bench import Bench
from tests.support.figures import Results


@pytest.mark.parametrize("way", freezes.WAYS, ids=lambda way: way.__name__)
def test_the_motors_stand_and_nothing_moves_when_it_is_over(held: Callable[[Callable[[Bench], None]], Results], way):
    if way is freezes.links_broken and os.geteuid() != 0:
        pytest.skip("only root may shut another process's sockets down")
    assert held(lambda under_test: under_test.once_it_moves(way)).by_figure


def test_a_driver_that_its_guard_ended_says_so_everywhere_in_the_same_words():
    def scenario(results: Results) -> None:
        with freezes.bench(results) as under_test:
            freezes.motor_driver_frozen(under_test)
            said = under_test.unit("motors")["last_end"]
            assert said.startswith("hung: the motor driver")
            events = under_test.robot.events()
            assert any(event["kind"] == "hung" and event["text"].startswith(said) for event in events)

    holds(scenario)
