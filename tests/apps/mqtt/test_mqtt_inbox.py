"""What waits to be read is bounded, and a stop among it is the last to be lost."""

from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.mqtt.inbox import Inbox

MOST = 4
MESSAGES = st.lists(st.tuples(st.integers(), st.booleans()), max_size=20)


@given(MESSAGES)
def test_whatever_comes_the_newest_stay_in_order_and_no_stop_is_lost_for_what_is_none(messages):
    inbox = Inbox(MOST, lambda message: message[1])
    for one in messages:
        inbox.put(one)
    taken = inbox.take()
    assert len(taken) == min(MOST, len(messages))
    stops, others = ([one for one in messages if one[1] is stop] for stop in (True, False))
    assert [one for one in taken if one[1]] == stops[-MOST:]
    kept = [one for one in taken if not one[1]]
    assert kept == others[len(others) - len(kept) :]
    assert inbox.take() == []
