"""Each cause alone, put into a healthy robot: it is named first, with its code, and hardware is not blamed for what is not."""

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from lbr.errors import InputError
from lbr.messages.codes import MEANINGS
from lbr.messages.system import Event
from lbr.messages.why import HARDWARE
from lbr.why import rendering
from lbr.why.chain import explain
from lbr.why.snapshot import Facts, Snapshot
from tests.why import healthy
from tests.why.healthy import edited, with_estop, with_event, with_joint, with_said, with_unit

Broken = Callable[[Snapshot], Snapshot]
MOTORS_CABLE = "/dev/ttyACM0 went away"
GRIPPED = {"phase": "waiting", "pid": None, "uptime_s": None}


@pytest.fixture(scope="module")
def all_rows(tmp_path_factory):
    return healthy.robot_rows(tmp_path_factory.mktemp("rows"))


@pytest.fixture(scope="module")
def robots(all_rows) -> dict[str, Snapshot]:
    return {name: healthy.snapshot(healthy.facts_of(rows)) for name, rows in all_rows.items()}


def down(name: str, why: str) -> Broken:
    return lambda now: with_unit(now, name, **GRIPPED, reason=why, last_end=why, code="failed", end_code="failed")


def gone(name: str, why: str, code: str = "unreachable") -> Broken:
    return lambda now: with_unit(now, name, phase="degraded", reason=why, code=code)


def without_motors(now: Snapshot) -> Snapshot:
    """The driver's own state says so too, as its does when the line is away."""
    return with_said(gone("motors", MOTORS_CABLE)(now), "motors/state", armed=False, reason=MOTORS_CABLE)


def drive_says(**fields) -> Broken:
    return lambda now: with_said(now, "drive/state", **fields)


