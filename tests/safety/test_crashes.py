"""Processes that crash or hang by themselves stop moving, are replaced, and do not go on where they were."""

import pytest

from benchmarks.bench import bench
from benchmarks.figures import Results
from benchmarks.scenarios import crashes
from tests.safety.limits import holds

pytestmark = pytest.mark.timeout(30)
SIDES = (crashes.motor_driver_fails, crashes.driving_app_fails)


@pytest.mark.parametrize("side", SIDES, ids=lambda side: side.__name__)
@pytest.mark.parametrize("ways", [crashes.CRASHES[:3], crashes.CRASHES[3:]], ids=",".join)
def test_a_crash_stops_the_motion_it_carries(side, ways):
    def scenario(results: Results) -> None:
        with bench(results, *crashes.VICTIMS, edits=crashes.EDITS) as under_test:
            for how in ways:
                side(under_test, how, "S13")

    results = holds(scenario)
    assert results.of("S13").n == len(ways)
    assert results.of("S13 gone").n == len(ways)


@pytest.mark.parametrize("how", crashes.HANGS)
def test_a_hang_stops_the_motion_and_is_replaced(how):
    def scenario(results: Results) -> None:
        with bench(results, *crashes.VICTIMS, edits=crashes.EDITS) as under_test:
            crashes.motor_driver_fails(under_test, how, "P5")
            crashes.driving_app_fails(under_test, how, "P5")

    assert holds(scenario).of("P5 ready").n == 2
