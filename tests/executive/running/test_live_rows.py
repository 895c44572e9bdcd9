"""A running robot, edited with another SQLite client: only what is affected moves, bad edits change nothing."""

import json
import time

import pytest

from lbr.bus import stamp, wire
from tests.support import databases
from tests.support.commands import here
from tests.support.robot import Robot, lbr
from tests.support.waiting import until

HELLO = """
from msgspec import Struct
from lbr.capability import Capability, Kind

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    word: str = "hello"

class Said(Struct, frozen=True):
    text: str

class Hello(Capability[Settings]):
    def step(self) -> None:
        self.ctx.publish("said", Said(self.ctx.settings.word))

KIND = Kind(name="hello", summary="says a word", family="app", entry=Hello, settings=Settings, outputs={"said": Said})
"""

DEAF = """
from msgspec import Struct
from lbr.capability import Capability, Kind
from lbr.messages.leases import StopCommand

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass

KEPT = []  # a question that is dropped is over at once

class Deaf(Capability[Settings]):
    def step(self) -> None:
        self.ctx.estop.acknowledge(stopped=True)

    def command(self, call) -> None:
        KEPT.append(call)

KIND = Kind(
    name="deaf", summary="hears no stop", family="app", entry=Deaf, settings=Settings, commands={"stop": StopCommand},
    moves=True,
)
"""


def pids(robot: Robot) -> dict[str, int]:
    return {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]}


def phase(robot: Robot, name: str) -> str:
    return next((unit["phase"] for unit in robot.status()["capabilities"] if unit["name"] == name), "absent")


def test_a_capability_of_ones_own_is_a_file_and_a_row(robot):
    before = pids(robot)
    file = robot.home / "capabilities" / "hello.py"
    file.write_text(HELLO)
    robot.edit("INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'greeter', 'hello')")
    until(lambda: phase(robot, "greeter") == "ready")
    until(lambda: robot.ask("greeter/said") == {"text": "hello"})
    robot.edit("""UPDATE capability SET settings = '{"word": "moin"}' WHERE name = 'greeter'""")
    until(lambda: robot.ask("greeter/said") == {"text": "moin"})
    file.write_text(HELLO.replace("Said(self.ctx.settings.word)", "Said(self.ctx.settings.word.upper())"))
    until(lambda: robot.ask("greeter/said") == {"text": "MOIN"})
    robot.edit("UPDATE capability SET enabled = 0 WHERE name = 'greeter'")
    until(lambda: phase(robot, "greeter") == "absent")
    robot.edit("DELETE FROM capability WHERE name = 'greeter'")
    assert {name: pid for name, pid in pids(robot).items() if name in before} == before


def test_a_word_is_a_row(robot):
    assert robot.line("creep")["code"] == 2
    robot.edit(
        "INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES "
        "('lbr', 'creep', 'creep', 'drive.command', ?, 'operate', 'Creep ahead')",
        json.dumps({"power": 0.1, "angle_deg": 0}),
    )
    reply = until(lambda: (said := robot.line("creep"))["code"] == 0 and said)
    assert reply["hold"]["payload"]["power"] == 0.1
    (changed,) = until(lambda: [e for e in robot.events() if e["kind"] == "rows_changed" and "creep" in e["text"]])
    assert changed["data"]["touched"] == ["drive"]
    robot.line("stop")
    robot.edit("DELETE FROM verb WHERE word = 'creep'")
    until(lambda: robot.line("creep")["code"] == 2)


def test_what_holds_the_base_is_named_by_the_word_and_by_the_command_and_what_to_type(robot):
    def told(line: str = "why drive") -> tuple[str, str]:
        found = robot.line(line, role="operate")["data"]
        return found["state"], found["code"]

    until(lambda: told()[0] != "held", what="nothing holds it")
    robot.press()
    until(lambda: not robot.ask("@estop")["waiting"], what="it is acknowledged")
    until(lambda: told() == told("/why/drive") == ("held", "estop"), what="each part told of it")
    why = lambda: json.loads(here(robot.home, "why", "drive", "--json").stdout)  # noqa: E731
    until(lambda: ((said := why())["code"], said["source"]) == ("estop", "bus"))
    part = until(lambda: "estop" in (said := here(robot.home, "status", "drive").stdout) and said)
    assert ("\nmotors " in part, "\ndrive " in part) == (False, True)
    (only,) = json.loads(here(robot.home, "status", "drive", "--json").stdout)["capabilities"]
    assert only["name"] == "drive"
    assert here(robot.home, "status", "driv").returncode == 2
    until(lambda: robot.line("reset")["code"] == 0)
    until(lambda: told()[0] != "held")
    until(lambda: robot.line("why drive", role="view")["data"]["code"] == "role")
    robot.edit("UPDATE capability SET enabled = 0 WHERE name = 'ranges'")
    found = until(lambda: (said := robot.line("why")["data"])["code"] == "off" and said)
    assert "SET enabled = 1" in found["do"]
    robot.edit("UPDATE capability SET enabled = 1 WHERE name = 'ranges'")
    until(lambda: told()[0] != "held", what="ranges are back")
    assert robot.line("why nothing")["reason_code"] == "unknown_name"


