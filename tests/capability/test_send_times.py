"""When a message was sent, also by a machine whose clock is another: what was held back is old, whatever it says."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.bus import stamp
from lbr.capability.send_times import WINDOW_S, SendTimes
from lbr.messages.system import Stamp

AHEAD_S = 5000.0
SECONDS = st.floats(0.0, 100.0)


def sent(at_s: float, boot: str = "afar") -> Stamp:
    """A stamp of another machine, whose clock is ahead."""
    return Stamp(source="attitude", seq=1, mono_ns=int((at_s + AHEAD_S) * 1e9), wall_ns=0, boot=boot)


def test_what_a_network_held_back_is_as_old_as_it_is():
    dates = SendTimes()
    for tenth in range(10):
        assert dates.sent_s(sent(tenth / 10), tenth / 10 + 0.002) == pytest.approx(tenth / 10 + 0.002)
    assert dates.sent_s(sent(1.0), 1.6) == pytest.approx(1.002)


@given(st.lists(st.tuples(SECONDS, st.floats(0.0, 3.0)), min_size=1, max_size=40))
def test_no_message_is_taken_for_newer_than_it_came_nor_for_older_than_it_is(messages):
    dates = SendTimes()
    for at_s, late_s in sorted(messages):
        dated = dates.sent_s(sent(at_s), at_s + late_s)
        assert at_s - 1e-6 <= dated <= at_s + late_s


def test_a_clock_that_drifts_for_an_hour_makes_nothing_old():
    dates = SendTimes()
    for now in range(0, 3600, 5):
        assert now - dates.sent_s(sent(now * (1 - 5e-5)), now) < 2 * WINDOW_S * 1e-4


def test_our_own_clock_is_believed_as_it_is():
    here = Stamp(source="imu", seq=1, mono_ns=int(7e9), wall_ns=0, boot=stamp.boot_id())
    assert SendTimes().sent_s(here, 9.0) == 7.0
    assert SendTimes().sent_s(None, 9.0) == 9.0


def test_a_machine_that_started_anew_counts_from_there_and_what_it_said_before_is_void():
    dates = SendTimes()
    assert dates.newer(sent(100.0, "first"))
    assert dates.newer(sent(3.0, "second"))
    assert not dates.newer(sent(3.0, "second"))
    assert not dates.newer(sent(200.0, "first"))
    assert dates.newer(sent(4.0, "second"))
