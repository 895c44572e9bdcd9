"""The connection to the broker, in a thread of its own, which reconnects for ever; no error ends it.

    loop                                    thread
      publish ──► outbox ────────────────►  broker
      take    ◄── inbox  ◄────────────────  messages of the subscribed topics

Messages for an absent broker are dropped: each connection starts with the state, and requests from in between are old.
"""

import ssl
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from msgspec import Struct
from paho.mqtt import client as mqtt
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode
from paho.mqtt.subscribeoptions import SubscribeOptions

from lbr import home
from lbr.apps.mqtt.documents import LARGEST_BYTES
from lbr.apps.mqtt.inbox import Inbox
from lbr.apps.retry import wait_s
from lbr.capability.border import border
from lbr.errors import InputError

STEADY_S = 20.0
"""After a connection of this length the next try comes soon again."""
CONNECT_S = 5.0
LOOK_S = 0.1
LARGEST_PACKET = LARGEST_BYTES + 1024
MOST_WAITING = 64
"""The most messages in either queue. When one is full the oldest is dropped, but stops last."""
MOST_UNACKNOWLEDGED = 100
NEWEST_PROTOCOL = mqtt.MQTTv5
LATER = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)


class Incoming(NamedTuple):
    """A message; `retained` by the broker for an unknown time."""

    topic: str
    payload: bytes
    retained: bool


class Outgoing(NamedTuple):
    """A message; one that is not `sure` is sent once, and may be lost."""

    topic: str
    payload: bytes
    retain: bool = False
    sure: bool = True


class Broker(Struct, frozen=True, kw_only=True):
    """The broker's address and the robot's credentials; the broker publishes `will` once the robot is gone."""

    host: str
    port: int
    client_id: str
    keepalive_s: int
    tls: ssl.SSLContext | None = None
    user: str = ""
    password: str = ""
    will: Outgoing | None = None
    topics: tuple[str, ...] = ()


def secured(ca: str, certificate: str, key: str) -> ssl.SSLContext:
    """Return the TLS context of files in `credentials/`; raise InputError for a missing, readable or wrong one."""
    paths = {name: _credential(name) for name in (ca, certificate, key) if name}
    try:
        context = ssl.create_default_context(cafile=paths.get(ca))
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        if ca:  # an authority made by OpenSSL's usual command lacks the key usage that Python 3.13 requires
            context.verify_flags &= ~ssl.VERIFY_X509_STRICT
        if certificate:
            context.load_cert_chain(paths[certificate], paths[key], password="")  # else OpenSSL prompts for one
    except (ssl.SSLError, OSError, ValueError) as err:
        raise InputError(
            f"{', '.join(map(str, paths.values()))}: TLS cannot be spoken with these files ({err})"
        ) from err
    return context


def secret(name: str) -> str:
    """Return the first line of a file in `credentials/`."""
    try:
        lines = _credential(name).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as err:
        raise InputError(f"credentials/{name} cannot be read ({err})") from err
    return lines[0].strip() if lines else ""


def _credential(name: str) -> Path:
    if found := home.given_credentials(name):
        return found[0]
    raise InputError(f"{home.directory('credentials') / name} is not there: put the file that the row names there")