def test_no_row_takes_the_words_that_stop_and_end_a_robot(robot):
    robot.edit("DELETE FROM verb")
    until(lambda: robot.line("f")["code"] == 2, what="the rows are gone")
    assert robot.line("/r/5/0")["text"].startswith("power is "), "the words of kinds are not"
    for line in ("s", "S", "stop", "/stop", "STOP"):
        assert (robot.line(line, role="view")["code"], robot.line(line)["text"]) == (0, "stopped"), line
    robot.press(role="view")
    assert "needs the role 'operate'" in robot.line("reset", role="view")["text"]
    until(lambda: robot.line("reset", role="operate")["code"] == 0)
    assert all(robot.line(line, role="view")["code"] == 0 for line in ("status", "help"))
    assert "needs the role 'admin'" in robot.line("Shutdown", role="operate")["text"]
    robot.edit(
        "INSERT INTO verb (robot, word, pattern, target, role) VALUES ('lbr', 'stop', 'stop', 'drive.command', 'admin')"
    )
    sentence = "verb 'lbr/stop/stop', word: 'stop' is a word that every robot has, and no row changes"
    until(lambda: sentence in " ".join(event["text"] for event in robot.events()), what="it is refused by name")
    assert robot.line("stop", role="view")["text"] == "stopped"
    robot.edit("DELETE FROM verb WHERE word = 'stop'")


def test_a_mover_that_does_not_answer_delays_the_stop_of_no_other(robot):
    (robot.home / "capabilities" / "deaf.py").write_text(DEAF)
    robot.edit("INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'deaf', 'deaf')")
    until(lambda: phase(robot, "deaf") == "ready")
    until(lambda: robot.line("/r/0.2/90")["code"] == 0, what="it drives")
    states = wire.Subscription(robot.bus, f"{robot.name}/drive/state", depth=1000)
    result = robot.line("stop")
    answered_ns = time.monotonic_ns()
    assert result["code"] == 1
    assert result["text"].startswith("stopped; 'deaf' did not answer")
    stopped = next(raw for raw in states.take() if b"stopped by" in raw.payload)
    assert stamp.read(stopped.attachment).mono_ns < answered_ns - 5e8, (
        "it was stopped while the deaf one was waited for"
    )
    robot.edit("DELETE FROM capability WHERE name = 'deaf'")
    until(lambda: phase(robot, "deaf") == "absent")


def test_who_may_less_than_a_command_needs_is_refused_whatever_its_row_says(robot):
    robot.edit(
        "INSERT INTO verb (robot, word, pattern, target, role, help) VALUES"
        " ('lbr', 'restart', '/restart/{name}', 'executive.restart', 'view', 'mine'),"
        " ('lbr', 'picture', 'picture', 'world.picture', 'view', 'mine')"
    )
    until(lambda: "mine" in {entry["help"] for entry in robot.line("help")["data"]})
    role = {entry["word"]: entry["role"] for entry in robot.line("help")["data"]}
    assert {role[word] for word in ("restart", "fault", "picture")} == {"admin"}
    for line in ("/restart/ranges", "/fault/range_board/silent", "picture"):
        assert robot.line(line, role="operate")["text"] == "this needs the role 'admin', and you have 'operate'"


def test_an_external_command_is_a_row_and_ends_with_it(robot):
    robot.edit(
        "INSERT INTO external_command (robot, name, argv, blocking, help) VALUES ('lbr', 'nap', ?, 0, '')",
        json.dumps(["/bin/sleep", "60"]),
    )
    until(lambda: robot.line("nap")["code"] == 0)
    assert "runs already" in robot.line("nap")["text"]
    texts = [event["text"] for event in robot.events() if event["kind"] == "external"]
    assert any(text.startswith("'nap' is started by ") and '["/bin/sleep", "60"]' in text for text in texts), texts
    ended = robot.line("stop nap")
    assert (ended["code"], ended["text"], ended["hold"]) == (0, "'nap' has ended", None)
    assert robot.line("nap")["code"] == 0
    robot.edit("DELETE FROM external_command WHERE name = 'nap'")
    until(lambda: robot.line("nap")["code"] == 2)


