"""What a recording with lines says of a device: to each question the answer of its time, whole or in pieces, and rubbish harms nothing."""

import threading

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.recorder.recording import chunks, lines
from lbr.apps.recorder.recording.chunks import Channel, Channels, Contents, Message
from lbr.apps.recorder.recording.lines import RecordedLine
from lbr.messages.taped import LineBytes, Taped, TapedCommand, TapedLine

MS = 1_000_000
questions = st.lists(st.integers(0, 99).map(lambda number: b"?%02d\r" % number), min_size=1, max_size=30)


def asked(sent, every_ms=20):
    """Return the pieces of a line on which these were asked, each answered by its turn."""
    found = []
    for turn, question in enumerate(sent):
        at_ns = turn * every_ms * MS
        found += [LineBytes(at_ns, True, question), LineBytes(at_ns + MS, False, b"%d\r" % turn)]
    return found


def message(taped, topic="@taped/motors", log_ns=1_000 * MS):
    data = taped if isinstance(taped, bytes) else msgspec.json.encode(taped)
    return Message(Channel(topic), log_ns, log_ns, 1, data)


@given(questions)
def test_each_question_has_the_answer_of_its_time(sent):
    line = RecordedLine("motors", asked(sent))
    for turn, question in enumerate(sent):
        assert [one.data for one in line.answers(question, turn * 20 * MS)] == [b"%d\r" % turn]


@given(questions)
def test_questions_that_come_together_are_told_apart(sent):
    line, rest = RecordedLine("motors", asked(sent)), b"".join(sent)
    for question in sent:
        found, unfinished = line.question(rest)
        assert (found, unfinished) == (question, False)
        rest = rest[len(found) :]


def test_what_was_never_sent_ends_where_a_question_begins_and_has_the_answer_of_its_like():
    line = RecordedLine("motors", asked([b"!M 200 200\r", b"?A\r"]))
    assert line.question(b"!M 201 200\r?A\r") == (b"!M 201 200\r", False)
    assert line.question(b"!M 20") == (b"!M 20", True)
    assert [one.data for one in line.answers(b"!M 201 200\r", 0)] == [b"0\r"]
    assert line.answers(b"\xff\xff\x08", 0) == ()


def test_an_answer_is_not_from_before_what_it_is_because_of():
    before = [LineBytes(turn * 180 * MS, True, b"torque?") for turn in range(4)]
    pieces = []
    for turn, one in enumerate(before):
        pieces += [one, LineBytes(one.at_ns + MS, False, b"on" if turn > 1 else b"off")]
    switched = LineBytes(300 * MS, True, b"torque on!")
    line = RecordedLine("servos", sorted([*pieces, switched], key=lambda one: one.at_ns))
    assert line.answers(b"torque?", 190 * MS)[0].data == b"off"
    line.answers(b"torque on!", 260 * MS)  # earlier than then
    assert line.answers(b"torque?", 262 * MS)[0].data == b"on"


def test_what_comes_by_itself_has_its_time_alone():
    line = RecordedLine("ranges", [LineBytes(turn * 100 * MS, False, b"%d" % turn) for turn in range(5)])
    assert line.came(100 * MS, 300 * MS) == [b"2", b"3"]
    assert not line.exchanges


def test_lines_and_commands_are_dated_by_the_recording():
    command = TapedCommand(
        name="stop",
        source="me",
        at_ns=20 * MS,
        payload=b"{}",
        answerable=True,
        answered_ns=21 * MS,
        reply=msgspec.Raw(b"{}"),
    )
    opened = TapedLine(device="motor", pieces=(LineBytes(1 * MS, True, b"?"),), opening=True)
    first = message(Taped(now_ns=10 * MS, lines=(opened,)))
    second = message(Taped(now_ns=30 * MS, commands=(command,)), log_ns=1_020 * MS)
    found = lines.recorded_lines([first, second])
    assert [one.at_ns for one in found.lines["motor"].exchanges] == [991 * MS]
    assert [(one.to, one.at_ns, one.answered_ns) for one in found.commands] == [("motors", 1_010 * MS, 1_011 * MS)]
    assert lines.is_opening(first)
    assert not lines.is_opening(second)


@given(st.lists(st.binary(max_size=80)))
def test_rubbish_is_passed_over(rubbish):
    found = lines.recorded_lines([message(data) for data in rubbish])
    assert found.commands == () or found.commands


def test_two_files_that_are_written_at_once_are_both_whole():
    plain = [b"".join(b"%d " % (number * 7919 % 1000) for number in range(20_000 + size)) for size in range(2)]
    faults = []

    def write(text):
        for _ in range(60):
            channels = Channels()
            number = channels.number(Channel("@log"))
            parts = [channels.of([number]), chunks.message(number, 1, 5, 5, text)]
            data = chunks.chunk(parts, 5, 5)
            span = chunks.head(data, 0, len(data))
            try:
                found = list(Contents().read(chunks.opened(data, span)))
                assert [one.data for one in found] == [text]
            except (chunks.DamagedError, AssertionError) as err:
                faults.append(err)

    threads = [threading.Thread(target=write, args=(text,)) for text in plain]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert not faults
