"""Bad rows: every one is named with table, row and column, and nothing in them raises."""

import copy
import json
import sqlite3
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database.checks import check as check_rows
from lbr.database.rows import RobotRow
from lbr.database.shipped import shipped as shipped_tables
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from lbr.messages.calibration import CalibrationValue
from lbr.messages.dance import DanceStep
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import Joint, MotionRow, MotionStep
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.sensing import RangeSensor
from lbr.messages.speech import Phrase
from lbr.resources import robot_db_sql

READ = (
    Phrase,
    BehaviourTable,
    BehaviourRow,
    DanceStep,
    CalibrationValue,
    Joint,
    MotionRow,
    MotionStep,
    Motor,
    Button,
    RangeSensor,
    Kinematics,
    Wheel,
)
"""What the kinds that come with lbr read."""
check = partial(check_rows, also=READ)
_, COLUMNS = shipped_tables()


def shipped() -> dict:
    connection = sqlite3.connect(":memory:")
    connection.row_factory = sqlite3.Row
    connection.executescript(robot_db_sql().read_text())
    tables = {name: [dict(row) for row in connection.execute(f"SELECT * FROM {name}")] for name in COLUMNS}
    connection.close()
    tables["calibration"] = [
        {"robot": "lbr", "device": "range_board", "name": "offset_cm", "value": 1.5, "measured_at": "2026-01-01"}
    ]
    neck = {"name": "neck", "device_id": 1, "side": "centre", "sign": 1, "zero_rad": 0.0, "speed_rps": 1.0, "bus": ""}
    tables["joint"] = [
        {"robot": "lbr", **neck, "lower_rad": -1.0, "upper_rad": 1.0},
        {"robot": "lbr", **neck, "name": "jaw", "device_id": 2, "lower_rad": 0.0, "upper_rad": 0.5},
    ]
    played = {"slot": None, "slot_s": None, "limp": 0, "builtin": 0}
    tables["motion"] = [
        {"robot": "lbr", "name": name, "help": "", "lead_in": lead_in, "lead_out": "", **played}
        for name, lead_in in (("nod", "rest"), ("rest", ""))
    ]
    counts = {"initial": 127, "lowest": 1, "highest": 254, "rest": 127}
    scan = {**tables["range_sensor"][0], "name": "scanner", "kind": "lidar", "rays": 90}
    tables["range_sensor"].insert(1, scan)
    tables["kinematics"] = [{"robot": "lbr", "name": "base", "kind": "skid", "track_factor": 1.0}]
    tables["wheel"] = [
        {
            "robot": "lbr",
            "name": f"{place}_{side}",
            "motor": side,
            "x_m": x_m,
            "y_m": y_m,
            "yaw_rad": 0.0,
            "roller_rad": 0.0,
            "diameter_m": 0.2,
        }
        for place, x_m in (("front", 0.1), ("rear", -0.1))
        for side, y_m in (("left", 0.15), ("right", -0.15))
    ]
    tables["motor"] = [
        {
            "robot": "lbr",
            "layer": "safe",
            "id": 1,
            "name": "neck",
            "description": "",
            **counts,
            "inverted": 0,
            "builtin": 1,
        }
    ]
    tables["button"] = [{"robot": "lbr", "id": 4, "name": "nod", "button": "U", "motion": "nod", "builtin": 0}]
    tables["motion_step"] = [
        {
            "robot": "lbr",
            "motion": "nod",
            "step": 1,
            "duration_s": 1.0,
            "stable": 1,
            "positions": '{"neck": 0.5, "jaw": 0}',
        }
    ]
    said = {"robot": "lbr", "target": "drive.command", "payload": None, "role": "operate", "help": "Drive"}
    tables["verb"] = [
        {**said, "word": "r", "pattern": "/r/{power}/{angle_deg}"},
        {**said, "word": "r", "pattern": "/r/{power}/{angle_deg}/{range_cm}/{sensor}/{interval_s}"},
        {**said, "word": "s", "pattern": "/s/{text...}", "target": "speech.say"},
        *tables["verb"],
    ]
    return {
        name: [row for row in rows if row.get("robot", row.get("name")) == "lbr"] for name, rows in tables.items()
    } | {"phrase": tables["phrase"]}


SHIPPED = shipped()


def with_value(table, number, column, value):
    tables = copy.deepcopy(SHIPPED)
    tables[table][number][column] = value
    return tables


