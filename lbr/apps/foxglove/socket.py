"""One client of Foxglove's protocol: its streams, services and motion; on the server's thread.

- subscribe: the newest messages of streams; a slow reader misses some, and a dead one is disconnected
- service: a console line with the client's role, and its answer; a goal goes on while the connection stands
- publish: a hand (`lbr.apps.web.api.holds`) with a lease, renewed while the client publishes
"""

import asyncio
import socket
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Protocol

import msgspec
from starlette.types import Receive
from starlette.websockets import WebSocket

from lbr.apps.foxglove import channels, protocol
from lbr.apps.foxglove import services as words
from lbr.apps.foxglove.channels import Source
from lbr.apps.foxglove.pictures import Pictures
from lbr.apps.foxglove.services import ESTOP, STOP, Service
from lbr.apps.http.connection import connection_of
from lbr.apps.web import viewing
from lbr.apps.web.api.feeds import KEPT_S, Feeds, Sample
from lbr.apps.web.api.holds import Hand, HoldNews
from lbr.apps.web.api.page_message import Wanted
from lbr.apps.web.api.requests import source_of
from lbr.apps.web.api.service import Api
from lbr.apps.web.face import Client, Refused
from lbr.bus.codec import decode_request
from lbr.errors import InputError, MalformedError
from lbr.messages.unreadable import UNREADABLE

MOST_CALLS, MOST_NEWS = 8, 256
RESTED_S = 1.0
"""The silence after which published motion begins anew. A network's delay is not a release, so it is longer than a
wireless network is usually silent."""
LOST_MS = 1500
"""The connection ends when data stays unacknowledged this long: the other machine, or its cable, is gone."""
ALIVE_S = 0.25
NOTHING_MOVES = 1e-6
_encode = msgspec.json.Encoder().encode


class Served(Protocol):
    """The sources of a client's data."""

    api: Api
    pictures: Pictures
    session: str
    sources: Mapping[int, Source]
    services: Mapping[int, Service]

    @property
    def feeds(self) -> Feeds:
        """The streams, received once for all clients."""

    async def run_service(self, service: Service, line: str, viewer: "Viewer") -> object:
        """Run a service's line in the name of a client; raise Refused."""

    def shows(self, source: Source, client: Client, *, pictures: bool) -> bool:
        """Return whether a client may subscribe to a channel."""

    def report(self, kind: str, text: str) -> None:
        """Publish an event."""


