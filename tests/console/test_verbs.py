import msgspec
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lbr.apps.recorder.messages import RecordCommand
from lbr.console.fields import Message
from lbr.console.verbs import ExternalCall, ExternalStop, PythonLine, VerbCall, Vocabulary
from lbr.database import builtin
from lbr.database.rows import ExternalCommandRow, VerbRow
from lbr.errors import InputError
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import StopCommand


def verb(pattern: str, target: str, payload: dict | None = None) -> VerbRow:
    word = pattern.lstrip("/").partition("/")[0]
    return VerbRow(word=word, pattern=pattern, target=target, role="operate", help=f"does {word}", payload=payload)


CLOCK = ExternalCommandRow(name="clock", argv=("/bin/date",), blocking=True)
BEAM = ExternalCommandRow(name="beam", argv=("/bin/echo",), arguments=(("left", "right"), "[0-9]+ cm|-1"))
SONG_SCHEMA = {
    "type": "object",
    "properties": {"song": {"type": "string", "maxLength": 20}, "times": {"type": "integer", "minimum": 1}},
    "required": ["song"],
}
VOCABULARY = Vocabulary(
    [
        verb("/r/{power}/{angle_deg}", "drive.command"),
        verb("/r/{power}/{angle_deg}/{range_cm}/{sensor}/{interval_s}", "drive.command"),
        verb("/go/{distance_cm}/{power}", "drive.command", {"angle_deg": 0}),
        verb("f", "drive.command", {"power": 0.25, "angle_deg": 0}),
        verb("/s/{text...}", "speech.say"),
        verb("/d/{song}", "dance.play"),
        verb("/d/{song}/{times}", "dance.play"),
        verb("/report/{name}", "executive.report"),
        verb("/report/all", "executive.report", {"name": "*"}),
    ],
    [CLOCK, BEAM, ExternalCommandRow(name="gone", argv=("/bin/true",), enabled=False)],
    {"drive.command": DriveCommand, "drive.stop": StopCommand, "dance.play": SONG_SCHEMA},
)


@pytest.mark.parametrize(
    ("line", "target", "payload"),
    [
        ("/r/0.2/0", "drive.command", {"power": 0.2, "angle_deg": 0.0}),
        ("//r//0.2///0", "drive.command", {"power": 0.2, "angle_deg": 0.0}),
        ("  /r/.5/-90/ \n", "drive.command", {"power": 0.5, "angle_deg": -90.0}),
        (
            "/r/0.2/0/40/Forward/0",
            "drive.command",
            {"power": 0.2, "angle_deg": 0.0, "range_cm": 40.0, "sensor": "forward", "interval_s": 0.0},
        ),
        ("S", "executive.stop", {}),
        ("s", "executive.stop", {}),
        ("stop", "executive.stop", {}),
        ("STOP", "executive.stop", {}),
        ("/stop", "executive.stop", {}),
        ("/S/", "executive.stop", {}),
        ("/s", "executive.stop", {}),
        ("f", "drive.command", {"power": 0.25, "angle_deg": 0}),
        ("F", "drive.command", {"power": 0.25, "angle_deg": 0}),
        ("/s/a/b", "speech.say", {"text": "a/b"}),
        ("/s/see http://x//y", "speech.say", {"text": "see http://x//y"}),
        ("/d/waltz/3", "dance.play", {"song": "waltz", "times": 3}),
        ("/report/telemetry", "executive.report", {"name": "telemetry"}),
        ("/report/all", "executive.report", {"name": "*"}),
        ("Shutdown", "executive.shutdown", {}),
    ],
)
def test_a_line_becomes_its_message(line, target, payload):
    call = VOCABULARY.parse(line)
    assert isinstance(call, VerbCall)
    assert f"{call.capability}.{call.command}" == target
    assert call.payload == payload