# table, which of its rows, column, bad value, what the problem says
BAD_VALUES = [
    ("robot", 0, "model", None, "is NULL, not a text"),
    ("robot", 0, "owner", b"\xff", "is a blob, not a text"),
    ("robot", 0, "estop_engaged", 7, "'7' is neither 0 nor 1"),
    ("robot", 0, "last_start", 5, "is a number"),
    ("capability", 0, "name", "Motors", "'Motors' is not a name"),
    ("capability", 0, "name", "mоtors", "is not a name"),  # noqa: RUF001 - a Cyrillic letter
    ("capability", 0, "name", "m" * 41, "is not a name"),
    ("capability", 0, "name", "motors\n", "is not a name"),
    ("capability", 0, "name", "executive", "is lbr itself"),
    ("capability", 0, "kind", "os.system", "'os.system' is not a name"),
    ("capability", 0, "enabled", None, "is neither 0 nor 1"),
    ("capability", 0, "settings", "{", "is not JSON"),
    ("capability", 0, "settings", "", "is not JSON"),
    ("capability", 0, "settings", "[]", "is not a JSON object"),
    ("capability", 0, "settings", "null", "is not a JSON object"),
    ("capability", 0, "settings", '{"a": 1, "a": 2}', "a key stands twice"),
    ("capability", 0, "settings", '{"a": NaN}', "NaN is not a number"),
    ("capability", 0, "settings", '{"a": 1e999}', "too large"),
    ("capability", 0, "settings", '{"a": 99999999999999999999}', "too large"),
    ("capability", 0, "settings", '{"a": "\\ud800"}', "is not JSON"),
    ("capability", 0, "settings", '{"a": ' + "[" * 40_000 + "]" * 40_000 + "}", "nested too deeply"),
    ("capability", 0, "settings", '{"a": "' + "x" * 1_000_000 + '"}', "longer than 100000"),
    ("capability", 0, "settings", '{"a": "\0"}', "NUL"),
    ("capability", 0, "settings", '{"device": "gone"}', "there is no device 'gone'"),
    ("capability", 0, "restart", "maybe", "'maybe' is not one of never, on-failure, always"),
    ("capability", 0, "needs", '["gone"]', "there is no capability 'gone'"),
    ("capability", 0, "needs", "[1]", "is not a JSON list of strings"),
    ("capability", 0, "needs", '{"a": 1}', "is not a JSON list of strings"),
    ("capability", 0, "needs", '["motors"]', "it needs itself"),
    ("capability", 0, "needs", '["drive"]', "it needs itself"),
    ("capability", 0, "process", "Base", "is not a name"),
    ("capability", 0, "robot", "lbrr", "there is no robot 'lbrr'"),
    ("capability", 0, "help", "\udcff", "is not valid UTF-8"),
    ("channel", 0, "source", "gone.setpoint", "there is no capability 'gone'"),
    ("channel", 0, "target", "gone.setpoint", "there is no capability 'gone'"),
    ("channel", 0, "source", "drive", "is not of the form capability.port"),
    ("channel", 0, "rate_hz", 0.0, "is not above 0"),
    ("channel", 0, "rate_hz", float("nan"), "is not above 0"),
    ("channel", 0, "rate_hz", float("inf"), "is not above 0"),
    ("channel", 0, "history", 65, "is not a whole number from 1 to 64"),
    ("channel", 0, "history", 1.5, "is not a whole number from 1 to 64"),
    ("channel", 0, "enabled", "yes", "is neither 0 nor 1"),
    ("device", 0, "name", "", "'' is not a name"),
    ("device", 0, "type", "ROBOTEQ", "is not a name"),
    ("device", 0, "address", " ", "is empty"),
    ("device", 0, "address", "/dev/\x1btty", "is not an address"),
    ("device", 0, "settings", "[1]", "is not a JSON object"),
    ("verb", 0, "word", "/r", "is not a word"),
    ("verb", 0, "word", "q", "begins with 'r', but the word of this row is 'q'"),
    ("verb", 0, "pattern", "", "is empty"),
    ("verb", 0, "pattern", "/r//x", "it has an empty part"),
    ("verb", 0, "pattern", "/r/{power}/{power}", "a field stands in it twice"),
    ("verb", 0, "pattern", "/r/{text...}/{x}", "takes the rest of the line"),
    ("verb", 0, "pattern", "/r/{a b}", "is neither a word nor a {field}"),
    ("verb", 0, "pattern", "r x", "it begins with a word"),
    ("verb", 1, "pattern", "/r/{speed}/{angle}", "takes the same lines as"),
    ("verb", 0, "target", "gone.command", "there is no capability 'gone'"),
    ("verb", 0, "target", "drive", "is not of the form capability.port"),
    ("verb", 0, "payload", "[]", "is not a JSON object"),
    ("verb", 0, "payload", '{"power": 1}', "sets 'power', which the pattern binds"),
    ("verb", 0, "role", "root", "'root' is not one of view, operate, admin"),
    ("external_command", 0, "name", "stop", "'stop' is a word that every robot has, and no row changes: drop this row"),
    ("external_command", 0, "name", "f", "'f' is a verb already"),
    ("external_command", 0, "argv", "[]", "names no program"),
    ("external_command", 0, "argv", '[""]', "names no program"),
    ("external_command", 0, "argv", '"/bin/date"', "is not a JSON list of strings"),
    ("external_command", 0, "argv", '["/bin/date", 1]', "is not a JSON list of strings"),
    ("external_command", 0, "argv", '["a\\u0000b"]', "is not a JSON list of strings"),
    ("external_command", 0, "blocking", 2, "is neither 0 nor 1"),
    ("external_command", 0, "arguments", '{"a": 1}', "is not a JSON list"),
    ("external_command", 0, "arguments", '[["left"], "("]', "entry 2 is not a regular expression"),
    ("external_command", 0, "arguments", "[[]]", "entry 1 is neither a list of words"),
    ("external_command", 0, "role", "god", "is not one of view, operate, admin"),
    ("phrase", 0, "language", "English", "is not a language tag"),
    ("phrase", 0, "text", "", "is empty"),
    ("choreography", 0, "dance", "Waltz", "is not a name"),
    ("choreography", 0, "step", 0, "'0' is not a whole number from 1 to 10000"),
    ("choreography", 0, "angle_deg", 361.0, "361 is outside -360 to 360"),
    ("choreography", 0, "power", 2.0, "2 is outside 0 to 1"),
    ("choreography", 0, "beats", 0, "'0' is not a whole number from 1 to 64"),
    ("calibration", 0, "device", "gone", "there is no device 'gone'"),
    ("calibration", 0, "value", float("inf"), "is not a finite number"),
    ("calibration", 0, "value", "1.5", "is not a finite number"),
    ("calibration", 0, "measured_at", None, "is NULL"),
    ("joint", 0, "device_id", 254, "'254' is not a whole number from 0 to 253"),
    ("joint", 1, "device_id", 1, "servo 1 moves joint 'neck' already"),
    ("joint", 0, "bus", "gone", "there is no device 'gone'"),
    ("joint", 0, "side", "top", "'top' is not one of left, right, centre"),
    ("joint", 0, "sign", 0, "'0' is not one of 1, -1"),
    ("joint", 0, "zero_rad", 11.0, "11 is outside -10 to 10"),
    ("joint", 0, "lower_rad", float("nan"), "is not a finite number"),
    ("joint", 0, "upper_rad", -2.0, "-2 is not above lower_rad, -1"),
    ("joint", 0, "speed_rps", 0.0, "0 would never get anywhere"),
    ("motion", 0, "lead_in", "gone", "there is no other motion 'gone'"),
    ("motion", 0, "lead_in", "nod", "there is no other motion 'nod'"),
    ("motion", 0, "lead_out", "No Name", "'No Name' is not a name"),
    ("motion", 0, "slot", 0, "'0' is not a whole number from 1 to 255"),
    ("motion", 0, "slot_s", 601.0, "601 is outside 0 to 600"),
    ("motion", 0, "limp", 2, "is neither 0 nor 1"),
    ("motion", 0, "builtin", 2, "is neither 0 nor 1"),
    ("motor", 0, "layer", "API", "'API' is not a name"),
    ("motor", 0, "id", 254, "is not a whole number from 0 to 253"),
    ("motor", 0, "lowest", -1, "is not a whole number from 0 to 16383"),
    ("motor", 0, "rest", -1, "is not a whole number from 0 to 16383"),
    ("motor", 0, "inverted", 2, "is neither 0 nor 1"),
    ("motor", 0, "builtin", 2, "is neither 0 nor 1"),
    ("button", 0, "id", -1, "is not a whole number from 0 to 9999"),
    ("button", 0, "button", None, "is NULL, not a text"),
    ("motor", 0, "highest", 1, "1 is not above lowest, 1"),
    ("motor", 0, "initial", 20_000, "is not a whole number from 0 to 16383"),
    ("motor", 0, "name", "", "is empty"),
    ("motor", 0, "name", "n" * 41, "is longer than 40 characters"),
    ("button", 0, "motion", "gone", "there is no motion 'gone'"),
    ("button", 0, "builtin", 2, "is neither 0 nor 1"),
    ("range_sensor", 0, "kind", "radar", "'radar' is not one of ultrasonic, infrared, time_of_flight, lidar"),
    ("range_sensor", 0, "x_m", float("nan"), "is not a finite number"),
    ("range_sensor", 0, "y_m", 6.0, "6 is outside -5 to 5"),
    ("range_sensor", 0, "z_m", -1.0, "-1 is outside 0 to 5"),
    ("range_sensor", 0, "yaw_rad", 90.0, "90 is outside -7 to 7"),
    ("range_sensor", 0, "pitch_rad", -3.0, "-3 is outside -2 to 2"),
    ("range_sensor", 0, "fov_rad", 7.0, "is not above 0 and at most 6.28"),
    ("range_sensor", 0, "min_m", -0.1, "-0.1 is outside 0 to 100"),
    ("range_sensor", 0, "max_m", 0.1, "is not greater than min_m 0.17"),
    ("range_sensor", 0, "rays", 0, "'0' is not a whole number from 1 to 4096"),
    ("range_sensor", 1, "pitch_rad", 1.0, "is beyond 0.5: a scan is taken to be level"),
    ("range_sensor", 0, "stop_m", float("inf"), "inf"),
    ("kinematics", 0, "kind", "tracks", "'tracks' is not one of differential, skid, mecanum, omni"),
    ("kinematics", 0, "kind", "mecanum", "wheel 'front_left' needs roller_rad"),
    ("kinematics", 0, "kind", "omni", "do not give motion ahead, sideways and round"),
    ("kinematics", 0, "track_factor", 9.0, "9 is outside 0.5 to 5"),
    ("kinematics", 0, "name", "Base", "is not a name"),
    ("wheel", 0, "name", "Front", "is not a name"),
    ("wheel", 0, "y_m", 5.5, "5.5 is outside -5 to 5"),
    ("wheel", 0, "yaw_rad", 90.0, "90 is outside -7 to 7"),
    ("wheel", 0, "roller_rad", 1.5708, "is outside -1.4 to 1.4"),
    ("wheel", 0, "diameter_m", 0.0, "is not above 0 and at most 2"),
    ("wheel", 0, "motor", "Left", "is not a name"),
    ("wheel", 0, "x_m", float("nan"), "is not a finite number"),
    ("behaviour", 0, "max_s", -1.0, "-1 is outside 0 to 86400"),
    ("behaviour_row", 0, "behaviour", "gone", "there is no behaviour 'gone'"),
    ("behaviour_row", 0, "step", 0, "'0' is not a whole number from 1 to 10000"),
    ("behaviour_row", 0, "type", "begin", "begin"),
    ("behaviour_row", 0, "state", "s" * 81, "80"),
    ("behaviour_row", 0, "conditions", '{"Forward": 40}', "Expected `str`, got `int`"),
    ("behaviour_row", 0, "outputs", "[]", "is not a JSON object"),
    ("behaviour_row", 0, "next_state", "s" * 81, "80"),
    ("behaviour_row", 0, "deadline_s", 0.0, "0"),
    ("motion_step", 0, "motion", "gone", "there is no motion 'gone'"),
    ("motion_step", 0, "step", 0, "'0' is not a whole number from 1 to 10000"),
    ("motion_step", 0, "duration_s", 0.0, "0 is no time to get anywhere"),
    ("motion_step", 0, "stable", 2, "'2' is neither 0 nor 1"),
    ("motion_step", 0, "positions", '{"gone": 0.5}', "there is no joint 'gone'"),
    ("motion_step", 0, "positions", '{"neck": 1.5}', "neck: 1.5 is outside -1 to 1, the joint's limits"),
    ("motion_step", 0, "positions", '{"neck": true}', "'neck': 'True' is not an angle in radians"),
    ("motion_step", 0, "positions", '{"neck": "up"}', "'neck': 'up' is not an angle in radians"),
]


