import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.ultrasonic import KIND, UltrasonicSettings
from lbr.drivers.ultrasonic.protocol import MAX_LINE_BYTES, BadLine, Frame, LineParser, classify, parse_line, to_ranges
from lbr.messages.sensing import RING

GOOD = b'{ "Ranges": { "Forward": 120, "Left": 45, "Right": 758, "Back": 0, "Bottom": -1, "Deltat": 102}}'  # as the board writes
FRAME = Frame(forward=120, left=45, right=758, back=0, bottom=-1, deltat=102)
ARDUINO = UltrasonicSettings(device="ring", board="arduino", absent=())
PARALLAX = UltrasonicSettings(device="ring", board="parallax", absent=())

integers = st.integers(-2, 1000)
others = st.dictionaries(st.from_regex("[a-z][a-z0-9_]{0,9}", fullmatch=True), integers, max_size=4).map(
    lambda named: {name: cm for name, cm in named.items() if name not in {*RING, "deltat"}}
)
frames = st.builds(
    Frame,
    forward=integers,
    left=integers,
    right=integers,
    back=integers,
    bottom=integers,
    deltat=st.integers(0, 10**9),
    others=others,
)


def spelt(frame):
    names = ("Forward", "Left", "Right", "Back", "Bottom", "Deltat")
    told = {name: getattr(frame, name.lower()) for name in names}
    more = {name.capitalize(): cm for name, cm in frame.others.items()}
    return json.dumps({"Ranges": told | more}).encode() + b"\r\n"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (GOOD, FRAME),
        (b"  " + GOOD + b"\r", FRAME),
        (b"", None),
        (b"\r", None),
        (b"received: g", None),
        (b"received: s\r", None),
        (b"received:", None),
    ],
)
def test_a_line_is_a_frame_or_nothing(line, expected):
    assert parse_line(line) == expected


@pytest.mark.parametrize(
    "line",
    [
        GOOD[:-1],
        GOOD[5:],
        GOOD[:40] + GOOD,
        GOOD.replace(b"120", b"12x"),
        GOOD.replace(b"120", b"NaN"),
        GOOD.replace(b"120", b"1e999"),
        GOOD.replace(b"120", b'"120"'),
        GOOD.replace(b"120", b"true"),
        GOOD.replace(b"120", b"120.5"),
        GOOD.replace(b'"Back": 0, ', b""),
        b'{"Ranges": null}',
        b"received: { ",
        b"\xff\xfe\x00",
        b"[" * 400,
        b"[" * 100_000,
        b'{"Ranges": {"x": ' + b"[" * 100_000,
        b'{"\xff": 1}',
        GOOD.replace(b"Forward", b"Forw\xffrd"),
        GOOD.replace(b"102", b"9" * 400),
        GOOD.replace(b"102", b"9" * 5000),
        GOOD.replace(b"102", b"4294967296"),
        GOOD.replace(b"120", b"-2147483649"),
        GOOD.replace(b"120", b"-" + b"9" * 400),
    ],
)
def test_what_is_damaged_becomes_no_frame(line):
    assert isinstance(parse_line(line), BadLine)


@pytest.mark.parametrize(
    ("cm", "status"),
    [
        (-2, "invalid"),
        (-1, "missing"),
        (0, "invalid"),
        (16, "invalid"),
        (17, "ok"),
        (757, "ok"),
        (758, "over_range"),
        (800, "over_range"),
        (801, "invalid"),
        (10**9, "invalid"),
    ],
)
def test_special_numbers_are_told_apart(cm, status):
    assert classify(cm, ARDUINO) == status


def test_a_frame_in_metres_has_null_wherever_nothing_was_measured():
    ranges = to_ranges(FRAME, ARDUINO)
    assert (ranges.forward_m, ranges.left_m) == (1.2, 0.45)
    assert (ranges.right_m, ranges.back_m, ranges.bottom_m) == (None, None, None)
    assert ranges.status == {
        "forward": "ok",
        "left": "ok",
        "right": "over_range",
        "back": "invalid",
        "bottom": "missing",
    }


