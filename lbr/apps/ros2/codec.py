"""Messages of ROS as bytes: their types, hashes and CDR, by rosbags for all but services. Pure."""

import struct
from collections.abc import Mapping, Sequence
from functools import cache
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from lbr.apps.ros2.wire import HUMBLE_HASH
from lbr.errors import InputError
from lbr.messages.codes import Reason
from lbr.messages.schema import JsonObject

TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
TRIGGER = "std_srvs/srv/Trigger"
SERVICE_HASHES = {TRIGGER: "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"}
HEAD = b"\x00\x01\x00\x00"
"""The head of CDR in little endian."""
ENDIANNESS = {b"\x00\x00": "deserialize_cdr_be", b"\x00\x01": "deserialize_cdr_le"}
LARGEST_BYTES = 1 << 16
"""The largest message that is decoded; all received types are small."""
S_NS = 1_000_000_000


class Stamped(NamedTuple):
    """A twist (REP 103), and the time in its header, or None."""

    vx_mps: float
    vy_mps: float
    wz_rps: float
    made_ns: int | None

    @property
    def rests(self) -> bool:
        """Return whether it is a twist of zero."""
        return not any(self[:3])

    @property
    def trouble(self) -> Reason | None:
        """Return why it cannot be followed, or None."""
        return None if all(map(isfinite, self[:3])) else Reason("bad_value", "its twist is not a number")


@cache
def _store() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)


@cache
def type_hash(type_: str, *, humble: bool = False) -> str:
    """Return the hash of a type as in keys and tokens."""
    if humble:
        return HUMBLE_HASH
    return SERVICE_HASHES.get(type_) or str(_store().hash_rihs01(type_))


def encode(type_: str, fields: Mapping[str, object]) -> bytes:
    """Encode a message; missing fields are zero, empty or false."""
    return bytes(_store().serialize_cdr(_made(type_, fields), type_))


def decode(type_: str, data: bytes) -> Any:
    """Decode a message; raise InputError if it is not of this type."""
    if len(data) > LARGEST_BYTES:
        raise InputError(f"it has {len(data)} bytes, and {LARGEST_BYTES} are the most", "malformed")
    try:
        return _decoded(type_, data)
    except (SerdeError, struct.error, ValueError, IndexError, MemoryError) as err:
        raise InputError(f"it is not a {type_}: {str(err)[:120]}", "malformed") from err


def twist(type_: str, data: bytes) -> Stamped:
    """Decode a Twist or TwistStamped; raise InputError for other bytes."""
    message = decode(type_, data)
    made_ns = None
    if type_ == TWIST_STAMPED:
        made_ns = nanoseconds(message.header.stamp) or None
        message = message.twist
    return Stamped(message.linear.x, message.linear.y, message.angular.z, made_ns)


def answer(text: str, *, success: bool) -> bytes:
    """Return the response of a Trigger."""
    message = text.encode() + b"\x00"
    return HEAD + bytes([success, 0, 0, 0]) + len(message).to_bytes(4, "little") + message


def nanoseconds(time: Any) -> int:
    """Return a time of a header, or a duration, in nanoseconds."""
    return int(time.sec) * S_NS + int(time.nanosec)


def stamp(at_ns: int) -> dict[str, int]:
    """Return a time in the form of headers."""
    return {"sec": at_ns // S_NS, "nanosec": at_ns % S_NS}


def header(at_ns: int, frame: str) -> JsonObject:
    """Return a header."""
    return {"stamp": stamp(at_ns), "frame_id": frame}


def _decoded(type_: str, data: bytes) -> Any:
    """Decode a message; bytes after its end are ignored, as rclpy leaves 16 for each point of a trajectory."""
    if data[:2] not in ENDIANNESS:
        raise SerdeError("its head is not one of CDR")
    described = _store().get_msgdef(type_)
    read = getattr(described, ENDIANNESS[data[:2]])
    return read(data[4:], 0, described.cls, _store())[0]


def _made(type_: str, fields: Mapping[str, Any]) -> Any:
    """Make a message of rosbags; raise TypeError for an unknown field."""
    described = _store().get_msgdef(type_).fields
    unknown = set(fields) - {name for name, _ in described}
    if unknown:
        raise TypeError(f"{type_} has no {', '.join(sorted(unknown))}")
    return _store().types[type_](**{name: _value(field, fields.get(name)) for name, field in described})


def _value(field: Any, given: Any) -> Any:
    kind, inside = field
    match kind:
        case Nodetype.BASE:
            return _base(inside[0], given)
        case Nodetype.NAME:
            return _made(inside, given or {})
        case _:
            return _many(inside, given, fixed=kind == Nodetype.ARRAY)


def _base(name: str, given: Any) -> Any:
    if name == "string":
        return given or ""
    if name == "bool":
        return bool(given)
    return float(given or 0.0) if name.startswith("float") else given or 0


def _many(inside: Any, given: Any, *, fixed: bool) -> Any:
    (kind, element), size = inside
    values: Sequence[Any] = given if given is not None else ()
    if kind == Nodetype.NAME:
        return [_made(element, one) for one in values]
    if element[0] == "string":
        return list(values)
    if isinstance(given, bytes):
        return np.frombuffer(given, dtype=np.uint8)
    if fixed and given is None:
        values = (0,) * size
    return np.array(values, dtype=np.dtype(element[0]))