class Viewer(viewing.Viewer):
    """A connected client. The capability's loop reads `gone`."""

    messages_hz, messages_at_once = 150.0, 300.0
    too_much = "too many messages"
    last_messages_s = 0.2  # they may contain a stop

    def __init__(self, served: Served, client: Client, name: str, rate_hz: float, *, pictures: bool) -> None:
        super().__init__(1.0 / rate_hz)
        self.client = client
        self.gone = False
        self._served = served
        self._pictures = pictures
        self._shown: Mapping[int, Source] = {}
        self._offered: Mapping[int, Service] = {}
        self._advertised: object = None
        self._subscribed: dict[int, int] = {}
        self._sent: dict[int, tuple[int, ...]] = {}
        self._event = 0
        self._watched: frozenset[str] = frozenset()
        self._publishes: dict[int, protocol.Published] = {}
        self._news: deque[str | bytes] = deque(maxlen=MOST_NEWS)
        self._news.append(protocol.server_info(name, served.session, publishes=client.may("operate")))
        self._alive_s = 0.0
        self._calls: set[asyncio.Task[None]] = set()
        self._stops: set[asyncio.Task[None]] = set()
        self._hand = Hand(source_of(client), served.api.may(client), self._report_hold, whose="Foxglove", resumes=True)
        self._has_hand = False
        self._push, self._silent_s, self._pushed_to = 0, 0.0, ""

    async def serve(self, socket: WebSocket, receive: Receive) -> None:
        """Serve until the client leaves, stalls or sends too much, or the server ends."""
        bound_silence(socket)
        await super().serve(socket, receive)

    def leave(self) -> None:
        """Release the hand, cancel all calls but stops, and leave all streams."""
        self.gone = True
        self._hand.release(for_good=True)
        for task in self._calls - self._stops:
            task.cancel()
        self._served.api.wake()
        self._served.feeds.leave(self)
        self._watch(frozenset())
        self._loop.call_later(KEPT_S + 0.1, self._served.feeds.tidy)

    def frames(self) -> Iterator[str | bytes]:
        """Yield the answers and news, and the newest messages."""
        self._advertise_changes()
        now = self._loop.time()
        if now - self._alive_s >= ALIVE_S:
            self._alive_s = now
            self._silent_s += ALIVE_S  # a loop that is held up reads no message, and that is no silence
            self._news.append(protocol.alive())
        while self._news:
            yield self._news.popleft()
        yield from self._messages()

    def _advertise_changes(self) -> None:
        """Advertise new channels and services, and withdraw removed ones."""
        served = self._served
        if self._advertised is served.sources:
            return
        self._advertised = served.sources
        visible = {
            number: source
            for number, source in served.sources.items()
            if served.shows(source, self.client, pictures=self._pictures)
        }
        offered = dict(served.services)
        hidden = [number for number, source in self._shown.items() if visible.get(number) != source]
        ended = [number for number, service in self._offered.items() if offered.get(number) != service]
        if hidden:
            self._news.append(protocol.unadvertise(hidden))
            self._subscribed = {
                subscription: number for subscription, number in self._subscribed.items() if number not in hidden
            }
        if ended:
            self._news.append(protocol.unadvertise_services(ended))
        if added := [source.channel for number, source in visible.items() if self._shown.get(number) != source]:
            self._news.append(protocol.advertise(added))
        if fresh := [(number, service) for number, service in offered.items() if self._offered.get(number) != service]:
            self._news.append(protocol.advertise_services(words.advertisement(*service) for service in fresh))
        self._shown, self._offered = visible, offered
        self._update_streams()

    def _update_streams(self) -> None:
        wanted = [self._shown[number] for number in self._subscribed.values()]
        self._served.feeds.want(self, {key for source in wanted if not source.picture for key in source.streams})
        self._watch(frozenset(key for source in wanted if source.picture for key in source.streams))

    def _watch(self, cameras: frozenset[str]) -> None:
        """Watch these cameras, and publish an event for each change."""
        for key in sorted(cameras ^ self._watched):
            more = "" if key in cameras else " no more"
            self._served.report("watched", f"{self.client} watches {key.partition('/')[0]}{more}, in Foxglove")
        self._watched = cameras
        self._served.pictures.want(self, cameras)

    def _messages(self) -> list[bytes]:
        """Return the newest unsent message of each subscription, and all unsent events."""
        now, wall_ns, made = self._served.api.now(), time.time_ns(), list[bytes]()
        events = self._served.feeds.events(self._event)
        for subscription, number in self._subscribed.items():
            source = self._shown[number]
            if source.streams == (channels.EVENT,):
                for event in events:
                    made += self._encoded(source, subscription, {channels.EVENT: event}, now, wall_ns)
                continue
            newest = self._served.pictures.newest if source.picture else self._served.feeds.newest
            samples = {key: sample for key in source.streams if (sample := newest(key)) is not None}
            state = tuple(samples[key].number if key in samples else 0 for key in source.streams)
            if (samples or source.still) and self._sent.get(subscription) != state:
                self._sent[subscription] = state
                made += self._encoded(source, subscription, samples, now, wall_ns)
        if events:
            self._event = events[-1].number
        return made

    def _encoded(
        self, source: Source, subscription: int, samples: Mapping[str, Sample], now: float, wall_ns: int
    ) -> list[bytes]:
        age_s = min((max(0.0, now - sample.sent_s) for sample in samples.values()), default=0.0)
        at_ns = max(0, wall_ns - int(age_s * 1e9))
        try:
            payload = channels.payload(source, {key: sample.text for key, sample in samples.items()}, at_ns)
        except (ValueError, ArithmeticError, *UNREADABLE) as err:
            text = f"{source.channel.topic} cannot be shown: {err}"
            self._news.append(protocol.status(protocol.WARNING, text[:300], source.channel.topic))
            return []
        return [protocol.message(subscription, at_ns, payload)]

    # Messages of the client.

    def receive(self, message: str | bytes) -> None:
        """Handle a message."""
        try:
            request = protocol.parse(message)
            if not self.gone or isinstance(request, protocol.ServiceCall):  # stops count even after the end
                self._handle(request)
        except MalformedError as err:
            self._hand.release()  # the message may have been a release
            self._served.api.wake()
            self._queue(protocol.status(protocol.ERROR, f"an unreadable message: {err}", "malformed"))

    def _handle(self, message: protocol.Message) -> None:
        match message:
            case protocol.Subscribe(subscriptions=wanted):
                self._subscribe(wanted)
            case protocol.Unsubscribe(subscription_ids=ids):
                for subscription in ids:
                    self._subscribed.pop(subscription, None)
                    self._sent.pop(subscription, None)
                self._update_streams()
            case protocol.Advertise(channels=advertised):
                self._advertise(advertised)
            case protocol.Unadvertise(channel_ids=ids):
                for channel in ids:
                    self._publishes.pop(channel, None)
                self._hand.release()
                self._served.api.wake()
            case protocol.MessageData():
                self._apply_data(message)
            case protocol.ServiceCall():
                self._call(message)
            case protocol.Unknown(op=op):
                self._queue(protocol.status(protocol.WARNING, f"'{op}' is not served here", "op"))

    def _subscribe(self, wanted: tuple[protocol.Subscription, ...]) -> None:
        for subscription in wanted:
            if subscription.channel_id not in self._shown:
                text = f"there is no channel {subscription.channel_id}"
                self._queue(protocol.status(protocol.WARNING, text, "channel"))
            elif subscription.id not in self._subscribed and len(self._subscribed) >= protocol.MOST_LISTED:
                self._queue(protocol.status(protocol.WARNING, "too many subscriptions", "channel"))
            else:
                self._subscribed[subscription.id] = subscription.channel_id
                self._sent.pop(subscription.id, None)
        if not self._event:
            self._event = self._served.feeds.last_event
        self._update_streams()
        self.wake()

    def _advertise(self, advertised: tuple[protocol.Published, ...]) -> None:
        for channel in advertised:
            if channel.encoding != "json":
                text = f"{channel.topic}: only JSON is understood here, and not '{channel.encoding}'"
                self._queue(protocol.status(protocol.ERROR, text, channel.topic))
            elif len(self._publishes) >= protocol.MOST_LISTED:
                self._queue(protocol.status(protocol.ERROR, "too many channels are advertised", "channel"))
            else:
                self._publishes[channel.id] = channel

    def _apply_data(self, data: protocol.MessageData) -> None:
        channel = self._publishes.get(data.channel_id)
        if channel is None:
            self._queue(protocol.status(protocol.WARNING, f"no channel {data.channel_id} was advertised", "channel"))
            return
        try:
            wanted = motion(channel, data.payload, self._served.api)
        except InputError as err:
            self._hand.release()
            self._served.api.wake()
            self._queue(protocol.status(protocol.ERROR, str(err), channel.topic))
            return
        if wanted is None:
            self._hand.release()
        else:
            self._hold(*wanted)
        self._served.api.wake()

    def _hold(self, to: str, message: dict[str, object]) -> None:
        if self._hand.wish.wanted is None or self._silent_s > RESTED_S or to != self._pushed_to:
            self._push += 1
        self._silent_s, self._pushed_to = 0.0, to
        self._hand.hold(Wanted(to=to, message=message, n=self._push), self._served.api.now())
        if not self._has_hand:
            self._has_hand = True
            self._served.api.holds.add(self._hand)

    def _call(self, call: protocol.ServiceCall) -> None:
        service = self._offered.get(call.service_id)
        stops = service is not None and service.word in {STOP, ESTOP}
        if self.gone and not stops:
            return
        if service is None:
            self._queue(protocol.failed(call, f"there is no service {call.service_id}"))
        elif not stops and call.encoding not in {"", "json"}:
            self._queue(protocol.failed(call, f"only JSON is understood here, and not '{call.encoding[:40]}'"))
        elif not stops and len(self._calls) >= MOST_CALLS:
            self._queue(protocol.failed(call, "too many services are asked for at once"))
        else:
            if stops:
                self._hand.release()
                self._served.api.wake()
            task = self._loop.create_task(self._answer(call, service))
            self._calls.add(task)
            task.add_done_callback(self._calls.discard)
            if stops:
                self._stops.add(task)
                task.add_done_callback(self._stops.discard)

    async def _answer(self, call: protocol.ServiceCall, service: Service) -> None:
        try:
            stops = service.word in {STOP, ESTOP}
            line = service.word if stops else service.line(words.read(call.payload))
            answer = await self._served.run_service(service, line, self)
        except (InputError, Refused) as err:
            self._queue(protocol.failed(call, str(err)))
            return
        self._queue(protocol.answered(call, _encode(answer)))

    def _queue(self, news: str | bytes) -> None:
        self._news.append(news)
        self.wake()

    def _report_hold(self, news: HoldNews) -> None:
        """Report why motion is not held; called from the capability's loop."""
        if news.holds or not news.reason:
            return
        held = f" (held by {news.holder})" if news.holder else ""
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(
                self._queue, protocol.status(protocol.WARNING, f"{news.reason}{held} [{news.code}]", "motion")
            )


