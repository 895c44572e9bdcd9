"""Processes that crash or hang by themselves stop moving, are replaced, and do not go on where they were.

One way of each nature; `python -m benchmarks.safety --gate` goes through all of them.
"""

import pytest

from benchmarks.bench import bench
from benchmarks.figures import Results
from benchmarks.scenarios import crashes
from tests.safety.limits import holds

pytestmark = pytest.mark.timeout(30)
SIDES = [
    (crashes.motor_driver_fails, ("exception", "callback", "exit 0", "segfault")),
    (crashes.driving_app_fails, ("thread", "memory")),
]
HANGS = ("deadlock", "frozen")


@pytest.mark.parametrize(
    ("side", "ways"), SIDES, ids=lambda part: ",".join(part) if isinstance(part, tuple) else part.__name__
)
def test_a_crash_stops_the_motion_it_carries_and_is_told_everywhere_in_the_same_words(side, ways):
    def scenario(results: Results) -> None:
        with bench(results, *crashes.VICTIMS, edits=crashes.EDITS) as under_test:
            for how in ways:
                side(under_test, how, "S13")

    results = holds(scenario)
    assert results.of("S13").n == len(ways)
    assert results.of("S13 gone").n == len(ways)


@pytest.mark.parametrize("how", HANGS)
def test_a_hang_stops_the_motion_and_is_replaced(how):
    def scenario(results: Results) -> None:
        with bench(results, *crashes.VICTIMS, edits=crashes.EDITS) as under_test:
            crashes.motor_driver_fails(under_test, how, "P5")
            crashes.driving_app_fails(under_test, how, "P5")

    assert holds(scenario).of("P5 ready").n == 2