@pytest.mark.parametrize(
    "line",
    [
        "/r/3/0",
        "/r/nan/0",
        "/r/inf/0",
        "/r/0x1/0",
        "/r/1_0/0",
        "/r/1e-1/0",
        "/r/\u0660.\u0662/0",
        "/r/-0.1/0",
        "/r/0.2/400",
        "/go/0/0.2",
        "/go/-0/0.2",
        "/r/0.2/0/900/forward/0",
        "/r/0.2/0/40/up!/0",
        "/d/" + "a" * 30,
        "/d/waltz/0",
        "/d/waltz/1.5",
        "/r/0.2",
        "/r",
        "/x/1",
        "stpo",
        "shutdown",
        "/stpo",
        "quit",
        "/exit",
        "?",
        "/stop/it",
        "s now",
        "stop it",
        "gone",
        "clock 'a",
        "/" * 9,
        "x" * 5000,
        "/s/a\x1b[2Jb",
        "/s/a\nS",
        "/s/\u202egnp",
        b"/s/\xff",
        "/s/\udcff",
    ],
)
def test_bad_input_gets_one_line_that_says_what_is_allowed(line, wording):
    with pytest.raises(InputError) as err:
        VOCABULARY.parse(line)
    wording(err.value)
    assert str(err.value).isprintable()


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("/x/1", "unknown_command"),
        ("stpo", "unknown_command"),
        ("quit", "unknown_command"),
        ("stop it", "unknown_name"),
        ("/r/3/0", "bad_value"),
        ("/r", "bad_value"),
    ],
)
def test_a_program_tells_a_word_that_is_not_there_from_one_with_a_wrong_value(line, code):
    with pytest.raises(InputError) as err:
        VOCABULARY.parse(line)
    assert err.value.code == code


def test_an_external_command_takes_what_its_row_allows_and_is_stopped_by_name():
    assert VOCABULARY.parse("beam left '12 cm'") == ExternalCall(command=BEAM, arguments=("left", "12 cm"))
    assert VOCABULARY.parse("beam") == ExternalCall(command=BEAM)
    assert VOCABULARY.parse("/clock") == ExternalCall(command=CLOCK)
    assert VOCABULARY.parse("Stop clock") == ExternalStop(command=CLOCK)


@pytest.mark.parametrize(
    "line",
    [
        "clock -f /etc/passwd",
        "clock ''",
        "beam up",
        "beam left -1",
        "beam left '1 cm' more",
    ],
)
def test_an_argument_that_the_row_does_not_allow_is_refused(line, wording):
    with pytest.raises(InputError) as err:
        VOCABULARY.parse(line)
    wording(err.value)


def test_help_tells_the_arguments_that_a_program_takes():
    assert "beam [left or right] [what fits [0-9]+ cm|-1]" in VOCABULARY.help()
    (entry,) = (entry for entry in VOCABULARY.entries() if entry["word"] == "beam")
    assert [field["choices"] for field in entry["fields"]] == [["left", "right"], []]


def test_python_and_empty_lines_are_told_apart():
    assert VOCABULARY.parse("!1 + 1") == PythonLine(code="1 + 1")
    assert VOCABULARY.parse(" \t\n") is None


def test_a_row_that_leaves_out_a_field_is_refused_naming_it():
    with pytest.raises(InputError, match="power"):
        Vocabulary([verb("g", "drive.command")], (), {"drive.command": DriveCommand}).parse("g")


@pytest.mark.parametrize("text", ["left", "0.5", "true"])
def test_what_may_be_of_several_types_is_taken_as_it_is_written(text):
    schema = {"type": "object", "properties": {"value": {"anyOf": [{"type": "boolean"}, {"type": "string"}]}}}
    vocabulary = Vocabulary([verb("/fault/{value}", "world.fault")], (), {"world.fault": schema})
    assert vocabulary.parse(f"/fault/{text}").payload == {"value": text}


def test_entries_tell_completion_the_fields_and_their_choices():
    entries = VOCABULARY.entries({"executive.report": ["drive", "battery"], "drive.command.power": ["0.2"]})
    assert entries[len(builtin.WORDS) + 1]["fields"][0]["choices"] == ["0.2"]
    assert entries[len(builtin.WORDS) + 1]["fields"][3] == {"name": "sensor", "hint": "a text", "choices": []}
    assert next(entry for entry in entries if entry["word"] == "report")["choices"] == ["battery", "drive"]
    assert entries[-1] == {
        "word": "beam", "pattern": "beam", "role": "operate", "help": "", "target": "external", "fields": [
            {"name": "argument_1", "hint": "left or right", "choices": ["left", "right"]},
            {"name": "argument_2", "hint": "what fits [0-9]+ cm|-1", "choices": []},
        ],
    }  # fmt: skip


def test_help_shows_every_pattern_as_people_say_it():
    assert "/r/power/angle/range/sensor/interval" in VOCABULARY.help()


