import struct

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.infrared import KIND, InfraredSettings, decoders
from lbr.drivers.infrared.records import Scancode, parser
from lbr.drivers.input_events import EVENT
from lbr.simulation.devices.infrared import BeamCodes

SONY = 0x400021
MSC_SCAN = (4, 4)


def scancode(code: int, *, taken_ns: int = 5_000_000_000, flags: int = 0, protocol: int = 7, keycode: int = 0) -> bytes:
    return struct.pack("=QHHIQ", taken_ns, flags, protocol, keycode, code)


def event(type_: int, code: int, value: int, *, seconds: int = 5, micros: int = 250_000) -> bytes:
    return EVENT.pack(seconds, micros, type_, code, value)


codes = st.integers(1, 2**32 - 1)


@given(st.lists(codes, max_size=8), st.data())
def test_scancodes_come_out_as_they_went_in_however_they_are_cut(sent, data):
    stream = b"".join(scancode(code) for code in sent)
    made, found = parser(events=False), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        found += made.feed(stream[:size])
        stream = stream[size:]
    assert found == [Scancode(code, 7, 5.0) for code in sent]
    assert made.passed_over == 0


@given(st.binary(max_size=200), st.booleans())
def test_whatever_comes_is_taken_or_passed_over_and_at_most_a_record_is_held(noise, events):
    made = parser(events=events)
    found = made.feed(noise)
    assert len(noise) - made.passed_over - 24 * len(found) >= 0
    assert len(found) <= len(noise) // 24


@given(st.binary(max_size=60), codes)
def test_after_damage_and_a_pause_the_next_record_is_heard(damage, code):
    made = parser(events=False)
    made.feed(damage)
    made.pause()
    assert made.feed(scancode(code)) == [Scancode(code, 7, 5.0)]


@given(st.integers(-(2**31), 2**31 - 1))
def test_of_input_events_only_scancodes_count(value):
    stream = event(*MSC_SCAN, value) + event(1, 30, 1) + event(0, 0, 0)
    assert parser(events=True).feed(stream) == [Scancode(value % 2**32, 0, 5.25)]


@pytest.mark.parametrize(
    "record",
    [
        scancode(SONY, taken_ns=0),
        scancode(SONY, flags=4),
        scancode(SONY, protocol=64),
        scancode(SONY, keycode=0x300),
        scancode(2**32),
        scancode(SONY, taken_ns=2**58),
    ],
)
def test_a_record_no_kernel_writes_is_no_scancode(record):
    made = parser(events=False)
    assert made.feed(record) == []
    assert made.passed_over


def test_codes_are_numbers_or_hexadecimal():
    settings = KIND.parse('{"device": "dock_receiver", "codes": {"left": 17, "right": "0x12", "power": null}}')
    assert settings.beams == {17: "left", 18: "right"}


@pytest.mark.parametrize(
    ("codes", "complaint"),
    [
        ('{"left": 17, "right": "0x11"}', "the same code"),
        ('{"left": "17"}', "matching regex"),
        ('{"left": 0}', ">= 1"),
        ('{"front": 1}', "unknown field `front`"),
    ],
)
def test_codes_that_cannot_be_told_apart_are_refused(codes, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        KIND.parse(f'{{"device": "dock_receiver", "codes": {codes}}}')


def as_sony_15(code: int) -> int:
    """What a code is when it was sent as Sony-15 and decoded again: seven bits of command, eight of device, low bits first."""
    sent = [code >> bit & 1 for bit in range(7)] + [code >> 16 + bit & 1 for bit in range(8)]
    return sum(bit << at for at, bit in enumerate(sent[:7])) | sum(bit << 16 + at for at, bit in enumerate(sent[7:]))


def test_the_codes_that_ship_can_occur_and_are_those_of_the_emulated_dock():
    shipped = InfraredSettings(device="dock_receiver")
    assert {code: as_sony_15(code) for code in shipped.beams} == {code: code for code in shipped.beams}
    assert {beam: code for code, beam in shipped.beams.items()} == BeamCodes().numbers()
    assert as_sony_15(0x40A1) == 0x21


def test_a_code_that_no_sony_remote_sends_is_refused_and_told_how_it_would_come():
    with pytest.raises(msgspec.ValidationError, match=r"0x40a1 \(as 0x21\): no code of a Sony remote comes like that"):
        KIND.parse('{"device": "dock_receiver", "protocols": [7], "codes": {"left": "0x40a1"}}')
    KIND.parse('{"device": "dock_receiver", "codes": {"left": "0x40a1"}}')


@pytest.mark.parametrize(
    ("text", "protocols", "said"),
    [
        ("rc-5 nec sony [lirc]", (), "decodes nothing: sudo ir-keytable -s rc0 -p sony"),
        ("rc-5 [nec] sony [lirc]", (7,), "decodes nec, not sony: sudo ir-keytable -s rc0 -p nec,sony"),
        ("rc-5 [nec] sony [lirc]", (), ""),
        ("rc-5 [nec] [sony]", (7,), ""),
    ],
)
@pytest.mark.parametrize("kind", ["lirc", "input"])
def test_what_the_kernel_does_not_decode_is_told_with_what_to_type(tmp_path, monkeypatch, kind, text, protocols, said):
    rc = tmp_path / "rc" / "rc0"
    (rc / "input7").mkdir(parents=True)
    (rc / "input7" / "device").symlink_to(rc)
    (rc / "protocols").write_text(text)
    name = "lirc0" if kind == "lirc" else "event4"
    (tmp_path / kind / name).mkdir(parents=True)
    (tmp_path / kind / name / "device").symlink_to(rc if kind == "lirc" else rc / "input7")
    monkeypatch.setattr(decoders, "SYS", tmp_path)
    assert decoders.of(f"/dev/{name}").lacks(protocols) == said
    assert decoders.of("/dev/pts/3") is None
