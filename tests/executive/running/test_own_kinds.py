"""A file of the user's own while the robot runs: one that breaks, hangs or exits, and one that brings a table."""

import json
import os
import shutil
import signal
import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest

from tests.support import commands, databases
from tests.support.commands import here
from tests.support.robot import lbr
from tests.support.waiting import STOPS_S, until

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
GOOD = """
from msgspec import Struct
from lbr.capability import Capability, Kind
class Greeter(Capability):
    pass
KIND = Kind(name="greeter", summary="", family="app", entry=Greeter)
"""
ROW = "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'greeter', 'greeter')"


@pytest.fixture
def file(robot):
    """Where the kind `greeter` is to be; it and its row are gone again after the test."""
    path = robot.home / "capabilities" / "greeter.py"
    yield path
    robot.edit("DELETE FROM capability WHERE name = 'greeter'")
    path.unlink(missing_ok=True)
    until(lambda: "greeter" not in pids(robot) and robot.status()["problems"] == [])


@pytest.fixture
def greeted(robot, file):
    file.write_text(GOOD)
    robot.edit(ROW)
    until(lambda: pids(robot).get("greeter"), what="the file runs")


def pids(robot):
    return {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]}


def test_a_file_that_hangs_holds_up_neither_the_robot_nor_its_stops_nor_other_edits(robot, file, greeted):
    before = pids(robot)
    file.write_text("\nwhile True: pass\n")
    slowest, until_s = 0.0, time.monotonic() + 2.0
    while time.monotonic() < until_s:
        began = time.monotonic()
        assert robot.line("s")["code"] == 0
        slowest = max(slowest, time.monotonic() - began)
    assert slowest < STOPS_S
    words = f"{file}, line 2 is not imported within 5 s"
    until(lambda: any(words in problem for problem in robot.status()["problems"]))
    assert pids(robot) == before
    file.write_text(GOOD)
    until(lambda: robot.status()["problems"] == [])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("import os\nos._exit(3)", "with exit code 3"),
        ("raise KeyboardInterrupt", "greeter.py, line 1 does not load: KeyboardInterrupt"),
        (
            GOOD.replace(
                "class Greeter", "class T: pass\nclass Odd(Struct, frozen=True):\n    t: T\nclass Greeter"
            ).replace("entry=Greeter", 'entry=Greeter, outputs={"odd": Odd}'),
            "greeter.py, line 9: port 'odd' carries Odd, which is not JSON",
        ),
    ],
    ids=["exits", "interrupts", "odd message"],
)
def test_a_file_that_breaks_is_told_and_one_that_is_mended_is_seen_without_another_edit(robot, file, text, words):
    file.write_text(text)
    before = pids(robot)
    robot.edit(ROW)
    until(lambda: any(words in problem for problem in robot.status()["problems"]))
    assert pids(robot) == before
    file.write_text(GOOD)
    until(lambda: "greeter" in pids(robot))
    assert robot.status()["problems"] == []


def test_a_check_says_each_files_fault_in_one_sentence_and_prints_nothing_else(robot, file, greeted):
    file.write_text("print('hello')\nimport nothing_like_this\n")
    done = lbr(robot.home, "db", "check", "--robot", "lbr", "--json")
    assert done.returncode == 2
    (told,) = json.loads(done.stdout)
    why = f"{file}, line 2 does not load: ModuleNotFoundError: No module named 'nothing_like_this'"
    assert told["problems"] == [f"capability 'lbr/greeter', kind: {why}"]
    assert done.stderr == ""


def test_a_check_hints_at_a_mover_that_no_stop_reaches_and_at_a_file_that_is_not_used(robot, file, greeted):
    file.write_text("print('hello')\n" + GOOD.replace("entry=Greeter", "entry=Greeter, moves=True"))
    (file.parent / "drive.py").write_text("raise ValueError")
    try:
        done = lbr(robot.home, "db", "check", "--robot", "lbr", "--json")
    finally:
        (file.parent / "drive.py").unlink()
    assert done.returncode == 0
    hints = " ".join(json.loads(done.stdout)[0]["hints"])
    assert "capability 'greeter' moves something, and `stop` does not reach it" in hints
    assert f"does not run {file.parent / 'drive.py'}: " in hints


