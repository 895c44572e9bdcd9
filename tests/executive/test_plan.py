"""Rows to a plan: what is wrong is said at once, and an edit touches only what it touches."""

import os

import msgspec
import pytest
from msgspec.structs import replace

from lbr.capability import registry
from lbr.capability.kind import KindError, LackingError
from lbr.database.rows import CapabilityRow, ChannelRow, DeviceRow, RobotRow, RobotRows, VerbRow
from lbr.errors import InputError
from lbr.executive.planning import joining, machine, planner
from lbr.executive.planning import plan as plans
from lbr.executive.planning.plan import Change
from lbr.executive.planning.profile import Profile, load
from lbr.messages.calibration import CalibrationValue, values
from lbr.operations.attitude.compass import from_values
from lbr.operations.attitude.geometry import times
from lbr.robot import registry as robots
from lbr.simulation.settings import WorldSettings
from tests.support.packages import imported_from, package
from tests.support.planning import SITE, planned, problems, shipped

SIMULATED = Profile(robot="lbr", simulate=True)
REAL = Profile(robot="lbr")


@pytest.fixture(scope="module")
def rows() -> RobotRows:
    return shipped("lbr")


def edited(rows, table, name, **fields):
    changed = tuple(replace(row, **fields) if row.name == name else row for row in getattr(rows, table))
    return replace(rows, **{table: changed})


def with_device(rows, device):
    return replace(rows, devices=(*rows.devices, device))


@pytest.mark.parametrize("robot", ["lbr", "bioloid", "uxa90"])
def test_a_start_refuses_nothing_of_a_robot_that_ships_so_no_start_judges_it(robot):
    found = robots.find(robot)
    assert found is not None
    assert not joining.fault(found)


def test_the_shipped_robot_starts_world_drivers_then_drive(rows):
    order = list(planned(rows).units)
    assert order.index("world") < order.index("motors") < order.index("drive")
    assert order.index("ranges") < order.index("drive")


def test_the_real_robot_has_no_world_and_its_own_addresses(rows):
    plan = planned(rows, REAL)
    assert "world" not in plan.units
    assert plan.units["motors"].config.devices[0].address.startswith("/dev/")


def test_a_profile_may_name_another_address_for_a_device(rows):
    profile = Profile(robot="lbr", devices={"motor_controller": "/dev/ttyACM1"})
    assert planned(rows, profile).units["motors"].config.devices[0].address == "/dev/ttyACM1"


def test_a_profile_may_have_capabilities_share_other_processes_than_their_rows(rows):
    small = planned(rows, load("lbr-small"))
    assert small.units["imu"].process == small.units["ranges"].process == "sensors"
    assert small.units["motors"].process == planned(rows, REAL).units["motors"].process == "base"
    text = "\n".join(problems(rows, Profile(robot="lbr", processes={"web": "base", "wing": "sensors"})))
    assert "there is no capability 'wing'" in text
    assert "'web'" in text


@pytest.mark.parametrize(
    ("name", "process", "said"),
    [
        ("drive", "operations", "they may not share the process 'operations'"),
        ("web", "base", "capability 'lbr/web', process: "),
        ("world", "sensors", "has a process of its own: it is the world"),
        ("web", "motors", "'motors' is a capability; choose another name"),
    ],
)
def test_who_may_not_share_a_process_is_told_so(rows, name, process, said):
    assert said in "\n".join(problems(edited(rows, "capabilities", name, process=process)))


def kept_by_attitude(rows, profile):
    found = planned(rows, profile).units["attitude"].config.rows[CalibrationValue.TABLE].rows
    return values(msgspec.json.decode(found, type=list[CalibrationValue]))


def test_what_ships_in_simulation_is_calibrated_and_what_was_measured_goes_before_that(rows):
    world = WorldSettings().imu
    kept = from_values(kept_by_attitude(rows, load("lbr-sim")))
    assert kept.known
    measured_ut = tuple(
        a + b for a, b in zip(times(world.soft_iron, (10.0, -17.0, -40.0)), world.hard_iron_ut, strict=True)
    )
    assert kept.apply(measured_ut) == pytest.approx((10.0, -17.0, -40.0), abs=0.01)
    assert kept_by_attitude(rows, load("lbr")) == {}
    measured = (
        "INSERT INTO calibration (robot, device, name, value, measured_at)"
        " VALUES ('lbr', 'imu', 'mag_offset_x_ut', 1.0, '2026-01-01T00:00:00.000Z')"
    )
    assert kept_by_attitude(shipped("lbr", measured), load("lbr-sim")) == {"mag_offset_x_ut": 1.0}
    said = "\n".join(problems(rows, Profile(robot="lbr", calibration={"wing": {"x": 1.0}})))
    assert "'wing'" in said


