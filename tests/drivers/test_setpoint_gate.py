"""What wheels and servos share of the decision whether a setpoint reaches motors."""

from dataclasses import dataclass
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.setpoint_gate import REVOKED_KEPT, SetpointGate, fresh

VALID_S = 0.1


@dataclass(frozen=True)
class Asked:
    lease: str = "L1"
    born: float = 10.0
    finite: bool = True
    neutral: bool = False


def test_a_fresh_setpoint_passes_and_a_revoked_lease_moves_nothing():
    gate = SetpointGate()
    assert gate.judge(Asked(), 10.0, VALID_S) == "passes"
    gate = gate.closed("late", "L1")
    assert (gate.setpoint, gate.reason) == (None, "late")
    assert gate.judge(Asked(), 10.0, VALID_S) == "revoked"
    assert gate.judge(Asked(neutral=True), 10.0, VALID_S) == "passes"
    assert gate.judge(Asked("L2"), 10.0, VALID_S) == "passes"


def test_what_is_no_number_is_told_apart_even_when_late():
    assert SetpointGate().judge(Asked(born=0.0, finite=False), 10.0, VALID_S) == "not_finite"


@pytest.mark.parametrize("age_s", [0.11, 5.0, -5.0, nan, inf, -inf])
def test_what_is_not_of_now_is_late(age_s):
    assert not fresh(10.0 - age_s, 10.0, VALID_S)
    assert SetpointGate().judge(Asked(born=10.0 - age_s), 10.0, VALID_S) == "late"


@pytest.mark.parametrize(
    ("age_s", "now"), [(0.0, True), (0.1249, True), (0.125, False), (-0.125, True), (-0.1251, False)]
)
def test_what_is_as_old_as_it_may_live_is_late_and_what_is_from_as_far_ahead_is_not(age_s, now):
    assert fresh(10.0 - age_s, 10.0, 0.125) is now


@given(st.lists(st.sampled_from(["", "a", "b", "c"]), max_size=20), st.integers(0, 3 * REVOKED_KEPT))
def test_the_memory_of_revoked_leases_is_bounded_and_keeps_the_newest(leases, others):
    gate = SetpointGate()
    for lease in (*map(str, range(others)), *leases):
        gate = gate.revoked(lease)
    assert len(gate.dead) <= REVOKED_KEPT
    assert "" not in gate.dead
    assert not leases or not leases[-1] or leases[-1] in gate.dead
