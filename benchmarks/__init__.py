"""Programs that measure a robot, run by `python -m benchmarks NAME`; each is a module of this folder.

A benchmark has a docstring about its measurement, and three names. `SMOKE` are the options of a run of seconds that
only shows that it still works. `options(parser)` adds its own options, and `measure(given)` returns `Measured`.
"""

import sys
import time
import traceback
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from msgspec import Struct

from tests.support.figures import Result, Results

FOLDER = Path(__file__).parent


class Measured(Struct, kw_only=True):
    """The result of a benchmark: graded `results`, other `figures`, `text` for people, and further reasons to fail."""

    results: list[Result] = []
    load: str = "I"
    figures: dict[str, Any] = {}
    text: str = ""
    broken: list[str] = []
    repeated: list[str] = []
    disturbed: list[str] = []


def names() -> list[str]:
    """Return the names for `python -m benchmarks`."""
    return sorted(path.stem for path in FOLDER.glob("[a-z]*.py"))


def one_by_one(results: Results, runs: Iterable[tuple[str, str, Callable[[], None]]]) -> None:
    """Run scenarios, given by name and figure; one that cannot go on counts as a violation of its figure."""
    for name, figure, run in runs:
        since = time.monotonic()
        try:
            run()
        except Exception as err:  # noqa: BLE001 - what went wrong is a finding, and the others are still wanted
            traceback.print_exc()
            results.check(figure, [f"could not go on: {err}"])
        print(f"{name}: {time.monotonic() - since:.0f} s", file=sys.stderr, flush=True)


def listed(text: str) -> list[str]:
    """Return the items between commas, as an option's type."""
    return [word for word in text.split(",") if word]


if any(word.removeprefix("benchmarks.") in names() for word in sys.orig_argv[1:] if word.startswith("benchmarks.")):
    sys.exit("each benchmark runs by its name: python -m benchmarks NAME")