@pytest.mark.parametrize(
    ("table", "number", "column", "value", "says"), BAD_VALUES, ids=[f"{b[0]}.{b[2]}-{b[4][:30]}" for b in BAD_VALUES]
)
def test_a_bad_value_is_named_with_its_place(table, number, column, value, says):
    tables = with_value(table, number, column, value)
    rows = check(tables, "lbr")
    at = {(p.table, p.column) for p in rows.problems if says in p.text}
    assert (table, column if "the word of this row" not in says else "pattern") in at
    assert all(p.row and p.row.isprintable() and len(str(p)) < 1000 for p in rows.problems)


def test_every_column_has_a_bad_value():
    covered = {(table, column) for table, _, column, _, _ in BAD_VALUES}
    alike = {"robot", "name", "description", "estop_reason", "last_shutdown", "kind", "help", "enabled", "settings"}
    for table, columns in COLUMNS.items():
        assert [c for c in columns if (table, c) not in covered and c not in alike] == []


def test_a_bad_row_is_left_out_and_the_others_stay():
    rows = check(with_value("verb", 0, "role", "root"), "lbr")
    assert len(rows.verbs) == len(SHIPPED["verb"]) - 1
    assert len(rows.capabilities) == len(SHIPPED["capability"])
    assert [str(p) for p in rows.problems] == [
        "verb 'lbr/r//r/{power}/{angle_deg}', role: 'root' is not one of view, operate, admin"
    ]


