"""Publishing, receiving, answering and asking: a thin layer, so that Zenoh's threads only write to a slot."""

import contextlib
import functools
import os
import re
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

import msgspec
import zenoh

from lbr.bus import keys
from lbr.bus import stamp as stamps
from lbr.bus.access import Credentials
from lbr.bus.inflow import Inflow
from lbr.errors import BusError
from lbr.messages.camera import JpegFrame
from lbr.messages.leases import CommandReply

JSON = zenoh.Encoding.APPLICATION_JSON
JPEG = zenoh.Encoding.IMAGE_JPEG
MAX_COMMAND_BYTES = 64 * 1024
MAX_WAITING_COMMANDS = 64
T = TypeVar("T")
encode = msgspec.json.Encoder().encode


class RawMessage(msgspec.Struct, frozen=True, gc=False):
    """A message as it arrived: its bytes, its attachment and its key."""

    key: str
    payload: bytes
    attachment: bytes
    arrived: float


def raw(sample: zenoh.Sample) -> RawMessage:
    """Copy a sample's bytes out of Zenoh."""
    attachment = sample.attachment
    taken = attachment.to_bytes() if attachment is not None else b""
    return RawMessage(str(sample.key_expr), sample.payload.to_bytes(), taken, time.monotonic())


def drained(slots: deque[T]) -> list[T]:
    """Remove all waiting items, oldest first, while another thread may append to them."""
    taken = []
    while slots:
        taken.append(slots.popleft())
    return taken


def plain(err: Exception) -> str:
    """Return an error's text without the place in the library's source."""
    return re.sub(r" at /\S+", "", str(err)).rstrip(". !")


def canonical(key: str) -> str:
    """Return a key expression in the library's form; raise BusError if it is invalid."""
    try:
        return str(zenoh.KeyExpr.autocanonize(key))
    except zenoh.ZError as err:
        raise BusError(plain(err)) from err


@contextlib.contextmanager
def _named(key: str) -> Iterator[None]:
    """Raise the library's error as a BusError that names the key."""
    try:
        yield
    except zenoh.ZError as err:
        raise BusError(f"{key}: {plain(err)}") from err


def _leave(err: BaseException) -> None:
    traceback.print_exception(err)
    os._exit(70)


on_callback_error: Callable[[BaseException], None] = _leave
"""The reaction to an exception on one of Zenoh's threads, where nobody would see it; by default the process ends."""


def direct(handle: Callable[[Any], None]) -> "zenoh.handlers.Callback[Any]":  # only the stub is generic
    """Run `handle` on Zenoh's own thread; it must only store and signal."""

    def guarded(item: object) -> None:
        try:
            handle(item)
        except BaseException as err:  # noqa: BLE001 - this thread's outermost frame
            on_callback_error(err)

    return zenoh.handlers.Callback(guarded, indirect=False)


