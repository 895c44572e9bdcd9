"""The channels: one for each stream, and others in Foxglove's own schemas, made of streams. Pure.

Topics are those of recordings, so that a layout shows both; made channels have a suffix, or begin with an @.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeVar

import msgspec
from msgspec import Struct

from lbr.apps.bodies.parts import RobotModel
from lbr.apps.foxglove import protocol, scene, schemas
from lbr.messages.attitude import AttitudeState
from lbr.messages.description import RobotDescription, Schema
from lbr.messages.joints import JointsState
from lbr.messages.odometry import OdometryState
from lbr.messages.schema import flat_schema
from lbr.messages.sensing import Ranges, RangeSensor, Scan
from lbr.messages.system import Event, Status

M = TypeVar("M", bound=Struct)
EVENT, STATUS = "@event", "@status"
MODEL, TRANSFORMS, LOG = "@model", "@tf", "@events"
Make = Callable[[Mapping[str, bytes], int], object]
"""Makes a channel's message of the newest samples of its streams and the time; MsgspecError for invalid samples."""


class Source(Struct, frozen=True, kw_only=True):
    """A channel, its streams, and the function that makes its message; without `make` the stream itself. `picture`: it
    is a camera's. `still`: each subscriber receives it once."""

    channel: protocol.Channel
    streams: tuple[str, ...] = ()
    make: Make | None = None
    picture: bool = False
    still: bool = False


def sources(description: RobotDescription, model: RobotModel, sensors: Sequence[RangeSensor]) -> tuple[Source, ...]:
    """Return all channels of a robot, numbered from 1 in the order of their topics."""
    offered: dict[str, Source] = {}
    typed: dict[str, list[str]] = {}
    for capability in description.capabilities:
        for name, schema in capability.outputs.items():
            key = f"{capability.name}/{name}"
            if "contentMediaType" in schema:
                offered[key] = _own(key, "CompressedImage", (key,), None, picture=True)
            else:
                offered[key] = Source(channel=_channel(key, type_of(schema), schema), streams=(key,))
                typed.setdefault(type_of(schema), []).append(key)
    for key, message in ((EVENT, Event), (STATUS, Status)):
        offered[key] = Source(channel=_channel(key, message.__name__, msgspec.json.schema(message)), streams=(key,))
    offered[LOG] = _own(LOG, "Log", (EVENT,), _made(Event, EVENT, schemas.log))
    offered |= {source.channel.topic: source for source in _measured(typed, sensors)}
    offered |= {source.channel.topic: source for source in _body(typed, model)}
    return tuple(
        msgspec.structs.replace(offered[key], channel=msgspec.structs.replace(offered[key].channel, id=number))
        for number, key in enumerate(sorted(offered), start=1)
    )


def type_of(schema: Schema) -> str:
    """Return the message type of a schema; empty if a program does not name it."""
    return str(schema.get("title") or str(schema.get("$ref") or "").rpartition("/")[2])


def _measured(typed: Mapping[str, Iterable[str]], sensors: Sequence[RangeSensor]) -> Iterable[Source]:
    known = {sensor.name: sensor for sensor in sensors}
    for key in typed.get(OdometryState.__name__, ()):
        yield _own(f"{key}/pose", "PoseInFrame", (key,), _made(OdometryState, key, schemas.position))
    for key in typed.get(Scan.__name__, ()):
        make = _made(Scan, key, lambda scan, at_ns: schemas.laser(scan, known.get(scan.sensor), at_ns))
        yield _own(f"{key}/laser", "LaserScan", (key,), make)
    for key in typed.get(Ranges.__name__, ()) if sensors else ():
        yield _own(
            f"{key}/rays",
            "SceneUpdate",
            (key,),
            _made(Ranges, key, lambda ranges, at_ns: schemas.rays(ranges, sensors, at_ns)),
        )


def _body(typed: Mapping[str, Sequence[str]], model: RobotModel) -> Iterable[Source]:
    if not model.links:
        return
    yield _own(MODEL, "SceneUpdate", (), lambda _streams, at_ns: scene.scene(model, at_ns), still=True)
    joints, odometry, attitude = (
        next(iter(typed.get(message.__name__, ())), "") for message in (JointsState, OdometryState, AttitudeState)
    )

    def make(samples: Mapping[str, bytes], at_ns: int) -> dict[str, object]:
        state = _read(JointsState, samples.get(joints))
        angles = {name: joint.position_rad or 0.0 for name, joint in state.joints.items()} if state is not None else {}
        place = _read(OdometryState, samples.get(odometry)), _read(AttitudeState, samples.get(attitude))
        return scene.transforms(model, angles, *place, at_ns)

    streams = tuple(key for key in (joints, odometry, attitude) if key)
    yield _own(TRANSFORMS, "FrameTransforms", streams, make, still=not streams)


def _read(message: type[M], data: bytes | None) -> M | None:
    return msgspec.json.decode(data, type=message) if data is not None else None


def _made(message: type[M], key: str, make: Callable[[M, int], object]) -> Make:
    return lambda samples, at_ns: make(msgspec.json.decode(samples[key], type=message), at_ns)


def _channel(topic: str, name: str, schema: Schema) -> protocol.Channel:
    if not schema:
        return protocol.Channel(id=0, topic=topic)
    return protocol.Channel(id=0, topic=topic, schema_name=name or topic, schema=flat_schema(schema).decode())


def _own(
    topic: str, name: str, streams: tuple[str, ...], make: Make | None, *, picture: bool = False, still: bool = False
) -> Source:
    known = f"foxglove.{name}"
    schema = msgspec.json.encode(schemas.SCHEMAS[known]).decode()
    channel = protocol.Channel(id=0, topic=topic, schema_name=known, schema=schema)
    return Source(channel=channel, streams=streams, make=make, picture=picture, still=still)


def payload(source: Source, samples: Mapping[str, bytes], at_ns: int) -> bytes:
    """Encode a message; MsgspecError if a sample is not of its type."""
    if source.picture:
        key = source.streams[0]
        return msgspec.json.encode(schemas.image(samples[key], key.partition("/")[0], at_ns))
    if source.make is None:
        return samples[source.streams[0]]
    return msgspec.json.encode(source.make(samples, at_ns))
