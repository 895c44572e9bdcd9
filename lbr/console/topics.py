"""The list of a robot's bus: every stream and command with its type, as its owner describes it."""

import time
from collections import Counter
from collections.abc import Iterable

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import keys, probe, wire
from lbr.bus.codec import Decoder, decode
from lbr.bus.session import Session
from lbr.console.fields import Field, properties
from lbr.console.printable import listed
from lbr.errors import BusError, InputError, MalformedError
from lbr.messages.rows import short
from lbr.messages.schema import JsonObject
from lbr.messages.system import RANKS, EstopRequest, Event, Role, Status, role_missing
from lbr.names import near

UNDESCRIBED = "(heard; no schema)"
LISTEN_S = 1.0


class Topic(Struct, frozen=True, kw_only=True):
    """A stream, a command or a setpoint; `name` is its key below the robot.

    A setpoint is a stream on its target's key, which only its wired source may write, sealed.
    """

    name: str
    role: str
    message: str
    rate_hz: float | None
    json_schema: JsonObject


def catalogue(bus: Session, robot: str, source: str) -> list[Topic]:
    """Return the topics of all running capabilities, by name."""
    schemas = probe.survey(bus, keys.schema(robot, "*", "*"), source=source)
    rates = _rates(wire.ask(bus, keys.status(robot), None, source=source))
    topics = {}
    for raw in schemas:
        capability, name = raw.key.split("/")[-2:]
        schema = _decoded(raw.payload)
        topic = f"{capability}/{name}"
        topics[topic] = Topic(
            name=topic,
            role="stream" if topic in rates else "command" if "x-role" in schema else "setpoint",
            message=str(schema.get("$ref", "")).rpartition("/")[2] or str(schema.get("title", "?")),
            rate_hz=rates.get(topic),
            json_schema=schema,
        )
    return _placed([topics[name] for name in sorted(topics)], bus, robot, source)


def undescribed(bus: Session, robot: str, known: Iterable[Topic]) -> list[Topic]:
    """Listen for streams without a description, such as those of programs of kind exec."""
    arrivals = probe.Arrivals(bus, f"{robot}/**")
    time.sleep(LISTEN_S)
    arrived = arrivals.take()
    arrivals.close()
    described = {topic.name for topic in known}
    counts = Counter(arrival.key.removeprefix(f"{robot}/") for arrival in arrived)
    return [
        Topic(name=name, role="stream", message=UNDESCRIBED, rate_hz=round(count / LISTEN_S, 1), json_schema={})
        for name, count in sorted(counts.items())
        if name not in described and not name.startswith("@")
    ]


def system_topics() -> list[Topic]:
    """Return the robot's own topics, which no capability owns."""
    return [
        Topic(name=name, role=role, message=kind.__name__, rate_hz=rate_hz, json_schema=msgspec.json.schema(kind))
        for name, role, kind, rate_hz in (
            ("@event", "stream", Event, None),
            ("@estop", "stream", EstopRequest, None),
            ("@status", "stream", Status, 1.0),
        )
    ]


def silence(topics: Iterable[Topic], key: str, seconds: float) -> str:
    """Return the possible reason for silence on a key."""
    name = key.partition("/")[2]
    known = {topic.name: topic for topic in topics}
    nothing = f"nothing has come on {key} within {seconds:g} s"
    if "*" in name:
        return nothing
    if name not in known:
        return f"{nothing}, and there is no '{short(name)}'; {_near(name, known)}"
    if known[name].role == "command":
        shows = f"'lbr topic info {name}' shows what it takes"
        return f"{nothing}: it is a command, which publishes nothing by itself; {shows}"
    return nothing


def why_not_publish(topics: Iterable[Topic], key: str, role: Role) -> str:
    """Return why a robot silently drops a publication of this role from another machine; empty if it does not."""
    name = key.partition("/")[2]
    known = {topic.name: topic for topic in topics}
    needed: Role | None = (
        "view" if name == "@estop" else known[name].json_schema.get("x-role") if name in known else None
    )
    if needed in RANKS:
        return missing.text if (missing := role_missing(needed, role)) is not None else ""
    return f"from another machine one may publish commands and the emergency stop, and '{short(name)}' is neither"


def choose(topics: Iterable[Topic], name: str) -> Topic:
    """Return the topic of that name; raise InputError with the probably meant ones."""
    known = {topic.name: topic for topic in topics}
    if name not in known:
        raise InputError(f"there is no '{short(name)}'; {_near(name, known)}", "unknown_name")
    return known[name]


def key_of(robot: str, name: str) -> str:
    """Return the key of a typed topic: `drive/state`, `/drive/state`, `lbr/drive/state`, `@event`."""
    name = name.strip("/")
    key = name if name.startswith(f"{robot}/") else f"{robot}/{name}"
    try:
        if name.isprintable() and not any(char in name for char in "$ "):
            return wire.canonical(key)
    except BusError:
        pass
    raise InputError(f"'{short(name)}' is not a topic; topics look like drive/state, and * stands for any one part")


def fields_of(topic: Topic) -> list[Field]:
    """Return a message's fields."""
    return properties(topic.json_schema)


def _near(name: str, known: dict[str, Topic]) -> str:
    close = near(name, known, most=3, cutoff=0.5)
    return f"{f'did you mean {listed(close)}? ' if close else ''}'lbr topic list' names what there is"


def _placed(topics: list[Topic], bus: Session, robot: str, source: str) -> list[Topic]:
    """Move outputs that are sent as setpoints to their real key: that of the receiving capability."""
    sent = {
        topic.message: topic
        for topic in topics
        if topic.rate_hz and not wire.ask(bus, f"{robot}/{topic.name}", None, source=source, timeout_s=1.0)
    }
    placed = []
    for topic in topics:
        setpoint = sent.get(topic.message)
        if setpoint is None or topic.role == "stream":
            placed.append(topic)
        else:
            placed.append(replace(topic, role="setpoint", rate_hz=setpoint.rate_hz))
    elsewhere = {topic.message for topic in placed if topic.role == "setpoint"}
    return [topic for topic in placed if not (topic in sent.values() and topic.message in elsewhere)]


def _rates(answers: list[wire.RawMessage]) -> dict[str, float]:
    if not answers:
        return {}
    try:
        status = Decoder(Status).decode(answers[0].payload)
    except MalformedError:
        return {}
    return {f"{one.name}/{output}": rate for one in status.capabilities for output, rate in one.rates_hz.items()}


def _decoded(payload: bytes) -> dict[str, object]:
    try:
        value = decode(payload)
    except MalformedError:
        return {}
    return value if isinstance(value, dict) else {}
