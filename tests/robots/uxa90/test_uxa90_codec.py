from math import isclose, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.robots.uxa90.driver import frames, packets
from lbr.robots.uxa90.driver.frames import Frame, FrameParser
from lbr.robots.uxa90.driver.packets import REGISTERS

VECTORS = [
    (packets.move(0, 0, 127), "FF 00 7F 7F"),
    (packets.move(23, 4, 100), "FF 97 64 73"),
    (packets.move(24, 0, 130), "FF 18 82 1A"),
    (packets.move(12, 2, 80), "FF 4C 50 1C"),
    (packets.move(13, 1, 254), "FF 2D FE 53"),
    (packets.move(23, 0, 20) + packets.move(24, 0, 120), "FF 17 14 03 FF 18 78 60"),
    (packets.read(0), "FF A0 00 20"),
    (packets.read(13), "FF AD 00 2D"),
    (packets.read(24), "FF B8 00 38"),
    (packets.passive(12), "FF CC 10 5C"),
    (packets.BREAK_ALL, "FF DF 20 7F"),
    (packets.configure(REGISTERS["runtime_speed"], 0, (30, 100)), "FF E0 17 1E 64 0D"),
    (packets.configure(REGISTERS["id"], 0, (30,)), "FF E0 0C 1E 1E 6C"),
    (packets.configure(REGISTERS["runtime_gains"], 0, (100, 100)), "FF E0 0B 64 64 6B"),
    (packets.ask(REGISTERS["boundary"], 23), "FF F7 12 00 00 65"),
    (packets.ask(REGISTERS["position14"], 23), "FF E0 AD 17 00 00 5A"),
    (packets.stored(7), "FF E0 E1 00 07 06"),
    (packets.stored(1), "FF E0 E1 00 01 00"),
    (packets.stored(21), "FF E0 E1 00 15 14"),
    (frames.TAKE_CONTROL, "FF FF AA 55 AA 55 37 BA 10 00 00 00 00 01 01 01"),
    (frames.remote(4), "FF FF AA 55 AA 55 37 BA 14 00 00 00 00 01 04 04"),
]
CAPTURED = {
    "FF FF AA 55 AA 55 37 BA 12 01 00 00 00 02 C9 00 C9": Frame(0x12, 1, b"\xc9\x00"),
    "FF FF AA 55 AA 55 37 BA 0C 04 00 00 00 0D" + b"6012000010005".hex() + "31": Frame(0x0C, 4, b"6012000010005"),
}
ZEROS = bytes.fromhex("8281818326d655ac8084838257a9867d807ed72b7f7f7f827d017f7f7f7f7f")


@pytest.mark.parametrize(("made", "known"), VECTORS, ids=[known for _, known in VECTORS])
def test_packets_are_those_known_of_the_robot(made, known):
    assert made == bytes.fromhex(known)


@pytest.mark.parametrize(("raw", "frame"), CAPTURED.items())
def test_captured_frames_are_read(raw, frame):
    assert FrameParser().feed(bytes.fromhex(raw)) == ([frame], b"")


def test_the_captured_zeros_are_read():
    raw = bytes.fromhex("FFFFAA55AA5537BA 0B 04 0000001F") + ZEROS + b"\xf4"
    assert FrameParser().feed(raw) == ([Frame(0x0B, 4, ZEROS)], b"")


@pytest.mark.parametrize("level", [-1, 5, 6, 7])
def test_a_torque_level_that_would_be_another_command_is_refused(level):
    with pytest.raises(ValueError, match="another command"):
        packets.move(3, level, 100)


@pytest.mark.parametrize(
    "build",
    [
        lambda: packets.move(31, 0, 100),
        lambda: packets.move(3, 0, 0),
        lambda: packets.move(3, 0, 255),
        lambda: packets.read(-1),
        lambda: packets.passive(31),
        lambda: packets.stored(0),
        lambda: frames.remote(43),
        lambda: packets.ask(REGISTERS["id"], 3),
        lambda: packets.configure(REGISTERS["position14"], 3, ()),
        lambda: packets.configure(REGISTERS["speed"], 3, (1,)),
        lambda: packets.configure(REGISTERS["overload"], 3, (32,)),
        lambda: packets.configure(REGISTERS["boundary"], 3, (200, 100)),
        lambda: packets.configure(REGISTERS["baud"], 3, (2,)),
        lambda: packets.configure(REGISTERS["gains"], 31, (20, 20)),
    ],
)
def test_what_is_not_allowed_is_never_built(build):
    with pytest.raises(ValueError, match=r"outside|only be|takes|leaves|not one of"):
        build()


@given(st.integers(0, 30), st.integers(0, 4), st.integers(1, 254))
def test_every_move_can_be_told_apart_from_its_bytes(servo, level, position):
    head, first, second, check = packets.move(servo, level, position)
    assert (head, first & 0x1F, first >> 5, second) == (0xFF, servo, level, position)
    assert check == (first ^ second) & 0x7F
    assert first != 0xFF


@given(st.integers(1, 254))
def test_angles_and_counts_are_one_another(count):
    assert packets.position_count(packets.position_rad(count)) == count


def test_angles_beyond_are_bounded_and_no_number_is_refused():
    assert (packets.position_count(9.0), packets.position_count(-9.0)) == (254, 1)
    assert isclose(packets.position_rad(254) - packets.position_rad(0), 4.694936, abs_tol=1e-4)
    with pytest.raises(ValueError, match="not a position"):
        packets.position_count(nan)


def test_torque_levels():
    assert [packets.torque_level(one) for one in (1.0, 0.8, 0.6, 0.4, 0.2, 0.01, 7.0, nan)] == [0, 1, 2, 3, 4, 4, 0, 4]
    assert [packets.torque_level(packets.level_torque(level)) for level in range(5)] == [0, 1, 2, 3, 4]


any_frame = st.builds(Frame, st.integers(0, 255), st.integers(0, 255), st.binary(max_size=frames.MOST_CONTENTS))
no_ff = st.binary(max_size=30).map(lambda data: data.replace(b"\xff", b"\xfe"))


@given(any_frame, no_ff, no_ff, st.integers(1, 20))
def test_a_frame_is_found_between_other_bytes_in_pieces_of_any_size(frame, before, after, size):
    raw = before + frames.encode(frame) + after
    parser, found, rest = FrameParser(), [], b""
    for start in range(0, len(raw), size):
        some, plain = parser.feed(raw[start : start + size])
        found += some
        rest += plain
    assert (found, rest) == ([frame], before + after)
    assert parser.held == 0


@given(st.lists(st.one_of(st.binary(max_size=40), any_frame.map(lambda one: frames.encode(one)[:-1]))))
def test_no_bytes_confuse_the_parser_or_get_lost(pieces):
    parser, frame_bytes, plain = FrameParser(), 0, b""
    for piece in pieces:
        found, rest = parser.feed(piece)
        frame_bytes += sum(len(frames.encode(one)) for one in found)
        plain += rest
        assert parser.held < frames.OVERHEAD_BYTES + frames.MOST_CONTENTS
    assert frame_bytes + len(plain) + len(parser.flush()) == sum(map(len, pieces))
    assert parser.held == 0
    assert parser.feed(frames.TAKE_CONTROL)[0]
