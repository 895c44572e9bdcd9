"""`lbr import`: data of former programs becomes rows, or has no place and is told; bad files are one sentence.

The files are synthetic (tests/support/old_data.py).
"""

import json
import os
import re
import sqlite3
from contextlib import closing

import pytest

from lbr import cli
from lbr.database import store
from lbr.messages.calibration import CalibrationValue
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import MotionRow, MotionStep, motions_of
from lbr.robots.bioloid.mtn import Page
from tests.apps.motions.test_motion_files import content as factory_file
from tests.support import databases
from tests.support.old_data import BOW, motion_file, old_database, old_sql, step

RIOX = "UPDATE device SET type = 'riox' WHERE name = 'imu' AND robot = 'lbr'"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    path = tmp_path_factory.mktemp("database") / "robot.db"
    databases.fresh(path)
    return path.read_bytes()


@pytest.fixture
def place(tmp_path, monkeypatch, made):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    monkeypatch.setattr("lbr.apps.motions.commands.importing.shipped", databases.tables)
    (tmp_path / "robot.db").write_bytes(made)
    (tmp_path / "robot.db").chmod(0o600)
    (tmp_path / "old").mkdir()
    return tmp_path


def lbr(capsys, *arguments: object) -> tuple[int, str, str]:
    code = cli.main(["import", *map(str, arguments)])
    return code, *capsys.readouterr()


def report(capsys, *arguments: object) -> dict:
    code, out, err = lbr(capsys, *arguments, "--json")
    assert (code, err) == (0, "")
    return json.loads(out)


def rows(place, robot):
    with store.Database.open(place / "robot.db") as database:
        return database.load(robot)


def settings(place, name):
    return next(json.loads(row.settings) for row in rows(place, "lbr").capabilities if row.name == name)


def edit(place, *statements):
    with closing(sqlite3.connect(place / "robot.db")) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def told(found, kind):
    return {(note["table"], note["row"], note["column"]) for note in found["report"] if note["kind"] == kind}


def test_a_database_of_the_first_lbr_becomes_rows_and_what_has_no_place_is_told(place, capsys):
    edit(place, RIOX, "UPDATE capability SET kind = 'riox' WHERE name = 'imu' AND robot = 'lbr'")
    script = place / "old" / "tools" / "tidy.sh"
    script.parent.mkdir()
    script.write_text("#!/bin/sh\n")
    script.chmod(0o700)
    (place / "old" / "robot.sqlite3").write_bytes(old_database())
    before = rows(place, "lbr").revision
    found = report(capsys, place / "old" / "robot.sqlite3")
    assert (found["robot"], found["written"], found["files"][0]["format"]) == ("lbr", True, "lbr-database")
    odometry = settings(place, "odometry")
    assert (odometry["wheel_diameter_m"], odometry["counts_per_turn"]) == (0.185, 120)
    of_robot = rows(place, "lbr")
    values = {row.name: row.value for row in of_robot.of(CalibrationValue)}
    assert values["mag_offset_x_ut"] == -34.5
    assert values["mag_matrix_11"] == 0.97
    assert of_robot.robot.owner == "A Person"
    (command,) = (row for row in of_robot.external_commands if row.name == "tidy_up")
    assert (command.argv, command.enabled, command.blocking) == ((str(script), "all", "now"), False, True)
    assert {
        ("extcmd", "lost", "target"), ("extcmd", "Tidy Up", "stdout"), ("extcmd", "robot_id 200", ""),
        ("robot", "lbr2a", ""), ("message", "1 row", ""), ("move_config", "2", "m4_direction"),
    } <= told(found, "no_place")  # fmt: skip
    assert all(note["text"] for note in found["report"])
    with store.Database.open(place / "robot.db") as database:
        assert {one.table for one in database.revisions(before)} == {
            "capability", "calibration", "robot", "external_command"
        }  # fmt: skip
    again = report(capsys, place / "old" / "robot.sqlite3")
    assert (again["written"], again["rows"]) == (False, 0)
    code, out, _ = lbr(capsys, place / "old" / "robot.sqlite3", "--dry-run")
    assert (code, "would take 0 rows for lbr" in out, "no place: extcmd 'lost', target" in out) == (0, True, True)


