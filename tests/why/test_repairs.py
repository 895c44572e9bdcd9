"""What is to be mended of a robot, and in which order."""

import pytest
from msgspec.structs import replace

from lbr.why.chain import explain
from lbr.why.snapshot import Channel, Facts, Part, Snapshot
from tests.why.healthy import snapshot, with_unit

DEVICES = {"motors": "roboteq", "ranges": "range_board"}
WIRES = (
    ("motors.state", "odometry.motors"),
    ("odometry.state", "drive.odometry"),
    ("drive.setpoint", "motors.setpoint"),
    ("ranges.readings", "drive.ranges"),
    ("drive.state", "behaviour.drive"),
    ("speech.state", "behaviour.speech"),
)
PARTS = ("motors", "ranges", "odometry", "drive", "behaviour", "speech")


@pytest.fixture
def well() -> Snapshot:
    parts = {name: Part(name=name, kind=name, family="app", device=DEVICES.get(name, "")) for name in PARTS}
    channels = tuple(Channel(source=source, target=target) for source, target in WIRES)
    addresses = {device: f"/dev/{device}" for device in DEVICES.values()}
    return snapshot(Facts(robot="any", parts=parts, channels=channels, devices=addresses))


def degraded(now: Snapshot, *names: str, code: str = "", reason: str = "waits") -> Snapshot:
    for name in names:
        now = with_unit(now, name, phase="degraded", code=code, reason=reason)
    return now


def told(now: Snapshot) -> list[tuple[str, tuple[str, ...], bool]]:
    return [(one.part, one.waits, one.device) for one in explain(now).repairs]


def test_a_robot_that_is_well_has_nothing_to_mend(well):
    assert told(well) == []
    assert explain(degraded(well, "drive"), "drive").repairs == ()


def test_a_part_without_its_device_comes_first_with_all_that_waits_for_it(well):
    now = degraded(well, "motors", code="unreachable", reason="/dev/ttyACM0 is not there")
    now = with_unit(degraded(now, "odometry", "drive"), "speech", phase="failed", reason="no loudspeaker")
    assert told(now) == [("motors", ("odometry", "drive"), True), ("speech", (), False)]
    motors, speech = explain(now).repairs
    assert motors.text == "/dev/ttyACM0 is not there"
    assert speech.text == "no loudspeaker"
    assert "/restart/speech" in speech.do


def test_a_part_may_wait_for_two_devices_and_by_way_of_others(well):
    away = degraded(well, "motors", "ranges", code="unreachable")
    now = degraded(away, "odometry", "drive", "behaviour")
    assert told(now) == [
        ("motors", ("odometry", "drive", "behaviour"), True),
        ("ranges", ("drive", "behaviour"), True),
    ]


def test_parts_that_wait_for_each_other_are_told_each_by_itself(well):
    wires = (Channel(source="drive.a", target="speech.a"), Channel(source="speech.b", target="drive.b"))
    now = degraded(replace(well, facts=replace(well.facts, channels=wires)), "drive", "speech")
    assert told(now) == [("drive", (), False), ("speech", (), False)]


def test_a_channel_that_is_switched_off_holds_nothing(well):
    wires = tuple(replace(one, enabled=False) for one in well.facts.channels)
    now = degraded(replace(well, facts=replace(well.facts, channels=wires)), "odometry", "drive")
    assert told(now) == [("drive", (), False), ("odometry", (), False)]
