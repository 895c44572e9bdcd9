"""What the robot says that it is: out of the plan that runs, for each robot that comes with lbr."""

import msgspec
import pytest

from lbr.bus import keys, session
from lbr.executive.planning import rights
from lbr.executive.service.reports import describe
from tests.support.planning import planned, shipped

ROBOTS = ("lbr", "bioloid", "uxa90")
MECANUM = """
INSERT INTO kinematics (robot, name, kind) VALUES ('lbr', 'base', 'mecanum');
INSERT INTO wheel (robot, name, motor, x_m, y_m, roller_rad, diameter_m) VALUES
    ('lbr', 'fl', 'front_left', 0.13, 0.18, -0.7854, 0.15), ('lbr', 'fr', 'front_right', 0.13, -0.18, 0.7854, 0.15),
    ('lbr', 'rl', 'rear_left', -0.13, 0.18, 0.7854, 0.15), ('lbr', 'rr', 'rear_right', -0.13, -0.18, -0.7854, 0.15);
"""


@pytest.fixture(scope="module")
def plans():
    return {name: planned(shipped(name)) for name in ROBOTS}


@pytest.mark.parametrize("name", ROBOTS)
def test_each_capability_is_described_by_what_its_kind_declares(plans, name):
    told = {one.name: one for one in describe(plans[name], ()).capabilities}
    assert told.keys() == plans[name].units.keys()
    for capability, kind in plans[name].kinds.items():
        if capability in told:
            assert told[capability].commands.keys() == kind.commands.keys()
            assert told[capability].summary == kind.summary


@pytest.mark.parametrize("name", ROBOTS)
def test_a_description_passes_in_one_message(plans, name):
    assert len(msgspec.json.encode(describe(plans[name], ()))) < session.MAX_MESSAGE_BYTES / 2


def test_a_command_says_who_may_and_whether_it_is_held(plans):
    drive = next(one for one in describe(plans["lbr"], ()).capabilities if one.name == "drive")
    assert (drive.commands["command"].role, drive.commands["command"].leased) == ("operate", True)
    assert (drive.commands["stop"].role, drive.commands["stop"].leased) == ("view", False)
    assert "power" in str(drive.commands["command"].schema)


def test_a_setpoint_is_no_stream(plans):
    drive = next(one for one in describe(plans["lbr"], ()).capabilities if one.name == "drive")
    assert set(drive.outputs) == {"state", "result"}


def test_rows_that_people_look_at_are_told(plans):
    told = describe(plans["lbr"], ({"word": "help"},))
    assert [row["name"] for row in told.ranges] == sorted(row["name"] for row in told.ranges)
    assert "forward" in {row["name"] for row in told.ranges}
    assert told.words == ({"word": "help"},)
    assert told.simulated


def test_what_serves_people_may_look_at_all_and_say_every_line_and_put_nothing(plans):
    plan = plans["uxa90"]
    allowed = rights.of_unit(plan, plan.units["web"])["web"]
    assert {"uxa90/**", keys.status("uxa90")} <= set(allowed.ask) & set(allowed.hear)
    assert {keys.console_of_pages("uxa90", role) for role in ("view", "operate", "admin")} <= set(allowed.ask)
    assert not any("command" in key or "**" in key for key in allowed.put)


def test_nothing_else_may_say_lines(plans):
    lines = {keys.console_of_pages("uxa90", role) for role in ("view", "operate", "admin")}
    plan = plans["uxa90"]
    for name in plan.units.keys() - {"web"}:
        assert not [may for may in rights.of_unit(plan, plan.units[name]).values() if lines & set(may.ask)]


def test_on_another_machine_it_has_no_such_rights(plans):
    plan = plans["uxa90"]
    web = msgspec.structs.replace(plan.units["web"], serves_people=False)
    assert "uxa90/**" not in rights.of_process(plan, web).ask


def test_a_base_says_how_it_moves_and_how_fast_by_its_rows(plans):
    told = describe(plans["lbr"], ()).base
    assert told is not None
    assert (told.capability, told.kind, told.sideways) == ("drive", "differential", False)
    assert (told.max_speed_mps > 0.0, told.max_turn_rps > 0.0) == (True, True)
    assert describe(plans["uxa90"], ()).base is None
    found = describe(planned(shipped("lbr", MECANUM)), ()).base
    assert found is not None
    assert (found.kind, found.sideways, found.max_speed_mps) == ("mecanum", True, told.max_speed_mps)
    assert found.max_turn_rps == pytest.approx(found.max_speed_mps / (0.13 + 0.18), rel=1e-3)


@pytest.mark.parametrize(("name", "cameras"), [("lbr", {"camera_front", "camera_rear"}), ("uxa90", {"camera_head"})])
def test_the_web_server_of_a_robot_with_cameras_gets_their_pictures(plans, name, cameras):
    assert "cameras" in msgspec.json.decode(plans[name].units["web"].config.settings)["faces"]
    wired = {(one.source_end, one.target_end) for one in plans[name].rows.channels}
    for camera in cameras:
        assert {((camera, "frame"), ("web", "frames")), ((camera, "state"), ("web", "cameras"))} <= wired
