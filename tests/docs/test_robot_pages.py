"""The pages of robots say every word of their consoles, every motion, and none that there is not."""

import json
import re
import sys
from collections.abc import Callable

import pytest

from lbr.console.fields import Message
from lbr.console.verbs import ExternalCall, ExternalStop, PythonLine, VerbCall, Vocabulary
from lbr.database.rows import BUILT_IN_VERBS, RobotRows
from lbr.database.store import Database
from lbr.executive.service.completion_values import REPORTS
from lbr.messages.joints import MotionRow
from lbr.robots.uxa90.driver.messages import InquireCommand
from tests.docs.pages import ROOT, said
from tests.support import databases, programs
from tests.support.words import with_words

PAGES = {name: ROOT / "docs" / "robots" / f"{name}.md" for name in ("lbr", "bioloid", "uxa90")}
MOTIONS = {"bioloid": "| motion | what |", "uxa90": "| motion | number | takes |"}
"""The head of the table of motions on a page."""
OWN = {"bow"}
"""Motions that a page has somebody make."""


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], RobotRows]:
    path = databases.fresh(tmp_path_factory.mktemp("pages") / "robot.db")

    def of(robot: str) -> RobotRows:
        with Database.open(path) as database:
            return with_words(database.load(robot))

    return of


@pytest.mark.parametrize("robot", PAGES)
def test_every_word_is_on_its_page_and_no_other(rows, robot):
    found = rows(robot)
    words = Vocabulary(found.verbs, found.external_commands)
    calls = [words.parse(line) for line in said(PAGES[robot])]
    patterns = {call.verb.pattern for call in calls if isinstance(call, VerbCall)}
    assert {row.pattern for row in (*BUILT_IN_VERBS, *found.verbs)} - patterns == set()
    if robot == "lbr":
        started = {call.command.name for call in calls if isinstance(call, ExternalCall)}
        assert {row.name for row in found.external_commands if row.enabled} - started == set()
        assert any(isinstance(call, ExternalStop) for call in calls)
        assert any(isinstance(call, PythonLine) for call in calls)


@pytest.mark.parametrize("robot", MOTIONS)
def test_every_motion_that_is_played_there_is_a_row_or_made_there(rows, robot):
    text = PAGES[robot].read_text()
    there = {row.name for row in rows(robot).of(MotionRow)}
    captured = set(re.findall(r"/capture/([a-z_0-9]+)", text))
    played = set(re.findall(r"/(?:play|mirror|pose)/([a-z_0-9]+)", text))
    assert played <= there | captured | OWN
    assert set(re.findall(r"`([a-z_0-9]+)`", text.split(MOTIONS[robot])[1].split("\n\n")[0])) == there


def test_whatever_a_page_asks_of_the_uxa90_may_be_asked_at_the_console():
    text = PAGES["uxa90"].read_text()
    what = Message(InquireCommand).field("what")
    asked = set(re.findall(r"/inquire/([a-z_0-9]+)", text))
    assert {what.read(one) for one in asked} == asked
    assert asked >= {"firmware", "serial", "zeros"}
    assert set(re.findall(r"/report/([a-z_]+)", text)) <= set(REPORTS)


def test_the_script_shows_angles_and_their_bounds_so_far():
    elbow = {"id": 6, "raw": 512, "reason": ""}
    states = [{"joints": {"left_elbow": elbow | {"position_rad": angle}}} for angle in (0.0, *([-0.5] * 9), -0.25)]
    states[0]["joints"]["neck"] = {"id": 19, "position_rad": None, "reason": "servo 19 does not answer"}
    script = ROOT / "docs" / "examples" / "joint_angles.py"
    given = "".join(json.dumps(state) + "\n" for state in states)
    done = programs.run([sys.executable, str(script)], input=given, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert "servo 19 does not answer" in lines[2]
    assert lines[-1].split() == ["left_elbow", "6", "512", "-14.3", "-28.6", "0.0", "-0.500", "0.000"]
