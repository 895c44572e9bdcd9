"""Bad rows: every one is named with table, row and column, and nothing in them raises."""

import json
import sqlite3
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.dance.messages import DanceStep
from lbr.database.checks import check as check_rows
from lbr.database.rows import RobotRow
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from lbr.messages.calibration import CalibrationValue
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import Joint, MotionRow, MotionStep
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.sensing import RangeSensor
from lbr.messages.speech import Phrase
from lbr.resources import robot_db_sql
from tests.support import databases

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
_, COLUMNS = databases.tables()


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


def copied() -> dict:
    return {table: [dict(row) for row in rows] for table, rows in SHIPPED.items()}


def with_value(table, number, column, value):
    tables = copied()
    tables[table][number][column] = value
    return tables


# table, which of its rows, column, bad value, what the problem says
BAD_VALUES = [
    ("robot", 0, "model", None),
    ("robot", 0, "owner", b"\xff"),
    ("robot", 0, "estop_engaged", 7),
    ("robot", 0, "last_start", 5),
    ("capability", 0, "name", "Motors"),
    ("capability", 0, "name", "mоtors"),  # noqa: RUF001 - a Cyrillic letter
    ("capability", 0, "name", "m" * 41),
    ("capability", 0, "name", "motors\n"),
    ("capability", 0, "name", "executive"),
    ("capability", 0, "kind", "os.system"),
    ("capability", 0, "enabled", None),
    ("capability", 0, "settings", "{"),
    ("capability", 0, "settings", ""),
    ("capability", 0, "settings", "[]"),
    ("capability", 0, "settings", "null"),
    ("capability", 0, "settings", '{"a": 1, "a": 2}'),
    ("capability", 0, "settings", '{"a": NaN}'),
    ("capability", 0, "settings", '{"a": 1e999}'),
    ("capability", 0, "settings", '{"a": 99999999999999999999}'),
    ("capability", 0, "settings", '{"a": "\\ud800"}'),
    ("capability", 0, "settings", '{"a": ' + "[" * 40_000 + "]" * 40_000 + "}"),
    ("capability", 0, "settings", '{"a": "' + "x" * 1_000_000 + '"}'),
    ("capability", 0, "settings", '{"a": "\0"}'),
    ("capability", 0, "settings", '{"device": "gone"}'),
    ("capability", 0, "restart", "maybe"),
    ("capability", 0, "needs", '["gone"]'),
    ("capability", 0, "needs", "[1]"),
    ("capability", 0, "needs", '{"a": 1}'),
    ("capability", 0, "needs", '["motors"]'),
    ("capability", 0, "needs", '["drive"]'),
    ("capability", 0, "process", "Base"),
    ("capability", 0, "robot", "lbrr"),
    ("capability", 0, "help", "\udcff"),
    ("channel", 0, "source", "gone.setpoint"),
    ("channel", 0, "target", "gone.setpoint"),
    ("channel", 0, "source", "drive"),
    ("channel", 0, "rate_hz", 0.0),
    ("channel", 0, "rate_hz", float("nan")),
    ("channel", 0, "rate_hz", float("inf")),
    ("channel", 0, "history", 65),
    ("channel", 0, "history", 1.5),
    ("channel", 0, "enabled", "yes"),
    ("device", 0, "name", ""),
    ("device", 0, "type", "ROBOTEQ"),
    ("device", 0, "address", " "),
    ("device", 0, "address", "/dev/\x1btty"),
    ("device", 0, "settings", "[1]"),
    ("verb", 0, "word", "/r"),
    ("verb", 0, "pattern", "/q/{power}"),
    ("verb", 0, "pattern", ""),
    ("verb", 0, "pattern", "/r//x"),
    ("verb", 0, "pattern", "/r/{power}/{power}"),
    ("verb", 0, "pattern", "/r/{text...}/{x}"),
    ("verb", 0, "pattern", "/r/{a b}"),
    ("verb", 0, "pattern", "r x"),
    ("verb", 1, "pattern", "/r/{speed}/{angle}"),
    ("verb", 0, "target", "gone.command"),
    ("verb", 0, "target", "drive"),
    ("verb", 0, "payload", "[]"),
    ("verb", 0, "payload", '{"power": 1}'),
    ("verb", 0, "role", "root"),
    ("external_command", 0, "name", "stop"),
    ("external_command", 0, "name", "f"),
    ("external_command", 0, "argv", "[]"),
    ("external_command", 0, "argv", '[""]'),
    ("external_command", 0, "argv", '"/bin/date"'),
    ("external_command", 0, "argv", '["/bin/date", 1]'),
    ("external_command", 0, "argv", '["a\\u0000b"]'),
    ("external_command", 0, "blocking", 2),
    ("external_command", 0, "arguments", '{"a": 1}'),
    ("external_command", 0, "arguments", '[["left"], "("]'),
    ("external_command", 0, "arguments", "[[]]"),
    ("external_command", 0, "role", "god"),
    ("phrase", 0, "language", "English"),
    ("phrase", 0, "text", ""),
    ("choreography", 0, "dance", "Waltz"),
    ("choreography", 0, "step", 0),
    ("choreography", 0, "angle_deg", 361.0),
    ("choreography", 0, "power", 2.0),
    ("choreography", 0, "beats", 0),
    ("calibration", 0, "device", "gone"),
    ("calibration", 0, "value", float("inf")),
    ("calibration", 0, "value", "1.5"),
    ("calibration", 0, "measured_at", None),
    ("joint", 0, "device_id", 254),
    ("joint", 1, "device_id", 1),
    ("joint", 0, "bus", "gone"),
    ("joint", 0, "side", "top"),
    ("joint", 0, "sign", 0),
    ("joint", 0, "zero_rad", 11.0),
    ("joint", 0, "lower_rad", float("nan")),
    ("joint", 0, "upper_rad", -2.0),
    ("joint", 0, "speed_rps", 0.0),
    ("motion", 0, "lead_in", "gone"),
    ("motion", 0, "lead_in", "nod"),
    ("motion", 0, "lead_out", "No Name"),
    ("motion", 0, "slot", 0),
    ("motion", 0, "slot_s", 601.0),
    ("motion", 0, "limp", 2),
    ("motion", 0, "builtin", 2),
    ("motor", 0, "layer", "API"),
    ("motor", 0, "id", 254),
    ("motor", 0, "lowest", -1),
    ("motor", 0, "rest", -1),
    ("motor", 0, "inverted", 2),
    ("motor", 0, "builtin", 2),
    ("button", 0, "id", -1),
    ("button", 0, "button", None),
    ("motor", 0, "highest", 1),
    ("motor", 0, "initial", 20_000),
    ("motor", 0, "name", ""),
    ("motor", 0, "name", "n" * 41),
    ("button", 0, "motion", "gone"),
    ("button", 0, "builtin", 2),
    ("range_sensor", 0, "kind", "radar"),
    ("range_sensor", 0, "x_m", float("nan")),
    ("range_sensor", 0, "y_m", 6.0),
    ("range_sensor", 0, "z_m", -1.0),
    ("range_sensor", 0, "yaw_rad", 90.0),
    ("range_sensor", 0, "pitch_rad", -3.0),
    ("range_sensor", 0, "fov_rad", 7.0),
    ("range_sensor", 0, "min_m", -0.1),
    ("range_sensor", 0, "max_m", 0.1),
    ("range_sensor", 0, "rays", 0),
    ("range_sensor", 1, "pitch_rad", 1.0),
    ("range_sensor", 0, "stop_m", float("inf")),
    ("kinematics", 0, "kind", "tracks"),
    ("kinematics", 0, "kind", "mecanum"),
    ("kinematics", 0, "kind", "omni"),
    ("kinematics", 0, "track_factor", 9.0),
    ("kinematics", 0, "name", "Base"),
    ("wheel", 0, "name", "Front"),
    ("wheel", 0, "y_m", 5.5),
    ("wheel", 0, "yaw_rad", 90.0),
    ("wheel", 0, "roller_rad", 1.5708),
    ("wheel", 0, "diameter_m", 0.0),
    ("wheel", 0, "motor", "Left"),
    ("wheel", 0, "x_m", float("nan")),
    ("behaviour", 0, "max_s", -1.0),
    ("behaviour_row", 0, "behaviour", "gone"),
    ("behaviour_row", 0, "step", 0),
    ("behaviour_row", 0, "type", "begin"),
    ("behaviour_row", 0, "state", "s" * 81),
    ("behaviour_row", 0, "conditions", '{"Forward": 40}'),
    ("behaviour_row", 0, "outputs", "[]"),
    ("behaviour_row", 0, "next_state", "s" * 81),
    ("behaviour_row", 0, "deadline_s", 0.0),
    ("motion_step", 0, "motion", "gone"),
    ("motion_step", 0, "step", 0),
    ("motion_step", 0, "duration_s", 0.0),
    ("motion_step", 0, "stable", 2),
    ("motion_step", 0, "positions", '{"gone": 0.5}'),
    ("motion_step", 0, "positions", '{"neck": 1.5}'),
    ("motion_step", 0, "positions", '{"neck": true}'),
    ("motion_step", 0, "positions", '{"neck": "up"}'),
]


