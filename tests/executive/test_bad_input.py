"""Rubbish on every key and line of a running robot: answered in one sentence, nothing dies, nothing moves."""

import json
import random
import sqlite3
import string

import pytest

from lbr.bus import wire
from tests.robot import Robot, lbr, until

pytestmark = pytest.mark.timeout(30)

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
    before, moved = pids(robot), outputs(robot)
    for round_ in range(1200):
        key = f"{robot.name}/{dice.choice(KEYS)}"
        payload = rubbish(dice)
        if key.endswith("command") and b'"power"' in payload and b'"lease": ""' in payload:
            payload = payload[:40]  # a well-formed command is no rubbish
        attachment = rubbish(dice)[:3000] if round_ % 3 else b""
        if round_ % 2:
            robot.bus.put(key, payload, attachment=attachment)
        else:
            list(robot.bus.get(key, payload=payload, attachment=attachment, timeout=2.0))
    assert robot.status()["ready"]
    assert pids(robot) == before
    assert outputs(robot) == moved
    assert robot.line("/r/0.1/180")["code"] == 0
    robot.line("stop")


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("dance", 2, "is not a word of this robot"),
        ("/r/0.2", 2, "/r/power/angle"),
        ("/r/2/0", 2, "power is 0 to 1, not 2"),
        ("/r/nan/0", 2, "power is 0 to 1, not 'nan'"),
        ("/r/0.2/inf", 2, "angle is"),
        ("/r/0.2/400", 2, "angle is"),
        ("/r/0.2/0/40/upward/0", 2, "sensor is"),
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
    result = robot.line(line)
    assert result["code"] == code
    assert words in result["text"]
    assert "\n" not in result["text"]
    assert result["text"].isprintable()


def test_a_put_that_is_refused_becomes_an_event(robot):
    heard = wire.Subscription(robot.bus, f"{robot.name}/@event", depth=64)
    said = []

    def told() -> bool:
        robot.bus.put(f"{robot.name}/motors/setpoint", b'{"left": 0.5, "right": 0.5}')
        robot.bus.put(f"{robot.name}/drive/command", b'{"power": 7}')
        said.extend(json.loads(raw.payload) for raw in heard.take())
        return len({event["subject"] for event in _refused(said)}) >= 2

    until(told)
    texts = " ".join(event["text"] for event in _refused(said))
    assert "is not wired to lbr/motors/setpoint" in texts
    assert "malformed command" in texts


def _refused(events: list[dict]) -> list[dict]:
    return [event for event in events if event["kind"] == "refused"]


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        ("UPDATE capability SET kind = 'os_system' WHERE name = 'motors'", "capability 'lbr/motors', kind"),
        (
            "UPDATE capability SET settings = '{\"device\": 3}' WHERE name = 'motors'",
            "capability 'lbr/motors', settings",
        ),
        ("DELETE FROM device WHERE name = 'range_board'", "there is no device 'range_board'"),
        ("UPDATE verb SET target = 'drive.fly' WHERE word = 'f'", "'drive' has no command 'fly'"),
        ("UPDATE external_command SET argv = '[\"date; rm -rf /\", 3]'", "external_command 'lbr/clock', argv"),
        ("DELETE FROM robot", "lbr"),
    ],
)
def test_bad_rows_are_named_and_nothing_starts(home, edit, words):
    with sqlite3.connect(home / "robot.db") as database:
        database.execute("PRAGMA ignore_check_constraints = ON")
        database.execute(edit)
    database.close()
    done = lbr(home, "run", "--no-console")
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("how", ["missing", "writable", "rubbish", "other", "newer"])
def test_a_database_that_cannot_be_used_is_one_sentence(home, how):
    path = home / "robot.db"
    arguments = ["run", "--no-console", "--db", str(path)]
    if how == "missing":
        path.unlink()
    elif how == "writable":
        path.chmod(0o666)
    elif how == "rubbish":
        path.write_bytes(b"not a database at all" * 100)
    elif how == "other":
        path.unlink()
        with sqlite3.connect(path) as database:
            database.execute("CREATE TABLE shopping (item)")
        database.close()
        path.chmod(0o600)
    else:
        with sqlite3.connect(path) as database:
            database.execute("UPDATE alembic_version SET version_num = '9999'")
        database.close()
    done = lbr(home, *arguments)
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
