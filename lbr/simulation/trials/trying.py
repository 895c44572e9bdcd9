"""Many trials of a table, several at a time, each in a process without a robot."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

import msgspec

from lbr.simulation.trials.faults import EVERY, NONE
from lbr.simulation.trials.humanoid import HumanoidTrial
from lbr.simulation.trials.places import starts
from lbr.simulation.trials.trial import Outcome, Setup, TableTrial, Trial

_setup: list[Setup] = []


def tried(setup: Setup, trials: Sequence[tuple[int, str]], *, seed: int, jobs: int = 0) -> Iterator[Outcome]:
    """Yield the outcome of each trial as it ends, given its number and its fault (empty: none)."""
    jobs = min(jobs or os.cpu_count() or 1, len(trials))
    if jobs <= 1:
        _begin(msgspec.json.encode(setup))
        yield from (_run(number, fault, seed) for number, fault in trials)
        return
    pool = ProcessPoolExecutor(
        jobs, mp_context=get_context("spawn"), initializer=_begin, initargs=(msgspec.json.encode(setup),)
    )
    try:
        waiting = [pool.submit(_run, number, fault, seed) for number, fault in trials]
        for done in as_completed(waiting):
            yield done.result()
    finally:
        pool.shutdown(cancel_futures=True)


def made(setup: Setup, number: int, fault: str, seed: int) -> TableTrial:
    """Return a trial: number 0 begins at the world's start, the others anywhere."""
    faults = EVERY[fault] if fault else NONE
    if setup.humanoid is not None:
        return HumanoidTrial(setup, number, seed=seed, fault=fault, faults=faults)
    start = setup.world.start if number == 0 else starts(setup.world, 2, seed * 1_000_003 + number)[1]
    return Trial(setup, number, start, seed=seed, fault=fault, faults=faults)


def _begin(setup: bytes) -> None:
    _setup[:] = [msgspec.json.decode(setup, type=Setup)]


def _run(number: int, fault: str, seed: int) -> Outcome:
    return made(_setup[0], number, fault, seed).run()