def motion(channel: protocol.Published, payload: bytes, api: Api) -> tuple[str, dict[str, object]] | None:
    """Return the command and fields of a published message; None for a Twist that stands still.

    A Twist, as a Teleop panel publishes it, is for the base; a message on a command's own topic is for that command.
    """
    try:
        fields = decode_request(payload)
    except MalformedError as err:
        raise InputError(f"{channel.topic}: {err}", "malformed") from None
    if not isinstance(fields, dict):
        raise InputError(f"{channel.topic}: this is no JSON object", "malformed")
    known, topic = api.known, channel.topic.lstrip("/")
    if known is not None and topic in known.commands:
        if not known.commands[topic].leased:
            raise InputError(f"'{topic}' is not held: ask for it by a service", "not_possible")
        return topic, {name: value for name, value in fields.items() if name not in {"lease", "ttl_s"}}
    if "Twist" not in channel.schema_name and topic != "cmd_vel":
        raise InputError(
            f"nothing on this robot listens to '{topic}': publish a Twist, or on a command's topic", "unknown_name"
        )
    base = known.robot.base if known is not None else None
    if base is None:
        raise InputError("this robot has no base that takes a twist", "not_possible")
    fields = fields.get("twist", fields)
    vx, vy, wz = _part(fields, "linear", "x"), _part(fields, "linear", "y"), _part(fields, "angular", "z")
    if not max(abs(vx), abs(vy), abs(wz)) > NOTHING_MOVES:  # this way round, NaN stands still
        return None
    return f"{base.capability}/twist", {"vx_mps": vx, "vy_mps": vy if base.sideways else 0.0, "wz_rps": wz}


def _part(said: object, vector: str, axis: str) -> float:
    found = said.get(vector, {}) if isinstance(said, dict) else None
    value = found.get(axis, 0.0) if isinstance(found, dict) else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{vector}.{axis} of a Twist is to be a number", "bad_value")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{vector}.{axis} of a Twist is too large", "bad_value") from None


def bound_silence(web: WebSocket) -> None:
    """Let the kernel end a connection without acknowledgements from its other end."""
    connection = connection_of(web.scope)
    sock = connection.transport.get_extra_info("socket") if connection is not None else None
    if sock is not None:
        with suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, LOST_MS)
