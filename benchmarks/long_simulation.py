"""Holds the drive kernel against its model through long seeded histories: K2. Nothing sleeps, nothing asks for the time.

`python -m benchmarks.long_simulation --steps 10000000 --seed 1`; the same seed gives the same trace hash, anywhere.
`--seeds 100` runs seeds 1 to 100 in as many processes as there are cores. After a violation, `--replay SEED --until
STEP` shows what led to it. Exit code 1 on a violation.
"""

import argparse
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from msgspec import Struct

from benchmarks.motion import broken
from benchmarks.motion.world import World

PROGRESS_STEPS = 500_000


class Run(Struct, frozen=True, kw_only=True):
    """What became of one seed; `violation` says what must never have been, `led_to_it` the last events before it."""

    seed: int
    steps: int
    seconds: float
    trace: str
    counts: dict[str, int]
    violation: str = ""
    led_to_it: tuple[str, ...] = ()

    @property
    def steps_per_s(self) -> float:
        """How fast it was."""
        return self.steps / max(self.seconds, 1e-9)


def simulate(seed: int, *, steps: int, kernel: str = "", progress: bool = False) -> Run:
    """Run one seed to its end, or to the first violation; `kernel` names one that is broken on purpose."""
    world = World(seed, broken.named(kernel))
    began, violation = time.perf_counter(), ""
    try:
        for mark in (*range(PROGRESS_STEPS, steps, PROGRESS_STEPS), steps):
            world.run(mark)
            if progress:
                _tell(f"seed {seed}: {world.arena.steps} of {steps} steps, {time.perf_counter() - began:.0f} s")
    except Exception as err:  # noqa: BLE001 - also a kernel that fails is a violation
        violation = f"{type(err).__name__}: {err}"
    return Run(
        seed=seed,
        steps=world.arena.steps,
        seconds=time.perf_counter() - began,
        trace=world.arena.trace,
        counts=world.arena.counts,
        violation=violation,
        led_to_it=tuple(world.arena.recent()) if violation else (),
    )


def replay(seed: int, until: int, kernel: str = "") -> tuple[str, ...]:
    """Return the last events of a seed up to a step, and the violation if there is one."""
    run = simulate(seed, steps=until, kernel=kernel)
    if run.violation:
        return (*run.led_to_it, run.violation)
    world = World(seed, broken.named(kernel))
    world.run(until)
    return (*world.arena.recent(), f"the state then: {world.arena.state}")


def main() -> int:
    """Simulate, print, and say whether anything was violated."""
    arguments = _arguments()
    if arguments.replay is not None:
        print("\n".join(replay(arguments.replay, arguments.until or arguments.steps, arguments.kernel)))
        return 0
    bad = 0
    for run in _runs(arguments):
        print(
            f"seed {run.seed}: {run.steps} steps, {run.steps_per_s:.0f} a second, trace {run.trace}, "
            f"{run.violation or 'no violation'}",
            flush=True,
        )
        if run.violation:
            bad += 1
            print("\n".join(run.led_to_it))
            print(f"again: python -m benchmarks.long_simulation --replay {run.seed} --until {run.steps}")
    return 1 if bad else 0


def _runs(arguments: argparse.Namespace) -> Iterator[Run]:
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    one = partial(simulate, steps=arguments.steps, kernel=arguments.kernel)
    if len(seeds) == 1:
        yield one(arguments.seed, progress=True)
        return
    with ProcessPoolExecutor(arguments.jobs, multiprocessing.get_context("spawn")) as pool:
        for done, run in enumerate(pool.map(one, seeds), start=1):
            _tell(f"{done} of {len(seeds)} seeds")
            yield run


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=1_000_000, help="events for each seed (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="the first seed (default %(default)s)")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="this many seeds, in processes of their own")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once (default: the cores)")
    parser.add_argument("--replay", type=int, metavar="SEED", help="show the last events of a seed")
    parser.add_argument("--until", type=int, metavar="STEP", help="with --replay: up to here")
    names = [kernel.__name__ for kernel in broken.KERNELS]
    parser.add_argument("--kernel", default="", choices=["", *names], help="one that is broken on purpose")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
