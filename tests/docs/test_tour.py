"""The tour says every word of the console, and what it types means what the rows say."""

import re

import pytest

from lbr.console.verbs import ExternalCall, ExternalStop, PythonLine, VerbCall, Vocabulary
from lbr.database.rows import BUILT_IN_VERBS
from lbr.database.store import Database
from lbr.errors import InputError
from tests.docs.pages import ROOT, blocks
from tests.support import databases
from tests.support.words import with_words

TOUR = ROOT / "docs" / "tour.md"
REFUSED = {"/r/3/0"}
"""What is typed to see that it is refused."""


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("tour") / "robot.db"
    databases.fresh(path)
    with Database.open(path) as database:
        return with_words(database.load("lbr"))


def typed() -> list[str]:
    text = "\n".join(block.text for block in blocks(TOUR))
    return re.findall(r"^Robot> (.+)$", text, flags=re.MULTILINE)


def test_every_word_of_the_console_is_in_the_tour(rows):
    words = Vocabulary(rows.verbs, rows.external_commands)
    said = [words.parse(line) for line in typed() if line not in REFUSED]
    patterns = {call.verb.pattern for call in said if isinstance(call, VerbCall)}
    assert {row.pattern for row in (*BUILT_IN_VERBS, *rows.verbs)} - patterns == set()
    started = {call.command.name for call in said if isinstance(call, ExternalCall)}
    assert {row.name for row in rows.external_commands if row.enabled} - started == set()
    assert any(isinstance(call, ExternalStop) for call in said)
    assert any(isinstance(call, PythonLine) for call in said)


def test_what_the_tour_refuses_is_refused(rows):
    from lbr.operations.drive import KIND

    messages = {f"drive.{name}": message for name, message in KIND.messages.items()}
    words = Vocabulary(rows.verbs, rows.external_commands, messages)
    for line in REFUSED:
        with pytest.raises(InputError):
            words.parse(line)
