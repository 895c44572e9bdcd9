"""Numbers over time out of the box's files: one chunk for each point, whatever the time is that they are asked for."""

import os

from lbr.apps.recorder.recording import chunks
from lbr.apps.recorder.recording.chunks import Channel, Channels
from lbr.apps.recorder.recording.history import history, value_of
from lbr.apps.recorder.recording.segments import Segment
from tests.support.segments import finished

S = 1_000_000_000
VOLTS, SPEED = "battery/state.voltage_v", "odometry/state.speed_mps"


def recorded(path, start_s, end_s):
    """Write a file with a chunk for each second: a voltage that is its second, and the first chunk with what was last."""
    channels = Channels()
    number = channels.number(Channel("battery/state", "json", "", b""))
    with finished(Segment(path, "a test", {})) as file:
        for second in range(start_s, end_s):
            said = [chunks.message(number, 0, second * S + at, 0, b'{"voltage_v": %d}' % second) for at in (0, 1)]
            file.write(chunks.chunk([channels.of([number]), *said], second * S, second * S + 1))
    os.utime(path, ns=(0, end_s * S))
    return path


def test_each_point_is_the_newest_value_of_a_chunk_and_the_points_are_no_more_than_asked(tmp_path):
    files = [recorded(tmp_path / f"{start}.mcap", start, start + 60) for start in (0, 60, 120)]
    found = history(files, (VOLTS, SPEED), 0, 180 * S, 18)
    assert 10 <= len(found.at_ms) <= 18
    assert found.values[VOLTS] == [ms // 1000 for ms in found.at_ms]
    assert found.values[SPEED] == [None] * len(found.at_ms)
    assert found.at_ms == sorted(set(found.at_ms))


def test_only_what_was_between_the_two_times_is_returned(tmp_path):
    files = [recorded(tmp_path / "one.mcap", 0, 60)]
    assert history(files, (VOLTS,), 20 * S, 30 * S, 600).values[VOLTS] == list(range(20, 30))
    assert history(files, (VOLTS,), 70 * S, 90 * S, 600).at_ms == []
    assert history([tmp_path / "gone.mcap"], (VOLTS,), 0, S, 2).at_ms == []


def test_a_damaged_chunk_is_a_point_without_a_value(tmp_path):
    path = recorded(tmp_path / "one.mcap", 0, 10)
    data = bytearray(path.read_bytes())
    at = data.index(b"zstd", data.index(b"zstd") + 4) + 30
    data[at] ^= 0xFF
    path.write_bytes(data)
    values = history([path], (VOLTS,), 0, 10 * S, 600).values[VOLTS]
    assert values == [None, *range(2, 10)]


def test_a_value_is_found_by_names_and_places_and_what_is_no_number_is_none():
    message = {"a": {"b": [1, {"c": True}]}, "d": "text"}
    assert value_of(message, ["a", "b", "1", "c"]) == 1.0
    assert value_of(message, ["d"]) is None
    assert value_of(message, ["a", "b", "7"]) is None
