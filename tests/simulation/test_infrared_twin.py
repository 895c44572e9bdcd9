"""The emulated infrared receiver: the kernel's records, as `struct lirc_scancode` lays them out."""

import itertools
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.simulation.devices.infrared import BeamCodes, InfraredFaults
from lbr.simulation.devices.infrared.twin import InfraredReceiver

CODES = {"left": 1, "right": 2, "power": 3}


def receiver(*beams, **faults):
    made = InfraredReceiver(CODES, protocol=7, faults=InfraredFaults(**faults), seed=2)
    made.beams = frozenset(beams)
    return made


def run(made, seconds, start=10.0):
    return b"".join(made.poll(start + step / 250) for step in range(int(seconds * 250)))


def records(data):
    return [struct.unpack("<QHHIQ", data[at : at + 24]) for at in range(0, len(data), 24)]


def test_a_beam_is_a_code_every_110_ms_with_the_time_it_came():
    seen = records(run(receiver("right"), 1.1))
    assert len(seen) == 10
    assert all(record[1:] == (0, 7, 0, 2) for record in seen)
    times = [record[0] / 1e9 for record in seen]
    assert times[0] == pytest.approx(10.0, abs=0.05)
    assert all(0.1 < b - a < 0.12 for a, b in itertools.pairwise(times))


def test_beams_take_turns():
    made = receiver("left", "right", "power")
    codes = [record[4] for record in records(run(made, 0.33))]
    assert codes == [1, 2, 3] * 3


def test_without_a_beam_nothing_is_heard_and_nothing_is_due():
    made = receiver("left")
    run(made, 0.2)
    made.beams = frozenset()
    assert run(made, 1.0, 11.0) == b""
    assert made.next_due() is None


def test_what_is_due_next_is_known():
    made = receiver("left")
    made.poll(10.0)
    assert made.next_due() == pytest.approx(10.11)


def test_a_beam_without_a_code_is_none():
    made = InfraredReceiver({"left": 1}, protocol=7)
    made.beams = frozenset({"right", "power"})
    assert run(made, 1.0) == b""


def test_faults_show():
    assert run(receiver("left", silent=True), 1.0) == b""
    assert {record[4] for record in records(run(receiver(stuck=True), 1.0))} == {1}
    assert len(run(receiver("left", half=1.0), 1.0)) < 24 * 9
    assert len(run(receiver("left", garbage=1.0), 1.0)) > 24 * 9
    assert [record[4] for record in records(run(receiver("left", stray=1.0), 0.1))] == [0x0F1F, 1]


@given(st.sets(st.sampled_from(["left", "right", "power"])), st.lists(st.floats(0.0, 0.5), max_size=50))
def test_whenever_it_is_asked_records_are_whole(beams, pauses):
    made, now = receiver(*beams), 0.0
    for pause in pauses:
        now += pause
        assert all(record[4] in CODES.values() for record in records(made.poll(now)))


def test_codes_of_a_row_are_numbers_or_hexadecimal_and_a_beam_may_be_missing():
    assert BeamCodes(left="0x15", right=7, power=None).numbers() == {"left": 0x15, "right": 7}
