"""The parts of the Foxglove bridge that know no robot: protocol, services, the body in space, schemas."""

import asyncio
import json
import math
import struct
from contextlib import closing, suppress
from types import SimpleNamespace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from starlette.websockets import WebSocket

from lbr.apps.bodies.model import model
from lbr.apps.foxglove import channels, protocol, scene, schemas, services
from lbr.apps.foxglove.capability import numbered
from lbr.apps.foxglove.kind import FoxgloveSettings
from lbr.apps.foxglove.socket import Viewer, motion
from lbr.apps.recorder.box import inbox
from lbr.apps.recorder.recording import chunks, export
from lbr.apps.web.face import Client
from lbr.errors import InputError, MalformedError
from lbr.messages.description import CapabilityDescription, RobotDescription
from lbr.messages.odometry import OdometryState
from lbr.messages.schema import flat_schema
from lbr.messages.sensing import RangeSensor, Scan, ranges, ring
from lbr.messages.system import Event

BODY = model("lbr", None, (), (), ring(0.4, 0.3))
FROM_CLIENTS = (
    protocol.Subscribe
    | protocol.Unsubscribe
    | protocol.Advertise
    | protocol.Unadvertise
    | protocol.MessageData
    | protocol.ServiceCall
    | protocol.Unknown
)


def read(said):
    """Return what comes, and what is called rubbish as something unknown; nothing else is raised."""
    try:
        return protocol.parse(said)
    except MalformedError as err:
        return protocol.Unknown(str(err)) if str(err).isprintable() else err


@given(st.binary(max_size=300) | st.text(max_size=300))
def test_whatever_comes_is_a_message_or_is_called_rubbish(said):
    assert isinstance(read(said), FROM_CLIENTS)


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(max_size=5), st.lists, max_leaves=9))
def test_any_json_under_the_words_of_the_protocol_is_no_fault(value):
    for op, name in (("subscribe", "subscriptions"), ("unsubscribe", "subscriptionIds"), ("advertise", "channels")):
        assert isinstance(read(json.dumps({"op": op, name: value})), FROM_CLIENTS)


@given(
    st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.binary(max_size=50), st.sampled_from(["", "json", "ros1"])
)
def test_what_a_client_publishes_and_asks_is_read_back(number, call, payload, encoding):
    assert protocol.parse(b"\x01" + struct.pack("<I", number) + payload) == protocol.MessageData(number, payload)
    head = struct.pack("<BIII", 2, number, call, len(encoding))
    asked = protocol.parse(head + encoding.encode() + payload)
    assert asked == protocol.ServiceCall(number, call, encoding, payload)
    told = protocol.answered(asked, payload)
    assert struct.unpack_from("<BIII", told) == (3, number, call, 4)
    assert told[13:] == b"json" + payload


WORDS = [
    {"word": "t", "pattern": "/t/{angle_deg}", "role": "operate", "help": "Turn", "fields": [{"name": "angle"}]},
    {"word": "s", "pattern": "s", "role": "view", "help": "Stop"},
    {"word": "s", "pattern": "/s/{text...}", "role": "operate", "help": "Say", "fields": [{"name": "text"}]},
    {"word": "torque", "pattern": "/torque/on", "help": "On"},
    {"word": "torque", "pattern": "torque off", "help": "Off"},
    {"word": "torque", "pattern": "/torque/off/{joints...}", "help": "Off", "fields": [{"name": "joints"}]},
    {
        "word": "music", "pattern": "music", "target": "external",
        "fields": [{"name": "argument_1"}, {"name": "argument_2"}],
    },
]  # fmt: skip


