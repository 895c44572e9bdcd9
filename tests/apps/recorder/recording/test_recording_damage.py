"""A recording that was cut anywhere, or whose bytes were flipped, gives all that is in its other chunks."""

import os
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from lbr import disk
from lbr.apps.recorder.recording import chunks, reader, selection
from lbr.apps.recorder.recording.chunks import Channel, Channels
from lbr.apps.recorder.recording.segments import Segment
from lbr.apps.recorder.recording.shelf import Shelf
from lbr.errors import InputError
from tests.support.segments import finished

DRIVE = Channel("drive/state", "json", "DriveState", b'{"type":"object"}')
EVENT = Channel("@event", "json", "Event", b'{"type":"object","title":"Event"}')
PER_CHUNK = 10


def written(path, count, *, ends=True, channel=DRIVE):
    """Write chunks of ten messages each; return where each of them ends in the file."""
    channels, ends_at = Channels(), []
    segment = Segment(path, "a test", {"robot": "lbr"})
    for index in range(count):
        numbers = [channels.number(channel), channels.number(EVENT)]
        parts = [
            chunks.message(numbers[n % 2], n + 1, n * 1000 + 1, n * 1000 + 7, b'{"power": %d}' % n)
            for n in range(index * PER_CHUNK, (index + 1) * PER_CHUNK)
        ]
        head = [channels.schemas if index == 0 else b"", channels.of(numbers)]
        segment.write(chunks.chunk([*head, *parts], index * 10_000, index * 10_000 + 9_999))
        ends_at.append(segment.size)
    if ends:
        segment.finish()
    else:
        segment.close()
    return ends_at


def numbers_of(path):
    with reader.opened(path) as found:
        return [one.sequence for one in found.messages()], found.damage


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "whole.mcap"
    return path.read_bytes() if path.exists() else (written(path, 8), path.read_bytes())


def test_what_was_written_is_read_here_and_by_the_library(tmp_path):
    path = tmp_path / "one.mcap"
    written(path, 3)
    found, damage = numbers_of(path)
    assert found == list(range(1, 31))
    assert (damage.places, damage.whole) == (0, True)
    with path.open("rb") as file:
        read = [
            (schema.name, channel.topic, message.data) for schema, channel, message in make_reader(file).iter_messages()
        ]
    assert len(read) == 30
    assert read[0] == ("DriveState", "drive/state", b'{"power": 0}')


@given(data=st.data())
def test_a_recording_cut_anywhere_keeps_every_chunk_before_the_cut(whole, tmp_path_factory, data):
    ends, content = whole
    cut = data.draw(st.integers(0, len(content)))
    path = tmp_path_factory.getbasetemp() / "cut.mcap"
    path.write_bytes(content[:cut])
    found, damage = numbers_of(path)
    assert found == list(range(1, sum(end <= cut for end in ends) * PER_CHUNK + 1))
    assert damage.whole == (cut == len(content))


def test_a_chunk_whose_length_is_wrong_takes_none_of_the_next(whole, tmp_path):
    ends, content = whole
    place = ends[2] + 1  # the lowest byte of the fourth chunk's length
    for wrong in range(256):
        hurt = bytearray(content)
        hurt[place] = wrong
        (tmp_path / "wrong.mcap").write_bytes(bytes(hurt))
        found, _damage = numbers_of(tmp_path / "wrong.mcap")
        assert set(range(1, 81)) - set(range(31, 41)) <= set(found), f"length {wrong}"


@given(seed=st.integers(0, 2**32), flips=st.integers(1, 4), run=st.integers(1, 40))
def test_flipped_bytes_cost_no_more_than_the_chunks_that_they_hit(whole, tmp_path_factory, seed, flips, run):
    ends, content = whole
    dice, hurt = random.Random(seed), bytearray(content)
    begins = [0, *ends[:-1]]
    hit = set()
    for _ in range(flips):
        at = dice.randrange(len(hurt))
        for place in range(at, min(len(hurt), at + run)):
            hurt[place] ^= dice.randrange(1, 256)
            hit |= {n for n, (begin, end) in enumerate(zip(begins, ends, strict=True)) if begin <= place < end}
    path = tmp_path_factory.getbasetemp() / "flipped.mcap"
    path.write_bytes(bytes(hurt))
    found, _damage = numbers_of(path)
    for n in range(len(ends)):
        inside = set(range(n * PER_CHUNK + 1, (n + 1) * PER_CHUNK + 1))
        assert inside <= set(found) or n in hit, f"chunk {n} is not hurt, and is lost"
    assert len(found) == len(set(found)), "a message is told twice"