def test_all_problems_come_at_once():
    tables = with_value("verb", 0, "role", "root")
    tables["device"][0]["address"] = ""
    tables["channel"][0]["history"] = 0
    tables["capability"][3]["settings"] = "{"
    assert {(p.table, p.column) for p in check(tables, "lbr").problems} == {
        ("verb", "role"),
        ("device", "address"),
        ("channel", "history"),
        ("capability", "settings"),
    }


def test_a_bad_row_is_not_reported_again_by_those_who_name_it():
    rows = check(with_value("capability", 0, "enabled", 5), "lbr")
    assert len(rows.problems) == 1


@pytest.mark.parametrize("value", [None, "", 2, b"\0", "0"])
def test_a_latch_that_cannot_be_read_is_engaged(value):
    assert check(with_value("robot", 0, "estop_engaged", value), "lbr").robot.estop_engaged


def test_a_robot_that_is_not_there_is_a_problem_naming_those_that_are():
    rows = check(SHIPPED, "lbr9")
    (problem,) = rows.problems
    assert str(problem).startswith("robot 'lbr9', name: there is no robot of this name (there is: lbr); ")
    assert "`lbr db add lbr9`" in str(problem)
    assert rows.robot == RobotRow(name="lbr9", estop_engaged=True)
    assert rows.capabilities == ()


