"""The connection to ROS: Zenoh sessions, opened and closed by a thread of its own.

    loop                                        thread
      publish, reply ─────────────────────────►   session to rmw_zenohd, or the router for ROS itself
      tokens, samples, requests ◄── inboxes ◄──   received there

A session ends with its router. A new router does not know the declarations of old sessions, so a new session declares
all of them again.
"""

import json
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import NamedTuple

import zenoh
from msgspec import Struct

from lbr.apps.retry import wait_s
from lbr.apps.ros2.kind import address
from lbr.apps.ros2.wire import ADMIN, CDR, Attachment, Endpoint, Node, Port
from lbr.bus.session import LINK_LEASE_MS
from lbr.bus.wire import direct, drained, plain
from lbr.errors import BusError

STEADY_S, LONGEST_WAIT_S = 20.0, 5.0
CONNECT_S = 1.0
MOST_TOKENS, MOST_SAMPLES, MOST_REQUESTS = 4096, 64, 16
HEARTBEAT_S = 0.5
LARGEST_MESSAGE_BYTES = 1 << 20


class Router(Struct, frozen=True, kw_only=True):
    """The router of ROS, to connect to or to be at `listen`, and the robot's name there."""

    connect: str
    listen: str
    domain: int
    namespace: str
    name: str

    @property
    def endpoint(self) -> str:
        """Return the address."""
        return self.listen or self.connect


class Token(NamedTuple):
    """An entity of ROS that appeared or disappeared."""

    present: bool
    text: str


class Sample(NamedTuple):
    """A message, and its arrival by the monotonic and by the wall clock."""

    key: str
    payload: bytes
    attachment: bytes
    arrived_s: float
    wall_ns: int


class Request(NamedTuple):
    """A call of a service, to be answered once."""

    service: str
    query: zenoh.Query


class Outlet:
    """A publisher with its number and gid; only the loop sends."""

    def __init__(self, publisher: zenoh.Publisher | zenoh.ext.AdvancedPublisher, gid: bytes) -> None:
        self._publisher = publisher
        self._gid = gid
        self._sequence = 0

    def put(self, payload: bytes) -> None:
        """Send a message."""
        self._sequence += 1
        attachment = bytes(Attachment(self._sequence, time.time_ns(), self._gid))
        with suppress(zenoh.ZError):  # the session is being closed
            self._publisher.put(payload, encoding=zenoh.Encoding(CDR), attachment=attachment)


