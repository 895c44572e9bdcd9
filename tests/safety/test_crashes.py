"""Processes that crash or hang by themselves stop moving, are replaced, and do not go on where they were.

One way of each nature; `python -m benchmarks safety --gate` goes through all of them.
"""

from tests.safety.limits import holds
from tests.scenarios import crashes
from tests.support.bench import bench
from tests.support.figures import Results

DRIVER = {"S13": ("exception", "segfault"), "P5": ("frozen",)}
APP = {"S13": ("thread", "exit 0"), "P5": ("deadlock",)}


def test_a_crash_or_hang_stops_the_motion_it_carries_and_is_told_everywhere_in_the_same_words():
    def scenario(results: Results) -> None:
        with bench(results, *crashes.VICTIMS, edits=crashes.EDITS) as under_test:
            for fails, ways in ((crashes.motor_driver_fails, DRIVER), (crashes.driving_app_fails, APP)):
                for figure, how in ((figure, how) for figure, found in ways.items() for how in found):
                    fails(under_test, how, figure)

    results = holds(scenario)
    assert results.of("S13").n == results.of("S13 gone").n == 4
    assert results.of("P5 ready").n == 2