def test_rows_of_another_robot_are_left_alone():
    tables = copy.deepcopy(SHIPPED)
    tables["robot"].append({**tables["robot"][0], "name": "other"})
    tables["capability"].append({**tables["capability"][0], "robot": "other", "settings": "{"})
    assert check(tables, "lbr") == check(SHIPPED, "lbr")
    assert len(check(tables, "other").problems) == 1


def test_needs_in_a_ring_are_found_in_every_member():
    tables = copy.deepcopy(SHIPPED)
    names = [row["name"] for row in tables["capability"]]
    for row, needed in zip(tables["capability"], names[1:] + names[:1], strict=True):
        row["needs"] = json.dumps([needed])
    problems = check(tables, "lbr").problems
    assert [p.row for p in problems] == [f"lbr/{name}" for name in names]


SQLITE_VALUES = (
    st.none()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats()
    | st.binary(max_size=20)
    | st.text(st.characters(), max_size=30)
    | st.sampled_from([good for rows in SHIPPED.values() for row in rows for good in row.values()])
    | st.recursive(
        st.none() | st.booleans() | st.integers() | st.text(st.characters(), max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
        max_leaves=5,
    ).map(json.dumps)
)
PLACES = [
    (table, number, column) for table, rows in SHIPPED.items() for number, row in enumerate(rows) for column in row
]


@given(st.lists(st.tuples(st.sampled_from(PLACES), SQLITE_VALUES), min_size=1, max_size=6))
def test_mutated_rows_never_raise_and_are_named_or_sound(mutations):
    tables = copy.deepcopy(SHIPPED)
    for (table, number, column), value in mutations:
        tables[table][number][column] = value
    rows = check(tables, "lbr")
    for problem in rows.problems:
        assert problem.table in COLUMNS
        assert problem.column in COLUMNS[problem.table]
        assert problem.text
        str(problem).encode()
    check_sound(rows)


def check_sound(rows):
    """What came through is well formed, whatever was in the tables."""
    capabilities = {row.name for row in rows.capabilities}
    for row in rows.capabilities:
        assert isinstance(json.loads(row.settings), dict)
        assert row.restart in ("never", "on-failure", "always")
        assert row.name not in row.needs
    for row in rows.channels:
        assert 1 <= row.history <= 64
        assert row.rate_hz is None or row.rate_hz > 0
        assert all((*row.source_end, *row.target_end))
    for row in rows.verbs:
        assert row.role in ("view", "operate", "admin")
        assert row.pattern.lstrip("/").split("/")[0] == row.word
    assert all(row.argv and row.argv[0] for row in rows.external_commands)
    assert capabilities or rows.problems


@given(
    st.dictionaries(
        st.sampled_from([*COLUMNS, "other"]),
        st.lists(
            st.dictionaries(
                st.sampled_from(sorted({c for columns in COLUMNS.values() for c in columns})), SQLITE_VALUES, max_size=8
            ),
            max_size=3,
        ),
    )
)
def test_arbitrary_tables_never_raise(tables):
    check_sound(check(tables, "lbr"))


@pytest.mark.parametrize(
    ("word", "pattern"),
    [
        ("stop", "stop"),
        ("s", "s"),
        ("S", "/S"),
        ("STOP", "STOP"),
        ("Stop", "/Stop"),
        ("estop", "estop"),
        ("estop", "/estop/{reason...}"),
        ("estop", "/estop/{name}"),
        ("Estop", "/Estop/now/{name}"),
        ("reset", "/reset"),
        ("status", "status"),
        ("help", "help"),
        ("Shutdown", "Shutdown"),
        ("shutdown", "shutdown"),
    ],
)
@pytest.mark.parametrize("target", ["drive.stop", "executive.report", "drive.command"])
def test_a_row_that_would_change_a_word_of_every_robot_is_refused_by_name(word, pattern, target):
    tables = copy.deepcopy(SHIPPED)
    row = {"robot": "lbr", "word": word, "pattern": pattern, "target": target, "payload": None, "role": "admin"}
    tables["verb"].append(row | {"help": ""})
    rows = check(tables, "lbr")
    why = f"'{word}' is a word that every robot has, and no row changes: drop this row, or choose another word"
    assert [str(problem) for problem in rows.problems] == [f"verb 'lbr/{word}/{pattern}', word: {why}"]
    assert all(verb.pattern != pattern for verb in rows.verbs)


def test_a_path_that_begins_like_a_word_of_every_robot_is_nobodys_and_may_be_a_row():
    assert any(row["pattern"] == "/s/{text...}" for row in SHIPPED["verb"])
    assert not check(SHIPPED, "lbr").problems


def test_servos_on_two_buses_have_numbers_of_their_own():
    tables = shipped()
    for joint, bus in zip(tables["joint"], ("range_board", "motor_controller"), strict=True):
        joint.update(bus=bus, device_id=1)
    assert not [problem for problem in check(tables, "lbr").problems if problem.table == "joint"]
    tables["joint"][0]["bus"] = ""
    (problem,) = [problem for problem in check(tables, "lbr").problems if problem.table == "joint"]
    assert (problem.row, problem.text) == ("lbr/jaw", "servo 1 moves joint 'neck' already")


def kinematics_problem(**changes):
    tables = shipped()
    row = tables["wheel"][0]
    tables["wheel"][0] = {**row, **changes}
    return [problem.text for problem in check(tables, "lbr").problems if problem.table == "kinematics"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, None),
        ({"y_m": 0.2}, "'front_left' and 'rear_left' are on motor 'left' and would have to turn at different speeds"),
        ({"yaw_rad": 1.5708}, "wheel 'front_left' must stand beside the middle"),
        ({"y_m": 0.0}, "wheel 'front_left' must stand beside the middle"),
    ],
)
def test_wheels_that_make_no_base_are_told_with_what_to_do(changes, said):
    found = kinematics_problem(**changes)
    assert (said is None) == (found == [])
    assert said is None or said in found[0]