class Link:
    """The connections to ROS: `connected` and `trouble` are the present state, `count` is their number."""

    def __init__(
        self,
        router: Router,
        ports: Mapping[str, Port],
        wake: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.connected = False
        self.trouble = "it was not reached yet"
        self.count = 0
        self.router = router
        self._ports, self._wake, self._clock = ports, wake, clock
        self._tokens: deque[Token] = deque(maxlen=MOST_TOKENS)
        self._samples: deque[Sample] = deque(maxlen=MOST_SAMPLES)
        self._requests: deque[Request] = deque(maxlen=MOST_REQUESTS)
        self._zid = ""
        self._outlets: Mapping[str, Outlet] = {}
        self._lost, self._ends = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="ros2", daemon=True)

    def start(self) -> None:
        """Connect, and reconnect, until `close`."""
        self._thread.start()

    def tokens(self) -> list[Token]:
        """Return the tokens since the last call."""
        return drained(self._tokens)

    def samples(self) -> list[Sample]:
        """Return the messages since the last call; of too many the newest."""
        return drained(self._samples)

    def requests(self) -> list[Request]:
        """Return the calls of services since the last call."""
        return drained(self._requests)

    def publish(self, port: str, payload: bytes) -> None:
        """Send a message, if there is a connection."""
        if (outlet := self._outlets.get(port)) is not None:
            outlet.put(payload)

    def reply(self, request: Request, payload: bytes) -> None:
        """Answer a call."""
        query = request.query
        attachment = query.attachment.to_bytes() if query.attachment is not None else b""
        with suppress(zenoh.ZError):
            query.reply(query.key_expr, payload, encoding=zenoh.Encoding(CDR), attachment=attachment)
            query.drop()

    def close(self, within_s: float = 0.5) -> None:
        """Disconnect, within `within_s` even if the router does not answer."""
        self._ends.set()
        self._lost.set()
        if self._thread.is_alive():
            self._thread.join(within_s)

    # On the thread.

    def _run(self) -> None:
        tries = 0
        while not self._ends.is_set():
            began = time.monotonic()
            try:
                self._connection()
            except (BusError, OSError) as err:
                self.trouble = str(err)
            except zenoh.ZError as err:
                self.trouble = plain(err)
            self._leave()
            tries = 0 if time.monotonic() - began > STEADY_S else tries + 1
            self._ends.wait(min(LONGEST_WAIT_S, wait_s(tries)))

    def _connection(self) -> None:
        """Connect and stay until the router is gone; raise the reason of a failure."""
        self._lost.clear()
        if not self.router.listen:
            _knock(self.router.connect)
        session = zenoh.open(zenoh.Config.from_json5(json.dumps(_settings(self.router))))
        try:
            declared = self._declare(session)  # a declaration ends with its last reference
            self._lost.wait()
            declared.clear()
            self.trouble = "its router is gone"
        finally:
            self._leave()
            session.close()

    def _leave(self) -> None:
        self.connected, self._outlets = False, {}
        self._wake()

    def _declare(self, session: zenoh.Session) -> list[object]:
        """Declare all the robot's entities in ROS, and subscribe to those of others; return the declarations."""
        self._tokens.clear()
        self._samples.clear()
        self._zid = str(session.zid())
        router = self.router
        node = Node(domain=router.domain, zid=self._zid, id="0", namespace=router.namespace, name=router.name)
        held: list[object] = [session.liveliness().declare_token(str(node))]
        outlets = {}
        for number, (name, port) in enumerate(self._ports.items(), 1):
            endpoint = Endpoint(
                node=node,
                id=str(number),
                kind=port.kind,
                topic=port.topic,
                type=port.type,
                hash=port.hash,
                qos=str(port.qos),
            )
            declared = self._declared(session, name, port, endpoint)
            if isinstance(declared, zenoh.Publisher | zenoh.ext.AdvancedPublisher):
                outlets[name] = Outlet(declared, endpoint.gid)
            held += [declared, session.liveliness().declare_token(str(endpoint))]
        tokens = f"{ADMIN}/{router.domain}/**"
        held.append(session.liveliness().declare_subscriber(tokens, direct(self._receive_token), history=True))
        if not router.listen:
            held.append(session.info.declare_transport_events_listener(direct(self._receive_link), history=False))
            if not list(session.info.routers_zid()):
                raise BusError("its router is gone")
        self._outlets = outlets
        self.count += 1
        self.connected, self.trouble = True, ""
        self._wake()
        return held

    def _declared(self, session: zenoh.Session, name: str, port: Port, endpoint: Endpoint) -> object:
        if port.kind == "MS":
            return session.declare_subscriber(port.keys or endpoint.key, direct(self._receive_sample))
        if port.kind == "SS":
            receive = direct(lambda query: self._receive_request(name, query))
            return session.declare_queryable(endpoint.key, receive, complete=True)
        drop = zenoh.CongestionControl.DROP
        if not port.qos.transient_local:
            return session.declare_publisher(endpoint.key, congestion_control=drop)
        return zenoh.ext.declare_advanced_publisher(
            session,
            endpoint.key,
            congestion_control=drop,
            cache=zenoh.ext.CacheConfig(max_samples=port.qos.depth),
            publisher_detection=True,
            sample_miss_detection=zenoh.ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=HEARTBEAT_S),
        )

    # On threads of Zenoh.

    def _receive_token(self, sample: zenoh.Sample) -> None:
        text = str(sample.key_expr)
        if f"/{self._zid}/" not in text:
            self._tokens.append(Token(sample.kind == zenoh.SampleKind.PUT, text))
            self._wake()

    def _receive_sample(self, sample: zenoh.Sample) -> None:
        attachment = sample.attachment.to_bytes() if sample.attachment is not None else b""
        key, payload = str(sample.key_expr), sample.payload.to_bytes()
        self._samples.append(Sample(key, payload, attachment, self._clock(), time.time_ns()))
        self._wake()

    def _receive_request(self, service: str, query: zenoh.Query) -> None:
        self._requests.append(Request(service, query))
        self._wake()

    def _receive_link(self, event: zenoh.TransportEvent) -> None:
        if event.kind == zenoh.SampleKind.DELETE:
            self.connected = False
            self._lost.set()
            self._wake()


def _knock(endpoint: str) -> None:
    """Raise BusError if nothing listens there, as opening a session costs much more."""
    try:
        socket.create_connection(address(endpoint), CONNECT_S).close()
    except OSError as err:
        raise BusError(f"nothing answers there ({err.strerror or err})") from err


def _settings(router: Router) -> dict[str, object]:
    """Return the configuration of a session, equal to that of rmw_zenoh where the two must agree."""
    common: dict[str, object] = {
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": bool(router.listen)}, "delay": 0},
        "transport": {
            "link": {
                "tx": {"lease": LINK_LEASE_MS, "keep_alive": 4},
                "rx": {"max_message_size": LARGEST_MESSAGE_BYTES},
            },
            "shared_memory": {"enabled": False},
        },
        "timestamping": {"enabled": True},  # publishers need it to keep their last message
        "adminspace": {"enabled": False},
    }
    if router.listen:
        return common | {"mode": "router", "listen": {"endpoints": [router.listen], "exit_on_failure": True}}
    connect = {"endpoints": [router.connect], "timeout_ms": int(CONNECT_S * 1000), "exit_on_failure": True}
    return common | {"mode": "client", "connect": connect}