def test_the_same_as_sql_and_another_of_its_robots(place, capsys):
    (place / "old.sql").write_text(old_sql())
    found = report(capsys, place / "old.sql", "--of", "lbr2a", "--dry-run")
    assert not found["written"]
    assert ("move_config", "1", "counts_per_rev") in told(found, "no_place")
    assert ("extcmd", "navcam", "target") in told(found, "no_place")
    assert "wheel_diameter_m" not in settings(place, "odometry")
    code, _, err = lbr(capsys, place / "old.sql", "--of", "lbr9")
    assert (code, "lbr2a, lbr6" in err) == (2, True)


def test_a_calibration_of_another_compass_has_no_place(place, capsys):
    (place / "old.sqlite3").write_bytes(old_database())
    found = report(capsys, place / "old.sqlite3")
    assert ("calibration", "MAG_COR3", "value") in told(found, "no_place")
    assert rows(place, "lbr").of(CalibrationValue) == ()


def test_what_a_person_has_set_stays_unless_told(place, capsys, wording):
    edit(place, """UPDATE capability SET settings = '{"wheel_diameter_m": 0.2}' WHERE name = 'odometry'""")
    (place / "old.sqlite3").write_bytes(old_database())
    code, out, err = lbr(capsys, place / "old.sqlite3")
    assert (code, out) == (2, "")
    assert "capability 'odometry', settings.wheel_diameter_m is 0.2 here, and 0.185 there" in err
    wording(err)
    assert (settings(place, "odometry"), rows(place, "lbr").robot.owner) == ({"wheel_diameter_m": 0.2}, "")
    assert report(capsys, place / "old.sqlite3", "--replace")["written"]
    assert settings(place, "odometry")["wheel_diameter_m"] == 0.185


def test_an_emergency_stop_stays_latched_over_an_import(place, capsys):
    with store.Database.open(place / "robot.db") as database:
        database.set_estop("lbr", engaged=True, reason="smoke")
    (place / "old.sqlite3").write_bytes(old_database())
    assert report(capsys, place / "old.sqlite3")["written"]
    robot = rows(place, "lbr").robot
    assert (robot.owner, robot.estop_engaged, robot.estop_reason) == ("A Person", True, "smoke")


def test_rows_that_would_not_run_refuse_all_of_it(place, capsys):
    edit(place, "UPDATE capability SET settings = '{\"device\": \"nothing\"}' WHERE name = 'imu' AND robot = 'lbr'")
    (place / "old.sqlite3").write_bytes(old_database())
    for more in ((), ("--dry-run",)):
        code, _, err = lbr(capsys, place / "old.sqlite3", *more)
        assert (code, "there is no device 'nothing'" in err) == (2, True)
    assert rows(place, "lbr").robot.owner == ""


def test_names_with_sql_in_them_are_names(place, capsys):
    evil = "x'); DROP TABLE robot; --"
    commands = [(1, 2, evil, "/bin/true", None, 0, None, None, None)]
    robots = [(2, "lbr6", "lbr", "", None, None, evil)]
    (place / "old.sqlite3").write_bytes(old_database(extcmd=commands, robot=robots))
    found = report(capsys, place / "old.sqlite3")
    assert found["written"]
    of_robot = rows(place, "lbr")
    assert of_robot.robot.owner == evil
    assert [row.name for row in of_robot.external_commands if row.argv == ("/bin/true",)] == ["x_drop_table_robot"]


@pytest.mark.parametrize(
    "value",
    ["nonsense", 1e999, -1, 0, None, b"\x00\xff", 10**18],
    ids=["text", "inf", "negative", "none", "null", "blob", "huge"],
)
def test_values_that_cannot_be_have_no_place(place, capsys, value):
    moves = [(2, value, value if value != 10**18 else 2, value, 0, 0, value)]
    measured = [(1, 2, "MAG_ALPHA", value), (2, 2, "MAG_BETA", value)]
    (place / "old.sqlite3").write_bytes(old_database(move_config=moves, calibration=measured, extcmd=[]))
    code, out, err = lbr(capsys, place / "old.sqlite3", "--json")
    assert (code, err) == (0, "")
    assert ("move_config", "2", "wheel_diameter") in told(json.loads(out), "no_place")


