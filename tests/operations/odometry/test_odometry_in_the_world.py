"""Odometry beside the truth of the simulated world: how far off it is after a walk, and that nothing seems to slip."""

from math import degrees, hypot

import pytest

from lbr.messages.attitude import AttitudeState
from lbr.messages.motors import MotorsState
from lbr.operations.odometry import OdometrySettings
from lbr.operations.odometry.reckoning import Reckoning
from lbr.simulation.engine import Engine
from lbr.simulation.settings import WorldSettings

STEP_S, TELL_STEPS = 0.02, 3
WALK = (
    (0.3, 0.3, 3.0),
    (0.2, -0.2, 1.0),
    (0.0, 0.0, 0.5),
    (0.5, 0.4, 3.0),
    (-0.3, -0.3, 2.0),
    (-0.2, 0.2, 1.5),
    (0.0, 0.0, 0.6),
)


@pytest.mark.parametrize(("attitude", "off_m", "off_deg"), [(True, 0.1, 1.0), (False, 0.25, 12.0)])
def test_a_walk_ends_near_where_odometry_says(attitude, off_m, off_deg):
    engine, reckoning = Engine(WorldSettings(walls=())), Reckoning(OdometrySettings(), "test")
    way_m, slipping, stalled, steps, turned_deg, before_deg = 0.0, 0, 0, 0, 0.0, 0.0
    for left, right, seconds in WALK:
        for _ in range(round(seconds / STEP_S)):
            engine.step(left, right, STEP_S)
            pose, steps = engine.pose(), steps + 1
            way_m += pose.speed_mps * STEP_S
            yaw_deg = degrees(pose.yaw_rad)
            turned_deg -= (yaw_deg - before_deg + 180.0) % 360.0 - 180.0
            before_deg = yaw_deg
            if attitude:
                told = AttitudeState(valid=True, epoch="a", measured_s=pose.time_s, turned_deg=turned_deg)
                reckoning.look(told)
            if steps % TELL_STEPS == 0:
                counted = dict(zip(("counts_left", "counts_right"), engine.sensed().counts, strict=True))
                state = MotorsState(left=left, right=right, armed=True, reason="", estop=False, **counted)
                reckoning.count(state, pose.time_s)
                slipping += reckoning.state().slipping
                stalled += reckoning.state().stalled
    found = reckoning.state()
    assert (slipping, stalled) == (0, 0)
    assert hypot(found.x_m - pose.x_m, found.y_m - pose.y_m) < off_m
    assert degrees(found.yaw_rad) == pytest.approx(-turned_deg, abs=off_deg)
    assert found.distance_m == pytest.approx(way_m, abs=0.05)
