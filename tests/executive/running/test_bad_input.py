"""Rubbish on every key and line of a running robot, and clients without a password: nothing dies, nothing moves."""

import json
import random
import sqlite3
import string
import sys
import time
from subprocess import PIPE, Popen

import pytest

from lbr.bus import session, stamp, wire
from lbr.bus.access import TOOLS, Credentials
from lbr.database.connection import BUSY_TIMEOUT_S
from tests.support.robot import Robot, lbr, running
from tests.support.waiting import until

KEYS = (
    "drive/command", "drive/stop", "drive/state", "motors/setpoint", "motors/enable", "motors/state", "ranges/readings",
    "world/fault", "world/picture", "world/pose", "@console", "@estop/reset", "@estop/ack/motors", "@status", "@event",
    "@alive/motors", "@schema/drive/command", "@estop/release/motors",
)  # fmt: skip


def rubbish(dice: random.Random) -> bytes:
    values = [
        float("nan"),
        float("inf"),
        -1e308,
        10**40,
        None,
        True,
        "x" * 300,
        "\x00",
        [],
        {},
        [[[]]],
        -0.0,
        "0.5",
        1e-320,
    ]
    kind = dice.randrange(6)
    if kind == 0:
        return dice.randbytes(dice.randrange(200))
    if kind == 1:
        return b"[" * dice.randrange(1, 20_000)
    if kind == 2:
        return json.dumps(dice.choice(values)).encode()
    if kind == 3:
        text = json.dumps({"power": 0.5, "angle_deg": 0, "lease": "", "left": 0.4, "right": 0.4})
        cut = dice.randrange(len(text))
        return (text[:cut] + dice.choice(string.printable) + text[cut + 1 :]).encode()[: dice.randrange(1, 90)]
    fields = [
        "power",
        "angle_deg",
        "lease",
        "range_cm",
        "sensor",
        "interval_s",
        "ttl_s",
        "take_over",
        "left",
        "right",
        "enabled",
    ]
    return json.dumps({field: dice.choice(values) for field in dice.sample(fields, dice.randrange(1, 6))}).encode()


def pids(robot: Robot) -> dict[str, int]:
    return {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]}


def outputs(robot: Robot) -> list[str]:
    return [line for line in robot.trace.read_text().splitlines() if " line " not in line]


def test_rubbish_on_every_key_kills_nothing_and_moves_nothing(robot):
    dice = random.Random(20)
    before, moved, asked = pids(robot), outputs(robot), []
    for round_ in range(1200):
        key = f"{robot.name}/{dice.choice(KEYS)}"
        payload = rubbish(dice)
        if key.endswith("command") and b'"power"' in payload and b'"lease": ""' in payload:
            payload = payload[:40]  # a well-formed command is no rubbish
        attachment = rubbish(dice)[:3000] if round_ % 3 else b""
        if round_ % 2:
            robot.bus.put(key, payload, attachment=attachment)
        else:
            asked.append(robot.bus.get(key, payload=payload, attachment=attachment))
        if round_ % 100 == 99:
            for answers in asked:
                list(answers)
            asked.clear()
    assert robot.status()["ready"]
    assert pids(robot) == before
    assert outputs(robot) == moved
    until(lambda: robot.line("/r/0.1/180")["code"] == 0, what="it drives")
    robot.line("stop")


STAMP = '{"source":"x","seq":1,"mono_ns":%s,"wall_ns":1,"boot":"%s","seal":"%s"%s}'
POISON = {
    "a seal that is not ASCII": ("motors/setpoint", b'{"left":0.4,"right":0.4}', (STAMP % (1, "", "é", "")).encode()),
    "a payload that is not UTF-8": ("drive/command", b'{"power":0.3,"lease":"\xff"}', b""),
    "a stamp that is not UTF-8": (
        "drive/command",
        b'{"power":9}',
        b'{"source":"\xff","seq":1,"mono_ns":1,"wall_ns":1}',
    ),
    "a stamp nested deeply": ("drive/command", b'{"power":9}', (STAMP % (1, "", "", ',"z":' + "[" * 1900)).encode()),
    "a time of 400 digits": ("drive/command", b'{"power":9}', (STAMP % ("9" * 400, stamp.boot_id(), "", "")).encode()),
    "readings that are not UTF-8": ("ranges/readings", b'{"forward_m":1,"status":{"forward":"\xff"}}', b""),
    "an event that is not UTF-8": ("@event", b'{"kind":"\xff","subject":"x","text":"x"}', b""),
    "an event of a megabyte": ("@event", b'{"kind":"x","subject":"x","text":"' + b"x" * 900_000 + b'"}', b""),
}


