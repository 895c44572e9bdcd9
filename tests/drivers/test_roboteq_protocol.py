import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.echoed_lines import MAX_LINE_BYTES, Ack, Echo, Nak, Noise, ReplyParser, Value, query
from lbr.drivers.roboteq import protocol as wire
from lbr.drivers.roboteq import readings

values = st.integers(-1000, 1000)


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (wire.motors(-500, 500), b"!M -500 500\r"),
        (wire.motors(0, 0), b"\x21\x4d\x20\x30\x20\x30\x0d"),
        (wire.STOP, wire.motors(0, 0)),
        (wire.EMERGENCY_STOP, b"!EX\r"),
        (wire.RELEASE, b"!MG\r"),
        (query("V"), b"\x3f\x56\x0d"),
        (query("A"), b"\x3f\x41\x0d"),
        (query("C"), b"\x3f\x43\x0d"),
        (wire.read_setting("RWD"), b"~RWD\r"),
        (wire.write_setting("ECHOF", 1), b"^ECHOF 1\r"),
        (wire.read_setting("MXMD"), b"~MXMD\r"),
    ],
)
def test_commands_are_spelt_as_the_manual_says(command, expected):
    assert command == expected


@pytest.mark.parametrize("value", [-1001, 1001, 10**9])
def test_a_motor_value_beyond_full_scale_is_never_encoded(value):
    with pytest.raises(ValueError, match=str(value)):
        wire.motors(0, value)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"+\r", [Ack()]),
        (b"-\r", [Nak()]),
        (b"!M 0 0\r+\r", [Echo(b"!M 0 0"), Ack()]),
        (b"!M 0 0+\r", [Echo(b"!M 0 0"), Ack()]),
        (b"!M 10 -20-\r", [Echo(b"!M 10 -20"), Nak()]),
        (b"?V\rV=135:126:4730\r", [Echo(b"?V"), Value("V", "135:126:4730")]),
        (b"?VV=135:126:4730\r", [Echo(b"?V"), Value("V", "135:126:4730")]),
        (b"V=135:126:4730\r", [Value("V", "135:126:4730")]),
        (b"~RWDRWD=200\r", [Echo(b"~RWD"), Value("RWD", "200")]),
        (b"\r\n\r\n", []),
        (b"V=135:12A=1:2\r", [Noise("V=135:12A=1:2")]),
        (b"\xff\x00junk\r+\r", [Noise("\\xff\\x00junk"), Ack()]),
        (b"V=13", []),
        (b"V=13\rA=-51:12\r", [Value("V", "13"), Value("A", "-51:12")]),
    ],
)
def test_bytes_become_replies_with_or_without_the_echo(data, expected):
    assert ReplyParser().feed(data) == expected


@pytest.mark.parametrize(
    ("meaning", "text", "expected"),
    [
        (readings.volts, "135:126:4730", (13.5, 12.6, 4.73)),
        (readings.volts, "135:126", (None, None, None)),
        (readings.volts, "135::4730", (13.5, None, 4.73)),
        (readings.volts, "935:-89:94730", (None, None, None)),
        (readings.amps, "-51:12", (-5.1, 1.2)),
        (readings.amps, "9051:-3001", (None, None)),
        (readings.amps, "", (None,)),
        (readings.counts, "130:-260", (130, -260)),
        (readings.counts, "1e3:٣", (None, None)),
        (readings.counts, "9999999999:-7", (None, -7)),
        (readings.hottest_c, "30:925:-99", 30.0),
        (readings.hottest_c, "30:25:41", 41.0),
        (readings.hottest_c, "", None),
        (readings.faults, "0", ()),
        (readings.faults, "5", ("overheat", "undervoltage")),
        (readings.faults, "16", ("emergency_stop",)),
        (readings.faults, "255", readings.FAULT_BITS),
        (readings.faults, "256", ("bit_8",)),
        (readings.faults, "-1", None),
        (readings.faults, "x", None),
        (readings.setting, "200", 200),
        (readings.setting, "2x0", None),
        (readings.setting, "0:0", 0),
        (readings.setting, "0:1", None),
    ],
)
def test_an_answer_means_what_the_facts_say_and_null_where_it_means_nothing(meaning, text, expected):
    assert meaning(text) == expected


@given(values, values)
def test_what_is_encoded_comes_back_as_its_own_echo(left, right):
    command = wire.motors(left, right)
    assert ReplyParser().feed(command + b"+\r") == [Echo(command[:-1]), Ack()]


@given(
    st.lists(st.sampled_from([b"+", b"-", b"\r", b"!M 1 2\r", b"V=1:2:3\r", b"\xff", b"=", b"x" * 300]), max_size=20)
)
def test_how_the_bytes_are_cut_changes_nothing(pieces):
    data = b"".join(pieces)
    whole, single = ReplyParser(), ReplyParser()
    expected = whole.feed(data)
    assert [reply for index in range(len(data)) for reply in single.feed(data[index : index + 1])] == expected
    assert single.held_bytes == whole.held_bytes


@given(st.lists(st.binary(max_size=400), max_size=20))
def test_whatever_babbles_little_is_held_and_the_next_clean_line_is_understood(pieces):
    parser = ReplyParser()
    for piece in pieces:
        parser.feed(piece)
        assert parser.held_bytes <= MAX_LINE_BYTES
    assert parser.feed(b"\rA=-51:12\r")[-1] == Value("A", "-51:12")


MEANINGS = (readings.volts, readings.amps, readings.counts, readings.hottest_c, readings.faults, readings.setting)


@given(st.text(alphabet="0123456789:-+. xV=", max_size=30), st.sampled_from(MEANINGS))
def test_no_text_breaks_the_decoder(text, meaning):
    meaning(text)