def test_a_word_is_said_with_the_fields_that_are_given():
    found = {one.word: one for one in services.services(WORDS)}
    assert set(found) == {"t", "s", "torque/on", "torque/off", "music", "stop", "estop"}
    assert found["torque/on"].line({}) == "/torque/on"
    assert found["torque/off"].line({}) == "torque off"
    assert found["torque/off"].line({"joints": "neck"}) == "/torque/off/neck"
    assert found["t"].line({"angle": 90}) == "/t/90"
    assert found["s"].line({}) == "s"
    assert found["s"].line({"text": "a {angle_deg} b"}) == "/s/a {angle_deg} b"
    assert found["music"].line({"argument_1": "on", "argument_2": 3}) == "music on 3"


@pytest.mark.parametrize(
    "given_", [{}, {"angle": None}, {"angle": [1]}, {"angle": True}, {"angle": "1\nestop"}, {"a": 1}]
)
def test_fields_that_do_not_fit_are_refused_in_words(given_):
    found = {one.word: one for one in services.services(WORDS)}
    with pytest.raises(InputError):
        found["t"].line(given_)


@given(st.binary(max_size=100))
def test_a_request_is_an_object_or_refused(payload):
    with suppress(InputError):
        assert isinstance(services.read(payload), dict)


BASE = SimpleNamespace(capability="drive", sideways=False)
COMMANDS = {"drive/twist": SimpleNamespace(leased=True), "speech/say": SimpleNamespace(leased=False)}
Known = SimpleNamespace(known=SimpleNamespace(commands=COMMANDS, robot=SimpleNamespace(base=BASE)))
"""An API that knows a robot with a base."""
TELEOP = protocol.Published(id=1, topic="/cmd_vel", encoding="json", schema_name="geometry_msgs/Twist")


def test_a_twist_is_motion_of_the_base_and_nothing_is_standing_still():
    said = b'{"linear": {"x": 0.2, "y": 0.1}, "angular": {"z": -1}}'
    assert motion(TELEOP, said, Known) == ("drive/twist", {"vx_mps": 0.2, "vy_mps": 0.0, "wz_rps": -1.0})
    assert motion(TELEOP, b'{"linear": {"x": 0}}', Known) is None
    assert motion(TELEOP, b'{"twist": {"linear": {"x": 1}}}', Known)[1]["vx_mps"] == 1.0


@pytest.mark.parametrize(
    "said",
    [b"", b"[]", b"1", b'{"linear": 1}', b'{"linear": {"x": "fast"}}', b'{"linear": {"x": true}}', b"[" * 9999,
     b'{"linear": {"x": NaN}}', b'{"linear": {"x": 1' + b"0" * 400 + b"}}"],
)  # fmt: skip
def test_a_twist_that_is_none_is_refused_or_no_number_that_moves(said):
    with pytest.raises(InputError):
        motion(TELEOP, said, Known)


@pytest.mark.parametrize(
    ("said", "wrong"),
    [(b'{"linear": {"x": 1e999}}', "/cmd_vel: Number out of range"), (b"{", "/cmd_vel: not JSON: .*truncated")],
)
def test_a_message_that_cannot_be_read_says_what_is_wrong(said, wrong):
    with pytest.raises(InputError, match=wrong):
        motion(TELEOP, said, Known)


def test_only_what_is_held_can_be_published():
    say = protocol.Published(id=1, topic="speech/say", encoding="json")
    with pytest.raises(InputError, match="service"):
        motion(say, b"{}", Known)
    with pytest.raises(InputError, match="listens"):
        motion(protocol.Published(id=1, topic="/other", encoding="json"), b"{}", Known)
    held = protocol.Published(id=1, topic="/drive/twist", encoding="json")
    assert motion(held, b'{"vx_mps": 1, "lease": "x"}', Known) == ("drive/twist", {"vx_mps": 1})


class VirtualTime(asyncio.SelectorEventLoop):
    """An event loop whose time passes as a test wants it."""

    now = 100.0

    def time(self):
        return self.now

    def pass_time(self, seconds, step_s=0.05):
        for _ in range(round(seconds / step_s)):
            self.now += step_s
            self.run_until_complete(self.turn())

    async def turn(self):
        for _ in range(20):
            await asyncio.sleep(0)