def test_in_simulation_a_device_without_a_twin_keeps_its_own_address_and_the_others_get_their_twins_place(rows):
    arm = DeviceRow(name="arm", type="servo_bus", address="/dev/serial/by-id/usb-arm")
    places = {one.name: one.address for one in planned(with_device(rows, arm)).units["world"].config.devices}
    assert places["arm"] == "/dev/serial/by-id/usb-arm"
    assert places["motor_controller"] == "/nowhere/run/lbr-devices/motor_controller"
    assert places["speaker"] == "/nowhere/run/lbr-devices/speaker"


def test_a_device_more_is_told_to_the_world_and_any_other_change_of_devices_begins_it_again(rows):
    arm = DeviceRow(name="arm", type="servo_bus", address="/dev/arm")
    ahrs = DeviceRow(name="ahrs", type="riox", address="/dev/ahrs")
    one, both = with_device(rows, arm), with_device(with_device(rows, arm), ahrs)
    assert plans.difference(planned(rows), planned(one)) == Change(plug=("world",))
    assert plans.difference(planned(rows), planned(both)) == Change(plug=("world",))
    added = plans.added_devices(planned(rows).units["world"], planned(both).units["world"])
    assert {device.name for device in added} == {"arm", "ahrs"}
    assert plans.difference(planned(one), planned(rows)) == Change(restart=("world",))
    moved = with_device(rows, replace(arm, address="/dev/other"))
    assert plans.difference(planned(one), planned(moved)) == Change(restart=("world",))
    assert plans.difference(planned(rows, REAL), planned(both, REAL)) == Change()
    smaller = replace(one, capabilities=tuple(changed_world(one)))
    assert plans.difference(planned(rows), planned(smaller)) == Change(restart=("world",))


def changed_world(rows):
    for row in rows.capabilities:
        yield replace(row, settings='{"seed": 7}') if row.name == "world" else row


def test_a_twin_that_does_not_load_refuses_the_simulated_robot_that_has_it_and_no_other(rows, tmp_path):
    package(tmp_path, "no-arm", brings={"twins": {"servo_bus": "no_arm:TWIN"}}, files={})
    new = with_device(rows, DeviceRow(name="arm", type="servo_bus", address="/dev/arm"))
    with imported_from(tmp_path):
        (said,) = problems(new)
        planned(new, REAL)
        planned(rows)
    assert "lbr/arm" in said
    assert "the twin 'servo_bus' of package 'no-arm 0.1'" in said
    assert "ModuleNotFoundError" in said


def test_a_setpoint_travels_sealed_on_its_targets_key(rows):
    plan = planned(rows)
    sent = plan.units["drive"].config.outputs["setpoint"]
    taken = plan.units["motors"].config.wiring["setpoint"]
    assert [wire.key for wire in sent] == ["lbr/motors/setpoint"] == [wire.key for wire in taken]
    assert sent[0].seal == taken[0].seal != ""
    assert taken[0].source == "drive"


def test_every_problem_is_named_at_once(rows):
    bad = replace(
        rows,
        capabilities=(
            *rows.capabilities,
            CapabilityRow(name="shell", kind="os.system", settings="{}"),
            CapabilityRow(name="second", kind="roboteq", settings='{"device": "motor_controller", "watchdog_ms": 900}'),
            CapabilityRow(name="third", kind="ultrasonic_ring", settings='{"device": "motor_controller"}'),
        ),
        channels=(*rows.channels, ChannelRow(source="drive.nonsense", target="motors.setpoint")),
        verbs=(
            *rows.verbs,
            VerbRow(word="fly", pattern="/fly/{height}", target="drive.command", role="operate", help=""),
        ),
    )
    found = "\n".join(problems(bad))
    for words in (
        "capability 'lbr/shell', kind: 'os.system' is not a kind's name",
        "capability 'lbr/second', settings: watchdog_ms is at least 50 and at most 250, not 900",
        "capability 'lbr/third', settings: device: device 'motor_controller' is of type 'roboteq'",
        "channel 'lbr/drive.nonsense/motors.setpoint', source: 'drive' has no output 'nonsense'",
        "verb 'lbr/fly//fly/{height}', pattern: drive.command has no field 'height'",
    ):
        assert words in found


@pytest.mark.parametrize(
    ("channel", "complaint"),
    [
        (
            ChannelRow(source="ranges.readings", target="motors.setpoint"),
            "sends Ranges, and motors.setpoint takes Motor",
        ),
        (
            ChannelRow(source="motors.state", target="drive.tail"),
            "'drive' has no input 'tail'; it has attitude, motors, odometry, ranges",
        ),
    ],
)
def test_a_channel_that_cannot_be_is_explained(rows, channel, complaint):
    assert complaint in "\n".join(problems(replace(rows, channels=(*rows.channels, channel))))