CAUSES: dict[str, tuple[str, str, Broken, tuple[str, str, str]]] = {
    "drive crashed": ("lbr", "drive", down("drive", "crashed: killed by signal 9"), ("process", "drive", "failed")),
    "drive failed for good": (
        "lbr", "drive",
        lambda now: with_unit(now, "drive", phase="failed", pid=None, reason="crashed: 6 ends within 30 s", code="failed"),
        ("process", "drive", "failed"),
    ),
    "drive is starting": (
        "lbr", "drive", lambda now: with_unit(now, "drive", phase="starting"), ("process", "drive", "not_ready"),
    ),
    "motors crashed": ("lbr", "drive", down("motors", "crashed: killed by signal 9"), ("process", "motors", "failed")),
    "motors hung": (
        "lbr", "drive",
        lambda now: with_unit(now, "motors", **GRIPPED, reason="hung: silent for 0.8 s", end_code="timeout", last_end="hung"),
        ("process", "motors", "timeout"),
    ),
    "ranges crashed": ("lbr", "drive", down("ranges", "crashed: exit code 1"), ("process", "ranges", "failed")),
    "world crashed": (
        "lbr", "drive", lambda now: without_motors(down("world", "crashed: exit code 1")(now)), ("process", "world", "failed"),
    ),
    "motors cable": ("lbr", "drive", without_motors, ("line", "motor_controller", "unreachable")),
    "motors cable, asked for the motors": ("lbr", "motors", without_motors, ("line", "motor_controller", "unreachable")),
    "motors cable, asked for the device": (
        "lbr", "motor_controller", without_motors, ("line", "motor_controller", "unreachable"),
    ),
    "no right to the port": (
        "lbr", "drive", gone("motors", "device 'motor_controller' at /dev/ttyACM0 may not be opened by this user", "rights"),
        ("port", "motor_controller", "rights"),
    ),
    "a port that is busy": (
        "lbr", "drive", gone("ranges", "device 'range_board' at /dev/ttyACM1 is busy; stop the other program", "busy"),
        ("port", "range_board", "busy"),
    ),
    "ranges cable": (
        "lbr", "drive", gone("ranges", "device 'range_board' is silent for 2 s; check its cable"),
        ("line", "range_board", "unreachable"),
    ),
    "imu cable": (
        "lbr", "attitude", gone("imu", "device 'imu' does not answer; check its wiring"), ("line", "imu", "unreachable"),
    ),
    "camera cable": (
        "lbr", "camera_front", gone("camera_front", "device 'front_camera' is missing; plug it in"),
        ("line", "front_camera", "unreachable"),
    ),
    "dock receiver": (
        "lbr", "dock", gone("dock", "device 'dock_receiver' is missing; plug it in"), ("line", "dock_receiver", "unreachable"),
    ),
    "emergency stop": (
        "lbr", "drive", lambda now: with_estop(now, reason="dog", source="console@a:1"), ("estop", "estop", "estop"),
    ),
    "emergency stop, motors not armed by it": (
        "lbr", "drive",
        lambda now: with_said(with_estop(now, reason="dog"), "motors/state", armed=False, estop=True, reason="emergency stop: dog"),
        ("estop", "estop", "estop"),
    ),
    "emergency stop of a humanoid": (
        "bioloid", "left_knee", lambda now: with_estop(now, reason="", source="web:anna"), ("estop", "estop", "estop"),
    ),
    "another drives": (
        "lbr", "drive", drive_says(moving=True, power=0.3, holder="web:anna", code=""), ("holder", "drive", "held"),
    ),
    "stopped by a wall": (
        "lbr", "drive",
        drive_says(holder="console@a:1", limited_by="forward", code="obstacle", reason="stopped by forward 0.24 m"),
        ("rule", "drive", "obstacle"),
    ),
    "ended by a wall": (
        "lbr", "drive", drive_says(code="obstacle", reason="blocked for 1 s by forward"), ("last", "drive", "obstacle"),
    ),
    "lapsed": ("lbr", "drive", drive_says(code="lapsed", reason="not renewed"), ("last", "drive", "lapsed")),
    "stuck": ("lbr", "drive", drive_says(code="stuck", reason="the wheels stand"), ("last", "drive", "stuck")),
    "not fresh": (
        "lbr", "drive", lambda now: with_said(now, "ranges/readings", age_s=9.0), ("input", "ranges", "stale_sensor"),
    ),
    "a sensor reads nothing": (
        "lbr", "drive", lambda now: with_said(now, "ranges/readings", forward_m=None, status={"forward": "missing"}),
        ("reading", "forward", "stale_sensor"),
    ),
    "a wall is near": (
        "lbr", "drive", lambda now: with_said(now, "ranges/readings", forward_m=0.2), ("reading", "forward", "obstacle"),
    ),
    "motors whose controller never sent a byte": (
        "lbr", "drive", lambda now: with_said(now, "motors/state", heard=False), ("line", "motor_controller", "unreachable"),
    ),
    "servos that never sent a byte": (
        "bioloid", "joints", lambda now: with_said(now, "servos/state", heard=False), ("line", "servo_bus", "unreachable"),
    ),
    "motors not armed": (
        "lbr", "drive", lambda now: with_said(now, "motors/state", armed=False, reason="waiting for a zero setpoint"),
        ("arming", "motors", "not_armed"),
    ),
    "setpoints that ceased": (
        "lbr", "drive",
        lambda now: with_said(now, "motors/state", armed=False, reason="no setpoint within 0.1 s", code="no_setpoint"),
        ("arming", "motors", "no_setpoint"),
    ),
    "short circuit": (
        "lbr", "drive",
        lambda now: with_said(now, "motors/state", armed=False, faults=["short_circuit"], reason="the controller reports short_circuit"),
        ("fault", "motor_controller", "latched"),
    ),
    "the driver tells the fault": (
        "lbr", "drive", gone("motors", "the controller reports overheat", "latched"), ("fault", "motor_controller", "latched"),
    ),
    "no setpoint": (
        "lbr", "drive", lambda now: with_unit(now, "drive", rates_hz={"setpoint": 0.0}), ("setpoint", "drive", "failed"),
    ),
    "role": ("lbr", "drive", lambda now: replace(now, role="view"), ("asker", "lbr why@here:1", "role")),
    "started again": (
        "lbr", "drive",
        lambda now: with_unit(now, "motors", restarts=1, uptime_s=3.0, last_end="crashed: killed by signal 9", end_code="failed"),
        ("process", "motors", "failed"),
    ),
    "busy machine": (
        "lbr", "drive", lambda now: with_event(now, "too_busy", "machine", 5.0, "this machine is too busy"),
        ("machine", "machine", "busy"),
    ),
    "an edit refused": (
        "lbr", "drive",
        lambda now: replace(now, status=replace(now.status, problems=("capability lbr/drive: bad",), problem_codes=("bad_value",))),
        ("rows", "rows", "bad_value"),
    ),
    "camera off": (
        "lbr", "camera_rear", lambda now: with_said(now, "camera_rear/state", on=False, phase="off"), ("switch", "camera_rear", "off"),
    ),
    "camera off, by its short name": (
        "lbr", "rear", lambda now: with_said(now, "camera_rear/state", on=False, phase="off"), ("switch", "camera_rear", "off"),
    ),
    "camera slow": (
        "lbr", "camera_front", lambda now: with_unit(now, "camera_front", rates_hz={"frame": 3.0}), ("rate", "camera_front", "timeout"),
    ),
    "camera gives nothing": (
        "lbr", "camera_front", lambda now: with_unit(now, "camera_front", rates_hz={"frame": 0.0}), ("rate", "camera_front", "timeout"),
    ),
    "camera lost": (
        "lbr", "camera_front",
        lambda now: with_said(now, "camera_front/state", phase="lost", reason="no picture has come"),
        ("line", "front_camera", "unreachable"),
    ),
    "no beam": (
        "lbr", "dock",
        lambda now: with_said(now, "dock/signal", left=False, right=False, left_age_s=None, right_age_s=None),
        ("reading", "dock", "stale_sensor"),
    ),
    "attitude not valid": (
        "lbr", "attitude", lambda now: with_said(now, "attitude/state", valid=False, reason="the robot moves"),
        ("reading", "attitude", "stale_sensor"),
    ),
    "torque off": (
        "bioloid", "joints",
        lambda now: with_said(
            now, "joints/state", joints={name: {**one, "torque": 0.0} for name, one in now.messages["joints/state"].message["joints"].items()}
        ),
        ("torque", "joints", "no_torque"),
    ),
    "one joint without torque": (
        "bioloid", "left_knee", lambda now: with_joint(now, "left_knee", torque=0.0), ("torque", "left_knee", "no_torque"),
    ),
    "one joint without torque, asked for all": (
        "bioloid", "joints", lambda now: with_joint(now, "left_knee", torque=0.0), ("torque", "joints", "no_torque"),
    ),
    "overload": (
        "bioloid", "left_knee", lambda now: with_joint(now, "left_knee", torque=0.0, latched=["overload"]),
        ("fault", "left_knee", "latched"),
    ),
    "too hot": (
        "bioloid", "left_knee", lambda now: with_joint(now, "left_knee", faults=["overheating"]), ("fault", "left_knee", "failed"),
    ),
    "a servo's cable": (
        "bioloid", "left_knee",
        lambda now: with_joint(
            gone("servos", "cannot be used: left_knee (servo 13)")(now), "left_knee", position_rad=None, torque=None, reason="silent"
        ),
        ("line", "left_knee", "unreachable"),
    ),
    "many servos without power": (
        "bioloid", "left_knee",
        lambda now: with_joint(with_joint(now, "left_knee", position_rad=None), "right_knee", position_rad=None),
        ("power", "left_knee", "unreachable"),
    ),
    "a place not believed": (
        "uxa90", "left_knee", lambda now: with_joint(now, "left_knee", trusted=False, position_rad=None),
        ("reading", "left_knee", "stale_sensor"),
    ),
    "at its limit": (
        "bioloid", "left_knee",
        lambda now: with_joint(now, "left_knee", position_rad=next(one.upper_rad for one in now.facts.joints if one.name == "left_knee")),
        ("limit", "left_knee", "limit"),
    ),
    "servo bus": (
        "bioloid", "left_knee",
        lambda now: with_said(
            gone("servos", "the servo line /dev/ttyACM0 went away; check the adapter's cable and power")(now),
            "servos/state", armed=False, phase="released",
        ),
        ("line", "servo_bus", "unreachable"),
    ),
    "servos crashed": ("bioloid", "left_knee", down("servos", "crashed: killed by signal 9"), ("process", "servos", "failed")),
    "joints crashed": ("bioloid", "left_knee", down("joints", "crashed: killed by signal 9"), ("process", "joints", "failed")),
    "motions need joints": ("bioloid", "motions", down("joints", "crashed: exit code 1"), ("process", "joints", "failed")),
    "another moves the joints": (
        "bioloid", "left_knee", lambda now: with_said(now, "joints/state", moving=True, holder="motions", code=""),
        ("holder", "joints", "held"),
    ),
    "the mover was lost": (
        "bioloid", "joints", lambda now: with_said(now, "joints/state", phase="holding"), ("holder", "joints", "holder_gone"),
    ),
    "the controller plays": (
        "uxa90", "left_knee", lambda now: with_said(now, "servos/state", mode="remote"), ("arming", "servos", "not_possible"),
    ),
    "the robot shuts down": (
        "bioloid", "power", lambda now: with_said(now, "power/state", phase="countdown", remaining_s=20.0, reason="9.8 V"),
        ("power", "power", "shutting_down"),
    ),
    "the relay is off": ("bioloid", "ups", lambda now: with_said(now, "ups/state", relay=False), ("power", "ups", "off")),
    "the relay is off, asked for a joint": (
        "bioloid", "left_knee", lambda now: with_said(now, "ups/state", relay=False), ("power", "ups", "off"),
    ),
    "head camera off": (
        "uxa90", "tracking", lambda now: with_said(now, "camera_head/state", on=False, phase="off"), ("switch", "camera_head", "off"),
    ),
    "the executive hangs": (
        "lbr", "drive", lambda now: replace(now, executive="silent", status=None, messages={}), ("executive", "executive", "unreachable"),
    ),
    "the robot does not run": (
        "lbr", "drive", lambda now: replace(now, executive="down", status=None, messages={}), ("executive", "executive", "unreachable"),
    ),
}  # fmt: skip
NOT_HARDWARE = {name for name, (*_, (link, _about, _code)) in CAUSES.items() if link not in HARDWARE}


