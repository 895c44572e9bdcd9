"""The telemetry of old, and when a client counts as lost: pure."""

import json
import time
from math import inf, nan, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from lbr.capability.context import Received
from lbr.messages.sensing import Ranges
from lbr.messages.telemetry import (
    AmperagesPart,
    BatteryPart,
    CameraPart,
    CamerasPart,
    CountsPart,
    DockSignalPart,
    ImuPart,
    Telemetry,
    VoltagesPart,
)
from lbr.robots.lbr.original.heartbeat import Heartbeat
from lbr.robots.lbr.original.package import cameras, lasting, package, with_beams

NOW, WALL = 100.0, 1676000000.0


def received(message, age_s=0.0):
    return Received(message, None, NOW - age_s, "test")


def ranges(**metres):
    given_m = {name: metres.get(name) for name in ("forward", "back", "left", "right", "bottom")}
    status = {name: "ok" if metre is not None else "missing" for name, metre in given_m.items()}
    return Ranges(**{f"{name}_m": metre for name, metre in given_m.items()}, status=status | {"left": "over_range"},
                  cycle_s=0.15)  # fmt: skip


WHOLE = Telemetry(
    time_s=WALL,
    imu=ImuPart(
        age_s=1.0,
        gyro_rps=(0.0, radians(2.0), radians(-10.0)),
        accel_mps2=(0.0, -9.81, 9.81),
        mag_ut=(-10.8, -10.7, -31.6),
        temperature_c=28.44,
        heading_deg=315.02,
        orientation=(1.0, 0.0, 0.0, 0.0),
        turned_deg=12.345,
    ),
    amperages=AmperagesPart(age_s=0.0, left_a=-5.13, right_a=-0.01),
    battery=BatteryPart(age_s=0.0, voltage_v=12.6, charge=0.9, charging=False, source="battery", level="ok"),
    counts=CountsPart(age_s=0.5, left=130, right=-260),
    voltages=VoltagesPart(age_s=0.0, battery_v=10.4, internal_v=12.0, output_v=5.1),
    dock_signal=DockSignalPart(age_s=2.0, left=True, right=False, power=False),
    cameras=CamerasPart(
        age_s=0.0,
        selected="front",
        cameras={
            "front": CameraPart(device="/dev/video0", on=True, phase="streaming"),
            "rear": CameraPart(device="/dev/video2", on=False, phase="off"),
        },
    ),
)


def told(telemetry=WHOLE, found=None, age_s=0.0):
    return package(received(telemetry, age_s) if telemetry else None, found, NOW, WALL, 758)


def test_every_part_has_its_name_of_old_and_its_unit():
    found = told(found=received(ranges(forward=0.67, right=1.299999999, back=0.18)))
    assert found["Ranges"] == {"Forward": 67, "Left": 758, "Right": 130, "Back": 18, "Bottom": 0, "Deltat": 150}
    assert found["Timestamp"] == WALL
    assert found["MPU"] == {
        "gyro": [0.0, 2.0, 10.0, WALL - 1.0],
        "accel": [0.0, -1.0, 1.0],
        "mag": [-10.8, -10.7, -31.6],
        "heading": 315.0,
        "temp": 28.4,
        "time": WALL - 1.0,
        "quat": "1.000 +0.000i +0.000j +0.000k",
        "qangle": 12.35,
    }
    assert found["amperages"] == {"leftMotor": -5.1, "rightMotor": 0.0, "time": time.asctime(time.localtime(WALL))}
    assert found["Bat"] == {"voltage": 12.6, "level": 0.9, "source": "BAT"}
    assert found["Count"] == {"left": 130, "right": -260, "time": WALL - 0.5}
    assert found["voltages"] == {
        "mainBattery": 10.4, "internal": 12.0, "vout": 5.1, "time": time.asctime(time.localtime(WALL)),
    }  # fmt: skip
    assert found["dockSignal"] == {"time": WALL - 2.0, "left": 1, "right": 0}
    assert found["cameras"] == {
        "front": {"device": "/dev/video0", "status": "on"},
        "rear": {"device": "/dev/video2", "status": "off"},
        "off": {"device": "", "status": "off"},
    }
    assert "-0.0" not in json.dumps(found)


def test_nothing_is_made_up():
    assert told(None) == {}
    assert told(Telemetry(time_s=WALL)) == {}
    assert cameras(None) == {}
    unknown = Telemetry(
        time_s=WALL,
        imu=ImuPart(age_s=0.0),
        amperages=AmperagesPart(age_s=0.0, left_a=None, right_a=0.0),
        battery=BatteryPart(age_s=0.0, voltage_v=None, charge=None, charging=None, source=None, level="unknown"),
        counts=CountsPart(age_s=0.0, left=None, right=None),
        voltages=VoltagesPart(age_s=0.0, battery_v=None, internal_v=None, output_v=None),
    )
    found = told(unknown)
    assert set(found) == {"MPU"}
    assert set(found["MPU"].values()) == {None, WALL}


