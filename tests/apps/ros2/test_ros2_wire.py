"""Keys, tokens, attachments and messages: what is written is read as it was, and what is none is refused."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.errors import InputError
from tests.support import needs

needs.modules("rosbags")
needs.modules("xxhash")
from lbr.apps.ros2 import codec, wire  # noqa: E402 - it needs both
from lbr.apps.ros2.trajectory import TRAJECTORY  # noqa: E402
from lbr.apps.ros2.wire import Attachment, Endpoint, Node, Qos  # noqa: E402

NAMES = st.text("abXYZ_09", max_size=12).map("n".__add__)
TOPICS = st.lists(NAMES, min_size=1, max_size=3).map(lambda parts: "/" + "/".join(parts))
TYPES = st.builds(
    lambda package, kind, name: f"{package}/{kind}/{name}",
    st.from_regex(r"[a-z][a-z0-9_]{0,12}", fullmatch=True),
    st.sampled_from(["msg", "srv"]),
    st.from_regex(r"[A-Z][A-Za-z0-9]{0,12}", fullmatch=True),
)
NODES = st.builds(
    Node,
    domain=st.integers(0, 232),
    zid=st.from_regex(r"[0-9a-f]{1,32}", fullmatch=True),
    id=st.integers(0, 99).map(str),
    namespace=st.one_of(st.just("/"), TOPICS),
    name=NAMES,
)
ENDPOINTS = st.builds(
    Endpoint,
    node=NODES,
    id=st.integers(0, 99).map(str),
    kind=st.sampled_from(["MP", "MS", "SS", "SC"]),
    topic=TOPICS,
    type=TYPES,
    hash=st.sampled_from([wire.HUMBLE_HASH, "RIHS01_" + "0" * 64]),
    qos=st.builds(Qos, reliable=st.booleans(), transient_local=st.booleans(), depth=st.integers(1, 100)).map(str),
)
ATTACHMENTS = st.builds(
    Attachment,
    sequence=st.integers(-(2**63), 2**63 - 1),
    sent_ns=st.integers(-(2**63), 2**63 - 1),
    gid=st.binary(min_size=16, max_size=16),
)
TOKEN = (
    "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/"
    "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18/::,10:,:,:,,"
)
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(st.one_of(NODES, ENDPOINTS))
def test_a_token_is_read_as_it_was_written(entity):
    assert wire.token(str(entity)) == entity


def test_a_token_of_rmw_zenoh_says_who_publishes_what():
    entity = wire.token(TOKEN)
    assert (entity.topic, entity.type, entity.node.path) == ("/chatter", "std_msgs/msg/String", "/talker")
    assert str(entity) == TOKEN
    assert entity.key == f"2/chatter/{'/'.join(TOKEN.split('/')[-3:-1])}"


@given(st.text(max_size=200).map(lambda text: f"@ros2_lv/0/{text}"))
def test_what_is_no_token_is_refused_or_left_alone(text):
    try:
        found = wire.token(text)
    except InputError:
        return
    assert found is None or isinstance(found, (Node, Endpoint))


@given(ATTACHMENTS)
def test_an_attachment_is_read_as_it_was_written_in_both_forms(attachment):
    data = bytes(attachment)
    assert len(data) == 33
    assert wire.attachment(data) == attachment
    named = b"\x0fsequence_number" + data[:8] + b"\x10source_timestamp" + data[8:16] + b"\x0asource_gid" + data[16:]
    assert len(named) == 77
    assert wire.attachment(named) == attachment


@given(st.binary(max_size=100).filter(lambda data: len(data) not in {33, 77}))
def test_another_attachment_is_refused(data):
    with pytest.raises(InputError, match="attachment"):
        wire.attachment(data)


@given(st.tuples(FINITE, FINITE, FINITE), st.integers(0, 2**31 - 1), st.integers(0, 999_999_999))
def test_a_twist_is_read_as_it_was_written_with_or_without_a_stamp(twist, sec, nanosec):
    vx, vy, wz = twist
    fields = {"linear": {"x": vx, "y": vy}, "angular": {"z": wz}}
    assert codec.twist(codec.TWIST, codec.encode(codec.TWIST, fields) + b"left by rclpy") == (vx, vy, wz, None)
    stamped = {"header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": "base_link"}, "twist": fields}
    found = codec.twist(codec.TWIST_STAMPED, codec.encode(codec.TWIST_STAMPED, stamped))
    assert found == (vx, vy, wz, sec * codec.S_NS + nanosec or None)


@given(st.binary(max_size=200), st.sampled_from([codec.TWIST, codec.TWIST_STAMPED, TRAJECTORY]))
def test_bytes_that_are_no_message_are_refused_by_one_error(data, type_):
    try:
        codec.decode(type_, codec.HEAD + data)
    except InputError as err:
        assert err.code == "malformed"  # noqa: PT017 - both ways are right


def test_a_twist_is_laid_out_as_ros_has_it():
    data = codec.encode(codec.TWIST, {"linear": {"x": 0.5}, "angular": {"z": -1.0}})
    assert data == b"\x00\x01\x00\x00" + struct.pack("<6d", 0.5, 0, 0, 0, 0, -1.0)


def test_an_answer_is_laid_out_as_ros_has_it():
    assert codec.answer("done", success=True) == b"\x00\x01\x00\x00" + b"\x01\x00\x00\x00" + b"\x05\x00\x00\x00done\x00"


def test_a_field_that_a_type_has_not_is_a_defect():
    with pytest.raises(TypeError, match="speed"):
        codec.encode(codec.TWIST, {"speed": 1.0})


def test_hashes_are_those_of_ros_and_humble_has_none():
    known = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
    assert codec.type_hash(codec.TWIST) == known
    assert codec.type_hash(codec.TWIST, humble=True) == "TypeHashNotSupported"
    assert codec.type_hash(codec.TRIGGER).startswith("RIHS01_eeff2cd6")