def nothing(*_args):
    return ()


@pytest.fixture
def connected():
    """Give the time of a bridge, the queue that its client writes to, and the hands that the client has."""
    with closing(VirtualTime()) as loop:
        waiting, sent, hands = asyncio.Queue(), [], []
        api = SimpleNamespace(
            known=Known.known, now=loop.time, wake=nothing, may=nothing, holds=SimpleNamespace(add=hands.append)
        )
        feeds = SimpleNamespace(leave=nothing, tidy=nothing, events=nothing, want=nothing, last_event=0)
        served = SimpleNamespace(
            api=api, feeds=feeds, session="1", sources={}, services={}, pictures=SimpleNamespace(want=nothing)
        )

        async def send(message):
            sent.append(message)

        async def serve():
            web = WebSocket({"type": "websocket"}, waiting.get, send)
            await web.accept()
            viewer = Viewer(served, Client("127.0.0.1", role="operate"), "lbr", 20.0, pictures=False)
            await viewer.serve(web, waiting.get)

        serving = loop.create_task(serve())
        waiting.put_nowait({"type": "websocket.connect"})
        advertised = {
            "op": "advertise",
            "channels": [{"id": 1, "topic": "/cmd_vel", "encoding": "json", "schemaName": "Twist"}],
        }
        waiting.put_nowait({"type": "websocket.receive", "text": json.dumps(advertised)})
        yield loop, waiting, hands
        waiting.put_nowait({"type": "websocket.disconnect"})
        loop.run_until_complete(serving)


def test_a_new_push_begins_after_a_silence_and_not_after_a_loop_that_was_held_up(connected):
    loop, waiting, hands = connected

    def push():
        data = struct.pack("<BI", 1, 1) + b'{"linear": {"x": 0.2}}'
        waiting.put_nowait({"type": "websocket.receive", "bytes": data})
        loop.run_until_complete(loop.turn())
        return hands[0].wish.wanted.n

    loop.pass_time(0.1)
    first = push()
    loop.pass_time(0.9)
    assert push() == first
    loop.now += 5.0
    assert push() == first
    loop.pass_time(1.4)
    assert push() == first + 1


def described(**outputs):
    one = CapabilityDescription(name="a", kind="k", family="driver", summary="", commands={}, outputs=outputs)
    return RobotDescription(robot="lbr", simulated=True, revision=1, capabilities=(one,))


def test_channels_are_made_of_what_the_robot_says_and_every_message_fits_its_schema():
    sensors = ring(0.4, 0.3)
    outputs = {
        "state": msgspec.json.schema(OdometryState),
        "scan": msgspec.json.schema(Scan),
        "frame": {"title": "JpegFrame", "contentMediaType": "image/jpeg"},
        "bare": {},
    }
    found = {one.channel.topic: one for one in channels.sources(described(**outputs), BODY, sensors)}
    assert {"a/state", "a/state/pose", "a/scan/laser", "a/frame", "a/bare", "@tf", "@model", "@events"} <= set(found)
    assert len({one.channel.id for one in found.values()}) == len(found)
    odometry = OdometryState(valid=True, epoch="e", x_m=1.0, y_m=2.0, yaw_rad=math.pi / 2)
    scan = Scan(
        sensor="forward", angle_min_rad=0.0, angle_increment_rad=0.1, range_min_m=0.1, range_max_m=5.0,
        ranges_m=(1.0, None, "Infinity"),
    )  # fmt: skip
    event = Event(kind="estop", subject="drive", text="it stands", level="error", code="estop")
    heard = {
        "a/state": odometry, "a/scan": scan, "@event": event,
    }  # fmt: skip
    said = {key: msgspec.json.encode(one) for key, one in heard.items()} | {"a/frame": b"\xff\xd8....\xff\xd9"}
    for one in found.values():
        if one.channel.schema_name.startswith("foxglove."):
            told = json.loads(channels.payload(one, said, 1_500_000_000))
            assert set(told) == set(json.loads(one.channel.schema)["properties"]), one.channel.topic
    placed = json.loads(channels.payload(found["@tf"], said, 0))["transforms"]
    assert placed[0]["translation"] == {"x": 1.0, "y": 2.0, "z": 0.0}
    assert placed[0]["rotation"]["z"] == pytest.approx(math.sqrt(0.5))
    with pytest.raises(msgspec.MsgspecError):
        channels.payload(found["@tf"], {"a/state": b"{}"}, 0)


