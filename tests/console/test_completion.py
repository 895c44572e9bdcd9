import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from lbr.console.completion import LineCompleter
from lbr.console.verbs import Vocabulary
from lbr.database.rows import ExternalCommandRow, VerbRow
from lbr.messages.drive import DriveCommand


def verb(pattern: str, target: str) -> VerbRow:
    word = pattern.lstrip("/").partition("/")[0]
    return VerbRow(word=word, pattern=pattern, target=target, role="operate", help=f"does {word}")


VOCABULARY = Vocabulary(
    [
        verb("/r/{power}/{angle_deg}", "drive.command"),
        verb("/r/{power}/{angle_deg}/{range_cm}/{sensor}/{interval_s}", "drive.command"),
        verb("/report/{name}", "executive.report"),
    ],
    [
        ExternalCommandRow(name="clock", argv=("/bin/date",)),
        ExternalCommandRow(name="beam", argv=("/bin/echo",), arguments=(("left", "right"), "[0-9]+")),
    ],
    {"drive.command": DriveCommand},
)
KNOWN = {
    "executive.report": ["health", "events"],
    "drive.command.sensor": ["back", "bottom", "forward", "left", "right"],
}
COMPLETER = LineCompleter(VOCABULARY.entries(KNOWN))


def offered(text: str) -> list[str]:
    return [
        one.text or one.display_text
        for one in COMPLETER.get_completions(Document(text), CompleteEvent(completion_requested=True))
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "",
            [
                "s",
                "S",
                "stop",
                "estop",
                "/estop/",
                "reset",
                "status",
                "help",
                "/help/",
                "Shutdown",
                "/r/",
                "/report/",
                "clock",
                "beam",
            ],
        ),
        ("/re", ["/report/"]),
        ("ST", ["stop", "status"]),
        ("stop c", ["clock"]),
        ("/r/", ["power: 0 to 1"]),
        ("/r/0.2/", ["angle: -360 to 360 degrees"]),
        ("/r/0.2/0/40/", ["back", "bottom", "forward", "left", "right"]),
        ("/r/0.2/0/40/F", ["forward"]),
        ("/r/0.2/0/40/forward/1/", []),
        ("/report/", ["events", "health"]),
        ("/nothing/", []),
        ("//", []),
        ("///x", []),
        ("clock ", []),
        ("clock -", []),
        ("beam ", ["left", "right"]),
        ("beam r", ["right"]),
        ("beam left ", ["argument_2: what fits [0-9]+"]),
        ("beam left 1 ", []),
    ],
)
def test_completion_offers_words_then_what_each_field_may_be(text, expected):
    assert offered(text) == expected


@pytest.mark.parametrize("entry", [{}, {"word": "x"}, {"word": "x", "pattern": "/x/{a}"}])
def test_entries_of_other_versions_do_not_break_completion(entry):
    completer = LineCompleter([entry])
    for text in ("", "/x/", "x"):
        list(completer.get_completions(Document(text), CompleteEvent()))


def test_an_empty_line_offers_nothing_until_tab_asks():
    assert not list(COMPLETER.get_completions(Document(""), CompleteEvent(text_inserted=True)))


def test_what_follows_a_word_of_lbr_itself_is_completed_after_a_space():
    words = Vocabulary([verb("why", "executive.why"), verb("/why/{part}", "executive.why")])
    completer = LineCompleter(words.entries({"executive.why": ["drive", "dock", "left_knee"]}))
    for text, expected in (("why d", ["dock", "drive"]), ("/why/l", ["left_knee"]), ("why drive x", [])):
        found = completer.get_completions(Document(text), CompleteEvent(completion_requested=True))
        assert [one.text for one in found] == expected