def test_what_was_accepted_starts_again_though_a_newer_file_is_refused(robot, file, greeted):
    file.write_text("raise ValueError")
    until(lambda: any("ValueError" in problem for problem in robot.status()["problems"]))
    before = pids(robot)["greeter"]
    os.kill(before, signal.SIGKILL)
    until(lambda: _phase(robot, "greeter") == "ready" and pids(robot)["greeter"] != before)


def _phase(robot, name):
    return next(unit["phase"] for unit in robot.status()["capabilities"] if unit["name"] == name)


def test_who_is_locked_out_is_out_while_a_file_is_broken(robot, file, greeted):
    assert here(robot.home, "token", "add", "tablet", "--role", "operate").returncode == 0
    file.write_text("raise ValueError")
    until(lambda: any("ValueError" in problem for problem in robot.status()["problems"]))
    before = pids(robot)
    assert here(robot.home, "token", "revoke", "tablet").returncode == 0
    until(lambda: "token 'tablet' has no rights any more" in robot.line("/report/events")["text"])
    assert pids(robot)["greeter"] == before["greeter"]
    assert any("ValueError" in problem for problem in robot.status()["problems"])


def test_what_publishes_another_type_than_it_declares_is_told_in_one_sentence(robot, file):
    file.write_text(
        GOOD.replace("    pass", "    def step(self) -> None:\n        self.ctx.publish('said', {'value': 1})")
        .replace("class Greeter", "class Said(Struct, frozen=True):\n    text: str\nclass Greeter")
        .replace("entry=Greeter", "entry=Greeter, outputs={'said': Said}")
    )
    robot.edit(ROW)
    words = "publishes a dict on 'said'"

    def told():
        return any(words in unit["reason"] for unit in robot.status()["capabilities"] if unit["name"] == "greeter")

    until(told, what="it is told")


def sql(robot, script):
    with closing(sqlite3.connect(robot.home / "robot.db", timeout=5.0)) as database:
        database.executescript(script)


def said(robot):
    return dict(databases.asked(robot.home / "robot.db", "SELECT name, said FROM greeting"))


def greet(robot, name):
    reply = robot.ask("greetings/greet", {"name": name})
    return str(reply["reason"]) if reply else ""


def test_a_kind_brings_its_table_reads_it_and_writes_back_what_it_learns(robot, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(robot.home))
    folder = robot.home / "capabilities"
    kind = "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'early', 'greetings')"
    shutil.copy(EXAMPLES / "greetings.py", folder)
    (folder / "greetings.py").chmod(0o600)
    sql(robot, kind)
    missing = "'greetings' reads the table 'greeting', which is not there, or has not the triggers"
    until(lambda: any(missing in problem for problem in robot.status()["problems"]), what="the table is missed")
    sql(robot, "DELETE FROM capability WHERE name = 'early'")
    sql(robot, commands.db("table", "greetings").stdout + (EXAMPLES / "greetings.sql").read_text())
    until(lambda: greet(robot, "ann") == "Good day, Ann.", what="it greets by its rows")
    assert "there is no row of 'greeting' for eve" in greet(robot, "eve")
    pid = until(lambda: robot.capability("greetings")["pid"])
    until(lambda: said(robot) == {"ann": 1, "bob": 0}, what="what it learnt is written")
    assert greet(robot, "ann") == "Good day, Ann."
    until(lambda: said(robot) == {"ann": 2, "bob": 0}, what="a row that it had is changed")
    until(lambda: robot.status()["revision"] == databases.newest(robot.home), what="the rows were read again")
    assert robot.capability("greetings")["pid"] == pid
    sql(robot, "PRAGMA ignore_check_constraints = ON; UPDATE greeting SET text = '' WHERE name = 'bob'")
    why = "greeting 'lbr/bob', text: is empty"
    until(lambda: why in robot.status()["problems"], what="a bad row is named")
    assert greet(robot, "bob") == "Hello Bob!"
    sql(robot, "UPDATE greeting SET text = 'Hi, Bob.' WHERE name = 'bob'")
    until(lambda: greet(robot, "bob") == "Hi, Bob.", what="a good edit is in force")