def test_cameras_as_the_api_told_them(place, capsys):
    cameras = {
        "front": {"device": "/dev/video4", "status": "on"},
        "rear": {"device": "/dev/video2", "status": "off", "settings": {"brightness": 40, "led1_mode": 1, "gain": "x"}},
        "mast": {"device": "/dev/video9", "status": "off"},
        "off": {"device": "", "status": "off"},
    }
    (place / "cameras.json").write_bytes(b"\xef\xbb\xbf" + json.dumps({"cameras": cameras}).encode())
    found = report(capsys, place / "cameras.json")
    devices = {row.name: row.address for row in rows(place, "lbr").devices}
    assert devices["front_camera"] == "/dev/video4"
    assert settings(place, "camera_rear")["controls"]["brightness"] == 40
    assert settings(place, "camera_rear")["controls"]["power_line_frequency"] == 2
    assert {
        ("cameras", "rear", "settings.led1_mode"),
        ("cameras", "rear", "settings.gain"),
        ("cameras", "mast", "device"),
    } <= told(found, "no_place")


def test_controls_in_the_originals_groups_are_taken(place, capsys):
    user = {"power_line_frequency": 1, "brightness": 18, "white_balance_automatic": 0, "gain": "x"}
    held = {"user": user, "camera": {"auto_exposure": 1, "exposure_time_absolute": 500, "led1_mode": 1}}
    camera = {"device": "/dev/video2", "status": "off", "settings": held}
    (place / "cameras.json").write_text(json.dumps({"rear": camera}))
    found = report(capsys, place / "cameras.json")
    assert settings(place, "camera_rear")["controls"] == {
        "power_line_frequency": 1,
        "brightness": 18,
        "auto_exposure": 1,
        "exposure_time_absolute": 500,
    }
    assert {one for one in told(found, "no_place") if one[2].startswith("settings")} == {
        ("cameras", "rear", "settings.user.white_balance_automatic"),
        ("cameras", "rear", "settings.user.gain"),
        ("cameras", "rear", "settings.camera.led1_mode"),
    }


NECK = {"id": 23, "name": "neck", "position": 127, "min": 1, "max": 254, "default": 127, "inverted": False}
MOTORS = [
    NECK | {"description": ""},
    NECK | {"id": 24, "name": "head", "min": 160, "max": 100, "inverted": True},
    {"id": "x", "name": "", "description": None, "position": 127.5, "min": 1, "max": 2, "default": 1},
]


def test_the_first_apis_tables_and_settings(place, capsys):
    (place / "old" / "motors.json").write_text(json.dumps({"data": MOTORS, "message": "getAllMotors"}))
    motions = [
        {"id": 4, "name": "walk_forward_short", "button": "U"},
        {"id": 40, "name": "kick_right", "button": ""},
        {"id": 41, "name": "moonwalk", "button": ""},
    ]
    (place / "old" / "motions.json").write_text(json.dumps({"data": motions, "message": "findAll"}))
    (place / "old" / ".env").write_text("# the server\nPORT=50001\nNODE_ENV='production'\n")
    (place / "old" / "notes.txt").write_text("nothing of that")
    (place / "old" / "robot.db").write_bytes((place / "robot.db").read_bytes())
    os.mkfifo(place / "old" / "pipe")
    (place / "old" / "link.mtn").symlink_to("/dev/zero")
    found = report(capsys, place / "old")
    of_robot = rows(place, "uxa90")
    assert [row.id for row in of_robot.of(Motor) if row.layer == "original"] == [23]
    assert [(row.id, row.motion) for row in of_robot.of(Button) if row.id >= 40] == [(40, "kick_right"), (99, "")]
    web = next(json.loads(row.settings) for row in of_robot.capabilities if row.name == "web")
    assert ("uxa90" in web["faces"], web["port"]) == (True, 50001)
    assert {("motion", "41", "name"), ("settings", "NODE_ENV", ""), ("file", "notes.txt", ""), ("file", "robot.db", ""), ("file", "pipe", ""),
            ("file", "link.mtn", ""), ("motor", "x", "min, max"), ("motor", "24", "min, max")} <= told(found, "no_place")  # fmt: skip