def told(now: Snapshot, part: str) -> tuple[str, str, str]:
    chain = explain(now, part)
    assert chain.first is not None, rendering.lines(chain)
    one = chain.links[chain.first]
    assert (chain.text, chain.code) == (one.text, one.code)
    assert "" not in (chain.text, chain.do), rendering.lines(chain)
    assert "\n" not in chain.text
    assert chain.code in MEANINGS
    return one.name, one.about, one.code


@pytest.mark.parametrize("cause", CAUSES)
def test_a_cause_alone_is_named_first_with_its_code_and_what_to_type(robots, cause):
    robot, part, broken, expected = CAUSES[cause]
    assert told(broken(robots[robot]), part) == expected


@pytest.mark.parametrize(
    ("robot", "part"),
    [("lbr", "drive"), ("lbr", "camera_front"), ("lbr", "dock"), ("lbr", ""), ("bioloid", "left_knee"), ("uxa90", "joints"), ("bioloid", "")],
)  # fmt: skip
def test_with_nothing_wrong_it_says_so_and_shows_the_chain_with_ages(robots, robot, part):
    chain = explain(robots[robot], part)
    assert (chain.state, chain.first) == ("ok", None), rendering.lines(chain)
    assert rendering.lines(chain)[0].startswith("Nothing is wrong: ")
    assert ("it waits for a command" in chain.text) == any(one.name == "last" for one in chain.links)
    assert len(rendering.lines(chain)) == 1
    assert len(rendering.lines(chain, verbose=True)) == 1 + len(chain.links)
    assert {one.state for one in chain.links} == {"ok"}
    assert any(one.age_s is not None for one in chain.links)


