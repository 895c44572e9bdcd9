"""`lbr topic`: list, info, echo, hz and pub."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import click
import msgspec

from lbr.bus import keys, pictures, probe, wire
from lbr.bus.codec import decode
from lbr.bus.session import Session
from lbr.bus.wire import RawMessage
from lbr.commands.completing import complete_topic
from lbr.commands.options import Number, Whom, json_option, print_json, robot_options
from lbr.console import rates, target, topics
from lbr.console.rates import Rate
from lbr.console.topics import Topic
from lbr.errors import BusError, InputError, MalformedError
from lbr.messages.plain import one_line

WAIT_S = 5.0
SILENT_S = 2.0
REFUSAL_S = 0.3
POLL_S = 0.02
DEEPEST = 60
"""Columns of indentation; deeper levels stand in one line."""


@click.group("topic")
def command() -> None:
    """Look at the bus. A topic is named below its robot: drive/state, @event; * stands for any one part."""


@command.command("list")
@robot_options
@json_option
def list_topics(whom: Whom, as_json: bool) -> int:
    """List streams and commands, with message types and rates; waits a second for streams without a description."""
    with _bus(whom) as (bus, name, source):
        streams = topics.catalogue(bus, name, source)
        streams = sorted([*streams, *topics.undescribed(bus, name, streams)], key=lambda topic: topic.name)
    if as_json:
        print_json([{"name": t.name, "role": t.role, "message": t.message, "rate_hz": t.rate_hz} for t in streams])
        return 0
    width = max((len(topic.name) for topic in streams), default=0)
    for topic in streams:
        rate = f"{topic.rate_hz:7.1f} Hz" if topic.rate_hz is not None else " " * 10
        click.echo(one_line(f"{topic.name:<{width}}  {topic.role:<8}  {rate}  {topic.message}"))
    return 0


@command.command("info")
@click.argument("topic", shell_complete=complete_topic)
@robot_options
@json_option
def info(topic: str, whom: Whom, as_json: bool) -> int:
    """Describe a stream or command: its key, its message and the values of each field."""
    with _bus(whom) as (bus, name, source):
        key = topics.key_of(name, topic)
        known, wanted = _known(bus, name, source), key.partition("/")[2]
        if wanted not in {topic.name for topic in known}:
            known += topics.undescribed(bus, name, known)
        chosen = topics.choose(known, wanted)
    if as_json:
        print_json({"key": key, "role": chosen.role, "rate_hz": chosen.rate_hz, "schema": chosen.json_schema})
        return 0
    rate = f", {chosen.rate_hz:.1f} Hz" if chosen.rate_hz is not None else ""
    click.echo(one_line(f"{key}  ({chosen.role} of {chosen.message}{rate})"))
    for field in topics.fields_of(chosen):
        about = str(field.schema.get("description", ""))
        click.echo(one_line(f"  {field.name:<20} {about or field.allowed}"))
    return 0


@command.command("echo")
@click.argument("topic", shell_complete=complete_topic)
@robot_options
@click.option("--once", is_flag=True, help="Print one message, the latest there is, and leave.")
@click.option("--raw", is_flag=True, help="Print the payload's bytes as they are.")
@json_option
def echo(topic: str, whom: Whom, once: bool, raw: bool, as_json: bool) -> int:
    """Print the messages of a stream, until Ctrl-C. If nothing comes for 2 s, the possible reason goes to standard
    error."""
    with _bus(whom) as (bus, name, source):
        key = topics.key_of(name, topic)
        feed = wire.Subscription(bus, key, depth=1000)
        messages = _latest(bus, key, _known(bus, name, source), source) if once else []
        started = time.monotonic()
        received = False
        while True:
            for message in messages:
                received = True
                print_message(message, as_json=as_json, raw=raw, named="*" in key)
                if once:
                    return 0
            if once and not time.monotonic() < started + WAIT_S:
                raise BusError(topics.silence(_known(bus, name, source), key, WAIT_S))
            if not (once or received or time.monotonic() < started + SILENT_S):
                received = True
                click.echo(f"lbr: {topics.silence(_known(bus, name, source), key, SILENT_S)}; waiting", err=True)
            time.sleep(POLL_S)
            messages = feed.take()


@command.command("hz")
@click.argument("topic", shell_complete=complete_topic)
@robot_options
@click.option("--seconds", type=Number(0.1, 3600), default=5.0, show_default=True, help="How long to listen.")
@json_option
def hz(topic: str, whom: Whom, seconds: float, as_json: bool) -> int:
    """Measure a stream: how often it is published, how often it arrives here, what is lost and how late it is.

    The publisher's rate is by its own numbering and clock, so a slow machine or network cannot make it look wrong.
    """
    with _bus(whom) as (bus, name, _source):
        key = topics.key_of(name, topic)
        listener = probe.Arrivals(bus, key)
        started = time.monotonic()
        try:
            time.sleep(seconds)
        except KeyboardInterrupt:
            click.echo(err=True)
        arrivals = listener.take()
        measured = rates.measure(arrivals, time.monotonic() - started)
    if as_json:
        print_json(measured)
        return 0 if measured else 1
    if not measured:
        raise BusError(f"nothing came on {key} within {seconds:g} s")
    for rate in measured:
        click.echo(rate_text(rate))
    return 0


@command.command("pub")
@click.argument("topic", shell_complete=complete_topic)
@click.argument("message", metavar="JSON")
@robot_options
@click.option("--rate", type=Number(0.01, 1000), default=10.0, show_default=True, help="Messages a second.")
@click.option("--count", type=click.IntRange(1), default=1, show_default=True, help="How many messages.")
def pub(topic: str, message: str, whom: Whom, rate: float, count: int) -> int:
    """Publish a message of JSON. A refusal by the robot is printed, and the exit code is then 1."""
    try:
        payload = msgspec.json.decode(message)
    except (msgspec.DecodeError, UnicodeError) as err:
        raise InputError(f"the message is not JSON: {err}") from None
    robot = target.find(*whom)
    name, source = robot.robot, target.source("lbr topic")
    with target.connected(robot) as bus:
        key = topics.key_of(name, topic)
        if "*" in key:
            raise InputError("a message goes to one topic; leave out the *")
        if robot.certificate and (why_not := topics.why_not_publish(_known(bus, name, source), key, robot.role)):
            raise BusError(why_not)
        events = wire.Subscription(bus, keys.event(name), depth=256)
        due = time.monotonic()
        for _ in range(count):
            time.sleep(max(0.0, due - time.monotonic()))
            wire.put(bus, key, payload, source=source)
            due += 1 / rate
        time.sleep(REFUSAL_S)
        refusals = [text for text in (refusal_in(raw, key, source) for raw in events.take()) if text]
    for text in dict.fromkeys(refusals):
        click.echo(text, err=True)
    return 1 if refusals else 0


@contextmanager
def _bus(whom: Whom) -> Iterator[tuple[Session, str, str]]:
    found = target.find(*whom)
    with target.connected(found) as bus:
        yield bus, found.robot, target.source("lbr topic")


def _known(bus: Session, robot: str, source: str) -> list[Topic]:
    return [*topics.catalogue(bus, robot, source), *topics.system_topics()]


def _latest(bus: Session, key: str, known: list[Topic], source: str) -> list[RawMessage]:
    """Ask a stream for its latest message; a command is never asked, because that would carry it out."""
    streams = {topic.name for topic in known if topic.role == "stream"}
    return wire.ask(bus, key, None, source=source, timeout_s=1.0) if key.partition("/")[2] in streams else []


def print_message(message: RawMessage, *, as_json: bool, raw: bool, named: bool) -> None:
    """Print a message: its bytes, its JSON, or lines for people."""
    if raw:
        out = sys.stdout.buffer
        out.write(message.payload + b"\n")
        out.flush()
        return
    value = value_of(message.payload)
    if as_json:
        print_json({"key": message.key, "message": value} if named else value)
        return
    if named:
        click.echo(f"# {message.key}")
    for line in lines_of(value):
        click.echo(line)
    click.echo("---")


def value_of(payload: bytes) -> object:
    """Return the JSON of a payload; of a picture or other bytes, a description."""
    if pictures.is_whole(payload):
        return pictures.described(payload)
    try:
        return decode(payload)
    except MalformedError:
        return f"{len(payload)} bytes that are not JSON"


def lines_of(value: object, indent: str = "") -> Iterator[str]:
    """Return lines for people, a field in each."""
    if not isinstance(value, dict):
        yield indent + one_line(_scalar(value))
        return
    for name, field in value.items():
        if isinstance(field, dict) and field and len(indent) < DEEPEST:
            yield f"{indent}{one_line(name)}:"
            yield from lines_of(field, indent + "  ")
        else:
            yield f"{indent}{one_line(name)}: {one_line(_scalar(field))}"


def _scalar(value: object) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.6g}" if isinstance(value, float) else msgspec.json.encode(value).decode()


def rate_text(rate: Rate) -> str:
    """Return a measured rate in one line."""
    published = f"published {rate.publisher_hz:.1f} Hz" if rate.publisher_hz is not None else "published ? Hz"
    parts = [published, f"received {rate.received_hz:.1f} Hz"]
    if rate.lost is not None:
        parts.append(f"lost {rate.lost} ({rate.lost_percent or 0:.1f} %)")
    if rate.period_p99_ms is not None:
        parts.append(f"period p50 {rate.period_p50_ms:.1f} p99 {rate.period_p99_ms:.1f} ms")
    if rate.age_p99_ms is not None:
        parts.append(f"age p50 {rate.age_p50_ms:.2f} p99 {rate.age_p99_ms:.2f} ms")
    return one_line(f"{rate.key} from {rate.source}: {', '.join([*parts, f'{rate.bytes_per_s / 1000:.1f} kB/s'])}")


def refusal_in(raw: RawMessage, key: str, source: str) -> str:
    """Return the text of an event that refuses this key or sender, otherwise an empty text."""
    value = value_of(raw.payload)
    if not isinstance(value, dict) or value.get("kind") != "refused":
        return ""
    text = str(value.get("text", ""))
    data = value.get("data")
    here = isinstance(data, dict) and data.get("key") == key
    ours = here or key.partition("/")[2].partition("/")[0] == value.get("subject") or value.get("about") == source
    return one_line(f"{value.get('subject', '')}: {text}") if ours else ""