def test_of_rows_that_contradict_each_other_the_first_counts_also_a_second_time(place, capsys):
    (place / "motors.json").write_text(json.dumps([NECK, NECK, {**NECK, "name": "head", "min": 50}]))
    for kind in ("added", "same"):
        found = report(capsys, place / "motors.json")
        assert [(row.name, row.lowest) for row in rows(place, "uxa90").of(Motor) if row.layer == "original"] == [
            ("neck", 1)
        ]
        assert told(found, "no_place") == {("motor", "original/23", "name"), ("motor", "original/23", "lowest")}
        assert len([note for note in found["report"] if note["kind"] == "added"]) == (kind == "added")
        assert ("motor", "original/23", "name") in told(found, kind) or kind == "added"


def test_motions_of_both_makers_and_a_second_time(place, capsys):
    (place / "moves.mtn").write_bytes(motion_file(Page("Bow", BOW), Page("Far", (step(s13=900),))))
    found = report(capsys, place / "moves.mtn")
    assert (found["robot"], found["written"]) == ("bioloid", True)
    assert told(found, "clamped") == {("motion_step", "far", "positions.right_knee")}
    of_robot = rows(place, "bioloid")
    known = {one.name: one for one in motions_of(of_robot.of(MotionRow), of_robot.of(MotionStep))}
    assert (len(known["bow"].frames), known["bow"].help) == (4, "Bow")
    assert not report(capsys, place / "moves.mtn")["written"]
    (place / "moves.mtn").write_bytes(motion_file(Page("Bow", BOW[:2])))
    code, _, err = lbr(capsys, place / "moves.mtn")
    assert (code, "motion 'bow' is there already" in err) == (2, True)
    assert report(capsys, place / "moves.mtn", "--replace")["written"]
    (place / "far.rbm").write_bytes(factory_file((20, 400, {24: 250})))
    found = report(capsys, place / "far.rbm")
    assert (found["robot"], told(found, "clamped")) == ("uxa90", {("motion_step", "a_test", "positions.head_pitch")})


def test_a_motion_that_is_as_shipped_is_nobodys_own(place, capsys):
    (place / "moves.mtn").write_bytes(motion_file(Page("Wave", BOW)))
    found = report(capsys, place / "moves.mtn")
    assert found["written"]
    assert ("motion", "wave", "") in told(found, "changed")
    (place / "moves.mtn").write_bytes(motion_file(Page("Wave", BOW[:2])))
    code, _, err = lbr(capsys, place / "moves.mtn")
    assert (code, "motion 'wave' is there already" in err) == (2, True)


def test_what_is_said_of_many_pages_is_one_line(place, capsys):
    pages = [Page(f"Step {number}", BOW, exit=number, compliance=(3,) * 26) for number in range(1, 41)]
    (place / "moves.mtn").write_bytes(motion_file(*pages))
    code, out, _ = lbr(capsys, place / "moves.mtn")
    lines = [line for line in out.splitlines() if line.startswith("no place: page")]
    assert (code, len(lines)) == (0, 2)
    assert all(line.startswith("no place: page '1 (Step 1), 2 (Step 2)") and " and 35 more'" in line for line in lines)
    assert len(told(report(capsys, place / "moves.mtn", "--dry-run"), "no_place")) == 80


def test_a_command_whose_name_is_a_word_of_every_robot_has_no_place_and_the_rest_is_taken(place, capsys):
    names = ("stop", "help", "tidy")
    commands = [(at, 2, name, "/bin/echo", None, 0, None, None, None) for at, name in enumerate(names, 1)]
    (place / "old.sqlite3").write_bytes(old_database(extcmd=commands))
    found = report(capsys, place / "old.sqlite3", "--of", "lbr6")
    assert found["written"]
    assert {("external_command", "stop", "name"), ("external_command", "help", "name")} <= told(found, "no_place")
    there = {row.name for row in rows(place, "lbr").external_commands}
    assert there & set(names) == {"tidy"}