ROWS: dict[str, tuple[str, str, str, dict, tuple[str, str, str]]] = {
    "what others need, of the whole robot": ("capabilities", "drive", "", {"enabled": False}, ("row", "drive", "off")),
    "drive": ("capabilities", "drive", "drive", {"enabled": False}, ("row", "drive", "off")),
    "motors": ("capabilities", "motors", "drive", {"enabled": False}, ("row", "motors", "off")),
    "ranges": ("capabilities", "ranges", "drive", {"enabled": False}, ("row", "ranges", "off")),
    "camera": ("capabilities", "camera_front", "camera_front", {"enabled": False}, ("row", "camera_front", "off")),
    "setpoint": (
        "channels", "drive.setpoint > motors.setpoint", "drive", {"enabled": False}, ("wire", "motors", "wiring"),
    ),
    "readings": (
        "channels", "ranges.readings > drive.ranges", "drive", {"enabled": False}, ("wire", "drive", "wiring"),
    ),
    "readings seldom": (
        "channels", "ranges.readings > drive.ranges", "drive", {"rate_hz": 2.0}, ("wire", "drive", "wiring"),
    ),
    "attitude seldom": (
        "channels", "attitude.state > drive.attitude", "drive", {"rate_hz": 4.0}, ("wire", "drive", "wiring"),
    ),
    "a program": ("external_commands", "autodock", "autodock", {"enabled": False}, ("row", "autodock", "off")),
}  # fmt: skip