class Publisher:
    """One stream: publishes stamped messages, and answers a `get` with its latest value. One thread publishes.

    It carries JSON, or, with `pictures`, the bytes of JPEG files. `renew` updates the latest value for the answer to a
    `get`, if part of it changes with time. It runs on Zenoh's thread, and must be quick and thread-safe. `watching` is
    called on Zenoh's thread whenever the first subscriber comes or the last one goes; see `watched`.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        source: str,
        *,
        seal: bytes = b"",
        pictures: bool = False,
        renew: Callable[[Any], Any] | None = None,
        watching: Callable[[], None] | None = None,
    ) -> None:
        self.key = key
        self.count = 0
        self.watched = True
        """True while there is a subscriber; without `watching`, always."""
        self._encoding = JPEG if pictures else JSON
        self._source = source
        self._seal = seal
        self._renew = renew
        self._last: tuple[Any, bytes, bytes] | None = None
        with _named(key):
            self._publisher = session.declare_publisher(
                key,
                encoding=self._encoding,
                congestion_control=zenoh.CongestionControl.DROP,
                priority=zenoh.Priority.DATA_LOW if pictures else zenoh.Priority.DATA,
            )
        self._latest = session.declare_queryable(key, direct(self._answer), complete=True)
        if watching is not None:
            self._watch(watching)

    def put(self, message: Any, *, taken_s: float | None = None, payload: bytes | None = None) -> bytes:
        """Publish, and return the stamp. Without a bus the message is lost silently, so motion never relies on it
        alone.

        `taken_s` is when a picture was taken, by the monotonic clock; it becomes the time of the stamp. `payload` is
        the message as bytes, if they are known.
        """
        if payload is None:
            payload = message.data if isinstance(message, JpegFrame) else encode(message)
        self.count += 1
        attachment = stamps.make(self._source, self.count, payload, self._seal, sent_s=taken_s)
        self._last = (message if self._renew is not None else None, payload, attachment)
        self._publisher.put(payload, attachment=attachment)
        return attachment

    def forget(self) -> None:
        """Stop answering `get` with the last message, until there is a new one."""
        self._last = None

    def close(self) -> None:
        """Stop publishing and answering; raise RuntimeError while another thread uses the publisher."""
        self._publisher.undeclare()
        self._latest.undeclare()

    def _watch(self, watching: Callable[[], None]) -> None:
        def look(_status: object = None) -> None:
            with contextlib.suppress(zenoh.ZError, RuntimeError):  # another thread is undeclaring it
                self.watched = bool(self._publisher.matching_status.matching)  # type: ignore[attr-defined]
            watching()

        self._watcher = self._publisher.declare_matching_listener(direct(look))
        look()

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            last = self._last  # another thread may set it or forget it
            if last is not None:
                message, payload, attachment = last
                if self._renew is not None:
                    payload = encode(self._renew(message))
                    attachment = stamps.make(self._source, self.count, payload, self._seal)
                query.reply(self.key, payload, encoding=self._encoding, attachment=attachment)


class Subscription:
    """The newest `depth` messages of a key expression, written by Zenoh's thread and read by ours."""

    def __init__(
        self, session: zenoh.Session, key: str, *, depth: int = 1, wake: Callable[[], None] = lambda: None
    ) -> None:
        self._slots: deque[RawMessage] = deque(maxlen=depth)
        self._wake = wake
        with _named(key):
            self._subscriber = session.declare_subscriber(key, direct(self._store))

    def take(self) -> list[RawMessage]:
        """Return the messages since the last call, oldest first."""
        return drained(self._slots)

    def close(self) -> None:
        """Stop receiving."""
        self._subscriber.undeclare()

    def _store(self, sample: zenoh.Sample) -> None:
        self._slots.append(raw(sample))
        self._wake()


class PolledSubscription:
    """The newest `depth` messages of a key expression, kept by Zenoh until we look: no Python runs when one arrives.

    It costs half as much as a Subscription. The arrival of a message is the time of `take`.
    """

    def __init__(self, session: zenoh.Session, key: str, *, depth: int = 1) -> None:
        self._key = key if "*" not in key else ""
        self._subscriber = session.declare_subscriber(key, zenoh.handlers.RingChannel(depth))

    def take(self) -> list[RawMessage]:
        """Return the messages since the last call, oldest first."""
        messages: list[RawMessage] = []
        now = time.monotonic()
        while (sample := self._received()) is not None:
            attachment = sample.attachment
            stamp = attachment.to_bytes() if attachment is not None else b""
            messages.append(RawMessage(self._key or str(sample.key_expr), sample.payload.to_bytes(), stamp, now))
        return messages

    def close(self) -> None:
        """Stop receiving."""
        with contextlib.suppress(zenoh.ZError):  # its session is closed
            self._subscriber.undeclare()

    def _received(self) -> zenoh.Sample | None:
        with contextlib.suppress(zenoh.ZError):  # its session is closed
            return self._subscriber.try_recv()
        return None


class Request:
    """A query, or a `put` on a command key, that waits for an answer."""

    def __init__(self, key: str, payload: bytes, attachment: bytes, query: zenoh.Query | None) -> None:
        self.key = key
        self.payload = payload
        self.attachment = attachment
        self.arrived = time.monotonic()
        self._query = query

    @property
    def answerable(self) -> bool:
        """Return whether the sender waits for an answer; after a `put` it does not."""
        return self._query is not None

    def reply(self, message: Any, source: str) -> None:
        """Answer, once; later answers are ignored."""
        self.forward_reply(encode(message), stamps.make(source, 0))

    def forward_reply(self, payload: bytes, attachment: bytes) -> None:
        """Pass on another's answer as bytes, once."""
        query, self._query = self._query, None
        if query is None:
            return
        with query:
            query.reply(self.key, payload, encoding=JSON, attachment=attachment)