@pytest.mark.parametrize("name", POISON)
def test_no_single_message_ends_a_process(robot, name):
    key, payload, attachment = POISON[name]
    before = pids(robot)
    robot.bus.put(f"{robot.name}/{key}", payload, attachment=attachment)
    list(robot.bus.get(f"{robot.name}/{key}", payload=payload, attachment=attachment, timeout=1.0))
    assert robot.line("/report/health")["code"] == 0
    assert pids(robot) == before


@pytest.mark.parametrize("payload", [b'{"engaged":true,"reason":"\xff"}', b'{"engaged":' + b"[" * 5000, b"stop!"])
def test_an_emergency_stop_that_cannot_be_read_latches_everywhere(robot, payload):
    before = pids(robot)
    robot.bus.put(f"{robot.name}/@estop", payload)
    until(lambda: robot.ask("@estop")["acknowledged"] == ["drive", "motors"])
    assert robot.line("/r/0.2/0")["code"] == 1
    assert until(lambda: (said := robot.ask("@estop/reset", {}))["accepted"] and said)
    assert pids(robot) == before
    until(lambda: robot.ask("motors/state")["armed"])


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("dance", 2, "'dance' is not a word"),
        ("/r/0.2", 2, "/r/power/angle"),
        ("/r/2/0", 2, "power is 0 to 1, not 2"),
        ("/r/nan/0", 2, "power is 0 to 1, not 'nan'"),
        ("/r/0.2/inf", 2, "angle is"),
        ("/r/0.2/400", 2, "angle is"),
        ("/r/0.2/0/40/upward/0", 1, "sensor 'upward' is not one of"),
        ("/r/0.2/0/900/forward/0", 2, "range is"),
        ("x" * 1_000_000, 2, "4096 characters"),
        ("/r/0.2/\x1b[31m0", 2, "control character"),
        ("/report/weather", 2, "telemetry"),
        ("!open('/tmp/pwned','w')", 1, "and nowhere else"),
        ("Shutdown", 1, "role 'admin'"),
        ("stop nothing", 2, "nothing"),
    ],
)
def test_a_bad_line_gets_one_sentence_that_says_what_is_allowed(robot, line, code, words):
    result = robot.line(line, role="operate")
    assert result["code"] == code
    assert words in result["text"]
    assert "\n" not in result["text"]
    assert result["text"].isprintable()


def test_a_restart_of_what_does_not_run_says_what_may_have_been_meant(robot):
    result = robot.line("/restart/motor")
    assert (result["code"], result["reason_code"]) == (2, "unknown_name")
    assert "'motor' does not run; did you mean motors" in result["text"]


def test_a_put_that_is_refused_becomes_an_event(robot):
    heard = wire.Subscription(robot.bus, f"{robot.name}/@event", depth=64)
    said = []

    def told() -> bool:
        robot.bus.put(f"{robot.name}/motors/setpoint", b'{"left": 0.5, "right": 0.5}')
        robot.bus.put(f"{robot.name}/drive/command", b'{"power": 7}')
        said.extend(json.loads(raw.payload) for raw in heard.take())
        return {event["subject"] for event in _refused(said)} >= {"drive", "motors"}

    until(told)
    texts = " ".join(event["text"] for event in _refused(said))
    assert "is not wired to lbr/motors/setpoint" in texts
    assert "malformed command" in texts