@pytest.mark.parametrize("cause", ROWS)
def test_a_row_that_holds_is_named_and_how_to_correct_it(all_rows, cause):
    table, row, part, change, expected = ROWS[cause]
    now = healthy.snapshot(healthy.facts_of(edited(all_rows["lbr"], table, row, **change)))
    assert told(now, part) == expected
    assert explain(now, part).do.startswith('sqlite3 ~/.lbr/robot.db "UPDATE ')


def test_a_part_that_is_missing_in_the_rows_is_told_with_what_may_be_meant(robots):
    with pytest.raises(InputError, match="there is no part 'left_kne'; did you mean left_knee") as err:
        explain(robots["bioloid"], "left_kne")
    assert err.value.code == "unknown_name"


def test_what_the_profile_leaves_out_is_told_who_asks_for_it_alone(all_rows):
    now = healthy.snapshot(healthy.facts_of(all_rows["lbr"], without=("beacon", "dance")))
    assert explain(now).state == "ok"
    assert told(now, "beacon") == ("row", "beacon", "off")


@pytest.mark.parametrize("word", ["t", "/t/30", "/twist/0.1/0/0"])
def test_a_word_of_the_console_is_explained_by_what_it_asks(robots, word):
    now = with_said(robots["lbr"], "drive/state", holder="page", code="held", reason="page drives")
    assert explain(now, word).links[1].text == f"'{word.strip('/').partition('/')[0]}' asks 'drive'"
    assert told(now, word) == told(now, "drive")


def test_a_word_that_the_robot_itself_answers_holds_nothing(robots):
    assert explain(robots["lbr"], "pair").state == "ok"


def test_rows_that_make_no_robot_are_told_when_nothing_runs():
    now = Snapshot(facts=Facts(robot="lbr", problems=("capability lbr/drive: kind",)), executive="down")
    chain = explain(now, "")
    assert [one.name for one in chain.links if one.state == "held"] == ["executive", "rows"]
    assert chain.source == "rows"


@pytest.mark.parametrize(
    ("start", "shutdown", "code", "words"),
    [
        ("", "", "unreachable", "never started"),
        ("2027-01-15T07:00:00Z", "2027-01-15T07:59:00Z", "shutting_down", "was shut down"),
        ("2027-01-15T07:59:30Z", "2027-01-15T07:00:00Z", "unreachable", "was killed"),
    ],
)
def test_how_a_robot_came_to_its_end_is_told_from_its_row(robots, start, shutdown, code, words):
    of = replace(robots["lbr"].facts, last_start=start, last_shutdown=shutdown, latched=True, latched_reason="dog")
    now = Snapshot(facts=of, executive="down", wall_ns=healthy.WALL_NS)
    chain = explain(now, "drive")
    assert (chain.code, words in chain.text) == (code, True), chain.text
    assert chain.since_s == (60.0 if code == "shutting_down" else None)
    assert [one.code for one in chain.links if one.name == "estop"] == ["estop"]


def test_what_only_some_motion_needs_does_not_hold_all_of_it(robots):
    chain = explain(gone("imu", "device 'imu' does not answer; check its wiring")(robots["lbr"]), "drive")
    assert (chain.state, chain.code) == ("doubt", "unreachable")
    other = explain(with_joint(robots["bioloid"], "left_knee", torque=0.0, latched=["overload"]), "right_knee")
    assert other.state == "ok", rendering.lines(other)


