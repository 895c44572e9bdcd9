"""The page of the UXA-90 says every word of its console, every motion of its main board, and none that there is not."""

import re

import pytest

from lbr.console.fields import Message
from lbr.console.verbs import VerbCall, Vocabulary
from lbr.database.rows import BUILT_IN_VERBS
from lbr.database.store import Database
from lbr.executive.service.completion_values import REPORTS
from lbr.messages.joints import MotionRow
from lbr.robots.uxa90.driver.messages import InquireCommand
from tests.docs.pages import ROOT, said
from tests.support import databases
from tests.support.words import with_words

PAGE = ROOT / "docs" / "robots" / "uxa90.md"
OWN = {"bow"}
"""Motions that the page has somebody make."""


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("uxa90") / "robot.db"
    databases.fresh(path)
    with Database.open(path) as database:
        return with_words(database.load("uxa90"))


def test_every_word_of_the_uxa90_is_on_its_page_and_no_other(rows):
    words = Vocabulary(rows.verbs, rows.external_commands)
    calls = [words.parse(line) for line in said(PAGE)]
    found = {call.verb.pattern for call in calls if isinstance(call, VerbCall)}
    assert {row.pattern for row in (*BUILT_IN_VERBS, *rows.verbs)} - found == set()


def test_every_motion_that_is_played_there_is_a_row_or_made_there(rows):
    text = PAGE.read_text()
    played = set(re.findall(r"/(?:play|mirror|capture)/([a-z_0-9]+)", text))
    assert played <= {row.name for row in rows.of(MotionRow)} | OWN
    told = set(re.findall(r"`([a-z_0-9]+)`", text.split("| motion | number | takes |")[1].split("\n\n")[0]))
    assert {row.name for row in rows.of(MotionRow)} == told


def test_whatever_the_page_has_somebody_ask_may_be_asked_at_the_console():
    what = Message(InquireCommand).field("what")
    asked = set(re.findall(r"/inquire/([a-z_0-9]+)", PAGE.read_text()))
    assert {what.read(one) for one in asked} == asked
    assert asked >= {"firmware", "serial", "zeros"}


def test_every_report_that_the_page_asks_for_is_one():
    assert set(re.findall(r"/report/([a-z_]+)", PAGE.read_text())) <= set(REPORTS)