class Session:
    """The connections to a broker: `connected` and `trouble` are the present state, and `count` is their number."""

    def __init__(
        self,
        broker: Broker,
        wake: Callable[[], None],
        is_stop: Callable[[Incoming], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.connected = False
        self.trouble = "it was not reached yet"
        self.count = 0
        self._broker = broker
        self._wake = wake
        self._clock = clock
        self._inbox: Inbox[Incoming] = Inbox(MOST_WAITING, is_stop)
        self._outbox: deque[Outgoing] = deque(maxlen=MOST_WAITING)
        self._last: tuple[Outgoing, ...] = ()
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mqtt", daemon=True)

    def start(self) -> None:
        """Connect, and reconnect, until `close`."""
        self._thread.start()

    def publish(self, message: Outgoing) -> None:
        """Send a message, if the broker is connected."""
        if self.connected:
            self._outbox.append(message)

    def take(self) -> list[Incoming]:
        """Return the messages since the last call."""
        return self._inbox.take()

    def close(self, last: Iterable[Outgoing] = (), within_s: float = 0.3) -> None:
        """Send the last messages and disconnect; do not wait longer for a broker that does not answer."""
        self._last = tuple(last)
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join(within_s)

    def _run(self) -> None:
        tries = 0
        while not self._ends.is_set():
            began = self._clock()
            with border(self._lose):
                self._connection()
            self.connected = False
            self._wake()
            tries = 0 if self._clock() - began > STEADY_S else tries + 1
            self._ends.wait(wait_s(tries))

    def _lose(self, err: Exception) -> None:
        self.trouble = _reason(err)

    def _connection(self) -> None:
        """Connect and serve until the connection is lost; raise the reason."""
        client = self._client()
        try:
            client.connect(
                self._broker.host,
                self._broker.port,
                keepalive=self._broker.keepalive_s,
                clean_start=True,
                properties=_limits(),
            )
            until = self._clock() + CONNECT_S
            while not self._ends.is_set():
                self._look(client, client.loop(LOOK_S))
                if self.connected:
                    self._send(client)
                elif self._clock() > until:
                    raise ConnectionError("it does not answer")
            self._leave(client)
        finally:
            client.on_disconnect = None
            client.disconnect()  # the client closes its sockets when it is deleted

    def _client(self) -> mqtt.Client:
        broker = self._broker
        client = mqtt.Client(
            mqtt.CallbackAPIVersion.VERSION2,
            client_id=broker.client_id,
            protocol=NEWEST_PROTOCOL,
            reconnect_on_failure=False,
        )
        client.connect_timeout = CONNECT_S
        client.max_queued_messages_set(MOST_UNACKNOWLEDGED)
        if broker.tls is not None:
            client.tls_set_context(broker.tls)
        if broker.user:
            client.username_pw_set(broker.user, broker.password or None)
        if broker.will is not None:
            client.will_set(broker.will.topic, broker.will.payload, qos=1, retain=broker.will.retain)
        client.on_connect = self._on_connect
        client.on_subscribe = self._on_subscribe
        client.on_message = self._on_message
        client.on_disconnect = self._on_disconnect
        return client

    def _look(self, client: mqtt.Client, code: int) -> None:
        """Raise ConnectionError if the connection is lost, or the broker breaks the limits."""
        size = int(getattr(client, "_in_packet", {}).get("remaining_length", 0))  # known from its head
        if size > LARGEST_PACKET:
            raise ConnectionError(f"it sent {size} bytes at once, and {LARGEST_PACKET} are the most")
        if code != mqtt.MQTT_ERR_SUCCESS:
            raise ConnectionError(self.trouble or mqtt.error_string(code).rstrip("."))

    def _send(self, client: mqtt.Client) -> None:
        with suppress(IndexError):
            while True:
                message = self._outbox.popleft()
                sent = client.publish(message.topic, message.payload, qos=int(message.sure), retain=message.retain)
                if sent.rc == mqtt.MQTT_ERR_QUEUE_SIZE:
                    raise ConnectionError("it acknowledges nothing")

    def _leave(self, client: mqtt.Client) -> None:
        """Send the last messages, and wait briefly for their acknowledgement."""
        if not self.connected:
            return
        self._send(client)
        sent = [client.publish(message.topic, message.payload, qos=1, retain=message.retain) for message in self._last]
        until = self._clock() + 0.2
        while not all(message.is_published() for message in sent) and self._clock() < until:
            if client.loop(0.02) != mqtt.MQTT_ERR_SUCCESS:
                return

    def _on_connect(
        self, client: mqtt.Client, _data: object, _flags: object, code: ReasonCode, _properties: object
    ) -> None:
        if code.is_failure:
            self.trouble = f"it lets us not in ({code})"
            return
        self._inbox.clear()
        self._outbox.clear()
        if self._broker.topics:
            client.subscribe([(topic, LATER) for topic in self._broker.topics])
        else:
            self._begin()

    def _on_subscribe(
        self, _client: mqtt.Client, _data: object, _mid: int, codes: list[ReasonCode], _properties: object
    ) -> None:
        refused = [topic for topic, code in zip(self._broker.topics, codes, strict=False) if code.is_failure]
        if refused:
            raise PermissionError(f"it refuses the subscription of {', '.join(refused)}")
        self._begin()

    def _begin(self) -> None:
        self.connected, self.trouble = True, ""
        self.count += 1
        self._wake()

    def _on_message(self, _client: mqtt.Client, _data: object, message: mqtt.MQTTMessage) -> None:
        self._inbox.put(Incoming(message.topic, message.payload, message.retain))
        self._wake()

    def _on_disconnect(
        self, _client: mqtt.Client, _data: object, _flags: object, code: ReasonCode, _properties: object
    ) -> None:
        if code.is_failure:
            self.trouble = self.trouble or f"the connection was lost ({code})"


def _limits() -> Properties:
    """Return the limits for the broker."""
    found = Properties(PacketTypes.CONNECT)
    found.MaximumPacketSize = LARGEST_PACKET
    found.ReceiveMaximum = MOST_WAITING
    return found


def _reason(err: Exception) -> str:
    """Return the reason of an error for people, in one line."""
    text = " ".join(str(err).split())[:200] or type(err).__name__
    if isinstance(err, ssl.SSLCertVerificationError):
        return f"its certificate is not one that we know ({err.verify_message})"
    if isinstance(err, TimeoutError):
        return "it does not answer"
    return text