def test_a_robot_that_is_not_before_its_dock_is_well_until_its_dock_is_asked_about(robots):
    now = with_said(robots["lbr"], "dock/signal", left=False, right=False, left_age_s=None, right_age_s=None)
    assert explain(now, "").state == "ok"
    assert any("no beam" in link.text for link in explain(now, "").links)
    assert explain(now, "beacon").code == "stale_sensor"


@pytest.fixture
def with_teleop(all_rows) -> Snapshot:
    return healthy.snapshot(healthy.facts_of(edited(all_rows["lbr"], "capabilities", "teleop", enabled=True)))


def test_a_gamepad_that_moves_nothing_says_why_not_and_no_dock_is_blamed(with_teleop, wording):
    now = with_said(with_teleop, "dock/signal", left=False, right=False, left_age_s=None, right_age_s=None)
    idle = with_said(
        now, "teleop/state", driving=False, dead_man=False, reason="the button tl is not held", code="idle"
    )
    assert told(idle, "teleop") == ("input", "teleop", "idle")
    wording(explain(idle, "teleop").text)
    assert explain(idle, "drive").state == explain(idle, "").state == "ok"
    assert told(with_estop(idle, reason="dog"), "teleop") == ("estop", "estop", "estop")


def test_a_gamepad_that_is_pulled_out_is_told_by_its_driver(all_rows):
    rows = edited(all_rows["lbr"], "capabilities", "teleop", enabled=True)
    row = next(one for one in rows.capabilities if one.name == "imu")
    pad = replace(row, name="gamepad", kind="gamepad", settings='{"device": "gamepad"}', needs=())
    device = replace(rows.devices[0], name="gamepad", type="gamepad", address="input:Pad")
    rows = replace(rows, capabilities=(*rows.capabilities, pad), devices=(*rows.devices, device))
    now = healthy.snapshot(healthy.facts_of(rows))
    assert explain(now, "teleop").state == "ok", rendering.lines(explain(now, "teleop"))
    now = with_said(now, "teleop/state", pad=False, driving=False, reason="no gamepad reports", code="unreachable")
    assert told(gone("gamepad", "device 'gamepad' is missing")(now), "teleop") == ("line", "gamepad", "unreachable")


def test_what_a_gamepad_holds_itself_does_not_hold_it(with_teleop):
    now = with_said(with_teleop, "drive/state", moving=True, power=0.3, holder="teleop", code="")
    assert explain(now, "teleop").state == "ok", rendering.lines(explain(now, "teleop"))
    assert told(now, "drive") == ("holder", "drive", "held")
    others = with_said(now, "drive/state", holder="web:anna")
    assert told(others, "teleop") == ("holder", "drive", "held")


def test_the_first_of_two_causes_is_the_one_nearer_to_who_asks(robots):
    both = with_estop(without_motors(robots["lbr"]), reason="dog")
    assert told(both, "drive") == ("estop", "estop", "estop")
    assert told(down("drive", "crashed")(both), "drive")[0] == "process"


def test_how_long_it_has_been_so_is_that_of_the_event_that_began_it(robots):
    now = with_event(with_estop(robots["lbr"], reason="dog"), "estop", "executive", 12.5)
    assert explain(now, "drive").since_s == pytest.approx(12.5)
    assert explain(
        with_event(without_motors(robots["lbr"]), "degraded", "motors", 3.0), "drive"
    ).since_s == pytest.approx(3.0)


def test_of_what_is_over_the_newest_is_told(robots):
    again = with_unit(robots["lbr"], "world", uptime_s=40.0, last_end="crashed: killed by signal 9", end_code="failed")
    lapsed = with_said(again, "drive/state", code="lapsed", reason="not renewed")
    assert told(again, "drive")[:2] == ("process", "world")
    assert told(with_event(lapsed, "lapsed", "drive", 2.0), "drive") == ("last", "drive", "lapsed")


