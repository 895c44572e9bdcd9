"""MQTT as a capability: reports the robot's state to the broker, does the words that its row allows, and answers.

Motion is leased, one goal at a time, and ends with this process. It also ends when the broker is lost, as the person
who requested it could not stop it any more.
"""

from contextlib import suppress
from math import inf
from typing import NamedTuple

import msgspec

from lbr import plugins
from lbr.apps.mqtt import discovery, report, words
from lbr.apps.mqtt.echo import Echo
from lbr.apps.mqtt.kind import MqttSettings
from lbr.apps.mqtt.messages import MqttState
from lbr.apps.mqtt.session import Broker, Incoming, Outgoing, Session, secret, secured
from lbr.apps.mqtt.shadow import Desire, ShadowState
from lbr.apps.mqtt.words import Ask, Motion, Order, StopWord
from lbr.bus.door import TokenRight
from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.errors import DeviceError, InputError
from lbr.leases.client import PendingReply
from lbr.leases.holder import TARGETS, Holder
from lbr.messages.behaviour import RunBehaviour
from lbr.messages.codes import Reason, heard
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.plain import one_line
from lbr.messages.speech import SayCommand
from lbr.messages.system import Role
from lbr.messages.unreadable import UNREADABLE, keyed_once

ASK_S = 3.0
PUBLISH_S = 1.0
PUBLISH_NEWS_S = 0.25
SETTLES_S = 1.2
"""The wait of the first report, by which every stream of 1 Hz has come."""
LARGEST_ASK = 2048
LONGEST_REASON = 200
LONGEST_WORD = 40
LONGEST_TOPIC = 200
OLD_PICTURE_S = 2.0
MOST_ASKED = 4
"""The most words in a round, and the most without an answer; nobody means more at once."""
PORTS = {StopCommand: "stop_all", RunBehaviour: "run", SayCommand: "say"}
STANDS_STILL = "the broker sends nothing back, so the person who asked could not stop this"
NO_BROKER = "no broker is named: write its address into 'host' of this row; docs/outside.md explains how to get one"


class Waiting(NamedTuple):
    """A request of a word that waits for its answer."""

    ask: Ask
    by: str
    question: PendingReply


