"""The charging dock: contacts, current, beams, and what the battery makes of it."""

from itertools import pairwise
from math import cos, pi, radians, sin

import pytest

from lbr.simulation.battery import BatteryState
from lbr.simulation.engine import Engine
from lbr.simulation.settings import Battery, BoxSettings, Dock, StartPose, WorldSettings

DOCK = Dock(x_m=-1.0, y_m=0.0)
BACK_M = 0.215


def at(x, y=0.0, yaw=0.0, walls=(), **settings):
    start = StartPose(x_m=DOCK.x_m + BACK_M + x, y_m=y, yaw_rad=yaw)
    return Engine(WorldSettings(walls=walls, dock=DOCK, start=start, **settings))


@pytest.mark.parametrize(
    ("x", "y", "yaw", "touches"),
    [
        (0.0, 0.0, 0.0, True),
        (0.015, 0.02, 0.0, True),
        (0.03, 0.0, 0.0, False),
        (0.0, 0.05, 0.0, False),
        (0.0, 0.0, 0.1, True),
        (0.01, 0.0, 0.4, False),
        (0.0, 0.0, pi, False),
    ],
)
def test_it_charges_while_both_contacts_touch(x, y, yaw, touches):
    engine = at(x, y, yaw)
    assert engine.sensed().charging is engine.pose().charging is touches
    assert ("power" in engine.sensed().beams) is touches


def test_backing_against_it_charges_and_is_no_collision():
    engine = at(0.5, battery=Battery(charge=0.5))
    assert not engine.pose().charging
    before_v = engine.sensed().battery_v
    for _ in range(100):
        engine.step(-0.25, -0.25, 0.04)
    engine.step(0.0, 0.0, 1.0)
    sensed = engine.sensed()
    assert sensed.charging
    assert sensed.charging_a == pytest.approx(3.0)
    assert sensed.battery_v > before_v + 0.1
    assert not engine.pose().touching
    for _ in range(50):
        engine.step(0.3, 0.3, 0.04)
    assert not engine.sensed().charging
    assert engine.sensed().charging_a == 0.0


def test_on_the_way_to_it_the_sensor_never_reads_nearer_than_the_rules_stop():
    for gap in (0.0, 0.05, 0.2, 0.4, 0.6):
        engine = at(gap, walls=(BoxSettings(name="wall", x_m=-1.41, y_m=0.0, length_m=0.1, width_m=4.0),))
        assert engine.ranges_m["back"] > 0.32


def beams(degrees, far_m=1.5, away=0.0, walls=()):
    """Return what a robot sees whose back is at this bearing from the dock, `away` from looking straight at it."""
    bearing = radians(degrees)
    back = (DOCK.x_m - 0.05 + far_m * cos(bearing), far_m * sin(bearing))
    yaw = bearing + radians(away)
    start = StartPose(x_m=back[0] + BACK_M * cos(yaw), y_m=back[1] + BACK_M * sin(yaw), yaw_rad=yaw)
    return set(Engine(WorldSettings(walls=walls, dock=DOCK, start=start)).sensed().beams)


@pytest.mark.parametrize(
    ("degrees", "seen"),
    [(0, {"left", "right"}), (2, {"left", "right"}), (10, {"left"}), (-10, {"right"}), (30, set()), (-30, set())],
)
def test_left_and_right_beam_overlap_in_the_middle(degrees, seen):
    assert beams(degrees) == seen


def test_beams_end_and_the_receiver_looks_back_and_sees_through_nothing():
    assert beams(0, far_m=2.9)
    assert not beams(0, far_m=3.1)
    assert beams(0, away=50)
    assert not beams(0, away=70)
    assert not beams(0, away=180)
    screen = BoxSettings(name="screen", x_m=-0.5, y_m=0.0, length_m=0.05, width_m=0.5)
    assert not beams(0, walls=(screen,))
    assert beams(0, walls=(BoxSettings(name="low", x_m=-0.5, y_m=0.0, length_m=0.05, width_m=0.5, height_m=0.1),))


def test_a_robot_without_dock_never_charges():
    sensed = Engine(WorldSettings(walls=(), dock=None)).sensed()
    assert (sensed.charging, sensed.charging_a, sensed.beams) == (False, 0.0, frozenset())


def test_the_voltage_rises_slowly_to_what_the_charger_gives_and_falls_back():
    battery = BatteryState(Battery(charge=0.8))
    seen = []
    for _ in range(600):
        battery.draw(0.0, 1.0, 3.0)
        seen.append(battery.voltage_v)
    assert all(later >= sooner - 1e-9 for sooner, later in pairwise(seen))
    assert seen[5] < 13.0 < seen[119] < seen[-1] == pytest.approx(13.8, abs=0.01)
    assert battery.charge > 0.8
    for _ in range(600):
        battery.draw(0.0, 1.0)
    assert 12.3 < battery.voltage_v < 12.6


def test_a_full_battery_takes_no_more_than_it_needs():
    battery = BatteryState(Battery(charge=0.999))
    for _ in range(36_000):
        battery.draw(0.0, 1.0, 3.0)
    assert battery.charge == pytest.approx(1.0, abs=1e-3)
    assert battery.charging_a == pytest.approx(1.5, abs=0.05)


@pytest.mark.parametrize(("charge", "volts"), [(1.0, 12.7), (0.9, 12.6), (0.55, 12.1), (0.05, 10.9), (0.0, 10.5)])
def test_at_rest_the_voltage_tells_the_charge(charge, volts):
    assert BatteryState(Battery(charge=charge, idle_a=0.0)).voltage_v == pytest.approx(volts)


def test_what_leaves_the_battery_is_counted():
    battery = BatteryState(Battery(capacity_ah=1.0, idle_a=0.0))
    for _ in range(1800):
        battery.draw(1.0, 1.0)
    assert battery.charge == pytest.approx(0.5)
    for _ in range(7200):
        battery.draw(1.0, 1.0)
    assert battery.charge == 0.0
    assert battery.voltage_v == pytest.approx(10.45)
