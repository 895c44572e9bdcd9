"""Holds the drive kernel against its model through long seeded histories: K2. Nothing sleeps, nothing asks for the time.

The same seed gives the same trace hash, anywhere.
"""

import time
from collections.abc import Callable

from msgspec import Struct

from tests.models.motion import broken
from tests.models.motion.world import World

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


def _quiet(_text: str) -> None:
    pass


def simulate(seed: int, *, steps: int, kernel: str = "", tell: Callable[[str], None] = _quiet) -> Run:
    """Run one seed to its end, or to the first violation; `kernel` names one that is broken on purpose, `tell` hears how far it is."""
    world = World(seed, broken.named(kernel))
    began, violation = time.perf_counter(), ""
    try:
        for mark in (*range(PROGRESS_STEPS, steps, PROGRESS_STEPS), steps):
            world.run(mark)
            tell(f"seed {seed}: {world.arena.steps} of {steps} steps, {time.perf_counter() - began:.0f} s")
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