def _refused(events: list[dict]) -> list[dict]:
    return [event for event in events if event["kind"] == "refused"]


BAD_ROWS = {
    "UPDATE capability SET kind = 'os_system' WHERE robot = 'lbr' AND name = 'motors'": "capability 'lbr/motors', kind",
    "UPDATE capability SET settings = '{\"device\": 3}' WHERE robot = 'lbr' AND name = 'drive'": (
        "capability 'lbr/drive', settings"
    ),
    "DELETE FROM device WHERE name = 'range_board'": "there is no device 'range_board'",
    "UPDATE verb SET target = 'drive.fly' WHERE robot = 'lbr' AND word = 'f'": "'drive' has no command 'fly'",
    "UPDATE external_command SET argv = '[\"date; rm -rf /\", 3]'": "external_command 'lbr/clock', argv",
}


def test_bad_rows_are_named_all_at_once_and_nothing_starts(home):
    with sqlite3.connect(home / "robot.db") as database:
        database.execute("PRAGMA ignore_check_constraints = ON")
        for edit in BAD_ROWS:
            database.execute(edit)
    database.close()
    done = lbr(home, "run", "--no-console")
    assert done.returncode == 2
    assert [words for words in BAD_ROWS.values() if words not in done.stderr] == []
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_a_database_that_cannot_be_used_is_one_sentence(home):
    path = home / "robot.db"
    path.write_bytes(b"not a database at all" * 100)
    done = lbr(home, "run", "--no-console", "--db", str(path))
    assert done.returncode == 2
    assert done.stderr.startswith("lbr: ")
    assert done.stderr.count("\n") == 1
    assert str(path) in done.stderr


def test_a_locked_database_is_one_sentence(home):
    with sqlite3.connect(home / "robot.db") as database:
        database.execute("PRAGMA locking_mode = EXCLUSIVE")
        database.execute("BEGIN EXCLUSIVE")
        done = lbr(home, "run", "--no-console")
    database.close()
    assert done.returncode in {1, 2}
    assert done.stderr.startswith("lbr: ")
    assert "Traceback" not in done.stderr


def test_rows_and_files_that_only_fail_when_used_do_not_end_the_executive(robot):
    shell = json.dumps({"argv": ["/bin/true"], "env": {"A=B": "c"}})
    robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'shell', 'exec', ?)", shell)
    until(lambda: any("'lbr/shell', settings" in problem for problem in robot.status()["problems"]))
    robot.edit("DELETE FROM capability WHERE name = 'shell'")
    folder = robot.home / "capabilities"
    folder.mkdir(mode=0o700, exist_ok=True)
    (folder / "odd.py").write_text(
        "from lbr.capability import Capability, Kind\n"
        "KIND = Kind(name='odd', summary='', family='app', entry=Capability, commands={'go': dict})\n"
    )
    robot.edit("INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'odd', 'odd')")
    until(lambda: any("'go' in 'commands'" in problem for problem in robot.status()["problems"]))
    robot.edit("DELETE FROM capability WHERE name = 'odd'")
    until(lambda: robot.status()["problems"] == [])


def test_an_external_command_without_a_place_for_its_log_is_an_answer(robot):
    robot.edit("INSERT INTO external_command (robot, name, argv) VALUES ('lbr', 'nap', '[\"/bin/sleep\", \"9\"]')")
    until(lambda: robot.line("help")["text"].count("\nnap "))
    logs = robot.home / "logs"
    logs.rename(robot.home / "away")
    try:
        result = robot.line("nap")
    finally:
        (robot.home / "away").rename(logs)
    assert (result["code"], "could not be started" in result["text"]) == (1, True)


def test_a_database_that_is_replaced_under_a_running_robot_is_noticed(home):
    with running(home) as robot:
        (home / "robot.db").rename(home / "old.db")
        until(lambda: any("is gone" in problem for problem in robot.status()["problems"]))
        (home / "old.db").rename(home / "robot.db")
        until(lambda: robot.status()["problems"] == [])


