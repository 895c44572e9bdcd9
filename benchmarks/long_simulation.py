"""Compares the drive kernel with its model over long seeded histories: K2. It neither sleeps nor reads the time.

`python -m benchmarks long_simulation --steps 10000000 --seed 1`; the same seed gives the same trace hash, anywhere.
`--seeds 100` runs seeds 1 to 100 in as many processes as there are cores. After a violation, `--replay SEED --until
STEP` shows its history. Exit code 1 on a violation.
"""

import argparse
import multiprocessing
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from benchmarks import Measured
from tests.models.long_simulation import Run, replay, simulate
from tests.models.motion import broken
from tests.support.figures import Promise, Results

SMOKE = "--steps 5000"
PROMISES = {"K2": Promise(what="seeds of long histories in which the kernel does what the model says, and no more")}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount, or a history to replay."""
    parser.add_argument("--steps", type=int, default=1_000_000, help="events for each seed (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="the first seed (default %(default)s)")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="this many seeds, in processes of their own")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once (default: the cores)")
    parser.add_argument("--replay", type=int, metavar="SEED", help="show the last events of a seed")
    parser.add_argument("--until", type=int, metavar="STEP", help="with --replay: up to here")
    names = [kernel.__name__ for kernel in broken.KERNELS]
    parser.add_argument("--kernel", default="", choices=["", *names], help="one that is broken on purpose")


def measure(given: argparse.Namespace) -> Measured:
    """Run the seeds."""
    if given.replay is not None:
        return Measured(text="\n".join(replay(given.replay, given.until or given.steps, given.kernel)))
    results, text = Results(PROMISES), []
    for run in _runs(given):
        text.append(f"seed {run.seed}: {run.steps} steps, {run.steps_per_s:.0f} a second, trace {run.trace}")
        results.check("K2", [f"seed {run.seed}: {run.violation}"] if run.violation else [])
        if run.violation:
            again = f"python -m benchmarks long_simulation --replay {run.seed} --until {run.steps}"
            text += [run.violation, *run.led_to_it, f"again: {again}"]
    return Measured(results=results.ordered(), load="nothing sleeps, nothing asks for the time", text="\n".join(text))


def _runs(arguments: argparse.Namespace) -> Iterator[Run]:
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    one = partial(simulate, steps=arguments.steps, kernel=arguments.kernel)
    if len(seeds) == 1:
        yield one(arguments.seed, tell=_tell)
        return
    with ProcessPoolExecutor(arguments.jobs, multiprocessing.get_context("spawn")) as pool:
        for done, run in enumerate(pool.map(one, seeds), start=1):
            _tell(f"{done} of {len(seeds)} seeds")
            yield run


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