def test_a_setpoint_has_one_writer(rows, wording):
    other = CapabilityRow(name="drive2", kind="drive", settings="{}")
    channel = ChannelRow(source="drive2.setpoint", target="motors.setpoint")
    twice = replace(rows, capabilities=(*rows.capabilities, other), channels=(*rows.channels, channel))
    wording(*problems(twice))


def test_two_capabilities_cannot_own_one_device(rows):
    twin = CapabilityRow(name="motors2", kind="roboteq", settings='{"device": "motor_controller"}')
    assert "already belongs to" in "\n".join(problems(replace(rows, capabilities=(*rows.capabilities, twin))))


def test_the_executives_name_is_taken(rows):
    more = (*rows.capabilities, CapabilityRow(name="executive", kind="drive"))
    assert "choose another" in "\n".join(problems(replace(rows, capabilities=more)))


def test_a_profile_that_names_nothing_is_refused(rows):
    assert "there is no capability 'wings'" in "\n".join(problems(rows, Profile(robot="lbr", without=("wings",))))
    said = "\n".join(problems(rows, Profile(robot="lbr", devices={"wing": "/dev/x"})))
    assert "there is no device row 'wing' (there is: " in said
    assert "motor_controller" in said


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_profile_that_an_editor_has_marked_is_read(tmp_path, encoding):
    path = tmp_path / "mine.toml"
    path.write_text('robot = "lbr"\ndescription = "ở nhà"\n', encoding=encoding, newline="\r\n")
    assert load(str(path)) == Profile(robot="lbr", description="ở nhà")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("devices = {imu = 'usb:', speaker = 5}", r"Expected `str`, got `int` - at `\$\.devices\.speaker`"),
        ("hosts = {pc = ['dance'], attic = 'ranges'}", r"Expected `array`, got `str` - at `\$\.hosts\.attic`"),
        ("hosts = {attic = ['ranges', 7]}", r"Expected `str`, got `int` - at `\$\.hosts\.attic\[1\]`"),
    ],
)
def test_a_profile_of_a_wrong_type_names_the_key(tmp_path, line, said):
    path = tmp_path / "mine.toml"
    path.write_text(f"robot = 'lbr'\n{line}\n")
    with pytest.raises(InputError, match=said):
        load(str(path))


def test_a_profile_that_is_not_there_is_told_with_what_may_be_meant():
    with pytest.raises(InputError, match=r"did you mean .*lbr-sim.* robot of your own rows write a \.toml file"):
        load("lbrsim")


def test_a_profile_that_is_no_text_says_so(tmp_path, wording):
    path = tmp_path / "mine.toml"
    path.write_bytes(b"PK\x03\x04\xbf\xff")
    with wording.of(InputError):
        load(str(path))


def test_no_edit_no_change(rows):
    assert plans.difference(planned(rows), planned(rows)) == Change()


def test_settings_restart_their_capability_alone(rows):
    new = edited(rows, "capabilities", "ranges", settings='{"device": "range_board", "timeout_s": 0.7}')
    assert plans.difference(planned(rows), planned(new)) == Change(restart=("ranges",))


def test_a_new_word_touches_no_process(rows):
    verb = VerbRow(
        word="creep", pattern="creep", target="drive.command", role="operate", help="", payload={"power": 0.1}
    )
    assert plans.difference(planned(rows), planned(replace(rows, verbs=(*rows.verbs, verb)))) == Change()


def test_a_device_restarts_its_driver_and_in_simulation_its_world(rows):
    new = replace(
        rows,
        devices=tuple(
            DeviceRow(name=d.name, type=d.type, address="/dev/other", settings=d.settings)
            if d.name == "range_board"
            else d
            for d in rows.devices
        ),
    )
    assert plans.difference(planned(rows, REAL), planned(new, REAL)) == Change(restart=("ranges",))


def test_disabling_stops_and_a_cut_wire_rewires_its_reader(rows):
    new = edited(rows, "capabilities", "ranges", enabled=False)
    change = plans.difference(planned(rows), planned(new))
    assert change.stop == ("ranges",)
    wired = {row.target_end[0] for row in rows.channels if row.source_end[0] == "ranges"}
    assert set(change.restart) == {*wired, "behaviour", "beacon"}, (
        "its kind wires itself to whatever tells of distances"
    )
    assert "drive" in change.restart


def test_rows_of_an_unknown_robot_make_an_empty_plan():
    plan = planned(RobotRows(robot=RobotRow(name="lbr")), REAL)
    assert plan.units == {}


def test_spaces_and_lines_in_settings_restart_nothing(rows):
    motors = next(row for row in rows.capabilities if row.name == "motors")
    new = edited(rows, "capabilities", "motors", settings=motors.settings.replace(":", " :\n "))
    assert plans.difference(planned(rows), planned(new)) == Change()
    assert b"\n" not in bytes(planned(new).units["motors"].config.settings)


