"""The page of the robot lbr says every word of its console, and what it types means what the rows say."""

import pytest

from lbr.console.verbs import ExternalCall, ExternalStop, PythonLine, VerbCall, Vocabulary
from lbr.database.rows import BUILT_IN_VERBS
from lbr.database.store import Database
from tests.docs.pages import ROOT, said
from tests.support import databases
from tests.support.words import with_words

PAGE = ROOT / "docs" / "robots" / "lbr.md"


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("lbr") / "robot.db"
    databases.fresh(path)
    with Database.open(path) as database:
        return with_words(database.load("lbr"))


def test_every_word_of_lbr_is_on_its_page_and_no_other(rows):
    words = Vocabulary(rows.verbs, rows.external_commands)
    calls = [words.parse(line) for line in said(PAGE)]
    patterns = {call.verb.pattern for call in calls if isinstance(call, VerbCall)}
    assert {row.pattern for row in (*BUILT_IN_VERBS, *rows.verbs)} - patterns == set()
    started = {call.command.name for call in calls if isinstance(call, ExternalCall)}
    assert {row.name for row in rows.external_commands if row.enabled} - started == set()
    assert any(isinstance(call, ExternalStop) for call in calls)
    assert any(isinstance(call, PythonLine) for call in calls)
