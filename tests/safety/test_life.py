"""Starting and stopping whole robots, whatever is plugged in, and editing their rows while they run.

Ways of each nature; `python -m benchmarks safety --gate` goes through all of them.
"""

import pytest

from tests.safety.limits import holds
from tests.scenarios import crashes, edits, shutdown, starts
from tests.support.bench import bench
from tests.support.figures import Results


@pytest.mark.parametrize("how", ["Shutdown", "end of input"])
def test_a_driving_robot_shuts_down_in_order(how):
    results = holds(lambda results: shutdown.shut_down(results, how))
    assert results.of("P4").n == 1
    assert results.of("P4 stop").n == 1


def test_a_frozen_process_does_not_hold_up_the_shutdown():
    results = holds(lambda results: shutdown.shut_down(results, "SIGTERM", freeze="ranges"))
    assert results.of("P4 gone, one frozen").n == 1


def test_until_ready_a_controller_hears_nothing_that_could_move_it():
    assert holds(starts.first_bytes).of("P6 bytes").n == 1


@pytest.mark.parametrize("trouble", ["missing", "wrong"])
def test_a_robot_without_its_controller_says_so_and_refuses_to_drive(trouble):
    assert holds(lambda results: starts.without_device(results, trouble)).of("P7").n == 1


def test_many_edits_restart_nothing_they_do_not_concern():
    def scenario(results: Results) -> None:
        with bench(results, *crashes.VICTIMS, edits=crashes.EDITS) as under_test:
            edits.edit_for(under_test, 2.5)
            edits.invalid_keeps_the_old(under_test)

    assert holds(scenario).of("P8").n == 2