@given(st.binary(max_size=400))
def test_any_bytes_are_read_to_their_end(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.mcap"
    for content in (data, chunks.MAGIC + data):
        path.write_bytes(content)
        numbers_of(path)


def test_a_stream_whose_schema_changed_has_both(tmp_path):
    channels = Channels()
    old, new = (Channel("drive/state", "json", "DriveState", schema) for schema in (b'{"a":1}', b'{"b":1}'))
    path = tmp_path / "two.mcap"
    with finished(Segment(path, "a test", {})) as segment:
        for at, channel in ((1, old), (2, new)):
            number, before = channels.number(channel), b""
            segment.write(
                chunks.chunk(
                    [channels.schemas, channels.of([number]), chunks.message(number, at, at, at, before)], at, at
                )
            )
    with reader.opened(path) as found:
        assert [one.channel.schema for one in found.messages()] == [b'{"a":1}', b'{"b":1}']


def test_a_recording_of_another_version_or_program_is_read(tmp_path):
    from mcap.writer import CompressionType, IndexType, Writer

    for index, (compression, chunked) in enumerate(
        [(CompressionType.LZ4, True), (CompressionType.NONE, True), (CompressionType.ZSTD, False)]
    ):
        path = tmp_path / f"{index}.mcap"
        with path.open("wb") as file:
            writer = Writer(
                file, compression=compression, use_chunking=chunked, index_types=IndexType.ALL, chunk_size=200
            )
            writer.start(profile="other")
            schema = writer.register_schema("Old", "jsonschema", b"{}")
            channel = writer.register_channel("old/topic", "json", schema)
            for n in range(1, 21):
                writer.add_message(channel, n, b"{}", n, n)
            writer.finish()
        assert numbers_of(path)[0] == list(range(1, 21)), compression


def test_a_file_that_cannot_be_read_is_named_and_others_are_read(tmp_path):
    good, gone = tmp_path / "good.mcap", tmp_path / "gone.mcap"
    written(good, 1)
    damage = selection.Damage()
    assert len(list(selection.messages([gone, good], damage=damage))) == PER_CHUNK
    assert "gone.mcap cannot be read" in damage.files[0]
    with pytest.raises(InputError), reader.opened(gone):
        pass


@pytest.mark.parametrize("given", [b"", b"root:x:0:0:\n", chunks.MAGIC, chunks.MAGIC + b"\x06\x00"])
def test_a_file_that_is_named_and_is_no_recording_is_refused_whatever_the_time(tmp_path, given, wording):
    path = tmp_path / "named.mcap"
    path.write_bytes(given)
    with wording.of(InputError):
        selection.choose(Shelf(tmp_path, "lbr"), str(path))


def test_a_file_that_is_named_is_read_from_its_first_whole_chunk_on(tmp_path):
    path = tmp_path / "named.mcap"
    written(path, 1, ends=False)
    assert selection.choose(Shelf(tmp_path, "lbr"), str(path)).files == (path,)


def test_what_is_said_again_at_the_beginning_of_a_file_is_one_message(tmp_path):
    files = [tmp_path / "1.mcap", tmp_path / "2.mcap"]
    for path in files:
        written(path, 1, channel=EVENT)
    found = [one.sequence for one in selection.messages([files[0]])]
    channels = Channels()
    with finished(Segment(tmp_path / "3.mcap", "a test", {})) as segment:
        number = channels.number(EVENT)
        again = chunks.message(number, PER_CHUNK, 9001, 9007, b'{"power": 9}')
        segment.write(chunks.chunk([channels.schemas, channels.of([number]), again], 9001, 9001))
    assert [one.sequence for one in selection.messages([files[0], tmp_path / "3.mcap"])] == found


def test_a_file_is_in_use_while_it_is_written(tmp_path):
    path = tmp_path / "open.mcap"
    segment = Segment(path, "a test", {})
    assert disk.is_locked(path)
    segment.finish()
    assert not disk.is_locked(path)


def test_a_pipe_in_a_recordings_place_keeps_nobody_waiting(tmp_path):
    os.mkfifo(tmp_path / "pipe.mcap")
    damage = selection.Damage()
    assert list(selection.messages([tmp_path / "pipe.mcap"], damage=damage)) == []
    assert "it is not a file" in damage.files[0]
    assert not disk.is_locked(tmp_path / "pipe.mcap")


@pytest.mark.parametrize(
    ("repeated_s", "about", "length_s"), [(0.4, {"robot": "lbr"}, 0.4), (61.0, {"robot": "lbr"}, 1.0), (61.0, {}, 61.0)]
)
def test_a_recording_of_one_chunk_spans_its_last_round_without_what_was_said_long_before(
    tmp_path, repeated_s, about, length_s
):
    path, channels, end_ns = tmp_path / "one.mcap", Channels(), 1_700_000_000 * 10**9
    number = channels.number(DRIVE)
    times = [end_ns - round(repeated_s * 1e9), end_ns]
    parts = [chunks.message(number, n, at, at, b"{}") for n, at in enumerate(times, start=1)]
    with finished(Segment(path, "a test", about)) as segment:
        segment.write(chunks.chunk([channels.schemas, channels.of([number]), *parts], *times))
    first, last = selection.span_ns([path])
    assert ((last - first) / 1e9, last) == (length_s, end_ns)