def test_a_device_row_restarts_its_driver_and_motion_stops_first(robot):
    before = pids(robot)
    robot.edit("""UPDATE capability SET settings = json_set(settings, '$.timeout_s', 0.8) WHERE name = 'ranges'""")
    until(lambda: pids(robot).get("ranges") not in {None, before["ranges"]} and phase(robot, "ranges") == "ready")
    after = pids(robot)
    assert {name for name in before if before[name] != after[name]} == {"ranges"}


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        ("UPDATE capability SET kind = 'os_system' WHERE name = 'ranges'", "capability 'lbr/ranges', kind"),
        (
            (
                "INSERT INTO verb (robot, word, pattern, target)"
                " SELECT 'lbr', 'w' || value, 'w' || value, 'drive.fly' FROM json_each('[1, 2, 3, 4]')"
            ),
            "`lbr db check`",
        ),
    ],
)
def test_a_bad_edit_changes_nothing_and_is_explained(robot, edit, complaint):
    before, good = pids(robot), databases.newest(robot.home)
    robot.edit(edit)
    until(lambda: any(one["kind"] == "rows_refused" and complaint in one["text"] for one in robot.events()))
    assert pids(robot) == before
    assert robot.status()["problems"], "who heard of the refusal reads why in the status"
    assert here(robot.home, "db", "rollback", str(good)).returncode == 0
    until(lambda: robot.status()["problems"] == [])
    assert pids(robot) == before


def test_an_edit_while_driving_stops_what_it_affects(robot):
    hold = until(lambda: (said := robot.line("/r/0.2/180"))["code"] == 0 and said)["hold"]
    edited_ns = time.time_ns()
    robot.edit(
        """UPDATE capability SET settings = json_set(settings, '$.reply_timeout_s', 0.04) WHERE name = 'motors'"""
    )
    refused = until(lambda: _refused(robot, hold), what="the lease to die with the driver it moved")
    assert refused
    started = lambda: {e["subject"] for e in robot.events() if e["kind"] == "started" and e["wall_ns"] > edited_ns}  # noqa: E731
    until(lambda: "motors" in started(), what="its driver begins again")
    until(lambda: (robot.ask("motors/state") or {}).get("left") == 0.0)


def _refused(robot: Robot, hold: dict) -> str:
    answer = robot.ask(hold["key"].partition("/")[2], hold["payload"])
    return "" if answer["accepted"] else answer["reason"]


COMPASS = """
from msgspec import Struct
from lbr.capability import Capability, Kind, Rows
from lbr.messages.calibration import CalibrationValue, measured, values
from lbr.messages.speech import HushCommand

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    device: str = "range_board"

class Known(Struct, frozen=True):
    values: dict[str, float]

class Compass(Capability[Settings]):
    def step(self) -> None:
        self.ctx.publish("known", Known(values(self.ctx.rows(CalibrationValue))))

    def command(self, call) -> None:
        self.ctx.learn(*measured(self.ctx.settings.device, {"offset_ut": 7.5}))
        call.refuse("measured")

KIND = Kind(name="compass", summary="measures", family="app", entry=Compass, settings=Settings,
            outputs={"known": Known}, commands={"measure": HushCommand},
            rows=(Rows(CalibrationValue, where={"device": "device"}, learnt=True),))
"""


def calibrations(robot: Robot) -> list[tuple[str, str, float]]:
    return databases.asked(robot.home / "robot.db", "SELECT device, name, value FROM calibration ORDER BY name")


def test_what_a_capability_measures_is_written_down_and_restarts_nothing_or_is_told_as_lost(robot):
    (robot.home / "capabilities" / "compass.py").write_text(COMPASS)
    robot.edit("INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'compass', 'compass')")
    until(lambda: robot.ask("compass/known") == {"values": {}})
    until(lambda: pids(robot).get("compass"), what="the status knows its process")
    before = pids(robot)
    robot.ask("compass/measure", {})
    until(lambda: calibrations(robot) == [("range_board", "offset_ut", 7.5)])
    until(lambda: any("insert calibration 'range_board/offset_ut'" in event["text"] for event in robot.events()))
    until(lambda: robot.ask("compass/known") == {"values": {"offset_ut": 7.5}})
    assert pids(robot) == before
    robot.edit("UPDATE calibration SET value = 8.5")  # by somebody else's hand it counts as any edit does
    until(lambda: robot.ask("compass/known") == {"values": {"offset_ut": 8.5}})
    assert pids(robot)["compass"] != before["compass"]
    robot.edit("CREATE TRIGGER full BEFORE UPDATE ON calibration BEGIN SELECT RAISE(FAIL, 'there is no room'); END")
    robot.ask("compass/measure", {})
    (lost,) = until(lambda: [event["text"] for event in robot.events() if event["kind"] == "learnt_lost"])
    assert "offset_ut" in lost
    assert "holds until the next restart only" in lost
    assert "there is no room" in lost
    until(lambda: robot.ask("compass/known") == {"values": {"offset_ut": 7.5}})
    assert calibrations(robot) == [("range_board", "offset_ut", 8.5)]
    robot.edit("DROP TRIGGER full")


def test_another_home_does_not_run_the_same_rows(robot, home):
    done = lbr(home, "run", "--no-console", "--db", str(robot.home / "robot.db"))
    assert done.returncode == 3, done.stderr
    assert f"'lbr' already runs from {robot.home / 'robot.db'}, in another home" in done.stderr
    assert phase(robot, "drive") == "ready"
