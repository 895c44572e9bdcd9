"""Bytes become messages or a MalformedError in one line, whatever they are; pictures are known without decoding."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.recorder.messages import RecordCommand
from lbr.bus import codec, pictures
from lbr.errors import MalformedError
from lbr.messages.drive import DriveCommand
from lbr.messages.motors import MotorSetpoint
from lbr.messages.tracking import LookCommand

drive = codec.Decoder(DriveCommand)
json_values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=4)),
    max_leaves=12,
)


def refused(data):
    """Return why bytes are no drive command; None if they are one."""
    try:
        assert isinstance(drive.decode(data), DriveCommand)
    except MalformedError as err:
        return str(err)
    return None


@given(st.binary(max_size=300))
def test_any_bytes_are_a_message_or_malformed(data):
    told = refused(data)
    assert told is None or (told and "\n" not in told)


@given(json_values)
def test_any_json_is_a_message_or_malformed(value):
    assert refused(msgspec.json.encode(value)) != ""


def test_a_long_value_that_is_refused_is_not_quoted_whole():
    with pytest.raises(MalformedError, match=r"^Invalid enum value '(far)+.?.?….*' - at `\$\.target`$") as err:
        codec.Decoder(LookCommand).decode(b'{"target": "' + b"far" * 5000 + b'"}')
    assert len(str(err.value)) <= codec.LONGEST + 1


@pytest.mark.parametrize("text", ["NaN", "Infinity", "-Infinity", "1e999", "-1e999", '"0.5"', "null", "[]", "true"])
@pytest.mark.parametrize("field", ["power", "angle_deg"])
def test_no_number_that_means_nothing_reaches_a_motor(field, text):
    good = {"power": "0.5", "angle_deg": "0"} | {field: text}
    with pytest.raises(MalformedError):
        drive.decode(("{" + ",".join(f'"{name}": {value}' for name, value in good.items()) + "}").encode())


@pytest.mark.parametrize("text", ["1.0001", "-1.0001", "1e308", "NaN", "1e999", "null"])
@pytest.mark.parametrize("wheel", ["left", "right", "motors"])
def test_no_setpoint_beyond_full_power_is_a_message(wheel, text):
    values = {"left": "0.5", "right": "-0.5"} | {wheel: f'{{"third": {text}}}' if wheel == "motors" else text}
    data = "{" + ",".join(f'"{name}": {value}' for name, value in values.items()) + "}"
    with pytest.raises(MalformedError):
        codec.Decoder(MotorSetpoint).decode(data.encode())


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"", "not JSON"),
        (b"\xff\xfe", "not JSON"),
        (b'{"power": 0.5', "not JSON"),
        (b'"\xed\xa0\x80"', "not JSON|Expected"),
        (b'{"more":' * 100_000, "nested too deeply|not JSON"),
        (b'{"power": ' + b"9" * 5000 + b"}", "out of range"),
        (b"{}", "missing required field"),
    ],
)
def test_what_is_wrong_is_said(data, why):
    with pytest.raises(MalformedError, match=why):
        drive.decode(data)


def test_deep_json_of_any_kind_is_malformed_and_overflows_no_stack():
    with pytest.raises(MalformedError):
        codec.decode(b'{"a":' * 50_000)


def test_unknown_fields_are_those_of_a_later_lbr_and_ignored():
    found = drive.decode(b'{"power": 0.5, "angle_deg": 0, "mood": "good"}')
    assert found.power == 0.5


# -- pictures ---------------------------------------------------------------------------------------------------------


def jpeg(*segments: bytes, end: bytes = b"\xff\xd9") -> bytes:
    return b"\xff\xd8" + b"".join(segments) + end


def segment(marker: int, body: bytes) -> bytes:
    return bytes((0xFF, marker)) + (len(body) + 2).to_bytes(2, "big") + body


def frame(width: int, height: int, marker: int = 0xC0) -> bytes:
    return segment(marker, b"\x08" + height.to_bytes(2, "big") + width.to_bytes(2, "big") + b"\x03" + bytes(9))


@given(st.integers(0, 65535), st.integers(0, 65535), st.sampled_from([0xC0, 0xC1, 0xC2, 0xC3, 0xC9, 0xCF]))
def test_the_size_is_what_the_frame_header_says(width, height, marker):
    data = jpeg(
        segment(0xE0, b"JFIF\0"), segment(0xC4, bytes(30)), b"\xff\xff", b"\xff\x01", frame(width, height, marker)
    )
    assert pictures.is_whole(data)
    assert pictures.size_px(data) == (width, height)
    assert pictures.described(data) == f"JPEG, {width}x{height}, {len(data)} bytes"


@given(st.binary(max_size=400))
def test_bytes_by_chance_have_a_size_or_none(data):
    for one in (data, b"\xff\xd8" + data, jpeg(b"\xff" + data)):
        assert pictures.size_px(one) is None or len(one) >= 11
        assert pictures.described(one).endswith(f"{len(one)} bytes")


@pytest.mark.parametrize("cut", range(2, 13))
def test_a_header_that_ends_early_has_no_size(cut):
    assert pictures.size_px((b"\xff\xd8" + frame(640, 480))[:cut]) is None or cut >= 11


def test_segments_of_no_length_do_not_hold_up_who_reads():
    assert pictures.size_px(b"\xff\xd8" + b"\xff\xe0\x00\x00" * 100_000) is None


@pytest.mark.parametrize("data", [b"", b"\xff\xd8", b"\xff\xd8\xff\xd9", b"\xff\xd8\xff\xd9\0", b"x" + jpeg(b"abc")])
def test_what_does_not_begin_and_end_like_a_picture_is_none(data):
    assert not pictures.is_whole(data)
    with pytest.raises(MalformedError, match=f"{len(data)} bytes"):
        codec.PictureDecoder().decode(data)


def test_a_whole_picture_is_taken_as_it_is():
    data = jpeg(frame(4, 3))
    assert codec.PictureDecoder().decode(data).data == data


def test_a_name_that_cannot_be_is_told_by_the_characters_it_may_have():
    with pytest.raises(MalformedError, match=r"Expected a file's name \(letters, digits, '\.', '_' and '-'.*\$\.name`"):
        codec.Decoder(RecordCommand).decode(b'{"name": "a/b"}')
