"""Both emulated ultrasonic boards against what their firmwares do."""

import json
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.messages.sensing import RangeSensor, ring
from lbr.simulation.devices.ultrasonic_ring import UltrasonicFaults
from lbr.simulation.devices.ultrasonic_ring.device import UltrasonicBoard
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, make

FACED = {"forward": 1.234, "left": 0.5, "right": 2.0, "back": None}
LINE = re.compile(
    rb'\{ "Ranges": \{ "Forward": -?\d+, "Left": -?\d+, "Right": -?\d+, "Back": -?\d+, '
    rb'"Bottom": -?\d+, "Deltat": \d+\}\}\r\n'
)


def board(name="parallax", **faults):
    made = UltrasonicBoard(name, faults=UltrasonicFaults(**faults), seed=5)
    made.distances_m = FACED
    return made


def run(made, seconds, start=0.0):
    """Poll as a host would and return all that came."""
    return b"".join(made.poll(start + step / 500) for step in range(int(seconds * 500)))


def reports(data):
    return [json.loads(line)["Ranges"] for line in data.split(b"\r\n") if line.startswith(b"{")]


def test_parallax_reports_by_itself_after_its_start():
    made = board()
    assert run(made, 0.5) == b""
    data = run(made, 1.5, 0.5)
    assert all(LINE.fullmatch(line + b"\r\n") for line in data.split(b"\r\n")[:-1])
    assert 8 <= len(reports(data)) <= 15
    assert reports(data)[0] == {"Forward": 123, "Left": 50, "Right": 200, "Back": 765, "Bottom": -1, "Deltat": 0}


def test_a_board_with_more_sensors_tells_them_after_the_others():
    made = UltrasonicBoard("parallax", more=("bow",))
    made.distances_m = {**FACED, "bow": 0.4}
    assert reports(run(made, 2))[0] == {
        "Forward": 123, "Left": 50, "Right": 200, "Back": 765, "Bottom": -1, "Deltat": 0, "Bow": 40
    }  # fmt: skip


def test_a_sensor_of_the_board_that_has_no_row_is_no_free_way(tmp_path):
    around = Surroundings(seed=1, now=0.0, sensors=ring(0.43, 0.3)[:1])
    twin = make(Device("ranges", "ultrasonic_ring", str(tmp_path / "ranges"), {"board": "parallax"}), around)
    twin.sense(Sensed(battery_v=12.0, ranges_m={"forward": None}))
    told = reports(run(twin._board, 2))[0]
    assert (told["Forward"], told["Back"], told["Left"], told["Right"]) == (765, 0, 0, 0)


def test_a_sensor_with_a_device_of_its_own_is_not_the_boards(tmp_path):
    sensors = (*ring(0.43, 0.3), *(RangeSensor(name=name, kind="infrared") for name in ("bow", "stern")))
    around = Surroundings(seed=1, now=0.0, sensors=sensors, apart=frozenset({"", "stern"}))
    twin = make(Device("ranges", "ultrasonic_ring", str(tmp_path / "ranges"), {}), around)
    assert "bow" in twin._board.sensors
    assert "stern" not in twin._board.sensors


def test_a_fault_of_a_sensor_that_is_not_there_is_refused(tmp_path):
    bow = RangeSensor(name="bow", kind="infrared")
    around = Surroundings(seed=1, now=0.0, sensors=(*ring(0.43, 0.3), bow))
    twin = make(Device("ranges", "ultrasonic_ring", str(tmp_path / "ranges"), {}), around)
    assert twin.fault("missing", "bow")["missing"] == ("bow",)
    with pytest.raises(InputError, match="there is no sensor 'up'; there is forward, left, right, back, bow"):
        twin.fault("error", "up")
    assert twin.fault("unplug", True)["error"] == ()


def test_parallax_counts_its_cycle_in_clock_ticks():
    last = reports(run(board(), 2))[-1]
    assert last["Deltat"] / 80_000 == pytest.approx(50 + 4 + (123 + 50 + 200 + 765) * 0.058, abs=0.01)


def test_arduino_counts_its_cycle_in_milliseconds():
    made = board("arduino")
    made.feed(b"g", 0.0)
    assert reports(run(made, 2))[-1]["Deltat"] == 120


def test_parallax_ignores_what_it_hears():
    made = board()
    made.feed(b"s\n", 0.0)
    assert reports(run(made, 1))


def test_arduino_waits_for_g_and_stops_on_s_and_echoes_both():
    made = board("arduino")
    assert run(made, 2) == b""
    made.feed(b"g\n", 2.0)
    data = run(made, 1, 2.0)
    assert data.startswith(b"received: g\nreceived: \n\n{")
    assert reports(data[len(b"received: g\nreceived: \n\n") :])[0]["Bottom"] == 0
    made.feed(b"s\n", 3.0)
    assert run(made, 1, 3.0).endswith(b"received: s\nreceived: \n\n")
    assert run(made, 1, 4.0) == b""


def test_arduino_gives_zero_for_a_missing_sensor():
    made = board("arduino", missing=("left",))
    made.feed(b"g", 0.0)
    last = reports(run(made, 2))[-1]
    assert last["Left"] == 0
    assert last["Forward"] == 123
    assert last["Deltat"] > 200


def test_parallax_waits_for_ever_for_a_missing_sensor():
    assert run(board(missing=("left",)), 3) == b""


def test_closer_than_seventeen_centimetres_reads_as_seventeen():
    made = board()
    made.distances_m = {"forward": 0.05}
    assert reports(run(made, 1))[0]["Forward"] == 17


@pytest.mark.parametrize(
    ("faults", "forward"),
    [
        ({"over_range": ("forward",)}, 758),
        ({"error": ("forward",)}, 0),
        ({"range_forward_m": 0.31}, 31),
    ],
)
def test_a_sensor_can_be_made_to_read(faults, forward):
    assert reports(run(board(**faults), 1))[-1]["Forward"] == forward


def test_frozen_numbers_do_not_follow_the_world():
    made = board(frozen=True)
    run(made, 1)
    made.distances_m = {"forward": 0.4}
    assert reports(run(made, 1, 1.0))[-1]["Forward"] == 123


def test_silence_is_silent():
    assert run(board(silent=True), 2) == b""


def test_half_lines_have_no_end():
    data = run(board(half_lines=1.0), 2)
    assert data
    assert b"\r\n" not in data


def test_garbage_and_noise_repeat_with_the_seed():
    first, second = (run(board(garbage=1.0, noise_cm=5.0), 2) for _ in range(2))
    assert first == second
    assert first != run(board(), 2)


def test_a_power_cycle_makes_the_arduino_wait_again():
    made = board("arduino")
    made.feed(b"g", 0.0)
    run(made, 1)
    made.power_cycle(1.0)
    assert run(made, 1, 1.0) == b""


@given(st.binary(max_size=200), st.sampled_from(["arduino", "parallax"]))
def test_any_bytes_are_survived(data, name):
    made = board(name)
    made.feed(data, 0.0)
    made.feed(b"g", 1.0)
    assert b'"Forward": 123' in run(made, 2, 1.0)