def stopped(now: Snapshot, by: str, times: int = 1) -> Snapshot:
    for ago_s in range(times, 0, -1):
        text = f"phone: stopped by {by}"
        event = Event(
            kind="stopped",
            subject="drive",
            text=text,
            code="stopped",
            about="phone",
            wall_ns=now.wall_ns - ago_s * 10**9,
        )
        now = replace(now, events=(*now.events, event))
    return with_said(now, "drive/state", code="stopped", reason=f"stopped by {by}", stopped_by=by)


def test_a_stop_by_another_than_the_sender_is_told_with_how_often_it_came(robots):
    busy = with_event(robots["lbr"], "too_busy", "machine", 5.0, "this machine is too busy")
    once = explain(stopped(busy, "remote_control"), "drive")
    assert (once.state, once.code) == ("past", "stopped")
    assert once.text == "'drive': the motion of phone was stopped by remote_control"
    assert "the last of 3 stops within a minute" in explain(stopped(busy, "remote_control", times=3), "drive").text
    for own in ("phone", robots["lbr"].asker):
        assert explain(stopped(robots["lbr"], own), "drive").state == "ok"


def test_what_ends_again_and_again_is_told_before_what_was_refused_for_want_of_it(robots):
    lately = with_unit(
        robots["lbr"], "attitude", uptime_s=2.0, last_end="crashed: killed by SIGKILL", end_code="failed"
    )
    refused = with_refusal(lately, 1.0)
    for ago_s in (50.0, 20.0):
        refused = with_event(refused, "crashed", "attitude", ago_s)
    assert told(refused, "drive")[0] == "refused"
    often = with_event(refused, "crashed", "attitude", 2.0)
    assert told(often, "drive") == ("process", "attitude", "failed")
    assert "3 times within a minute" in explain(often, "drive").text


def took(now: Snapshot, who: str, part: str, ago_s: float) -> Snapshot:
    event = Event(
        kind="holder",
        subject=part,
        text=f"{who} took {part}",
        data={"took": who},
        wall_ns=now.wall_ns - int(ago_s * 1e9),
    )
    return replace(now, events=(*now.events, event))


@pytest.mark.parametrize("crashed", ["drive", "motors"])
def test_after_a_command_that_was_taken_a_crash_before_it_is_no_reason_to_say_it_again(robots, crashed, wording):
    lately = with_unit(robots["lbr"], crashed, uptime_s=20.0, last_end="crashed: exit code 1", end_code="failed")
    for before in (lately, took(lately, "console", "drive", 25.0), took(lately, "console", "dock", 5.0)):
        wording(explain(before, crashed).do)
        assert explain(before, "drive").state == "past"
    after = took(lately, "console", "drive", 5.0)
    for part in (crashed, "drive", ""):
        assert (explain(after, part).state, explain(after, part).do) == ("ok", "")


def rows_changed(now: Snapshot, *touched: str) -> Snapshot:
    text = "update capability 'motors': restart motors"
    data = {"revision": 3, "touched": list(touched)}
    event = Event(kind="rows_changed", subject="executive", text=text, data=data, wall_ns=now.wall_ns - 46 * 10**9)
    return replace(now, events=(*now.events, event))


def test_an_edit_of_a_part_on_the_way_is_told_with_what_it_may_have_led_to(robots):
    since = "; 46 s ago the rows were changed: update capability 'motors': restart motors"
    edited_now = rows_changed(robots["lbr"], "motors")
    well = explain(edited_now, "drive")
    assert (well.state, well.text) == ("ok", f"Nothing is wrong: it waits for a command{since}")
    stuck = explain(with_said(edited_now, "drive/state", code="stuck", reason="the base does not turn"), "drive")
    assert (stuck.code, stuck.text) == ("stuck", f"'drive': its last motion ended: the base does not turn{since}")
    busy = explain(with_event(edited_now, "too_busy", "machine", 5.0, "this machine is too busy"), "drive")
    assert busy.text == f"this machine is too busy{since}"
    assert "rows were changed" not in explain(with_estop(edited_now, reason="dog"), "drive").text


def test_an_edit_of_other_parts_or_of_what_no_part_has_is_not_told(robots):
    for touched in ((), ("speech",)):
        assert "rows were changed" not in explain(rows_changed(robots["lbr"], *touched), "drive").text


