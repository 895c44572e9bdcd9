import json
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.bus import pictures
from lbr.bus.codec import PictureDecoder
from lbr.drivers.camera.picture import Picture, usable
from lbr.drivers.camera.stream_protocol import LARGEST_BYTES, RecordParser, request
from lbr.errors import MalformedError
from tests.drivers.camera_peers import jpeg

RECORDS = st.lists(st.tuples(st.binary(min_size=1, max_size=300), st.integers(0, 2**64 - 1)), max_size=6)


@given(RECORDS, st.data())
def test_pictures_come_out_whole_however_the_bytes_are_cut(records, data):
    stream = b"".join(struct.pack("<IQ", len(body), taken) + body for body, taken in records)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    parser, found = RecordParser(), []
    for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True):
        found += parser.feed(stream[begin:end])
    assert found == records


@given(st.binary(max_size=200))
def test_whatever_comes_is_pictures_or_malformed_and_never_more_is_held_than_one(data):
    parser = RecordParser()
    try:
        for byte in data:
            parser.feed(bytes([byte]))
    except MalformedError:
        return
    assert len(parser._held) <= LARGEST_BYTES + 12


@pytest.mark.parametrize("length", [0, LARGEST_BYTES + 1, 2**32 - 1])
def test_a_length_that_no_picture_has_means_that_the_ends_are_out_of_step(length):
    with pytest.raises(MalformedError, match=f"{length} bytes"):
        RecordParser().feed(struct.pack("<IQ", length, 1))


def test_what_is_wanted_is_asked_for_in_one_line():
    line = request(width=640, height=360, fps=15)
    assert line.endswith(b"\n")
    assert json.loads(line) == {"width": 640, "height": 360, "fps": 15}


@given(st.integers(1, 65535), st.integers(1, 65535))
def test_a_pictures_size_is_read_from_its_frame_header(width, height):
    assert pictures.size_px(jpeg(width=width, height=height)) == (width, height)
    assert pictures.described(jpeg(width=width, height=height)).startswith(f"JPEG, {width}x{height}, ")


@given(st.binary(max_size=60))
def test_the_size_of_anything_is_two_numbers_or_none(data):
    for picture in (data, b"\xff\xd8" + data, jpeg()[: len(data)]):
        size = pictures.size_px(picture)
        assert size is None or min(size) >= 0


@given(st.binary(max_size=60))
def test_only_what_begins_and_ends_as_a_jpeg_file_does_is_passed_on(data):
    try:
        picture = PictureDecoder().decode(data)
    except MalformedError:
        return
    assert picture.data.startswith(b"\xff\xd8")
    assert picture.data.endswith(b"\xff\xd9")


def test_zeros_that_a_camera_appends_are_cut_off_and_other_remains_make_a_picture_unusable():
    assert usable(Picture(jpeg() + b"\0" * 64, 1.0)) == Picture(jpeg(), 1.0)
    assert usable(Picture(jpeg() + b"rest", 1.0)) is None
    assert usable(Picture(jpeg()[:-1], 1.0)) is None
    assert usable(Picture(jpeg(size=pictures.MOST_BYTES), 1.0)) is None
