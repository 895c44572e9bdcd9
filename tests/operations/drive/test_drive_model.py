"""The kernel against a simple model of who may move it: histories that Hypothesis chooses, and seeded long ones."""

import sys

import pytest
from hypothesis import HealthCheck, settings

from tests.models import long_simulation
from tests.models.motion import broken
from tests.models.motion.machine import MotionMachine
from tests.support import programs

FOUND_WITHIN = {
    "forgets_stops": 15_000,
    "ignores_a_broken_clock": 60_000,
    "believes_any_attitude": 30_000,
    "misses_no_attitude": 40_000,
    "resumes_after_reset": 15_000,
    "passes_nan": 15_000,
}
STEPS = 8_000
KINDS = ("tick", "command", "ranges", "motors", "attitude", "odometry", "stop", "latch")

TestMotion = MotionMachine.TestCase
TestMotion.settings = settings(stateful_step_count=40, suppress_health_check=[HealthCheck.too_slow])


@pytest.mark.parametrize("seed", [1, 2])
def test_a_long_history_breaks_no_rule(seed):
    run = long_simulation.simulate(seed, steps=25_000)
    assert run.violation == ""
    assert min(run.counts[kind] for kind in KINDS) > 10


def test_the_same_seed_is_the_same_history_in_another_process():
    again = "from tests.models.long_simulation import simulate; print(simulate(7, steps=3000).trace)"
    there = programs.run([sys.executable, "-c", again], capture_output=True, text=True, check=True)
    assert there.stdout.strip() == long_simulation.simulate(7, steps=3000).trace
    assert there.stdout.strip() != long_simulation.simulate(8, steps=3000).trace


@pytest.mark.parametrize("kernel", broken.KERNELS, ids=lambda kernel: kernel.__name__)
def test_a_kernel_that_is_broken_on_purpose_is_found_out(kernel):
    run = long_simulation.simulate(1, steps=FOUND_WITHIN.get(kernel.__name__, STEPS), kernel=kernel.__name__)
    assert run.violation
    assert run.led_to_it


def test_a_replay_shows_what_led_to_a_violation():
    run = long_simulation.simulate(1, steps=STEPS, kernel="no_lapse")
    shown = long_simulation.replay(1, run.steps, kernel="no_lapse")
    assert shown[-1] == run.violation
    assert shown[:-1] == run.led_to_it
