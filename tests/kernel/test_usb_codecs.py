"""What the played USB devices say and hear, byte by byte: on any machine, whatever its kernel."""

import errno
import os
import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.usb import descriptors, usbip
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import answer
from tests.support.usb.i2c_function import TinyI2c
from tests.support.usb.rig import FT232R
from tests.support.usb.serial_function import Ftdi, divisor, rate
from tests.support.usb.usbip import FramingError, Reader, Setup, Submit, Unlink
from tests.support.usb.uvc_function import INTERVALS, SIZES, Camera, agreement, read_agreement

WORD, BYTE, SHORT = st.integers(0, 2**32 - 1), st.integers(0, 255), st.integers(0, 2**16 - 1)
SETUPS = st.builds(Setup, BYTE, BYTE, SHORT, SHORT, SHORT)
TEXTS = st.text(st.characters(codec="utf-16-le", exclude_characters="\0"), max_size=60)
IDENTITIES = st.builds(Identity, SHORT, SHORT, TEXTS, TEXTS, TEXTS, SHORT)
SUBMITS = st.builds(
    lambda number, device, endpoint, setup, data, room: Submit(
        number, device, not data, endpoint, len(data) or room, setup, data
    ),
    WORD, WORD, st.integers(0, 15), SETUPS, st.binary(max_size=200), st.integers(0, usbip.MOST_BYTES),
)  # fmt: skip
UNLINKS = st.builds(Unlink, WORD, WORD, WORD)


def said_by_the_kernel(request: Submit | Unlink) -> bytes:
    """Written from the kernel's documentation alone."""
    if isinstance(request, Unlink):
        return struct.pack(">6I", 2, request.number, request.device, 0, 0, request.wanted) + bytes(24)
    head = struct.pack(">5I", 1, request.number, request.device, request.into_host, request.endpoint)
    body = struct.pack(">IiIii", 0, request.length, 0, 0, 0)
    return head + body + request.setup.encoded() + request.data


def camera(identity: Identity) -> Camera:
    return Camera(lambda width, height, number: b"\xff\xd8" + bytes(40_000) + b"\xff\xd9", identity)


@given(st.lists(SUBMITS | UNLINKS, max_size=6), st.lists(st.integers(1, 100), min_size=1, max_size=5))
def test_requests_are_read_whole_however_they_are_chopped(requests, sizes):
    reader, found = Reader(), []
    data = b"".join(map(said_by_the_kernel, requests))
    turn = 0
    while data:
        piece, data = data[: sizes[turn % len(sizes)]], data[sizes[turn % len(sizes)] :]
        found += reader.feed(piece)
        turn += 1
    assert found == requests


@given(st.binary(min_size=48, max_size=300))
def test_what_is_no_request_is_refused_or_waited_for_and_never_crashes(data):
    try:
        found = Reader().feed(data)
    except FramingError:
        return
    for one in found:
        assert isinstance(one, Unlink) or one.length <= usbip.MOST_BYTES


@pytest.mark.parametrize("head", [(7, 1, 1, 0, 0), (1, 1, 1, 2, 0), (1, 1, 1, 0, 16)])
def test_a_head_that_can_be_none_is_told(head):
    with pytest.raises(FramingError):
        Reader().feed(struct.pack(">5I", *head) + bytes(28))


@given(WORD, st.binary(max_size=100))
def test_an_answer_has_status_and_length_where_the_kernel_looks(number, data):
    found = usbip.submitted(number, 0, actual=len(data), data=data)
    assert struct.unpack_from(">2I", found) == (3, number)
    assert struct.unpack_from(">ii", found, 20) == (0, len(data))
    assert found[48:] == data
    gone = usbip.unlinked(number, -errno.ECONNRESET)
    assert (len(gone), struct.unpack_from(">i", gone, 20)) == (48, (-104,))


@given(IDENTITIES, st.integers(0, 5))
def test_an_identity_is_a_device_descriptor_and_the_strings_that_it_names(identity, index):
    found = identity.descriptor()
    assert (len(found), found[0], found[1]) == (18, 18, 1)
    assert struct.unpack_from("<HH", found, 8) == (identity.vendor, identity.product)
    for at, text in zip(found[14:17], identity.strings, strict=True):
        string = identity.string(at) if at else None
        assert (string[2:].decode("utf-16-le") if string else "") == text
    assert index in {0, *(at for at in found[14:17] if at)} or identity.string(index) is None


def test_a_camera_and_an_adaptor_have_descriptors_whose_lengths_add_up():
    for function in (camera(Identity(0x046D, 0x0825)), TinyI2c(None)):
        parts = descriptors.split(function.configuration)
        assert struct.unpack_from("<H", parts[0], 2)[0] == len(function.configuration)
        assert sum(part[1] == descriptors.INTERFACE for part in parts) == parts[0][4]
    streaming = next(part for part in parts if part[1] == descriptors.INTERFACE)
    assert streaming[4] == 0, "an adaptor without endpoints"


@given(SETUPS, st.binary(max_size=40))
def test_no_control_request_crashes_a_camera(setup, data):
    found = answer(camera(Identity(1, 2, "a", "b")), setup, data)
    assert found is None or isinstance(found, bytes)


@given(st.sampled_from(range(1, len(SIZES) + 1)), st.sampled_from(INTERVALS))
def test_what_a_camera_agreed_to_is_read_as_it_was_written(frame, interval):
    assert read_agreement(agreement(frame, interval)) == (frame, interval)
    assert len(agreement(frame, interval)) == 34


def test_a_picture_comes_in_payloads_with_one_end():
    one = camera(Identity(1, 2))
    payloads = [one.come(16_384) for _ in range(3)]
    assert b"".join(payload[2:] for payload in payloads) == one.picture(640, 480, 0)
    assert [bool(payload[1] & 2) for payload in payloads] == [False, False, True]
    assert len({payload[1] & 1 for payload in payloads}) == 1
    assert one.come(16_384)[1] & 1 != payloads[0][1] & 1, "the next one has the other toggle"


@given(st.integers(300, 1_500_000))
def test_a_divisor_of_an_ftdi_means_the_rate_that_was_asked_for(baud):
    found = rate(*divisor(baud))
    assert abs(found - baud) <= max(1, baud * 0.032 if baud > 460_800 else baud * 0.011)


def test_an_ftdi_forgets_what_came_before_it_was_opened():
    device, line = os.openpty()
    function = Ftdi(Path(os.ttyname(line)), FT232R)
    try:
        os.write(device, b"old")
        function.control(Setup(0x40, 0, 0, 0, 0), b"")
        os.write(device, b"new")
        assert function.come(64) == Ftdi.STATUS + b"new"
    finally:
        function.finish()
        for end in (device, line):
            os.close(end)
