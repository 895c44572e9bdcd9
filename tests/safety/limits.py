"""What a scenario must show on any machine: it stops, nothing resumes, programs end and start.

How fast, `python -m benchmarks safety` measures; here a stop has the bound of one that is lost.
"""

from collections.abc import Callable

from tests.scenarios.promises import PROMISES
from tests.support.figures import Promise, Result, Results
from tests.support.waiting import HANG_S, STOPS_S

PROGRAMS = (
    *(
        "S6 gone",
        "S13 gone",
        "S13 ready",
        "P1 motors",
        "P1 drive",
        "P3 ready",
        "P5 gone",
        "P5 ready",
        "P6",
        "P7",
        "P8 edit",
    ),
    *("F7 second run", "S18 interval", "P4 gone", "P4 gone, one frozen"),
)
"""Times that programs need to start or to end."""


def holds(scenario: Callable[[Results], None], promises: dict[str, Promise] = PROMISES) -> Results:
    """Run a scenario once, and fail on what must never be."""
    results = Results(promises)
    scenario(results)
    assert not results.violations(), results.violations()
    assert results.by_figure, "the scenario measured nothing"
    assert not results.disturbed, results.disturbed
    assert not lost(results)
    return results


def lost(results: Results) -> list[str]:
    """Return what took longer than anything that comes at all."""
    found = []
    for result in results.by_figure.values():
        worst, limit = max(result.samples, default=0.0), _limit(result)
        if limit is not None and not worst <= limit:
            found.append(f"{result.figure}: {worst:.0f} {result.promise.unit}, at most {limit:g}")
    return found


def _limit(result: Result) -> float | None:
    if result.promise.unit != "ms":
        return result.promise.hard
    return (HANG_S if result.figure in PROGRAMS else STOPS_S) * 1000.0