def test_a_motion_goes_out_as_a_file_of_roboplus_and_comes_in_again(place, capsys, wording):
    assert cli.main(["motion", "export", "wave", "--to", str(place / "wave.mtn")]) == 0
    capsys.readouterr()
    found = report(capsys, place / "wave.mtn", "--robot", "bioloid", "--replace")
    assert (found["written"], found["robot"]) == (True, "bioloid")
    assert cli.main(["motion", "import", str(place / "wave.mtn"), "--name", "wave_2", "--robot", "bioloid"]) == 0
    (place / "two.mtn").write_bytes(motion_file(Page("A", BOW), Page("B", BOW)))
    assert cli.main(["motion", "import", str(place / "two.mtn")]) == 2
    wording(capsys.readouterr().err)


def test_a_motion_that_the_controller_keeps_is_never_written_over(place, capsys):
    (place / "sit.rbm").write_bytes(factory_file((20, 400, {24: 130})).replace(b":7:A: test:", b":8:sit down:"))
    code, _, err = lbr(capsys, place / "sit.rbm", "--replace")
    assert (code, "built in" in err or "kept by the controller" in err) == (2, True)


def ours(_place):
    return (_place / "robot.db").read_bytes()


def another(_place):
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute("CREATE TABLE songs (name)")
        return connection.serialize()


BAD = {
    "empty.mtn": lambda _: b"",
    "empty.dat": lambda _: b"",
    "frames.mtn": lambda _: motion_file(Page("long", BOW[:1] * 10_000)),
    "cut.mtn": lambda _: motion_file(Page("Bow", BOW))[:-12],
    "half.mtn": lambda _: "type=motion".encode("utf-16") + b"\xd8",
    "huge.mtn": lambda _: b"type=motion\n" * 500_000,
    "song.mp3": lambda _: b"ID3\0\0\xff\xfb" * 50,
    "ours.db": ours,
    "other.db": another,
    "deep.json": lambda _: b"[" * 100_000,
    "list.json": lambda _: b"[1, 2]",
}
BAD_SQL = {
    "cut.sqlite3": (lambda _: old_database()[:5000], "SQLite|malformed"),
    "cut.sql": (lambda _: old_sql()[:-200].encode(), "incomplete|unrecognized|syntax"),
    "file.sql": (lambda _: b"CREATE TABLE robot (robot_id, name); ATTACH '/tmp/x' AS y;", "authorized|prohibited"),
    "write.sql": (lambda _: b"CREATE TABLE a (b); PRAGMA writable_schema = 1;", "not authorized"),
    "load.sql": (lambda _: b"CREATE TABLE a (b); SELECT load_extension('x');", "authorized"),
    "loop.sql": (
        lambda _: (
            b"CREATE TABLE a AS WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i FROM n;"
        ),
        "authorized",
    ),
}


def refused(place, capsys, name, content):
    (place / name).write_bytes(content)
    before = rows(place, "lbr").revision
    code, out, err = lbr(capsys, place / name)
    assert (code, out, len(err.splitlines())) == (2, "", 1), err
    assert rows(place, "lbr").revision == before
    return err.removeprefix("lbr: ")


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_one_sentence_and_changes_nothing(place, capsys, name, wording):
    wording(refused(place, capsys, name, BAD[name](place)))


@pytest.mark.parametrize("name", BAD_SQL)
def test_what_sqlite_itself_refuses_changes_nothing(place, capsys, name):
    content, why = BAD_SQL[name]
    assert re.search(why, refused(place, capsys, name, content(place)))


def test_what_is_no_file_and_what_is_asked_wrongly_is_one_sentence(place, capsys, wording):
    os.mkfifo(place / "pipe")
    (place / "loop").symlink_to("loop")
    (place / "sparse.sqlite3").touch()
    os.truncate(place / "sparse.sqlite3", 1 << 30)
    (place / "bow.mtn").write_bytes(motion_file(Page("Bow", BOW)))
    for arguments in (
        (place / "pipe",),
        ("/dev/zero",),
        (place / "loop",),
        (place / "nowhere",),
        (place / "sparse.sqlite3",),
        (place / "old",),
        (place / "bow.mtn", "--as", "mp3"),
        (place / "bow.mtn", "--as", "lbr-database"),
        (place / "bow.mtn", "--as", "rbm"),
        (place / "bow.mtn", "--robot", "nobody"),
        (place / "bow.mtn", "--robot", "lbr"),
    ):
        code, out, err = lbr(capsys, *arguments)
        assert (code, out, len(err.splitlines())) == (2, "", 1), err
        wording(err)
