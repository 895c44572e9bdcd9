"""The context of a capability over a transport: its ports, commands, presence and emergency stop."""

import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any, Protocol, TypeVar, cast

import msgspec
from msgspec import Struct

from lbr.bus import keys, session, stamp, wire
from lbr.bus.codec import Decoder, PictureDecoder
from lbr.bus.inflow import Inflow
from lbr.bus.transport import Feed, Transport, ZenohTransport
from lbr.capability import way_in
from lbr.capability.calls import UNSTAMPED, Answers, BusCall
from lbr.capability.config import InputWire, ProcessConfig
from lbr.capability.context import Device, EmergencyStop, Received
from lbr.capability.estop import EstopLatch, NothingToStop
from lbr.capability.events import Throttle
from lbr.capability.kind import STOP, Kind
from lbr.capability.overtaken import Overtaken
from lbr.capability.reporter import Reporter
from lbr.capability.send_times import SendTimes
from lbr.capability.tape import Tape
from lbr.errors import MalformedError
from lbr.messages.camera import JpegFrame
from lbr.messages.codes import Code, Reason
from lbr.messages.leases import CommandReply, refused
from lbr.messages.rows import Row, RowsChanged, RowSet, by_table, changes, edited, with_rows
from lbr.messages.schema import JsonObject
from lbr.messages.system import EstopRequest, Event
from lbr.messages.unreadable import UNREADABLE

COMPLAINTS_PER_S = 2
ACKNOWLEDGE_S = 0.5
"""The time for a mover to acknowledge an emergency stop if it has no setting `acknowledge_s`."""
EDITED = "@edit"  # the executive's edit of rows, left out of recordings as rows have secrets
UNREAD_S = 2.0
"""After this time without a reader, the subscription ends."""
NEWEST_WAIT_S = 0.1
"""The longest wait of the first reader for the newest message; a frozen sender costs it once."""
R = TypeVar("R", bound=Row)


class Join(Protocol):
    """Opens a capability's part of the bus; for the emergency stop, one `alone`."""

    def __call__(self, config: ProcessConfig, *, alone: bool) -> Transport:
        """Open it; raise BusError if it is refused."""