def test_sensors_take_turns_so_that_the_first_is_the_oldest():
    ages = to_ranges(parse_line(GOOD.replace(b"102}", b'102, "Stern": 100}')), ARDUINO).ages_s
    assert list(ages) == ["forward", "left", "right", "back", "stern"]
    assert ages["stern"] == pytest.approx(0.015 + 100 * 58e-6, abs=1e-3)
    assert ages["back"] - ages["stern"] == pytest.approx(0.1)  # its error takes the whole of the board's patience
    assert ages["forward"] - ages["left"] == pytest.approx(120 * 58e-6, abs=1e-3)


def test_a_board_with_more_sensors_tells_them_by_their_names():
    ranges = to_ranges(parse_line(GOOD.replace(b"102}", b'102, "Bow_left": 33, "Stern": 758}')), ARDUINO)
    assert ranges.others_m == {"bow_left": 0.33, "stern": None}
    assert ranges.status["stern"] == "over_range"
    assert ranges.forward_m == 1.2


@pytest.mark.parametrize("name", [b"bow", b"Bow-left", b"B\xc3\xb6w", b"", b"B" * 50])
def test_a_name_that_no_row_could_have_is_damage(name):
    assert isinstance(parse_line(GOOD.replace(b"102}", b'102, "%s": 33}' % name)), BadLine)


def test_a_sensor_declared_absent_is_missing_whatever_the_board_says():
    settings = KIND.parse('{"device": "ring", "absent": ["forward"]}')
    ranges = to_ranges(FRAME, settings)
    assert ranges.forward_m is None
    assert ranges.status["forward"] == "missing"


@pytest.mark.parametrize(
    ("settings", "deltat", "cycle_s"),
    [(ARDUINO, 102, 0.102), (PARALLAX, 8_160_000, 0.102), (ARDUINO, 0, None), (PARALLAX, -5, None)],
)
def test_the_cycle_is_in_the_boards_own_unit(settings, deltat, cycle_s):
    frame = Frame(forward=20, left=20, right=20, back=20, bottom=20, deltat=deltat)
    assert to_ranges(frame, settings).cycle_s == cycle_s


@given(frames)
def test_what_a_board_writes_is_what_is_read(frame):
    assert LineParser().feed(spelt(frame)) == [frame]


@given(st.lists(st.sampled_from([GOOD, b"\r\n", b"\n", b"received: g\n", b"{", b"\xff", b"x" * 600]), max_size=15))
def test_how_the_bytes_are_cut_changes_nothing(pieces):
    data = b"".join(pieces)
    single = LineParser()
    expected = LineParser().feed(data)
    assert [item for index in range(len(data)) for item in single.feed(data[index : index + 1])] == expected


@given(st.lists(st.binary(max_size=700), max_size=10), frames)
def test_whatever_babbles_little_is_held_and_the_next_clean_line_is_read(pieces, frame):
    parser = LineParser()
    for piece in pieces:
        parser.feed(piece)
        assert parser.lines.held_bytes <= MAX_LINE_BYTES
    assert parser.feed(b"\n" + spelt(frame))[-1] == frame


@given(st.binary(max_size=60), st.integers(0, len(GOOD)), st.integers(0, 20))
def test_damage_anywhere_in_a_line_never_raises(damage, at, length):
    found = parse_line(GOOD[:at] + damage + GOOD[at + length :])
    if isinstance(found, Frame):
        to_ranges(found, ARDUINO)


@given(st.sampled_from(["Forward", "Left", "Right", "Back", "Bottom", "Deltat"]), st.integers(1, 6000))
def test_a_number_of_any_length_is_read_or_makes_a_bad_line(name, digits):
    numbers = dict.fromkeys(("Forward", "Left", "Right", "Back", "Bottom", "Deltat"), "1") | {name: "9" * digits}
    line = '{"Ranges": {' + ", ".join(f'"{key}": {number}' for key, number in numbers.items()) + "}}"
    found = parse_line(line.encode())
    assert isinstance(found, Frame if digits < 10 else BadLine)
    if isinstance(found, Frame):
        to_ranges(found, PARALLAX)


@given(frames)
def test_no_number_comes_out_that_was_not_measured(frame):
    ranges = to_ranges(frame, ARDUINO)
    for name, status in ranges.status.items():
        metres = ranges.metres(name)
        assert (metres is not None) == (status == "ok")
        assert metres is None or 0.17 <= metres < 7.58