@pytest.mark.parametrize(
    ("table", "number", "column", "value"), BAD_VALUES, ids=[f"{b[0]}.{b[2]}-{b[3]!r:.30}" for b in BAD_VALUES]
)
def test_a_bad_value_is_named_with_its_place(table, number, column, value, wording):
    rows = check(with_value(table, number, column, value), "lbr")
    wording(*(p.text for p in rows.problems if (p.table, p.column) == (table, column)))
    assert all(p.row and p.row.isprintable() and len(str(p)) < 1000 for p in rows.problems)


def test_every_column_has_a_bad_value():
    covered = {(table, column) for table, _, column, _ in BAD_VALUES}
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


def test_a_robot_that_is_not_there_is_a_problem_naming_those_that_are(wording):
    rows = check(SHIPPED, "lbr9")
    (problem,) = rows.problems
    wording(problem)
    assert "`lbr db add lbr9`" in str(problem)
    assert rows.robot == RobotRow(name="lbr9", estop_engaged=True)
    assert rows.capabilities == ()


def test_rows_of_another_robot_are_left_alone():
    tables = copied()
    tables["robot"].append({**tables["robot"][0], "name": "other"})
    tables["capability"].append({**tables["capability"][0], "robot": "other", "settings": "{"})
    assert check(tables, "lbr") == check(SHIPPED, "lbr")
    assert len(check(tables, "other").problems) == 1


def test_needs_in_a_ring_are_found_in_every_member():
    tables = copied()
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
    tables = copied()
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
    tables = copied()
    row = {"robot": "lbr", "word": word, "pattern": pattern, "target": target, "payload": None, "role": "admin"}
    tables["verb"].append(row | {"help": ""})
    rows = check(tables, "lbr")
    assert [(one.table, one.row, one.column) for one in rows.problems] == [("verb", f"lbr/{word}/{pattern}", "word")]
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