def test_a_joint_that_has_latched_is_told_before_torque_which_it_refuses_until_recovered(robots):
    now = with_joint(robots["bioloid"], "left_knee", torque=0.0, latched=["overload"])
    assert told(now, "joints") == ("fault", "joints", "latched")
    assert told(now, "motions") == ("fault", "joints", "latched")
    assert explain(now, "joints").do == "remove the cause, then recover, then /torque/on"
    loose = with_joint(now, "right_knee", torque=0.0)
    assert any(one.text == "right_knee without torque" for one in explain(loose, "joints").links)


def test_an_edit_that_was_refused_is_told_before_what_is_over(robots):
    again = with_unit(robots["lbr"], "world", uptime_s=4.0, last_end="crashed: killed by signal 9", end_code="failed")
    refused = replace(again.status, problems=("capability lbr/drive: bad",), problem_codes=("bad_value",))
    assert told(replace(again, status=refused), "drive")[0] == "rows"


def with_refusal(now: Snapshot, ago_s: float, code: str = "stale_sensor", kind: str = "refused") -> Snapshot:
    wall_ns = now.wall_ns - int(ago_s * 1e9)
    text = "phone: bow forward reading is invalid"
    event = Event(kind=kind, subject="drive", text=text, code=code, about="phone", wall_ns=wall_ns)
    return replace(now, events=(*now.events, event))


def test_what_was_refused_last_is_told_before_what_holds_another_way_and_after_what_holds(robots, wording):
    near = with_said(robots["lbr"], "ranges/readings", right_m=0.1)
    assert told(near, "drive")[0] == "reading"
    refused = with_refusal(near, 20.0)
    assert told(refused, "drive") == ("refused", "drive", "stale_sensor")
    wording(explain(refused, "drive").text)
    busy = with_event(with_refusal(robots["lbr"], 20.0), "too_busy", "machine", 5.0)
    assert told(busy, "drive")[0] == "refused"
    assert told(with_estop(refused, reason="dog"), "drive")[0] == "estop"
    assert told(down("drive", "crashed")(refused), "drive")[0] == "process"


def test_what_was_refused_long_ago_before_another_command_as_a_renewal_or_by_a_stop_that_is_over_is_not_told(robots):
    for now in (
        with_refusal(robots["lbr"], 61.0),
        with_refusal(with_refusal(robots["lbr"], 9.0), 3.0, kind="holder", code=""),
        with_refusal(robots["lbr"], 3.0, code="dead_lease"),
        with_refusal(robots["lbr"], 3.0, code="estop"),
    ):
        assert explain(now, "drive").state == "ok"


def test_a_camera_that_rests_without_a_viewer_is_not_told_as_slow(robots):
    resting = with_said(
        with_unit(robots["lbr"], "camera_front", rates_hz={"frame": 2.0}), "camera_front/state", rests=True
    )
    assert explain(resting, "camera_front").state == "ok"
    assert told(with_unit(resting, "camera_front", rates_hz={"frame": 0.0}), "camera_front")[0] == "rate"


def test_what_runs_and_does_not_answer_is_told(robots):
    now = robots["lbr"]
    silent = replace(
        now, messages={topic: one for topic, one in now.messages.items() if not topic.startswith("drive/")}
    )
    assert told(silent, "drive") == ("process", "drive", "timeout")


def test_hardware_is_blamed_for_nothing_else(robots):
    for cause in NOT_HARDWARE:
        robot, part, broken, _ = CAUSES[cause]
        chain = explain(broken(robots[robot]), part)
        assert not [one for one in chain.links if one.state == "held" and one.name in HARDWARE], cause


def test_a_message_that_is_not_understood_is_passed_over(robots):
    now = with_said(robots["lbr"], "drive/state", moving="perhaps")
    assert explain(now, "drive").state == "ok"


def test_times_are_told_in_the_greatest_unit_that_fits():
    assert [rendering.ago(seconds) for seconds in (0.04, 12.0, 90.0, 7300.0, 200_000.0)] == [
        "0.0 s", "12 s", "1.5 min", "2.0 h", "2.3 d",
    ]  # fmt: skip