class CommandQueue:
    """The commands of one key: a bounded queue.

    Messages that quote the lease `first` have a queue of their own and are served before all others. An `inflow` limits
    the rate of every other sender.
    """

    def __init__(self, key: str, wake: Callable[[], None], source: str, inflow: Inflow | None) -> None:
        self.key = key
        self.dropped = 0
        self.first = b""
        self._source = source
        self._wake = wake
        self._inflow = inflow
        self._waiting: deque[Request] = deque()
        self._waiting_first: deque[Request] = deque()

    def take(self) -> list[Request]:
        """Remove and return the waiting requests, oldest first, with those of the lease `first` before them."""
        return drained(self._waiting_first) + drained(self._waiting)

    def queue(self, request: Request) -> None:
        """Queue a request, or refuse it if the queue is full."""
        first = self.first
        quotes = bool(first) and first in request.payload
        waiting = self._waiting_first if quotes else self._waiting
        if len(waiting) >= MAX_WAITING_COMMANDS or not (quotes or self._admits(request)):
            self.dropped += 1
            reason = f"too many commands at once on {self.key}"
            request.reply(CommandReply(accepted=False, code="busy", reason=reason), self._source)
            return
        waiting.append(request)
        self._wake()

    def _admits(self, request: Request) -> bool:
        if self._inflow is None:
            return True
        found = stamps.read(request.attachment)
        return self._inflow.admits(found.source if found is not None else "", request.arrived)


class QueryServer(CommandQueue):
    """The queries and puts of a command key, from Zenoh's threads."""

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        wake: Callable[[], None],
        *,
        puts: bool = True,
        source: str = "",
        inflow: Inflow | None = None,
    ) -> None:
        super().__init__(key, wake, source, inflow)
        self._queryable = session.declare_queryable(key, direct(self._asked), complete=True)
        self._subscriber = session.declare_subscriber(key, direct(self._put)) if puts else None

    def close(self) -> None:
        """Stop answering."""
        self._queryable.undeclare()
        if self._subscriber is not None:
            self._subscriber.undeclare()

    def _asked(self, query: zenoh.Query) -> None:
        if str(query.key_expr) != self.key:
            return  # a query with a wildcard only looks around; a command has one target
        payload, attachment = query.payload, query.attachment
        self.queue(
            Request(
                self.key,
                payload.to_bytes() if payload is not None else b"",
                attachment.to_bytes() if attachment is not None else b"",
                query,
            )
        )

    def _put(self, sample: zenoh.Sample) -> None:
        message = raw(sample)
        self.queue(Request(self.key, message.payload, message.attachment, None))