class Mqtt(Capability[MqttSettings]):
    """Reports the robot's state to the broker, and passes the broker's words to the robot."""

    woken_by_streams = False

    def __init__(self, ctx: Context[MqttSettings]) -> None:
        super().__init__(ctx)
        settings = ctx.settings
        self._topic = settings.topic or f"lbr/{ctx.robot}"
        self._session: Session | None = None
        self._echo = Echo() if settings.words and self._has_own_topics else None
        self._shadow: ShadowState | None = None
        if settings.shadow is not None:
            mark = f"{ctx.robot}-{ctx.name}-{int(ctx.clock() * 1000)}"
            self._shadow = ShadowState(settings.shadow.thing, settings.shadow.name, settings.every_s, mark)
        self._holder = Holder(ctx)
        self._moving: tuple[Ask, str] | None = None
        self._waiting: list[Waiting] = []
        self._answer: dict[str, str | int] = {}
        self._desired: object = None
        self._connection = MqttState(
            connected=False, broker=f"{settings.host}:{settings.port}" if settings.host else ""
        )
        self._published: MqttState | None = None
        self._published_at = -inf
        self._count = self._reported = self._asked = self._refused = 0
        self._state: report.Report = {}
        self._state_at = self._picture_at = -inf
        self._health = ""
        self._report_from = inf

    @property
    def _role(self) -> Role | None:
        """The role of the row's token; None for a host's token."""
        token = next((row for row in self.ctx.rows(TokenRight) if row.name == self.ctx.settings.token), None)
        return token.role if token is not None and token.role != "host" else None

    def open(self) -> None:
        """Start the connection, if a broker is named."""
        self._report_from = self.ctx.clock() + SETTLES_S
        settings = self.ctx.settings
        if not settings.host:
            return
        try:
            self._session = Session(self._broker(), self.ctx.wake, self._may_stop)
        except InputError as err:
            raise DeviceError(str(err)) from err
        self._session.start()

    def step(self) -> None:
        """Do one round: handle messages, renew motion, publish the state."""
        now = self.ctx.clock()
        self._look_after_connection()
        if self._session is not None:
            for message in self._session.take():
                self._handle(message, now)
            self._listen_for_echo(self._session, now)
        self._go_on()
        self._read_answers()
        if self._session is not None and self._session.connected and now >= self._report_from:
            self._report(now)
        self._publish_state(now)

    def close(self) -> None:
        """Stop its motion, and publish that the robot is offline."""
        self._end_motion(Reason("shutting_down", "the connection to the broker is shut down"))
        session, self._session = self._session, None
        if session is not None:
            session.close([self._available(discovery.OFFLINE)] if self._has_own_topics else [])

    # The connection.

    def _broker(self) -> Broker:
        settings = self.ctx.settings
        topics = (*(self._shadow.topics if self._shadow is not None else ()), *self._asked_on())
        return Broker(
            host=settings.host,
            port=settings.port,
            client_id=settings.client_id or f"lbr-{self.ctx.robot}-{self.ctx.name}",
            keepalive_s=settings.keepalive_s,
            tls=secured(settings.ca, settings.certificate, settings.key) if settings.tls else None,
            user=settings.user,
            password=secret(settings.password) if settings.password else "",
            will=self._available(discovery.OFFLINE) if self._has_own_topics else None,
            topics=topics,
        )

    @property
    def _has_own_topics(self) -> bool:
        """True if topics of its own are used: a shadow alone needs no rights to others."""
        return self.ctx.settings.home_assistant is not None or self.ctx.settings.shadow is None

    def _asked_on(self) -> tuple[str, ...]:
        if not self._has_own_topics:
            return ()
        echo = (f"{self._topic}/echo",) if self._echo is not None else ()
        return (f"{self._topic}/ask", f"{self._topic}/ask/+", *echo)

    def _available(self, payload: str) -> Outgoing:
        return Outgoing(f"{self._topic}/available", payload.encode(), retain=True)

    def _look_after_connection(self) -> None:
        session = self._session
        health = NO_BROKER if session is None else self._silence() if session.connected else session.trouble
        if session is not None and health:
            health = f"the broker {self._connection.broker}: {health}"
        self._health = health
        if health:
            self.ctx.warn(health, "unreachable" if session is not None else "off")
        else:
            self.ctx.ready()
        if session is None:
            return
        if not session.connected:
            self._end_motion(Reason("unreachable", "the broker is gone, and with it who could stop this"))
        elif session.count != self._count:
            self._count = session.count
            self._publish_all(session)

    def _silence(self) -> str:
        """Return why words are refused while the broker echoes nothing; empty if it does."""
        if self._echo is None or not self._echo.stands_still(self.ctx.clock()) or self._session is None:
            return ""
        if self._session.count != self._count:
            return ""
        why = (
            "it stands still"
            if self._echo.ever
            else "it stands still, or the robot's user may not write and read there"
        )
        return f"nothing comes back on {self._topic}/echo: {why}. Nothing but a stop is done meanwhile"

    def _listen_for_echo(self, session: Session, now: float) -> None:
        """Send an echo word to the broker at intervals; end the motion without its return."""
        if self._echo is None or not session.connected:
            return
        if word := self._echo.word(now):
            session.publish(Outgoing(f"{self._topic}/echo", word.encode(), sure=False))
        if self._echo.stands_still(now):
            self._end_motion(Reason("unreachable", STANDS_STILL))

    def _publish_all(self, session: Session) -> None:
        """Publish everything that a broker may have lost since the last connection."""
        self._state, self._state_at = {}, -inf
        if self._echo is not None:
            self._echo.connected(self.ctx.clock())
        if self._shadow is not None:
            self._shadow.connected()
        if self._has_own_topics:
            session.publish(self._available(discovery.ONLINE))
        home_assistant = self.ctx.settings.home_assistant
        if home_assistant is not None:
            device = discovery.document(
                self.ctx.robot,
                home_assistant.name,
                self._topic,
                self.ctx.settings.report,
                self.ctx.settings.words,
                picture=bool(self.ctx.sources("frames")),
                version=plugins.version(),
            )
            key = f"{home_assistant.prefix}/device/lbr_{self.ctx.robot}/config"
            session.publish(Outgoing(key, msgspec.json.encode(device), retain=True))

    # Words.

    def _may_stop(self, message: Incoming) -> bool:
        """Return whether a message is or may contain a stop, as a shadow's may; called on the connection's thread."""
        if self._shadow is not None and message.topic.startswith(f"{self._shadow.root}/"):
            return True
        name = self._word_in(message.topic)
        if not name and len(message.payload) <= LARGEST_ASK:
            with suppress(InputError):
                name = words.read(_json(message.payload)).word
        return isinstance(self.ctx.settings.words.get(name), StopWord)

    def _word_in(self, topic: str) -> str:
        """Return the word in an own topic, or an empty string."""
        return topic.removeprefix(f"{self._topic}/ask").lstrip("/")

    def _handle(self, message: Incoming, now: float) -> None:
        """Handle a message; report its faults with its topic."""
        try:
            if self._shadow is not None and message.topic.startswith(f"{self._shadow.root}/"):
                if asked := self._shadow.receive(message.topic, message.payload, now):
                    self._desire(message.topic, asked)
            elif self._echo is not None and message.topic == f"{self._topic}/echo":
                self._echo.receive(message.payload, now)
            else:
                self._serve(message, now)
        except InputError as err:
            self._complain(message.topic, str(err), err.code)

    def _serve(self, message: Incoming, now: float) -> None:
        """Do a word from an own topic; the topic names it, or the message."""
        name = self._word_in(message.topic)
        ask = Ask(word=name[:LONGEST_WORD])
        try:
            _refuse_unfit(message)
            if name:
                ask = _named(name, message.payload, self.ctx.settings.words.get(name))
            else:
                ask = words.read(_json(message.payload))
            self._do(ask, message.topic, late=self._echo is not None and self._echo.late(now))
        except InputError as err:
            self._complain(message.topic, str(err), err.code, ask)

    def _desire(self, topic: str, asked: Desire) -> None:
        """Do the desire of a shadow; each is answered, so that the shadow does not repeat it."""
        assert self._shadow is not None
        self._desired = self._shadow.done(asked.raw)
        ask = Ask(word="")
        try:
            ask = words.read(asked.raw)
            _refuse_late(ask, asked.age_s, self.ctx.settings.late_s)
            self._do(ask, topic)
        except InputError as err:
            self._complain(topic, str(err), err.code, ask)

    def _do(self, ask: Ask, topic: str, *, late: bool = False) -> None:
        """Do a word; one that may be late only if it is a stop."""
        self._asked += 1
        order = words.order(ask, self.ctx.settings.words, self._role)
        if isinstance(order, StopCommand):
            self._end_motion(Reason("stopped", f"stopped by '{ask.word}'"))
        elif late:
            text = f"the broker is slow: what it sends back on {self._topic}/echo is late, or does not come; ask again"
            raise InputError(text, "late")
        elif len(self._waiting) >= MOST_ASKED:
            raise InputError("too much was asked at once; ask again", "busy")
        if isinstance(order, Motion):
            self._move(ask, order, topic)
        else:
            self._pass_on(ask, order, topic)
        self.ctx.event("mqtt_asked", f"'{ask.word}' was asked for on {topic}", code="done", about=self.ctx.name)

    def _move(self, ask: Ask, order: Motion, topic: str) -> None:
        if self._moving is not None:
            raise InputError(f"'{self._moving[0].word}' is under way; a stop ends it", "busy")
        self._require(ask, TARGETS[type(order)].motion)
        self._moving = (ask, topic)
        self._holder.begin(TARGETS[type(order)], msgspec.structs.replace(order, ttl_s=self.ctx.settings.ttl_s))
        self._reply(ask, "running", Reason("done", f"'{ask.word}' has begun"))

    def _pass_on(self, ask: Ask, order: Order, topic: str) -> None:
        port = PORTS[type(order)]
        self._require(ask, port)
        self._waiting.append(Waiting(ask, topic, self.ctx.ask(port, order, ASK_S)))

    def _require(self, ask: Ask, port: str) -> None:
        if not self.ctx.targets(port):
            raise InputError(f"'{ask.word}': this robot has nothing that does it", "not_possible")

    def _go_on(self) -> None:
        """Renew the motion, and report its end."""
        ended = self._holder.step([one.message for one in self.ctx.take("results")])
        if self._moving is not None and ended is not None:
            (ask, _topic), self._moving = self._moving, None
            self._reply(ask, "done" if self._holder.good else "failed", ended)

    def _end_motion(self, why: Reason) -> None:
        if self._moving is not None:
            (ask, _topic), self._moving = self._moving, None
            self._holder.release(why.text)
            self._reply(ask, "failed", why)

    def _read_answers(self) -> None:
        for waiting in [waiting for waiting in self._waiting if waiting.question.answers() is not None]:
            self._waiting.remove(waiting)
            answers = waiting.question.answers() or {}
            replies = [reply for reply in answers.values() if isinstance(reply, CommandReply)]
            refusals = [reply.why for reply in replies if not reply.accepted]
            silent = [name for name, reply in answers.items() if reply is None]
            if refusals or silent or not replies:
                lost = Reason("unreachable", f"no answer from {', '.join(silent) or 'anything'}")
                self._complain(
                    waiting.by, str(refusals[0] if refusals else lost), (refusals or [lost])[0].code, waiting.ask
                )
            else:
                text = "; ".join(dict.fromkeys(reply.reason for reply in replies if reply.reason))
                self._reply(waiting.ask, "done", heard("done", text or "done"))

    def _complain(self, topic: str, text: str, code: str, ask: Ask | None = None) -> None:
        """Refuse a message: publish an event, and an answer to the broker."""
        self._refused += 1
        why = heard(code, f"{one_line(topic[:LONGEST_TOPIC])}: {text}")
        self.ctx.event("refused", why.text, level="warning", code=why.code, about=self.ctx.name)
        self._reply(ask or Ask(word=""), "refused", why)

    def _reply(self, ask: Ask, state: str, why: Reason) -> None:
        """Store the last answer, which a shadow reports, and send it to the broker."""
        self._answer = {
            "word": one_line(ask.word),
            "id": ask.id,
            "state": state,
            "code": why.code,
            "reason": why.text[:LONGEST_REASON],
        }
        if self._session is not None and self._has_own_topics:
            self._session.publish(Outgoing(f"{self._topic}/answer", msgspec.json.encode(self._answer)))

    # Reports.

    def _report(self, now: float) -> None:
        assert self._session is not None
        settings = self.ctx.settings
        wired = [name for name in report.SOURCES if self.ctx.sources(name)]
        state = report.report(settings.report, self.ctx.latest, wired, now)
        if self._has_own_topics and state != self._state and now - self._state_at >= settings.every_s:
            self._state, self._state_at = state, now
            self._reported += 1
            self._session.publish(Outgoing(f"{self._topic}/state", msgspec.json.encode(state), retain=True))
        if self._shadow is not None:
            answered = {"ask": self._desired, "answer": self._answer} if self._answer else {}
            for topic, payload in self._shadow.publish(state | answered, now):
                self._reported += topic.endswith("/update")
                self._session.publish(Outgoing(topic, payload))
        if settings.home_assistant is not None and now - self._picture_at >= settings.home_assistant.picture_s:
            self._publish_picture(now)

    def _publish_picture(self, now: float) -> None:
        """Publish the newest picture, unless it is old."""
        frame = self.ctx.latest("frames")
        if frame is None or not frame.age_s(now) <= OLD_PICTURE_S or self._session is None:
            return
        self._picture_at = now
        self._session.publish(Outgoing(f"{self._topic}/picture", frame.message.data, sure=False))

    def _publish_state(self, now: float) -> None:
        session, moving = self._session, self._moving
        self._connection = MqttState(
            connected=session is not None and session.connected,
            broker=self._connection.broker,
            reason=self._health,
            connections=self._count,
            reported=self._reported,
            asked=self._asked,
            refused=self._refused,
            answer=str(self._answer.get("reason", "")),
            code=str(self._answer.get("code", "")),
            doing=moving[0].word if moving is not None else "",
            version=self._shadow.version if self._shadow is not None else None,
        )
        if now - self._published_at >= (PUBLISH_S if self._connection == self._published else PUBLISH_NEWS_S):
            self._published, self._published_at = self._connection, now
            self.ctx.publish("state", self._connection)


