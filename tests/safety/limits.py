"""What a scenario may never show, on however busy or slow a machine."""

from collections.abc import Callable

import pytest

from tests.scenarios.promises import PROMISES
from tests.support.figures import Promise, Results
from tests.support.machine import Stopwatch, measure_again, notes

TRIES = 3
PROGRAMS = (
    *("S13 gone", "S13 ready", "P1 motors", "P1 drive", "P3 ready", "P5 gone", "P5 ready", "P6", "P7", "P8 edit"),
    *("F7 second run", "S18 interval", "P4 gone", "P4 gone, one frozen"),
)
"""Times that programs need to start or to end: judged by what the machine gave, because nobody is hurt by them."""


def over_their_limit(results: Results, stretch: float = 1.0) -> list[str]:
    """Return what took longer than it ever may; what programs need to start and to end is stretched."""
    found = []
    for result in results.by_figure.values():
        hard, worst = result.promise.hard, max(result.samples, default=0.0)
        if hard is not None and not worst <= hard * (stretch if result.figure in PROGRAMS else 1.0):
            found.append(f"{result.figure}: {worst:.0f} {result.promise.unit}, at most {hard:g}")
    return found


def holds(scenario: Callable[[Results], None], promises: dict[str, Promise] = PROMISES) -> Results:
    """Run a scenario and fail on what must never be.

    One that came too late, or in which nothing moved before the fault, is measured again if the machine was busy with
    something else; the limits of stops stay what they are, and each such time is told at the end of the run.
    """
    complaints: list[str] = []
    for _ in measure_again(complaints, times=TRIES):
        results, watch = Results(promises), Stopwatch()
        scenario(results)
        assert not results.violations(), results.violations()
        assert results.by_figure, "the scenario measured nothing"
        notes.extend(results.repeated)
        complaints[:] = [*over_their_limit(results, watch.stretch), *results.disturbed]
        if not complaints:
            return results
    pytest.fail("; ".join(complaints))
