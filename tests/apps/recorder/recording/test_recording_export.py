"""Recordings as files for other programs."""

import csv
import math

import msgspec
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from lbr.apps.recorder.recording import export
from lbr.apps.recorder.recording.chunks import PICTURES, Channel, Message

DRIVE = Channel("drive/state", "json", "DriveState", b'{"type":"object"}')
JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=10,
)


def said(data, n=1, channel=DRIVE):
    return Message(channel, n * 10**9, n * 10**9, n, data)


def test_a_table_for_each_topic_with_a_column_for_each_field(tmp_path):
    found = [
        said(b'{"power": 0.5, "loop": {"rate_hz": 50}}', 1),
        said(b'{"power": null, "reason": "a, b\\n"}', 2),
        said(b"no JSON", 3, Channel("own/topic")),
    ]
    assert export.to_csv(tmp_path / "out", lambda: found) == {"drive/state": 2, "own/topic": 1}
    with (tmp_path / "out" / "drive_state.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["time_s"] for row in rows] == ["1.000000", "2.000000"]
    assert (rows[0]["power"], rows[0]["loop.rate_hz"], rows[1]["reason"]) == ("0.5", "50", "a, b\n")


def test_a_field_named_as_the_recordings_own_time_has_a_column_of_its_own(tmp_path):
    export.to_csv(tmp_path, lambda: [said(b'{"time_s": 12.5, "time": "noon"}', 3, Channel("imu/sample"))])
    (header, row) = csv.reader((tmp_path / "imu_sample.csv").read_text().splitlines())
    assert header == ["time", "time_s", "message.time_s", "message.time"]
    assert row[1:] == ["3.000000", "12.5", "noon"]


def test_topics_whose_files_would_be_called_the_same_have_a_file_each(tmp_path):
    found = [said(b'{"x": 1}', 1, Channel("a_b/c")), said(b'{"y": 2}', 2, Channel("a/b_c"))]
    export.to_csv(tmp_path, lambda: found)
    tables = {path.name: path.read_text().split(",")[2].split()[0] for path in tmp_path.iterdir()}
    assert tables == {"a_b_c.csv": "x", "a_b_c-2.csv": "y"}


def test_pictures_become_files(tmp_path):
    import base64

    picture = {"format": "jpeg", "data": base64.b64encode(b"\xff\xd8\xff\xd9").decode()}
    channel = Channel("camera_front/frame", "json", PICTURES, b"{}")
    export.to_csv(tmp_path, lambda: [said(msgspec.json.encode(picture), 1, channel), said(b"{}", 2, channel)])
    (file,) = tmp_path.glob("*.jpg")
    assert file.read_bytes() == b"\xff\xd8\xff\xd9"


def test_an_mcap_file_of_it_has_an_index(tmp_path):
    path = tmp_path / "all.mcap"
    assert export.to_mcap(path, [said(b"{}", n) for n in range(1, 50)], "a test") == 49
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary.statistics.message_count == 49
    assert [channel.topic for channel in summary.channels.values()] == ["drive/state"]


@given(JSON)
def test_whatever_is_in_a_message_becomes_plain_values(value):
    for name, part in export.fields(value):
        assert name
        assert part is None or isinstance(part, bool | int | float | str)
        assert not (isinstance(part, float) and math.isnan(part))