def test_help_of_a_robot_is_of_what_runs_and_of_its_own_words():
    told = VOCABULARY.help(("speech",))
    assert "/r/power" not in told
    assert "\nshutdown " in told.lower()
    assert "beam [left or right]" in told
    assert VOCABULARY.help(("drive",)).count("/r/power") == VOCABULARY.help().count("/r/power")


pieces = st.sampled_from(["/", "r", "s", "stop", " ", "0.2", "forward", "!", "'", "\\", "clock", "\x00", "é", "\uff19"])
lines = st.one_of(st.text(max_size=60), st.lists(pieces | st.text(max_size=3), max_size=20).map("".join), st.binary())


@given(lines)
@example("/r/" + "9" * 400 + "/0")
@example("/d/a/" + "9" * 400)
def test_any_line_parses_or_is_refused_in_one_printable_line(line):
    assert refusal(line).isprintable()


def refusal(line: str | bytes) -> str:
    try:
        VOCABULARY.parse(line)
    except InputError as err:
        return str(err) or "\n"
    return ""


@given(st.floats(0, 1), st.floats(-360, 360))
def test_every_number_in_range_comes_through(power, angle):
    call = VOCABULARY.parse(f"/r/{power:.6f}/{angle:.6f}")
    assert call.payload["power"] == pytest.approx(power, abs=1e-6)
    assert call.payload["angle_deg"] == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize("line", ["s", "S", "stop", "STOP", "/stop", "//s/", " stop "])
def test_the_stop_words_are_there_without_rows_and_whatever_rows_say(line):
    stolen = [verb(pattern, "drive.command", {"power": 1.0, "angle_deg": 0}) for pattern in ("s", "S", "stop", "/stop")]
    for vocabulary in (Vocabulary([]), Vocabulary(stolen, [ExternalCommandRow(name="s", argv=("/bin/true",))])):
        call = vocabulary.parse(line)
        assert isinstance(call, VerbCall)
        assert (call.capability, call.command, call.verb.role) == ("executive", "stop", "view")


def test_a_word_needs_the_higher_of_the_roles_of_its_row_and_of_its_command():
    rows = [verb("a", "x.low"), verb("b", "x.high"), msgspec.structs.replace(verb("c", "x.low"), role="admin")]
    vocabulary = Vocabulary(rows, (), {}, {"x.low": "view", "x.high": "admin"})
    assert [vocabulary.parse(line).verb.role for line in "abc"] == ["operate", "admin", "admin"]


OWN = Vocabulary(
    [
        verb("f", "drive.command", {"power": 0.25}),
        verb("/f/{power}", "drive.command"),
        verb("why", "executive.why"),
        verb("/why/{part}", "executive.why"),
    ]
)


@pytest.mark.parametrize(
    ("line", "payload"),
    [("why", {}), ("why drive", {"part": "drive"}), ("/why/drive", {"part": "drive"}), ("why  left_knee ", {"part": "left_knee"})],
)  # fmt: skip
def test_a_word_of_lbr_itself_takes_its_one_field_after_a_space(line, payload):
    found = OWN.parse(line)
    assert isinstance(found, VerbCall)
    assert (found.capability, found.command, found.payload) == ("executive", "why", payload)


def test_an_emergency_stop_with_words_after_it_is_one_and_gives_them_as_the_reason():
    found = OWN.parse("estop the dog is under it")
    assert isinstance(found, VerbCall)
    assert (found.command, found.payload) == ("estop", {"reason": "the dog is under it"})


def test_a_word_of_a_capability_does_not():
    with pytest.raises(InputError, match="nothing may follow 'f'"):
        OWN.parse("f 0.3")


def test_a_recordings_name_that_cannot_be_is_told_by_the_characters_it_may_have():
    with pytest.raises(InputError, match=r"name 'a b' is not a file's name \(letters, digits"):
        Message(RecordCommand).field("name").read("a b")


def test_a_word_that_changes_the_robot_is_never_proposed():
    close = VerbRow(word="close", pattern="close", target="executive.close", role="admin", help="shuts the door")
    with pytest.raises(InputError) as refused:
        Vocabulary([close]).parse("clear")
    assert refused.value.code == "unknown_command"
    assert "close" not in str(refused.value)


def test_a_part_that_is_taken_for_a_word_is_told_where_its_words_are():
    with pytest.raises(InputError, match="'help drive'") as refused:
        VOCABULARY.parse("drive")
    assert refused.value.code == "unknown_command"