def test_a_new_listener_costs_its_publisher_nothing(rows):
    ear = CapabilityRow(name="ear", kind="exec", settings='{"argv": ["/bin/cat"], "inputs": ["pose"]}')
    wire = ChannelRow(source="world.pose", target="ear.pose")
    new = replace(rows, capabilities=(*rows.capabilities, ear), channels=(*rows.channels, wire))
    assert plans.difference(planned(rows), planned(new)) == Change(start=("ear",))


def test_a_robots_row_opens_a_door_to_other_machines(rows, wording):
    opened = edited(rows, "capabilities", "lan", enabled=True)
    change = plans.difference(planned(rows), planned(opened))
    assert change.start == ("lan",)
    clear = edited(rows, "capabilities", "lan", enabled=True, settings='{"listen": ["tcp/0.0.0.0:7447"]}')
    wording(*problems(clear))


@pytest.mark.parametrize("settings", [{"no_such": 1}, {"faults": {"drop": 2}}, {"left_channel": 3}])
def test_what_a_device_row_sets_for_its_twin_is_validated(rows, settings):
    (text,) = problems(edited(rows, "devices", "motor_controller", settings=settings))
    assert text.startswith("device 'lbr/motor_controller', settings: ")


def test_there_is_a_log_of_each_part_and_of_nothing_else(rows):
    plan = planned(rows)
    assert plan.log("motors") == plan.units["motors"].log
    assert plan.log("executive") == "lbr-executive.log"
    assert not plan.log("nothing")


def test_a_verb_of_the_executives_has_only_the_fields_it_takes(rows):
    (text,) = problems(edited_verb(rows, "f", target="executive.report", payload={"nothing": 1}))
    assert "executive.report has no field 'nothing'; it has name" in text


def edited_verb(rows, word, **fields):
    return replace(rows, verbs=tuple(replace(v, **fields) if v.word == word else v for v in rows.verbs))


def test_what_a_kind_wires_by_itself_goes_to_every_port_of_that_type_and_a_row_goes_before(rows):
    made = planned(rows).units["behaviour"].config
    assert {wire.source for wire in made.wiring["ranges"]} == {"ranges"}
    assert {wire.source for wire in made.wiring["battery"]} == {"battery"}
    assert set(made.requests["move"]) == set(made.requests["halt"]) == {"drive"}
    assert "joints" not in made.wiring
    own = ChannelRow(source="behaviour.halt", target="dance.stop")
    made = planned(replace(rows, channels=(*rows.channels, own))).units["behaviour"].config
    assert set(made.requests["halt"]) == {"dance"}


def test_rows_that_a_kind_follows_reach_it_without_a_restart(rows):
    edit = "UPDATE behaviour SET help = 'another' WHERE name = 'patrol'"
    old, new = planned(rows), planned(shipped("lbr", edit))
    assert plans.difference(old, new) == Change(follow=("behaviour",))
    told = plans.changed_rows(old.units["behaviour"], new.units["behaviour"])
    assert told is not None
    assert set(told.rows) == {"behaviour"}
    assert told.rows["behaviour"].count('"another"') == 1
    assert told.gone == {"behaviour": "[]"}


def test_a_pipe_in_place_of_a_launch_profile_is_refused_and_not_waited_for(tmp_path):
    pipe = tmp_path / "robot.toml"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match=r"launch profile .*robot\.toml is no file"):
        load(str(pipe))


def lacking(name, home):
    """Find kinds where a broken component may have those that are not there."""
    try:
        return registry.find(name, home)
    except KindError as err:
        raise LackingError(f"{err}; it may be of a broken component") from err


def test_what_a_broken_component_may_have_is_left_out_at_a_start_and_refused_where_it_is_new(rows):
    speechless = edited(rows, "capabilities", "speech", kind="spech")
    plan, found = planner.make(speechless, SIMULATED, SITE, find=lacking)
    assert not found
    assert "speech" not in plan.units
    assert planner.make(speechless, SIMULATED, SITE, find=lacking, before=plan.rows)[1] == ()
    for misspelt in (
        edited(speechless, "capabilities", "box", kind="boks"),
        replace(speechless, capabilities=(*speechless.capabilities, CapabilityRow(name="again", kind="spech"))),
    ):
        made, found = planner.make(misspelt, SIMULATED, SITE, find=lacking, before=plan.rows)
        assert made is None
        assert [(problem.table, problem.column) for problem in found] == [("capability", "kind")]


def test_tokens_go_on_without_a_capability_that_was_left_out(rows):
    plan, _ = planner.make(edited(rows, "capabilities", "speech", kind="spech"), SIMULATED, SITE, find=lacking)
    again = planner.with_tokens(plan, (), SIMULATED, SITE, machine.ANY)
    assert again.units.keys() == plan.units.keys()
