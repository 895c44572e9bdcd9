"""The LD06's packets: whatever comes, only whole packets count, and only whole turns are told."""

from math import inf, isnan, nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.ld06.protocol import HEAD, PACKET_BYTES, Packet, PacketParser, Point, Turn, check, decode
from lbr.messages.sensing import RangeSensor
from lbr.simulation.devices.ld06 import Ld06Faults
from lbr.simulation.devices.ld06.twin import Ld06

ROUND = RangeSensor(name="lidar", kind="lidar", fov_rad=6.2832, min_m=0.02, max_m=12.0, rays=360)


def spelt(start=0, end=880, distances=(1000,) * 12, confidence=200, speed=3600):
    points = b"".join(mm.to_bytes(2, "little") + bytes((confidence,)) for mm in distances)
    numbers = speed.to_bytes(2, "little") + start.to_bytes(2, "little")
    body = HEAD + numbers + points + end.to_bytes(2, "little") + b"\x00\x00"
    return body + bytes((check(body),))


packets = st.builds(
    lambda start, span, distances: spelt(start, (start + span) % 36000, distances),
    st.integers(0, 35999),
    st.integers(0, 3000),
    st.lists(st.integers(0, 65535), min_size=12, max_size=12),
)


def turned(lidar, seconds=1.0):
    """Return the scans of a device that talks for a while."""
    parser, turn = PacketParser(), Turn(ROUND)
    scans = [turn.add(packet) for step in range(int(seconds * 100)) for packet in parser.feed(lidar.poll(step / 100))]
    return [scan for scan in scans if scan is not None]


def test_a_packet_is_read():
    packet = decode(spelt(35900, 780, range(1, 13)))
    assert packet == Packet(3600, 35900, 780, tuple(Point(mm, 200) for mm in range(1, 13)))
    assert packet.span_cdeg == 880


@given(packets)
def test_what_is_written_is_read(data):
    (packet,) = PacketParser().feed(data)
    assert decode(data) == packet


@given(packets, st.integers(0, PACKET_BYTES - 1), st.integers(0, 7))
def test_one_wrong_bit_anywhere_is_no_packet(data, at, bit):
    spoilt = bytearray(data)
    spoilt[at] ^= 1 << bit
    assert decode(bytes(spoilt)) is None


@given(st.binary(max_size=200))
def test_whatever_bytes_come_nothing_is_raised(data):
    decode(data)
    parser = PacketParser()
    parser.feed(data)
    assert parser.held_bytes < PACKET_BYTES


@given(st.lists(st.one_of(packets, st.binary(max_size=60), st.just(HEAD)), max_size=8))
def test_how_the_bytes_are_cut_changes_nothing(pieces):
    data = b"".join(pieces)
    single, whole = PacketParser(), PacketParser()
    expected = whole.feed(data)
    assert [packet for byte in data for packet in single.feed(bytes((byte,)))] == expected
    assert single.bad_bytes == whole.bad_bytes


@given(st.lists(st.binary(max_size=100), max_size=8), packets)
def test_after_any_babble_a_packet_is_found_again(babble, data):
    parser = PacketParser()
    for piece in babble:
        parser.feed(piece)
    assert decode(data) in parser.feed(bytes(PACKET_BYTES) + data)


def test_the_emulated_device_is_understood_and_turns_the_other_way():
    """Something to the left is at 270 degrees for the lidar, which counts clockwise, and at +pi/2 in a scan."""
    lidar = Ld06()
    lidar.face = lambda angle: 0.5 if abs((angle % (2 * pi)) - pi / 2) < 0.1 else 2.0
    scan = turned(lidar)[0]
    found = dict(zip(ROUND.angles(), scan.metres(), strict=True))
    assert [metres for angle, metres in found.items() if abs(angle - pi / 2) < 0.08] == pytest.approx([0.5] * 9)
    assert min(metres for angle, metres in found.items() if abs(angle - pi / 2) > 0.12) == 2.0
    assert scan.scan_s == 0.1
    assert scan.angle_max_rad == pytest.approx(pi - 2 * pi / 360)


def test_ten_whole_turns_a_second_are_told():
    lidar = Ld06()
    lidar.face = lambda angle: 1.0
    scans = turned(lidar, 2.0)
    assert 13 <= len(scans) <= 15
    assert not any(isnan(metres) for scan in scans for metres in scan.metres())


@pytest.mark.parametrize(
    ("distance_mm", "confidence", "metres"),
    [(0, 200, nan), (19, 200, -inf), (20, 200, 0.02), (12_000, 200, 12.0), (12_001, 200, inf), (1000, 9, nan)],
)
def test_near_far_and_unknown_are_told_as_rep_117_has_them(distance_mm, confidence, metres):
    turn = Turn(ROUND, least_confidence=10)
    starts = [number * 960 % 36000 for number in range(160)]
    data = [spelt(start, (start + 880) % 36000, (distance_mm,) * 12, confidence) for start in starts]
    scans = [scan for packet in map(decode, data) if (scan := turn.add(packet)) is not None]
    assert scans
    assert all(value == metres or (isnan(value) and isnan(metres)) for value in scans[-1].metres())


def test_a_turn_of_which_a_packet_is_missing_is_not_told():
    lidar = Ld06()
    lidar.face = lambda angle: 1.0
    found = PacketParser().feed(b"".join(lidar.poll(step / 100) for step in range(150)))
    whole, gap = Turn(ROUND), Turn(ROUND)
    count = sum(whole.add(packet) is not None for packet in found)
    assert sum(gap.add(packet) is not None for number, packet in enumerate(found) if number != 60) == count - 1
    assert gap.broken == whole.broken + 1


@pytest.mark.parametrize("faults", [{"silent": True}, {"stalled": True}, {"bit_flip": 1.0}])
def test_no_whole_turn_no_scan(faults):
    lidar = Ld06(faults=Ld06Faults(**faults))
    lidar.face = lambda angle: 1.0
    assert turned(lidar) == []


def test_where_nothing_comes_back_is_not_known():
    assert {isnan(metres) for metres in turned(Ld06(faults=Ld06Faults(dark=True)))[0].metres()} == {True}


def test_noise_between_packets_costs_nothing():
    lidar = Ld06(faults=Ld06Faults(garbage=0.5), seed=3)
    lidar.face = lambda angle: 1.0
    assert len(turned(lidar, 2.0)) >= 13


def test_a_sensor_that_sees_less_than_all_around_tells_its_part():
    half = RangeSensor(name="half", kind="lidar", fov_rad=pi, max_m=12.0, rays=181)
    turn, lidar, parser = Turn(half), Ld06(), PacketParser()
    lidar.face = lambda angle: 1.0 if -pi / 2 < -((-angle + pi) % (2 * pi) - pi) < pi / 2 else 3.0
    scans = [
        scan for step in range(100) for packet in parser.feed(lidar.poll(step / 100)) if (scan := turn.add(packet))
    ]
    assert scans[0].angle_min_rad == -pi / 2
    assert scans[0].angle_max_rad == pytest.approx(pi / 2)
    assert set(scans[0].metres()[2:-2]) == {1.0}