def test_a_heading_that_is_north_when_rounded_is_zero_degrees():
    north = structs.replace(WHOLE, imu=structs.replace(WHOLE.imu, heading_deg=359.97))
    assert told(north)["MPU"]["heading"] == 0.0


def test_a_part_that_is_not_told_any_more_stays_as_it_was_with_its_own_old_time():
    before = told(age_s=4.0)
    silent = structs.replace(
        WHOLE,
        imu=structs.replace(WHOLE.imu, age_s=0.0, heading_deg=None),
        amperages=AmperagesPart(age_s=0.0, left_a=None, right_a=None),
        battery=None,
        counts=CountsPart(age_s=0.0, left=None, right=None),
        voltages=None,
        dock_signal=None,
    )
    now = told(silent)
    later = lasting(before, now)
    assert {name: later[name] for name in ("amperages", "Bat", "Count")} == {
        name: before[name] for name in ("amperages", "Bat", "Count")
    }
    assert (later["MPU"]["heading"], later["MPU"]["time"]) == (315.0, WALL - 5.0)
    assert {"voltages", "dockSignal"} & later.keys() == set()
    assert lasting(before, told())["amperages"] == told()["amperages"]
    assert lasting({}, {}) == {}


def test_voltages_are_told_when_they_are_low_alone():
    full = VoltagesPart(age_s=0.0, battery_v=12.6, internal_v=12.0, output_v=5.1)
    assert "voltages" not in told(Telemetry(time_s=WALL, voltages=full))


def test_what_is_old_has_its_age_in_its_time_and_old_distances_are_none():
    found = told(found=received(ranges(forward=0.67), age_s=3.0), age_s=4.0)
    assert set(found["Ranges"].values()) == {-1, 0}
    assert found["Ranges"]["Forward"] == -1
    assert found["Timestamp"] == WALL - 3.0
    assert found["MPU"]["time"] == WALL - 5.0


def test_beams_that_others_saw_join_those_of_the_receiver():
    assert with_beams({}, {}, WALL) == {}
    assert with_beams({}, {"left": 1.0}, WALL)["dockSignal"] == {"time": WALL - 1.0, "left": 1, "right": 0}
    both = with_beams(told(), {"right": 0.5}, WALL)["dockSignal"]
    assert both == {"time": WALL - 0.5, "left": 1, "right": 1}


@given(st.floats() | st.none(), st.floats() | st.none(), st.sampled_from(["ok", "over_range", "invalid", "missing"]))
def test_whatever_was_measured_can_be_told(value, age_s, status):
    value = None if value in {inf, -inf} or value != value else value
    age_s = 0.0 if age_s is None or not abs(age_s) < 1e6 else age_s
    metres = None if value is None or abs(value) > 1e6 else value
    reading = Ranges(
        forward_m=metres, back_m=None, left_m=None, right_m=None, bottom_m=None, status={"forward": status}
    )
    part = AmperagesPart(age_s=0.0, left_a=value, right_a=value)
    json.dumps(told(Telemetry(time_s=WALL, amperages=part), found=received(reading, age_s)))


def test_a_client_that_drives_is_lost_once_it_is_silent():
    heart = Heartbeat(10.0, 1.5)
    assert not heart.is_lost(11.5)
    assert heart.is_lost(11.51)
    heart.beat(11.4)
    assert not heart.is_lost(12.9)
    assert heart.is_lost(12.91)
    assert heart.is_lost(nan)


def test_what_ends_by_itself_goes_on_for_a_client_that_only_began_it():
    heart = Heartbeat(10.0, 1.5, 10.0)
    assert not heart.is_lost(20.0)
    assert heart.is_lost(20.01)
    heart.beat(11.0)  # it looked once
    assert not heart.is_lost(19.0)
    heart.beat(16.0)  # and much later again
    assert not heart.is_lost(19.0)


def test_a_client_that_attends_to_what_ends_by_itself_is_lost_as_any_other():
    heart = Heartbeat(10.0, 1.5, 10.0)
    heart.beat(11.0)
    heart.beat(11.5)
    assert not heart.is_lost(13.0)
    assert heart.is_lost(13.01)


@pytest.mark.parametrize("alone_s", [0.0, 10.0])
def test_no_client_is_heard_for_ever(alone_s):
    assert Heartbeat(0.0, 1.5, alone_s).is_lost(60.0)