class Port:
    """One input or setpoint: decodes its streams, and drops messages that are not genuine, too fast or malformed.

    Pictures are received `while_read`: a camera without a subscriber rests.
    """

    def __init__(
        self,
        bus: Transport,
        wires: tuple[InputWire, ...],
        kind: type[Struct],
        wake: Callable[[], None] | None,
        complain: Callable[[str, str, Code, str], None],
        name: str,
        *,
        while_read: bool = False,
    ) -> None:
        self.sources = tuple(wire.source for wire in wires)
        self.last: Received | None = None
        self._bus, self._wires, self._wake = bus, wires, wake
        self._name = name
        self._while_read = while_read or kind is JpegFrame
        self._read_at = 0.0
        self._decoder = PictureDecoder() if kind is JpegFrame else Decoder(kind)
        self._complain = complain
        self._fresh: deque[Received] = deque(maxlen=max((wire.history for wire in wires), default=1))
        self._next: dict[str, float] = {}
        self._dates = {wire.key: SendTimes() for wire in wires}
        self._feeds: list[tuple[InputWire, Feed]] = []
        if not self._while_read:
            self._subscribe()

    def take(self) -> list[Received]:
        """Return the new messages, oldest first."""
        self._drain()
        fresh = list(self._fresh)
        self._fresh.clear()
        return fresh

    def latest(self) -> Received | None:
        """Return the newest message since the start."""
        self._drain()
        return self.last

    def drop_unread(self, now: float) -> None:
        """End the subscription of an unread stream."""
        if self._while_read and self._feeds and now - self._read_at > UNREAD_S:
            for _, subscription in self._feeds:
                subscription.close()
            self._feeds.clear()

    def _subscribe(self) -> None:
        self._feeds = [
            (feed, self._bus.subscribe(feed.key, depth=feed.history, wake=self._wake)) for feed in self._wires
        ]

    def _begin_to_read(self) -> None:
        """Receive it, and get the newest message at once."""
        self._subscribe()
        keys_asked = {feed.key: feed for feed in self._wires}
        for raw in self._bus.newest(keys_asked, source=self._name, timeout_s=NEWEST_WAIT_S):
            if raw.key in keys_asked and (received := self._check(keys_asked[raw.key], raw)) is not None:
                self.last = received
                self._fresh.append(received)

    def _drain(self) -> None:
        if self._while_read:
            self._read_at = self._bus.clock()
            if self._wires and not self._feeds:
                self._begin_to_read()
        for feed, subscription in self._feeds:
            for raw in subscription.take():
                received = self._check(feed, raw)
                if received is not None:
                    self.last = received
                    self._fresh.append(received)

    def _check(self, feed: InputWire, raw: wire.RawMessage) -> Received | None:
        now = self._bus.clock()
        sent = stamp.read(raw.attachment)
        source = sent.source if sent is not None else UNSTAMPED
        if feed.seal:
            if not stamp.genuine(sent, raw.payload, bytes.fromhex(feed.seal)) or sent is None:
                why = f"'{source}' is not wired to {feed.key}; only '{feed.source}' may write it"
                self._complain(feed.key, why, "denied", source)
                return None
            if not self._dates[feed.key].newer(sent):
                self._complain(feed.key, f"a message on {feed.key} came twice or out of order", "repeated", source)
                return None
        if feed.rate_hz is not None:
            if now < self._next.get(feed.key, now):
                return None
            self._next[feed.key] = now + 0.9 / feed.rate_hz
        try:
            message = self._decoder.decode(raw.payload)
            return Received(message, sent, self._dates[feed.key].sent_s(sent, raw.arrived), source)
        except MalformedError as err:
            self._complain(
                feed.key, f"a message on {feed.key} from '{source}' is malformed: {err}", "malformed", source
            )
            return None


