"""The wire of rmw_zenoh: keys of topics, liveliness tokens of nodes and endpoints, attachments of messages. Pure.

    topic key   <domain>/<topic>/<pkg>::msg::dds_::<Type>_/<hash>

    node        @ros2_lv/<domain>/<zid>/<node>/<node>/NN/<enclave>/<namespace>/<name>

    endpoint    @ros2_lv/<domain>/<zid>/<node>/<id>/MP/<enclave>/<namespace>/<name>/<topic>/<type>/<hash>/<qos>

The kinds of endpoints are MP and MS, which publish and subscribe, and SS and SC, servers and clients of services.
In a token every `/` of a name is a `%`.
"""

import re
import struct
from typing import Literal, NamedTuple

import xxhash
from msgspec import Struct

from lbr.errors import InputError

ADMIN = "@ros2_lv"
HUMBLE_HASH = "TypeHashNotSupported"
"""Humble's value in place of a type's hash."""
CDR = "application/cdr"
EndpointKind = Literal["MP", "MS", "SS", "SC"]
"""Publisher, subscriber, server and client of a service."""
LONGEST_TOKEN = 1024
GID_BYTES = 16
_DDS = re.compile(r"([A-Za-z][A-Za-z0-9_]*)::(msg|srv|action)::dds_::([A-Za-z][A-Za-z0-9_]*)_")
_NODE_PARTS, _ENDPOINT_PARTS = 9, 13


class Qos(Struct, frozen=True, kw_only=True):
    """The delivery of a topic, where it may differ from rmw_zenoh's default."""

    reliable: bool = True
    transient_local: bool = False
    depth: int = 10

    def __str__(self) -> str:
        return f"{'' if self.reliable else 2}:{1 if self.transient_local else ''}:,{self.depth}:,:,:,,"


class Node(Struct, frozen=True, kw_only=True):
    """A node of ROS; `zid` is that of its Zenoh session."""

    domain: int
    zid: str
    id: str
    namespace: str
    name: str

    @property
    def path(self) -> str:
        """Return its full name."""
        return f"{self.namespace.rstrip('/')}/{self.name}"

    def __str__(self) -> str:
        own = f"{ADMIN}/{self.domain}/{self.zid}/{self.id}/{self.id}/NN"
        return f"{own}/%/{mangled(self.namespace or '/')}/{self.name}"


class Endpoint(Struct, frozen=True, kw_only=True):
    """A publisher, a subscriber, or one side of a service; `type` is in ROS's form, `geometry_msgs/msg/Twist`."""

    node: Node
    id: str
    kind: EndpointKind
    topic: str
    type: str
    hash: str
    qos: str = str(Qos())

    def __str__(self) -> str:
        node = self.node
        own = f"{ADMIN}/{node.domain}/{node.zid}/{node.id}/{self.id}/{self.kind}/%/{mangled(node.namespace or '/')}"
        return f"{own}/{node.name}/{mangled(self.topic)}/{dds_type(self.type)}/{self.hash}/{self.qos}"

    @property
    def gid(self) -> bytes:
        """Return its identifier in messages and requests."""
        return gid(str(self))

    @property
    def key(self) -> str:
        """Return the key of its messages."""
        return topic_key(self.node.domain, self.topic, self.type, self.hash)


class Port(Struct, frozen=True, kw_only=True):
    """A published or received topic, or a service; `keys` are a subscriber's, if it has more than its type's."""

    kind: EndpointKind
    topic: str
    type: str
    hash: str
    qos: Qos = Qos()
    keys: str = ""


class Attachment(NamedTuple):
    """The number of a message, its time by the sender's wall clock, and its endpoint."""

    sequence: int
    sent_ns: int
    gid: bytes

    def __bytes__(self) -> bytes:
        return struct.pack("<qqB", self.sequence, self.sent_ns, GID_BYTES) + self.gid


def topic_key(domain: int, topic: str, type_: str, hash_: str) -> str:
    """Return the key of a topic's messages, or of a service's requests."""
    return f"{domain}/{topic.strip('/')}/{dds_type(type_)}/{hash_}"


def hash_in(key: str) -> str:
    """Return the hash of the type in a key."""
    return key.rpartition("/")[2]


def type_in(key: str) -> str:
    """Return the type in a key; raise InputError if the key is malformed."""
    return ros_type(key.split("/")[-2])


def dds_type(type_: str) -> str:
    """Return a type in the form of keys: `geometry_msgs::msg::dds_::Twist_`."""
    package, kind, name = type_.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def ros_type(dds: str) -> str:
    """Return a type in ROS's form; raise InputError for anything else."""
    found = _DDS.fullmatch(dds)
    if found is None:
        raise InputError(f"'{dds[:80]}' is not a type of ROS", "malformed")
    return "/".join(found.groups())


def mangled(name: str) -> str:
    """Return a name in the form of tokens."""
    return name.replace("/", "%")


def gid(token: str) -> bytes:
    """Return the identifier of the endpoint with this token."""
    digest = xxhash.xxh3_128(token.encode()).intdigest()
    return digest.to_bytes(GID_BYTES, "little")


def token(text: str) -> Node | Endpoint | None:
    """Return the entity of a token, None if its kind is unknown; raise InputError for a malformed token."""
    parts = text.split("/")
    if len(text) > LONGEST_TOKEN or len(parts) < _NODE_PARTS or parts[0] != ADMIN or not parts[1].isdecimal():
        raise InputError(f"'{text[:80]}' is not a token of ROS", "malformed")
    _, domain, zid, node_id, id_, kind, _enclave, namespace, name = parts[:_NODE_PARTS]
    node = Node(domain=int(domain), zid=zid, id=node_id, namespace=_path(namespace), name=name)
    if kind == "NN" and len(parts) == _NODE_PARTS:
        return node
    if kind not in {"MP", "MS", "SS", "SC"}:
        return None
    if len(parts) != _ENDPOINT_PARTS:
        raise InputError(f"'{text[:80]}' is not a token of ROS", "malformed")
    topic, dds, hash_, qos = parts[_NODE_PARTS:]
    path, named = _path(topic), ros_type(dds)
    return Endpoint(node=node, id=id_, kind=kind, topic=path, type=named, hash=hash_, qos=qos)  # type: ignore[arg-type]


def attachment(data: bytes) -> Attachment:
    """Decode the attachment of a message; raise InputError if it is not rmw_zenoh's."""
    if len(data) == 33 and data[16] == GID_BYTES:
        sequence, sent_ns = struct.unpack_from("<qq", data)
        return Attachment(sequence, sent_ns, data[17:])
    if (found := _named(data)) is not None:
        return found
    raise InputError("its attachment is not one of rmw_zenoh", "malformed")


def _named(data: bytes) -> Attachment | None:
    """Decode an attachment with named values, as of rmw_zenoh 0.2.0 to 0.2.3."""
    values: dict[str, bytes] = {}
    at = 0
    for size in (8, 8, 1 + GID_BYTES):
        length = data[at] if at < len(data) else 0
        name, at = data[at + 1 : at + 1 + length], at + 1 + length
        values[name.decode("ascii", "replace")], at = data[at : at + size], at + size
    fields = [values.get(name, b"") for name in ("sequence_number", "source_timestamp", "source_gid")]
    if at != len(data) or list(map(len, fields)) != [8, 8, 1 + GID_BYTES] or fields[2][0] != GID_BYTES:
        return None
    sequence, sent_ns = (int.from_bytes(one, "little", signed=True) for one in fields[:2])
    return Attachment(sequence, sent_ns, fields[2][1:])


def _path(name: str) -> str:
    return name.replace("%", "/")