def test_a_ray_is_drawn_from_the_sensor_as_far_as_it_reads():
    sensor = RangeSensor(name="left", kind="ultrasonic", y_m=0.1, z_m=0.2, yaw_rad=math.pi / 2)
    drawn = schemas.rays(ranges({"left": 2.0}, {"left": "ok"}), (sensor,), 0)
    begin, end = drawn["entities"][0]["lines"][0]["points"]
    assert begin == {"x": 0.0, "y": 0.1, "z": 0.2}
    assert end == pytest.approx({"x": 0.0, "y": 2.1, "z": 0.2})
    silent = schemas.rays(ranges({"left": None}, {"left": "missing"}), (sensor,), 0)
    assert silent["entities"] == []
    assert silent["deletions"][0]["id"] == "range left"


def test_every_shape_of_the_body_is_drawn_on_a_frame_that_is_placed():
    drawn = scene.scene(BODY, 0)["entities"]
    kinds = {"box": "cubes", "cylinder": "cylinders", "sphere": "spheres", "ellipsoid": "spheres"}
    for link in BODY.links:
        entity = next(one for one in drawn if one["id"] == link.name)
        for shape in link.shapes:
            assert entity[kinds[shape.kind]]
    frames = {one["child_frame_id"] for one in scene.transforms(BODY, {}, None, None, 0)["transforms"]}
    assert {one["frame_id"] for one in drawn} <= frames


def test_numbers_stay_with_what_they_were_for():
    first = numbered({"b": 1, "a": 1}, {})
    assert first == {"a": 1, "b": 2}
    assert numbered({"b": 1, "c": 1}, first) == {"b": 2, "c": 3}


@pytest.mark.parametrize("settings", [{"cors": ["evil"]}, {"tls": True, "clear_text": True}])
def test_settings_that_cannot_be_meant_are_refused(settings):
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(settings, FoxgloveSettings)


def test_a_recording_opens_with_the_topics_and_schemas_of_the_live_robot(tmp_path):
    """What is exported is read by the format's own reader."""
    schema = msgspec.json.schema(OdometryState)
    found = {one.channel.topic: one.channel for one in channels.sources(described(state=schema), BODY, ())}
    said = msgspec.json.encode(OdometryState(valid=True, epoch="e"))
    recorded = chunks.Channel("a/state", "json", "OdometryState", flat_schema(schema))
    picture = chunks.Channel("a/frame", "json", "foxglove.CompressedImage", inbox.PICTURE_SCHEMA)
    pixels = inbox.image(b"\xff\xd8....\xff\xd9", "a", 5)
    path = tmp_path / "all.mcap"
    export.to_mcap(path, [chunks.Message(recorded, 1, 1, 1, said), chunks.Message(picture, 2, 2, 1, pixels)], "lbr")
    with path.open("rb") as file:
        opened = {channel.topic: (schema, channel, one) for schema, channel, one in make_reader(file).iter_messages()}
    kept, channel, one = opened["a/state"]
    live = found["a/state"]
    assert (kept.name, kept.encoding, kept.data.decode()) == (live.schema_name, live.schema_encoding, live.schema)
    assert (channel.message_encoding, one.data) == ("json", said)
    kept, _, one = opened["a/frame"]
    assert kept.name == "foxglove.CompressedImage"
    assert set(json.loads(one.data)) == set(schemas.SCHEMAS[kept.name]["properties"])
