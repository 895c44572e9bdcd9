"""The page of the Bioloid says every word of its console, and none that there is not."""

import json
import re
import sys

import pytest

from lbr.console.verbs import VerbCall, Vocabulary
from lbr.database.rows import BUILT_IN_VERBS
from lbr.database.store import Database
from lbr.messages.joints import MotionRow
from tests.docs.pages import ROOT, said
from tests.support import databases, programs
from tests.support.words import with_words

PAGE = ROOT / "docs" / "robots" / "bioloid.md"


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("bioloid") / "robot.db"
    databases.fresh(path)
    with Database.open(path) as database:
        return with_words(database.load("bioloid"))


def test_every_word_of_the_bioloid_is_on_its_page_and_no_other(rows):
    words = Vocabulary(rows.verbs, rows.external_commands)
    calls = [words.parse(line) for line in said(PAGE)]
    assert {row.pattern for row in (*BUILT_IN_VERBS, *rows.verbs)} - {
        call.verb.pattern for call in calls if isinstance(call, VerbCall)
    } == set()


def test_every_motion_that_is_played_there_is_a_row_or_captured_there(rows):
    text = PAGE.read_text()
    captured = set(re.findall(r"/capture/([a-z_]+)", text))
    played = set(re.findall(r"/(?:play|mirror|pose)/([a-z_]+)", text))
    assert played <= {row.name for row in rows.of(MotionRow)} | captured
    told = set(re.findall(r"`([a-z_]+)`", text.split("| motion | what |")[1].split("\n\n")[0]))
    assert {row.name for row in rows.of(MotionRow)} == told


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
