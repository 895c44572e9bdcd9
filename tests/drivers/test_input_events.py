import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.input_events import (
    EVENT,
    EVENT_32,
    EVENT_64,
    BadRecordError,
    InputEvent,
    RecordParser,
    read_event,
)

LAYOUTS = st.sampled_from([EVENT_32, EVENT_64])
EVENTS = st.builds(
    InputEvent,
    type=st.integers(0, 0x1F),
    code=st.integers(0, 0x2FF),
    value=st.integers(-(2**31), 2**31 - 1),
    taken_s=st.integers(0, 2**31).map(float),
)


def packed(event: InputEvent, layout=EVENT) -> bytes:
    return layout.pack(int(event.taken_s), 0, event.type, event.code, event.value)


def parser(layout=EVENT) -> RecordParser[InputEvent]:
    return RecordParser(layout.size, lambda record: read_event(record, layout))


@given(LAYOUTS, st.lists(EVENTS, max_size=8), st.data())
def test_events_come_out_as_they_went_in_however_they_are_cut_on_every_userland(layout, sent, data):
    stream, made, found = b"".join(packed(event, layout) for event in sent), parser(layout), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        found += made.feed(stream[:size])
        stream = stream[size:]
    assert found == sent
    assert made.passed_over == 0


@given(LAYOUTS, st.binary(max_size=200))
def test_whatever_comes_is_an_event_or_passed_over_and_less_than_a_record_is_held(layout, noise):
    made = parser(layout)
    found = made.feed(noise)
    assert 0 <= len(noise) - made.passed_over - layout.size * len(found) < layout.size


@given(st.binary(max_size=60), EVENTS)
def test_after_damage_and_a_pause_the_next_event_is_heard(damage, event):
    made = parser()
    made.feed(damage)
    made.pause()
    assert made.feed(packed(event)) == [event]


@pytest.mark.parametrize(
    "record",
    [
        EVENT_64.pack(-1, 0, 0, 0, 0),
        EVENT_64.pack(2**36, 0, 0, 0, 0),
        EVENT_64.pack(0, -1, 0, 0, 0),
        EVENT_64.pack(0, 1_000_000, 0, 0, 0),
        EVENT_64.pack(0, 0, 0x20, 0, 0),
        EVENT_64.pack(0, 0, 0, 0x300, 0),
    ],
)
def test_what_no_kernel_writes_is_no_event(record):
    with pytest.raises(BadRecordError):
        read_event(record, EVENT_64)


def test_a_record_is_as_long_as_this_kernel_writes_it():
    assert (EVENT_32.size, EVENT_64.size) == (16, 24)
    assert EVENT in (EVENT_32, EVENT_64)
