"""A table of a user's own: a class and a kind in one file, its rows in another, and nothing of lbr is changed for it."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.support import databases
from tests.support.robot import Robot, lbr
from tests.support.waiting import until

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
pytestmark = [pytest.mark.slow_start]


def sql(robot: Robot, script: str) -> None:
    with closing(sqlite3.connect(robot.home / "robot.db", timeout=5.0)) as database:
        database.executescript(script)


def said(robot: Robot) -> dict[str, int]:
    return dict(databases.asked(robot.home / "robot.db", "SELECT name, said FROM greeting"))


def greet(robot: Robot, name: str) -> str:
    reply = robot.ask("greetings/greet", {"name": name})
    return str(reply["reason"]) if reply else ""


def test_a_kind_brings_its_table_reads_it_and_writes_back_what_it_learns(robot):
    folder = robot.home / "capabilities"
    folder.mkdir(mode=0o700, exist_ok=True)
    kind = "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'early', 'greetings')"
    shutil.copy(EXAMPLES / "greetings.py", folder)
    (folder / "greetings.py").chmod(0o600)
    sql(robot, kind)
    missing = "'greetings' reads the table 'greeting', which is not there, or has not the triggers"
    until(lambda: any(missing in problem for problem in robot.status()["problems"]), what="the table is missed")
    sql(robot, "DELETE FROM capability WHERE name = 'early'")
    made = lbr(robot.home, "db", "table", "greetings")
    sql(robot, made.stdout + (EXAMPLES / "greetings.sql").read_text())
    until(lambda: greet(robot, "ann") == "Good day, Ann.", what="it greets by its rows")
    assert "there is no row of 'greeting' for eve" in greet(robot, "eve")
    pid = until(lambda: robot.capability("greetings")["pid"])
    until(lambda: said(robot) == {"ann": 1, "bob": 0}, what="what it learnt is written")
    assert greet(robot, "ann") == "Good day, Ann."
    until(lambda: said(robot) == {"ann": 2, "bob": 0}, what="a row that it had is changed")
    ((newest,),) = databases.asked(robot.home / "robot.db", "SELECT max(id) FROM revision")
    until(lambda: robot.status()["revision"] == newest, what="the rows were read again")
    assert robot.capability("greetings")["pid"] == pid
    sql(robot, "PRAGMA ignore_check_constraints = ON; UPDATE greeting SET text = '' WHERE name = 'bob'")
    why = "greeting 'lbr/bob', text: is empty"
    until(lambda: why in robot.status()["problems"], what="a bad row is named")
    assert greet(robot, "bob") == "Hello Bob!"
    sql(robot, "UPDATE greeting SET text = 'Hi, Bob.' WHERE name = 'bob'")
    until(lambda: greet(robot, "bob") == "Hi, Bob.", what="a good edit is in force")
