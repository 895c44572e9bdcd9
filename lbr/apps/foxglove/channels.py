"""The channels: one for each stream as it is, and more of Foxglove's own schemas, made of streams. Pure.

Topics are those of recordings, so that a layout shows both; what is made of streams is named beside them, or by an @.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import msgspec
from msgspec import Struct

from lbr.apps.bodies.parts import RobotModel
from lbr.apps.foxglove import protocol, scene, shown
from lbr.messages.attitude import AttitudeState
from lbr.messages.description import RobotDescription, Schema
from lbr.messages.joints import JointsState
from lbr.messages.odometry import OdometryState
from lbr.messages.schema import flat_schema
from lbr.messages.sensing import Ranges, RangeSensor, Scan
from lbr.messages.system import Event, Status

EVENT, STATUS = "@event", "@status"
MODEL, TRANSFORMS, LOG = "@model", "@tf", "@events"
Make = Callable[[Mapping[str, bytes], int], Any]
"""The message of a channel out of the newest messages of streams, and the time; a MsgspecError if one is invalid."""


class Source(Struct, frozen=True, kw_only=True):
    """A channel and where it comes from: the streams that it is made of, and how; without `make` the one as it is.

    A `picture` is of a camera. A `still` message goes to each subscriber, once.
    """

    channel: protocol.Channel
    streams: tuple[str, ...] = ()
    make: Make | None = None
    picture: bool = False
    still: bool = False


def sources(told: RobotDescription, model: RobotModel, sensors: Sequence[RangeSensor]) -> tuple[Source, ...]:
    """Return all channels of a robot, numbered from 1 in the order of their topics."""
    found: dict[str, Source] = {}
    typed: dict[str, list[str]] = {}
    for one in told.capabilities:
        for name, schema in one.outputs.items():
            key = f"{one.name}/{name}"
            if "contentMediaType" in schema:
                found[key] = _own(key, "CompressedImage", (key,), None, picture=True)
            else:
                found[key] = Source(channel=_channel(key, type_of(schema), schema), streams=(key,))
                typed.setdefault(type_of(schema), []).append(key)
    for key, message in ((EVENT, Event), (STATUS, Status)):
        found[key] = Source(channel=_channel(key, message.__name__, msgspec.json.schema(message)), streams=(key,))
    found[LOG] = _own(LOG, "Log", (EVENT,), _made(Event, EVENT, shown.log))
    found |= {one.channel.topic: one for one in _measured(typed, sensors)}
    found |= {one.channel.topic: one for one in _body(typed, model)}
    return tuple(
        msgspec.structs.replace(found[key], channel=msgspec.structs.replace(found[key].channel, id=number))
        for number, key in enumerate(sorted(found), start=1)
    )


def type_of(schema: Schema) -> str:
    """Return the name of the message that a schema is of; empty where a program says none."""
    return str(schema.get("title") or str(schema.get("$ref") or "").rpartition("/")[2])


def _measured(typed: Mapping[str, Iterable[str]], sensors: Sequence[RangeSensor]) -> Iterable[Source]:
    known = {one.name: one for one in sensors}
    for key in typed.get(OdometryState.__name__, ()):
        yield _own(f"{key}/pose", "PoseInFrame", (key,), _made(OdometryState, key, shown.position))
    for key in typed.get(Scan.__name__, ()):
        make = _made(Scan, key, lambda scan, at_ns: shown.laser(scan, known.get(scan.sensor), at_ns))
        yield _own(f"{key}/laser", "LaserScan", (key,), make)
    for key in typed.get(Ranges.__name__, ()) if sensors else ():
        yield _own(
            f"{key}/rays", "SceneUpdate", (key,), _made(Ranges, key, lambda one, at_ns: shown.rays(one, sensors, at_ns))
        )


def _body(typed: Mapping[str, Sequence[str]], model: RobotModel) -> Iterable[Source]:
    if not model.links:
        return
    yield _own(MODEL, "SceneUpdate", (), lambda _streams, at_ns: scene.scene(model, at_ns), still=True)
    joints, odometry, attitude = (
        next(iter(typed.get(one.__name__, ())), "") for one in (JointsState, OdometryState, AttitudeState)
    )

    def make(heard: Mapping[str, bytes], at_ns: int) -> dict[str, Any]:
        state = _read(JointsState, heard.get(joints))
        angles = {name: one.position_rad or 0.0 for name, one in state.joints.items()} if state is not None else {}
        place = _read(OdometryState, heard.get(odometry)), _read(AttitudeState, heard.get(attitude))
        return scene.transforms(model, angles, *place, at_ns)

    streams = tuple(one for one in (joints, odometry, attitude) if one)
    yield _own(TRANSFORMS, "FrameTransforms", streams, make, still=not streams)


def _read(message: Any, said: bytes | None) -> Any:
    return msgspec.json.decode(said, type=message) if said is not None else None


def _made(message: Any, key: str, make: Callable[[Any, int], Any]) -> Make:
    return lambda heard, at_ns: make(msgspec.json.decode(heard[key], type=message), at_ns)


def _channel(topic: str, name: str, schema: Schema) -> protocol.Channel:
    if not schema:
        return protocol.Channel(id=0, topic=topic)
    return protocol.Channel(id=0, topic=topic, schema_name=name or topic, schema=flat_schema(schema).decode())


def _own(
    topic: str, name: str, streams: tuple[str, ...], make: Make | None, *, picture: bool = False, still: bool = False
) -> Source:
    known = f"foxglove.{name}"
    schema = msgspec.json.encode(shown.SCHEMAS[known]).decode()
    channel = protocol.Channel(id=0, topic=topic, schema_name=known, schema=schema)
    return Source(channel=channel, streams=streams, make=make, picture=picture, still=still)


def payload(source: Source, heard: Mapping[str, bytes], at_ns: int) -> bytes:
    """Return the bytes of a message; MsgspecError if what was heard is no message of its type."""
    if source.picture:
        key = source.streams[0]
        return msgspec.json.encode(shown.image(heard[key], key.partition("/")[0], at_ns))
    if source.make is None:
        return heard[source.streams[0]]
    return msgspec.json.encode(source.make(heard, at_ns))