def test_stops_are_answered_while_another_program_locks_the_database(robot):
    with sqlite3.connect(robot.home / "robot.db") as database:
        database.execute("BEGIN IMMEDIATE")
        began = time.monotonic()
        robot.press()
        assert robot.line("s")["code"] == 0
        taken = time.monotonic() - began
        database.rollback()
    database.close()
    assert taken < BUSY_TIMEOUT_S
    assert until(lambda: (said := robot.ask("@estop/reset", {}))["accepted"] and said)


def test_a_press_during_a_reset_leaves_nobody_behind(robot):
    for _ in range(10):
        robot.put("@estop", {"engaged": True})
        until(lambda: robot.ask("@estop")["acknowledged"] == ["drive", "motors"])
        reset = robot.bus.get(f"{robot.name}/@estop/reset", payload=b"{}")
        robot.put("@estop", {"engaged": True})
        list(reset)
        until(
            lambda: (
                len(
                    {
                        robot.ask("drive/state")["estop"],
                        robot.ask("motors/state")["estop"],
                        robot.ask("@estop")["engaged"],
                    }
                )
                == 1
            )
        )
    until(lambda: robot.ask("@estop/reset", {})["accepted"])


STREAMS = ("drive/state", "motors/state", "ranges/readings")
WILDCARDS = ("*/*", "*/state", "drive/*", "dr$*/state", "**", "*/readings", "motors/sta$*")


@pytest.fixture
def stranger(robot):
    with session.open_client(robot.endpoints) as bus:
        yield bus


@pytest.fixture
def inside(robot):
    """A session behind the rights."""
    record = json.loads((robot.home / "run" / "lbr.json").read_text())
    with session.open_client([record["core"]], Credentials(user=TOOLS, password=record["password"])) as bus:
        yield bus


def test_no_wildcard_carries_a_forged_stream_past_the_rights(inside, stranger):
    feeds = [wire.Subscription(inside, f"lbr/{key}", depth=256) for key in (*STREAMS, "drive/stop")]
    heard = []

    def said(what):
        stranger.put("lbr/drive/stop", json.dumps({"said": what}))
        heard.extend(raw.payload for feed in feeds for raw in feed.take())
        return any(what.encode() in payload for payload in heard)

    until(lambda: said("first"), what="what may be put arrives")
    for key in (*STREAMS, *WILDCARDS):
        stranger.put(f"lbr/{key}", json.dumps({"forged": key}))
    until(lambda: said("last"), what="what was put last")
    assert not [payload for payload in heard if b"forged" in payload]


def test_commands_can_be_put_without_a_password(inside, stranger):
    taken = wire.Subscription(inside, "lbr/drive/command", depth=8)
    until(lambda: stranger.put("lbr/drive/command", '{"power": 0}') or taken.take(), what="the command")


def test_a_press_in_the_executives_name_is_a_press(robot, stranger):
    press = {"engaged": True, "reason": "in its name"}
    robot.put("@estop", {"engaged": True, "reason": "the first"})
    until(lambda: robot.status()["estop"]["acknowledged"], what="the first is acknowledged")
    until(lambda: robot.line("reset")["code"] == 0, what="the reset")
    wire.put(stranger, "lbr/@estop", press, source="executive", urgent=True)
    until(lambda: robot.status()["estop"]["reason"] == "in its name", what="it is latched")
    until(lambda: robot.line("reset")["code"] == 0, what="the second reset")


@pytest.mark.parametrize("key", ["lbr/**", "lbr/*/*"])
def test_a_client_that_asks_more_than_it_listens_to_holds_up_no_stop(robot, inside, key):
    command = [sys.executable, "-m", "tests.support.clients.asker", robot.endpoints[0], key]
    with Popen(command, stdout=PIPE) as asker:
        try:
            assert asker.stdout.readline() == b"asking\n"
            end = time.monotonic() + 3.0
            while time.monotonic() < end:
                answers = wire.ask_all(inside, ["lbr/drive/stop"], b"{}", source="test", timeout_s=3.0)
                assert answers, "a stop was not answered"
        finally:
            asker.kill()
