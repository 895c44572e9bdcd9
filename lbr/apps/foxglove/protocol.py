"""Foxglove's WebSocket protocol: frames of a client become messages, ours become frames. Pure.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
"""

import struct
from collections.abc import Iterable
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct

PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""The newest first; their messages are the same here."""
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
    """A topic, and how its messages are written. JSON, with a JSON Schema, is all that is served here."""

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
    """The subscription of a client, and its own number for it."""

    id: Number
    channel_id: Number


class Subscribe(Struct, frozen=True, tag_field="op", tag="subscribe"):
    """Hear these, too."""

    subscriptions: Annotated[tuple[Subscription, ...], Meta(max_length=MOST_LISTED)]


class Unsubscribe(Struct, frozen=True, tag_field="op", tag="unsubscribe", rename="camel"):
    """Hear these no more."""

    subscription_ids: Annotated[tuple[Number, ...], Meta(max_length=MOST_LISTED)]


class Advertise(Struct, frozen=True, tag_field="op", tag="advertise"):
    """Publish on these."""

    channels: Annotated[tuple[Published, ...], Meta(max_length=MOST_LISTED)]


class Unadvertise(Struct, frozen=True, tag_field="op", tag="unadvertise", rename="camel"):
    """Publish on these no more."""

    channel_ids: Annotated[tuple[Number, ...], Meta(max_length=MOST_LISTED)]


class Say(Struct, frozen=True):
    """A message of a channel that the client has advertised."""

    channel_id: int
    payload: bytes


class Call(Struct, frozen=True):
    """A service that is asked for; its answer quotes both numbers."""

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


class Unknown(Struct, frozen=True):
    """A message of a newer protocol, or of a part that is not served here."""

    op: str


class Rubbish(Exception):  # noqa: N818 - an answer, not a fault
    """The bytes are not a message; the text names the place where they do not fit."""


class _Op(Struct, frozen=True):
    op: Text


Message = Subscribe | Unsubscribe | Advertise | Unadvertise | Say | Call | Unknown
_KNOWN = {"subscribe", "unsubscribe", "advertise", "unadvertise"}
_op = msgspec.json.Decoder(_Op)
_text = msgspec.json.Decoder(Subscribe | Unsubscribe | Advertise | Unadvertise)


def parse(said: str | bytes) -> Message:
    """Return what a client says: text is JSON, bytes are binary messages. Raise Rubbish, and nothing else."""
    try:
        return _binary(said) if isinstance(said, bytes) else _json(said.encode("utf-8", "surrogatepass"))
    except RecursionError:
        raise Rubbish("the JSON is nested too deeply") from None
    except (msgspec.MsgspecError, ValueError, OverflowError) as err:
        raise Rubbish("".join(one if one.isprintable() else " " for one in str(err))[:200]) from None


def _json(said: bytes) -> Message:
    op = _op.decode(said).op
    return _text.decode(said) if op in _KNOWN else Unknown(op)


def _binary(said: bytes) -> Message:
    if not said:
        raise Rubbish("an empty binary message")
    if said[0] == 1:
        if len(said) < 1 + _PUBLISHED.size:
            raise Rubbish("a published message is too short")
        return Say(_PUBLISHED.unpack_from(said, 1)[0], said[1 + _PUBLISHED.size :])
    if said[0] == 2:
        if len(said) < 1 + _CALL.size:
            raise Rubbish("a service request is too short")
        service, call, length = _CALL.unpack_from(said, 1)
        begin = 1 + _CALL.size
        if length > len(said) - begin:
            raise Rubbish("a service request is shorter than it says")
        return Call(service, call, said[begin : begin + length].decode(), said[begin + length :])
    raise Rubbish(f"there is no binary message {said[0]}")


def server_info(name: str, session: str, *, publishes: bool) -> str:
    """Return the first word of a server."""
    can = ["services", *(["clientPublish"] if publishes else [])]
    info = {"name": name, "capabilities": can, "supportedEncodings": ["json"], "metadata": {}, "sessionId": session}
    return _told("serverInfo", info)


def advertise(channels: Iterable[Channel]) -> str:
    """Tell which topics there are."""
    return _told("advertise", {"channels": list(channels)})


def unadvertise(ids: Iterable[int]) -> str:
    """Tell which topics are no more."""
    return _told("unadvertise", {"channelIds": list(ids)})


def advertise_services(services: Iterable[dict[str, Any]]) -> str:
    """Tell which services there are."""
    return _told("advertiseServices", {"services": list(services)})


def unadvertise_services(ids: Iterable[int]) -> str:
    """Tell which services are no more."""
    return _told("unadvertiseServices", {"serviceIds": list(ids)})


def status(level: int, text: str, about: str = "") -> str:
    """Tell a sentence that Foxglove shows among its problems; one that is about the same takes the place of the
    last."""
    return _told("status", {"level": level, "message": text, **({"id": about} if about else {})})


def alive() -> str:
    """Say something that changes nothing: what is not acknowledged tells that the other end is lost."""
    return _told("removeStatus", {"statusIds": ["alive"]})


def failed(call: Call, why: str) -> str:
    """Tell why a service did nothing."""
    return _told("serviceCallFailure", {"serviceId": call.service_id, "callId": call.call_id, "message": why})


def message(subscription: int, at_ns: int, payload: bytes) -> bytes:
    """Return a message of a topic."""
    return _HEAD.pack(_MESSAGE, subscription, at_ns) + payload


def answered(call: Call, payload: bytes) -> bytes:
    """Return the answer of a service, in JSON."""
    head = struct.pack("<BIII", _SERVICE, call.service_id, call.call_id, len(b"json"))
    return head + b"json" + payload


def _told(op: str, more: dict[str, Any]) -> str:
    return _encode({"op": op, **more}).decode()