class PendingQuery:
    """A query under way; its answers arrive on Zenoh's thread.

    `attachment` passes on a stamp instead of our own. `proof` is our token at a robot's door: it identifies the sender
    there. `waited_s` is how long the query waited here, `origin` its original sender.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        payload: bytes,
        *,
        timeout_s: float,
        source: str,
        attachment: bytes = b"",
        proof: Credentials | None = None,
        waited_s: float = 0.0,
        origin: stamps.Origin | None = None,
        sent_s: float | None = None,
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        user, secret = (proof.user, proof.password.encode()) if proof is not None else ("", b"")
        self.key = key
        self.replies: list[RawMessage] = []
        self.done = False
        self._wake = wake
        with _named(key):
            session.get(
                key,
                zenoh.handlers.Callback(self._reply, self._finished, indirect=False),
                payload=payload,
                encoding=JSON,
                attachment=attachment
                or stamps.make(source, 0, payload, secret, token=user, sent_s=sent_s, waited_s=waited_s, origin=origin),
                timeout=timeout_s,
                congestion_control=zenoh.CongestionControl.BLOCK,
                priority=zenoh.Priority.REAL_TIME,
                express=True,
            )

    def _reply(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self.replies.append(raw(reply.ok))
            self._wake()

    def _finished(self) -> None:
        self.done = True
        self._wake()


def ask(
    session: zenoh.Session,
    key: str,
    message: Any,
    *,
    source: str,
    timeout_s: float = 2.0,
    sent_s: float | None = None,
    attachment: bytes = b"",
    waited_s: float = 0.0,
    origin: stamps.Origin | None = None,
) -> list[RawMessage]:
    """Query a key and wait for all answers; an empty list means that no answer came in time.

    `sent_s` is when a passed-on request was first sent, so that it keeps its age. `waited_s` is how long it had waited
    by then, `origin` its original sender. `attachment` passes on the stamp itself.
    """
    payload = encode(message) if message is not None else b""
    stamp = attachment or stamps.make(source, 0, payload, sent_s=sent_s, waited_s=waited_s, origin=origin)
    with _named(key):
        replies = session.get(
            key,
            payload=payload,
            encoding=JSON,
            attachment=stamp,
            timeout=timeout_s,
            consolidation=zenoh.ConsolidationMode.NONE,
        )
        return [raw(reply.ok) for reply in replies if reply.ok is not None]


def ask_all(
    session: zenoh.Session,
    keys: Iterable[str],
    payload: bytes = b"",
    *,
    source: str,
    timeout_s: float,
    attachment: bytes = b"",
) -> list[RawMessage]:
    """Query several keys at once and return all answers that arrive in time; `attachment` replaces our own stamp."""
    woken = threading.Event()
    questions = [
        PendingQuery(session, key, payload, timeout_s=timeout_s, source=source, attachment=attachment, wake=woken.set)
        for key in dict.fromkeys(keys)
    ]
    end = time.monotonic() + timeout_s
    while not all(question.done for question in questions) and time.monotonic() < end:
        woken.wait(max(0.0, end - time.monotonic()))
        woken.clear()
    return [answer for question in questions for answer in list(question.replies)]


def put(
    session: zenoh.Session, key: str, message: Any, *, source: str, urgent: bool = False, to_others: bool = False
) -> None:
    """Publish once; raise BusError if it was not sent.

    `urgent` overtakes streams. `to_others` skips this session's own subscriptions, which would be called at once.
    """
    with _named(key):
        session.put(
            key,
            encode(message),
            encoding=JSON,
            attachment=stamps.make(source, 0),
            allowed_destination=zenoh.Locality.REMOTE if to_others else zenoh.Locality.ANY,
            priority=zenoh.Priority.REAL_TIME if urgent else zenoh.Priority.DATA,
            congestion_control=zenoh.CongestionControl.BLOCK if urgent else zenoh.CongestionControl.DROP,
            express=urgent,
        )


def forward(session: zenoh.Session, key: str, payload: bytes, attachment: bytes) -> None:
    """Publish another's message as bytes, at once; it is lost rather than late."""
    session.put(
        key,
        payload,
        encoding=JSON,
        attachment=attachment,
        priority=zenoh.Priority.REAL_TIME,
        congestion_control=zenoh.CongestionControl.DROP,
        express=True,
    )


def alive(session: zenoh.Session, robot: str, name: str) -> zenoh.LivelinessToken:
    """Show that a capability is present, until its session ends."""
    return session.liveliness().declare_token(keys.alive(robot, name))


class Presence:
    """The liveliness tokens of a robot; the death of a process is known within milliseconds."""

    def __init__(
        self, session: zenoh.Session, robot: str, changed: Callable[[str, bool], None] = lambda _name, _alive: None
    ) -> None:
        self.names: set[str] = set()
        self._changed = changed
        self._subscriber = session.liveliness().declare_subscriber(
            f"{robot}/@alive/*", direct(self._note), history=True
        )

    def close(self) -> None:
        """Stop watching."""
        self._subscriber.undeclare()

    def _note(self, sample: zenoh.Sample) -> None:
        name = str(sample.key_expr).rpartition("/")[2]
        alive = sample.kind == zenoh.SampleKind.PUT
        (self.names.add if alive else self.names.discard)(name)
        self._changed(name, alive)


class ComputedReply:
    """A key whose every query `make` answers at that moment; `make` must be quick and thread-safe."""

    def __init__(self, session: zenoh.Session, key: str, make: Callable[[], Any]) -> None:
        self._key = key
        self._make = make
        self._queryable = session.declare_queryable(key, direct(self._answer), complete=True)

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            query.reply(self._key, encode(self._make()), encoding=JSON)


class StaticReply(ComputedReply):
    """A key whose every query gets the same document, which is made for the first one."""

    def __init__(self, session: zenoh.Session, key: str, make: Callable[[], object]) -> None:
        super().__init__(session, key, functools.cache(lambda: msgspec.Raw(encode(make()))))

    def close(self) -> None:
        """Stop answering."""
        self._queryable.undeclare()
