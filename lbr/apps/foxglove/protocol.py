"""Foxglove's WebSocket protocol: parses a client's frames, and encodes the server's. Pure.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
"""

import struct
from collections.abc import Iterable, Mapping
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from lbr.errors import MalformedError
from lbr.messages.plain import one_line

PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""The newest version first; their messages are the same here."""
MOST_LISTED = 256
INFO, WARNING, ERROR = 0, 1, 2
_MESSAGE, _SERVICE = 1, 3
_HEAD = struct.Struct("<BIQ")
_PUBLISHED = struct.Struct("<I")
_CALL = struct.Struct("<III")
_encode = msgspec.json.Encoder().encode

Number = Annotated[int, Meta(ge=0, le=2**32 - 1)]
Text = Annotated[str, Meta(max_length=200)]


class Channel(Struct, frozen=True, kw_only=True, rename="camel"):
    """A topic and its encoding. The server has JSON only, with a JSON Schema."""

    id: Number
    topic: Text
    encoding: str = "json"
    schema_name: str = ""
    schema: str = ""
    schema_encoding: str = "jsonschema"


class Published(Struct, frozen=True, kw_only=True, rename="camel"):
    """A topic on which a client publishes."""

    id: Number
    topic: Text
    encoding: Text
    schema_name: str = ""


class Subscription(Struct, frozen=True, kw_only=True, rename="camel"):
    """A client's subscription, with the client's number for it."""

    id: Number
    channel_id: Number


class Subscribe(Struct, frozen=True, tag_field="op", tag="subscribe"):
    """Add these subscriptions."""

    subscriptions: Annotated[tuple[Subscription, ...], Meta(max_length=MOST_LISTED)]


class Unsubscribe(Struct, frozen=True, tag_field="op", tag="unsubscribe", rename="camel"):
    """End these subscriptions."""

    subscription_ids: Annotated[tuple[Number, ...], Meta(max_length=MOST_LISTED)]


class Advertise(Struct, frozen=True, tag_field="op", tag="advertise"):
    """Publish on these topics."""

    channels: Annotated[tuple[Published, ...], Meta(max_length=MOST_LISTED)]


class Unadvertise(Struct, frozen=True, tag_field="op", tag="unadvertise", rename="camel"):
    """End publishing on these topics."""

    channel_ids: Annotated[tuple[Number, ...], Meta(max_length=MOST_LISTED)]


class MessageData(Struct, frozen=True):
    """A message of a channel that the client has advertised."""

    channel_id: int
    payload: bytes


class ServiceCall(Struct, frozen=True):
    """The request of a service; its answer quotes both numbers."""

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


class Unknown(Struct, frozen=True):
    """A message of a newer protocol, or of an unsupported part."""

    op: str


class _Op(Struct, frozen=True):
    op: Text


Message = Subscribe | Unsubscribe | Advertise | Unadvertise | MessageData | ServiceCall | Unknown
_KNOWN = {"subscribe", "unsubscribe", "advertise", "unadvertise"}
_op = msgspec.json.Decoder(_Op)
_text = msgspec.json.Decoder(Subscribe | Unsubscribe | Advertise | Unadvertise)


def parse(frame: str | bytes) -> Message:
    """Parse a frame: text is JSON, bytes are a binary message. Raise MalformedError, and nothing else."""
    try:
        return _binary(frame) if isinstance(frame, bytes) else _json(frame.encode("utf-8", "surrogatepass"))
    except RecursionError:
        raise MalformedError("the JSON is nested too deeply") from None
    except (msgspec.MsgspecError, ValueError, OverflowError) as err:
        raise MalformedError(one_line(str(err))[:200]) from None


def _json(data: bytes) -> Message:
    op = _op.decode(data).op
    return _text.decode(data) if op in _KNOWN else Unknown(op)


def _binary(data: bytes) -> Message:
    if not data:
        raise MalformedError("an empty binary message")
    if data[0] == 1:
        if len(data) < 1 + _PUBLISHED.size:
            raise MalformedError("a published message is too short")
        return MessageData(_PUBLISHED.unpack_from(data, 1)[0], data[1 + _PUBLISHED.size :])
    if data[0] == 2:
        if len(data) < 1 + _CALL.size:
            raise MalformedError("a service request is too short")
        service, call, length = _CALL.unpack_from(data, 1)
        begin = 1 + _CALL.size
        if length > len(data) - begin:
            raise MalformedError("a service request is shorter than its header states")
        return ServiceCall(service, call, data[begin : begin + length].decode(), data[begin + length :])
    raise MalformedError(f"there is no binary message {data[0]}")


def server_info(name: str, session: str, *, publishes: bool) -> str:
    """Return the first message of a server."""
    can = ["services", *(["clientPublish"] if publishes else [])]
    info = {"name": name, "capabilities": can, "supportedEncodings": ["json"], "metadata": {}, "sessionId": session}
    return _encoded("serverInfo", info)


def advertise(channels: Iterable[Channel]) -> str:
    """Advertise topics."""
    return _encoded("advertise", {"channels": list(channels)})


def unadvertise(ids: Iterable[int]) -> str:
    """Withdraw topics."""
    return _encoded("unadvertise", {"channelIds": list(ids)})


def advertise_services(services: Iterable[dict[str, object]]) -> str:
    """Advertise services."""
    return _encoded("advertiseServices", {"services": list(services)})


def unadvertise_services(ids: Iterable[int]) -> str:
    """Withdraw services."""
    return _encoded("unadvertiseServices", {"serviceIds": list(ids)})


def status(level: int, text: str, about: str = "") -> str:
    """Report a sentence among Foxglove's problems; it replaces the last one with the same `about`."""
    return _encoded("status", {"level": level, "message": text, **({"id": about} if about else {})})


def alive() -> str:
    """Return a message without effect, by whose acknowledgement the kernel finds a lost peer."""
    return _encoded("removeStatus", {"statusIds": ["alive"]})


def failed(call: ServiceCall, why: str) -> str:
    """Report why a service failed."""
    return _encoded("serviceCallFailure", {"serviceId": call.service_id, "callId": call.call_id, "message": why})


def message(subscription: int, at_ns: int, payload: bytes) -> bytes:
    """Return a message of a topic."""
    return _HEAD.pack(_MESSAGE, subscription, at_ns) + payload


def answered(call: ServiceCall, payload: bytes) -> bytes:
    """Return the answer of a service, in JSON."""
    head = struct.pack("<BIII", _SERVICE, call.service_id, call.call_id, len(b"json"))
    return head + b"json" + payload


def _encoded(op: str, fields: Mapping[str, object]) -> str:
    return _encode({"op": op, **fields}).decode()