class ProcessContext:
    """A capability's context, over a transport that `join` opens: by default Zenoh's.

    Each arrival calls `wake`, in any thread; that of a stream if `woken_by_streams` is true or names it.
    """

    def __init__(
        self,
        config: ProcessConfig,
        kind: Kind,
        reporter: Reporter,
        wake: Callable[[], None],
        woken_by_streams: bool | Collection[str],
        join: Join | None = None,
        received_while_read: Collection[str] = (),
    ) -> None:
        join = join or way_in.join
        self.robot = config.robot
        self.name = config.name
        self.simulated = config.simulated
        self.settings: Any = kind.parse(config.settings)
        self.home = config.home
        self._row_sets: Mapping[str, RowSet] = config.rows
        self._rows: dict[type[Row], tuple[Row, ...]] = {}
        self.devices = tuple(Device(d.name, d.type, d.address, d.settings) for d in config.devices)
        self.device = next((d for d in self.devices if d.name == config.device), None)
        self.on_tick = False
        self.live_lease = ""
        self._origin: stamp.Origin | None = None
        self._overtaken = Overtaken()
        within_s = getattr(self.settings, "acknowledge_s", ACKNOWLEDGE_S)
        self.estop: EmergencyStop = (
            EstopLatch(config, wake, within_s, join(config, alone=True)) if kind.moves else NothingToStop()
        )
        self.config = config
        self.kind = kind
        self._reporter = reporter
        self._wake = wake
        self._complained: dict[str, float] = {}
        self._throttle = Throttle()
        self._dropped: dict[str, int] = {}
        self._refused_outputs: set[str] = set()
        with ExitStack() as failed:  # an interruption, too, must leave nothing open
            failed.callback(self.estop.close)
            self._bus = join(config, alone=False)
            failed.pop_all()
        self._events = self._bus.publisher(keys.event(config.robot), config.name)
        taps = {device.name: device.tap for device in self.devices} if self.device is not None else {}
        self._tape = Tape(self._bus, config.robot, config.name, taps)
        self._outputs = {
            name: [
                self._bus.publisher(
                    o.key,
                    config.name,
                    seal=bytes.fromhex(o.seal),
                    pictures=(pictures := kind.outputs.get(name) is JpegFrame),
                    watching=wake if pictures else None,
                )
                for o in wires
            ]
            for name, wires in config.outputs.items()
        }
        self._declared = {name: Decoder(one) for name, one in kind.outputs.items() if one is not JpegFrame}
        ports = {**kind.inputs, **kind.setpoints}
        self._ports = {
            name: Port(
                self._bus,
                config.wiring.get(name, ()),
                message,
                wake if woken_by_streams is True or name in (woken_by_streams or ()) else None,
                self._refused,
                config.name,
                while_read=name in received_while_read,
            )
            for name, message in ports.items()
        }
        self._commands = {
            name: (
                self._bus.serve(
                    keys.port(config.robot, config.name, name),
                    wake,
                    source=config.name,
                    inflow=None if name == STOP else Inflow(),
                ),
                Decoder(message, command=True),
            )
            for name, message in kind.messages.items()
        }
        if any(read.followed for read in kind.reads):
            served = self._bus.serve(keys.edit(config.robot, config.name), wake, source=config.name)
            self._commands[EDITED] = served, Decoder(RowsChanged, command=True)
        _serve_schemas(self._bus, config, kind)
        self._presence = self._bus.presence(config.robot, lambda _name, _alive: wake())
        self._bus.alive(config.robot, config.name)

    @property
    def bus(self) -> session.Session | None:
        """Return this process's session, for kinds that receive more than their wires; one thread may read from it."""
        return self._bus.session if isinstance(self._bus, ZenohTransport) else None

    def clock(self) -> float:
        """Return monotonic seconds."""
        return self._bus.clock()

    def rows(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table that the kind reads."""
        if row not in self._rows:
            if row.TABLE not in self._row_sets:
                raise ValueError(f"'{self.name}' reads no rows of '{row.TABLE}': list them in `rows` of its kind")
            rows = self._row_sets[row.TABLE].rows
            self._rows[row] = tuple(msgspec.json.decode(rows, type=list[row]))  # type: ignore[valid-type]
        return cast("tuple[R, ...]", self._rows[row])

    def publish(self, output: str, message: Struct, *, taken_s: float | None = None) -> None:
        """Publish on every key of an output; `taken_s` is when a picture was taken.

        A message that does not fit the declared type is not published. That is reported once, until one fits again.
        """
        if output not in self._outputs:
            raise KeyError(f"'{self.name}' has no output '{output}'; it has {', '.join(self._outputs) or 'none'}")
        declared = self.kind.outputs[output]
        if not isinstance(message, declared):
            what = f"a {type(message).__name__} on '{output}', which its kind declares to be {declared.__name__}"
            raise TypeError(f"'{self.name}' publishes {what}")
        payload = self._checked(output, message)
        for publisher in self._outputs[output] if payload is not None else ():
            publisher.put(message, taken_s=taken_s, payload=payload)

    def _checked(self, output: str, message: Struct) -> bytes | None:
        """Return a message as bytes, if its declared type accepts them; otherwise None."""
        if isinstance(message, JpegFrame):
            return message.data
        try:
            payload = wire.encode(message)
            self._declared[output].decode(payload)
        except (MalformedError, TypeError, ValueError, RecursionError) as err:
            if output not in self._refused_outputs:
                self._refused_outputs.add(output)
                text = f"'{self.name}' published on '{output}' what its kind does not declare: {err}"
                self.event("refused", text, level="warning", data={"output": output}, code="malformed", about=self.name)
            return None
        self._refused_outputs.discard(output)
        return payload

    def forget(self, output: str) -> None:
        """Stop answering `get` with the last message of an output."""
        for publisher in self._outputs[output]:
            publisher.forget()

    def watched(self, output: str) -> bool:
        """Return whether there is a subscriber of an output of pictures."""
        return any(publisher.watched for publisher in self._outputs[output])

    def wake(self) -> None:
        """Have `step` called at once; may be called from any thread."""
        self._wake()

    def latest(self, port: str) -> Received | None:
        """Return the newest message of an input or setpoint."""
        return self._ports[port].latest()

    def take(self, port: str) -> list[Received]:
        """Return what arrived on an input or setpoint since the last call."""
        return self._ports[port].take()

    def sources(self, port: str) -> tuple[str, ...]:
        """Return the capabilities wired to an input or setpoint."""
        return self._ports[port].sources

    def alive(self, capability: str) -> bool:
        """Return whether another capability's process is on the bus."""
        return capability in self._presence.names

    def targets(self, request: str) -> tuple[str, ...]:
        """Return the names of the capabilities wired to a request."""
        return tuple(self.config.requests.get(request, {}))

    def ask(
        self,
        request: str,
        message: Struct,
        timeout_s: float,
        *,
        only: Collection[str] | None = None,
    ) -> Answers:
        """Ask every capability wired to a request, or `only` some of them; during a command, in its sender's name."""
        payload = wire.encode(message)
        wired = self.config.requests.get(request, {})
        asked = {name: key for name, key in wired.items() if only is None or name in only}
        questions = {
            name: self._bus.query(
                key, payload, timeout_s=timeout_s, source=self.name, origin=self._origin, wake=self._wake
            )
            for name, key in asked.items()
        }
        return Answers(questions, Decoder(self.kind.replies.get(request, CommandReply)))

    def event(
        self,
        kind: str,
        text: str,
        *,
        level: str = "info",
        data: JsonObject | None = None,
        code: str = "",
        about: str = "",
    ) -> None:
        """Publish on `@event`; if there are too many of this kind, count it for a summary."""
        if not self._throttle.take(kind, self.clock()):
            return
        safe = level if level in {"info", "warning", "error"} else "info"
        event = Event(
            kind=kind,
            subject=self.name,
            text=text,
            level=safe,  # type: ignore[arg-type]
            wall_ns=time.time_ns(),
            data=data or {},
            code=code,
            about=about,
        )
        self._events.put(event)

    def tell_missed(self) -> None:
        """Report the number of suppressed events; called once a second."""
        for kind, missed in self._throttle.missed().items():
            text = f"{missed} more events '{kind}' within a second"
            event = Event(kind="repeated", subject=self.name, text=text, level="warning", wall_ns=time.time_ns())
            self._events.put(event)

    def drop_unread(self) -> None:
        """Stop receiving pictures that are not read; called once a second."""
        now = self.clock()
        for port in self._ports.values():
            port.drop_unread(now)

    def tell_recorder(self) -> None:
        """Publish bytes and commands to a recorder, if there is one; called after each tick."""
        self._tape.step(self.clock())

    def engage_estop(self, reason: str) -> None:
        """Latch the emergency stop of everything that moves."""
        request = EstopRequest(engaged=True, reason=reason[:200])
        self._bus.put(keys.estop(self.robot), request, source=self.name)

    def learn(self, *rows: Row) -> None:
        """Have learnt rows stored."""
        for row in rows:
            if type(row) not in self.kind.learns:
                raise ValueError(f"'{self.name}' learns no rows of '{row.TABLE}': list them in `learns` of its kind")
        told = _plain(rows)
        self._reporter.learnt(changes(self._row_sets, told))
        self._take_over(told)

    def adopt(self, rows: Iterable[Row]) -> None:
        """Use the rows of an accepted edit."""
        self._take_over(_plain(rows))

    def _take_over(self, told: Mapping[str, msgspec.Raw]) -> None:
        self._row_sets = with_rows(self._row_sets, told)
        self._rows.clear()

    def ready(self, reason: str = "") -> None:
        """Report that this capability works."""
        self._reporter.phase("ready", reason)

    def warn(self, reason: str | Reason, code: Code = "failed") -> None:
        """Report that it works only partly."""
        self._reporter.phase("degraded", str(reason), reason.code if isinstance(reason, Reason) else code)

    @contextmanager
    def on_behalf(self, call: BusCall) -> Iterator[None]:
        """Ask in the name and with the date of this command's sender, until it is answered."""
        self._origin = call.origin
        try:
            yield
        finally:
            self._origin = None

    def calls(self) -> Iterator[BusCall]:
        """Yield the waiting commands, each after all stops that are older than it; refuse malformed ones."""
        self.estop.serve()
        overtaken = self.kind.moves and STOP in self._commands
        for name, (served, _) in self._commands.items():
            served.first = self.live_lease.encode()
            if served.dropped > self._dropped.get(name, 0):
                self._dropped[name] = served.dropped
                self._refused(
                    served.key, f"too many commands at once on {served.key}; {served.dropped} were dropped", "busy"
                )
            for request in served.take():
                if overtaken and name != STOP:
                    yield from (call for stop in self._commands[STOP][0].take() for call in self._call(STOP, stop))
                yield from self._call(name, request)

    def _call(self, name: str, request: wire.Request) -> list[BusCall]:
        """Return the decoded command, or refuse it."""
        call = BusCall(
            name,
            None,
            request,
            self.name,
            lambda who, reply: self._refused(who, f"{who}: {reply.reason}", reply.code, about=who),
            away=bool(self.config.host),
            overtaken=self._overtaken,
            answered=self._tape.answered if name != EDITED else None,
        )
        try:
            call.message = _read(name, request.payload, self._commands[name][1])
            if not isinstance(call.message, RowsChanged):
                return [call]
            self._row_sets = edited(self._row_sets, (read.row for read in self.kind.reads), call.message)
            self._rows.clear()
            call.reply(CommandReply(accepted=True))
        except (MalformedError, *UNREADABLE) as err:
            call.refuse(f"malformed command: {err}", "malformed")
        return []

    def counts(self) -> dict[str, int]:
        """Return how many messages each output has published."""
        return {name: publishers[0].count for name, publishers in self._outputs.items() if publishers}

    def close(self) -> None:
        """Refuse the waiting commands, and leave the bus; the token goes with it."""
        for served, _ in self._commands.values():
            for request in served.take():
                request.reply(refused(Reason("shutting_down", f"'{self.name}' ends")), self.name)
        self.estop.close()
        self._bus.close()

    def _refused(self, key: str, text: str, code: str, about: str = "") -> None:
        now = self.clock()
        if now >= self._complained.get(key, 0.0):
            if len(self._complained) > 256:
                self._complained.clear()
            self._complained[key] = now + 1 / COMPLAINTS_PER_S
            self.event("refused", text, level="warning", data={"key": key}, code=code, about=about)


def _plain(rows: Iterable[Row]) -> dict[str, msgspec.Raw]:
    """Return rows as others receive them; raise msgspec.ValidationError for values that their annotations refuse."""
    return by_table(msgspec.convert(msgspec.to_builtins(row), type(row)) for row in rows)


def _read(name: str, payload: bytes, decoder: Decoder[Any]) -> Any:
    """Return a command's message; an unreadable stop is a stop."""
    try:
        return _decode(payload, decoder)
    except MalformedError:
        if name != STOP:
            raise
        return decoder.decode(b"{}")


def _decode(payload: bytes, decoder: Decoder[object]) -> object:
    if len(payload) > wire.MAX_COMMAND_BYTES:
        raise MalformedError(f"it may have {wire.MAX_COMMAND_BYTES} bytes, not {len(payload)}")
    return decoder.decode(payload or b"{}")


def _serve_schemas(bus: Transport, config: ProcessConfig, kind: Kind) -> None:
    keyed = {wire.key for wires in config.outputs.values() for wire in wires}
    own = {name: kind.outputs[name] for name in kind.outputs if keys.port(config.robot, config.name, name) in keyed}
    types = {**own, **kind.messages, **kind.setpoints}
    for name, message in types.items():
        bus.document(keys.schema(config.robot, config.name, name), partial(kind.schema, name, message))