def _refuse_unfit(message: Incoming) -> None:
    """Refuse retained messages, which may be old, and messages that are too large."""
    if message.retained:
        raise InputError("it was kept by the broker, and nobody knows for how long: ask without 'retain'", "late")
    if len(message.payload) > LARGEST_ASK:
        raise InputError(f"it has {len(message.payload)} bytes, and {LARGEST_ASK} are the most", "malformed")


def _named(name: str, payload: bytes, word: words.Word | None) -> Ask:
    """Return the request of a topic's word, with the text or number in the message, if the word has one."""
    wanted = words.bounds(word) if word is not None else None
    if wanted is None:
        return Ask(word=name[:LONGEST_WORD])
    try:
        return Ask(word=name, value=payload.decode() if wanted.text else msgspec.json.decode(payload, type=float))
    except UNREADABLE as err:
        raise InputError(f"a {'text' if wanted.text else 'number'} comes with '{name}' ({err})", "malformed") from err


def _json(payload: bytes) -> object:
    try:
        return msgspec.json.decode(keyed_once(payload))
    except UNREADABLE as err:
        raise InputError(f"it is no JSON ({str(err)[:100]})", "malformed") from err


def _refuse_late(ask: Ask, age_s: float | None, late_s: float) -> None:
    """Refuse a desire that is too old: its author may be gone, and people near the robot expect nothing."""
    if age_s is None or not age_s <= late_s:
        age = "an unknown time" if age_s is None else f"{age_s:.0f} s"
        raise InputError(f"'{ask.word}' has been desired for {age}; it is too late for it", "late")
