"""However often something happens, what is told about it is bounded, and the rest is counted."""

from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.events import BURST, PER_S, Throttle


def test_a_burst_is_told_then_a_trickle():
    throttle = Throttle()
    assert sum(throttle.take("fault", 100.0) for _ in range(1000)) == BURST
    assert sum(throttle.take("fault", 100.0 + n / 100) for n in range(1, 1001)) == 10 * PER_S
    assert throttle.missed() == {"fault": 2000 - BURST - 10 * PER_S}
    assert throttle.missed() == {}


def test_one_kind_does_not_silence_another():
    throttle = Throttle()
    for _ in range(1000):
        throttle.take("fault", 100.0)
    assert throttle.take("trip", 100.0)


@given(st.lists(st.floats(0.0, 2.0), max_size=300))
def test_nothing_is_lost_uncounted(gaps):
    throttle, now, told = Throttle(), 50.0, 0
    for gap in gaps:
        now += gap
        told += throttle.take("x", now)
    assert told + throttle.missed().get("x", 0) == len(gaps)
    assert told <= BURST + PER_S * (now - 50.0) + 1
