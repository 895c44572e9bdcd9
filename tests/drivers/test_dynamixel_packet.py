from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lbr.drivers.dynamixel import packet as dynamixel
from lbr.drivers.dynamixel import table
from lbr.drivers.servos.protocol1 import packet
from lbr.drivers.servos.protocol1.packet import Status, StatusParser

PACKETS = [
    (packet.write(1, 12, b"\x64\xaa"), "FF FF 01 05 03 0C 64 AA DC"),
    (packet.ping(1), "FF FF 01 02 01 FB"),
    (packet.read(1, 36, 6), "FF FF 01 04 02 24 06 CE"),
    (
        packet.sync_write(30, {1: b"\x00\x02\x1e\x00", 2: b"\x00\x02\x1e\x00"})[0],
        "FF FF FE 0E 83 1E 04 01 00 02 1E 00 02 00 02 1E 00 0B",
    ),
    (
        dynamixel.adapter_sync_read(36, 6, range(1, 19)),
        "FF FF FD 16 84 24 06 " + bytes(range(1, 19)).hex() + "93",
    ),
]


@pytest.mark.parametrize(
    ("made", "expected"), PACKETS, ids=["write", "ping", "read", "sync_write", "adapter_sync_read"]
)
def test_an_instruction_is_the_manual_s_bytes(made, expected):
    assert made == bytes.fromhex(expected)


@pytest.mark.parametrize(
    ("data", "status"),
    [
        ("FF FF 01 02 00 FC", Status(1, 0, b"")),
        ("FF FF 01 08 00 00 02 00 00 00 00 F4", Status(1, 0, b"\x00\x02\0\0\0\0")),
        ("FF FF 01 02 24 D8", Status(1, 0x24, b"")),
    ],
)
def test_a_status_packet_is_understood(data, status):
    assert StatusParser().feed(bytes.fromhex(data)) == [status]


def test_error_bits_have_names():
    assert dynamixel.error_names(0x24) == ("overheat", "overload")
    assert dynamixel.error_mask("overheat", "overload") == 0x24


def test_a_long_sync_write_is_cut_so_that_the_adapter_takes_it():
    blocks = {servo: bytes(6) for servo in range(1, 41)}
    pieces = packet.sync_write(30, blocks)
    assert all(piece[3] < 124 for piece in pieces)
    assert [servo for piece in pieces for servo in piece[7:-1:7]] == list(blocks)


def test_blocks_of_a_sync_write_are_of_one_size():
    with pytest.raises(ValueError, match="one size"):
        packet.sync_write(30, {1: b"\0", 2: b"\0\0"})


def status(servo: int, error: int, params: bytes) -> bytes:
    body = bytes((servo, len(params) + 2, error)) + params
    return b"\xff\xff" + body + bytes((255 - sum(body) % 256,))


statuses = st.builds(Status, st.integers(0, 253), st.integers(0, 127), st.binary(max_size=30))
quiet_noise = st.binary(max_size=20).map(lambda noise: noise.replace(b"\xff", b"\xfe"))


@given(st.lists(st.tuples(quiet_noise, statuses), max_size=6), st.lists(st.integers(1, 40), min_size=1))
def test_packets_are_found_among_noise_however_the_bytes_arrive(sent, cuts):
    stream = b"".join(noise + status(s.id, s.error, s.params) for noise, s in sent)
    parser, found, at, turn = StatusParser(), [], 0, 0
    while at < len(stream):
        size = cuts[turn % len(cuts)]
        found += parser.feed(stream[at : at + size])
        at, turn = at + size, turn + 1
    assert found == [s for _, s in sent]
    assert parser.held_bytes == 0


@given(st.lists(st.binary(max_size=60)))
def test_no_bytes_break_the_parser_or_fill_it(pieces):
    parser = StatusParser()
    fed = 0
    for piece in pieces:
        fed += len(piece)
        for found in parser.feed(piece):
            assert found.id <= 253
            assert found.error <= 127
    assert parser.held_bytes <= 260
    assert parser.noise <= fed


@given(st.binary(max_size=300), statuses)
def test_a_packet_is_found_after_any_noise_once_the_noise_could_have_ended(noise, sent):
    parser = StatusParser()
    parser.feed(noise)
    found = parser.feed(bytes(260) + status(sent.id, sent.error, sent.params))
    assert sent in found


@pytest.mark.parametrize(
    "lead", ["FF", "FF FF", "FF FF FF", "FF FF 01", "FF FF FF FE 05", "00 FF FF 01 02 80", "FF FF 01 00"]
)
def test_a_slipped_header_costs_no_packet(lead):
    reply = bytes.fromhex("FF FF 01 02 00 FC")
    parser = StatusParser()
    assert Status(1, 0, b"") in parser.feed(bytes.fromhex(lead) + reply + bytes(8))


def test_a_corrupt_packet_is_counted_and_not_given():
    parser = StatusParser()
    assert parser.feed(bytes.fromhex("FF FF 01 02 00 FD")) == []
    assert parser.corrupt == 1


def test_registers_do_not_overlap_and_refuse_what_the_servo_would():
    ends = [(register.address, register.address + register.size) for register in table.REGISTERS]
    assert all(end <= start for (_, end), (start, _) in pairwise(ends))
    assert [register.name for register in table.REGISTERS if register.address < table.RAM][-1] == "shutdown"
    with pytest.raises(ValueError, match=r"goal position 1024 is outside 0\.\.1023"):
        table.GOAL_POSITION.encode(1024)
    with pytest.raises(ValueError, match="can only be read"):
        table.PRESENT_LOAD.encode(0)


def test_positions_survive_the_way_to_radians_and_back():
    assert all(table.position_raw(table.position_rad(raw)) == raw for raw in range(1024))


@example(5e307, 5e-324)
@given(st.floats(), st.floats())
def test_no_number_leaves_the_servo_s_range(angle, torque):
    if abs(angle) < float("inf"):
        assert 0 <= table.position_raw(angle) <= 1023
    else:
        with pytest.raises(ValueError, match="not a position"):
            table.position_raw(angle)
    assert 0 <= table.torque_raw(torque) <= 1023
    if 0.0 < angle < float("inf"):
        assert 1 <= table.speed_raw(angle) <= 1023


def test_units_are_the_manual_s():
    assert table.position_rad(1023) == pytest.approx(2.6154, abs=1e-3)
    assert table.Motion(0, 512, 1024 + 100, 100).speed_rps == pytest.approx(-1.1624)
    assert table.Motion(0, 512, 1024, 0).speed_rps == 0.0
    assert table.Motion(0, 512, 0, 1023).load_fraction == 1.0
    assert table.speed_raw(None) == 0
    assert table.speed_raw(0.001) == 1
    assert (table.torque_raw(0.5), table.torque_raw(1e-9)) == (512, 1)


@given(position=st.integers(0, 1023), goal=st.integers(0, 1023), speed=st.integers(0, 2047))
def test_a_servo_is_held_at_its_goal_if_it_rests_near_it_and_else_where_it_is(position, goal, speed):
    held = table.holding_goal(position, speed, goal)
    assert held == (goal if abs(goal - position) <= table.SAG and speed in {0, 1024} else position)
