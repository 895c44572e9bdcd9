"""The link between a front end and a robot: sends lines, holds motions, and keeps the robot's latest messages."""

import contextlib
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from msgspec import Struct

from lbr.bus import keys, wire
from lbr.bus.access import Credentials
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.console.ear import Ear
from lbr.console.event_filter import EventFilter
from lbr.console.lease_keeper import Ending, LeaseKeeper, stop
from lbr.console.printable import clean
from lbr.console.stops import is_stop, stop_in
from lbr.console.verbs import VerbCall, Vocabulary
from lbr.errors import BusError, InputError, MalformedError
from lbr.messages.drive import DriveState
from lbr.messages.joints import JointsState
from lbr.messages.motors import MotorsState
from lbr.messages.power import PowerState
from lbr.messages.schema import JsonObject
from lbr.messages.sensing import Ranges
from lbr.messages.system import ConsoleResult, EstopRequest, Event, Hold, Role, Status

LINE_TIMEOUT_S = 600.0
SETTLE_S = 0.6
LATE_ANSWER_S = 1.0
STOP_TIMEOUT_S = 5.0
"""A stop is answered within 2 s, even if a mover does not answer."""
LET_GO = "the operator released it"

_BUILT_IN = Vocabulary(())

T = TypeVar("T", bound=Struct)


class Telemetry(Struct, frozen=True, kw_only=True):
    """The latest messages for a console; None without a fresh one."""

    status: Status | None = None
    status_age_s: float = 0.0
    drive: DriveState | None = None
    motors: MotorsState | None = None
    ranges: Ranges | None = None
    joints: JointsState | None = None
    power: PowerState | None = None


def emergency(line: str) -> str | None:
    """Return the reason of an emergency stop, None for another line: each robot has its own words."""
    try:
        said = _BUILT_IN.parse(line)
    except InputError:
        return None
    return str(said.payload.get("reason", "")) if isinstance(said, VerbCall) and said.command == "estop" else None


class BusOperator:
    """An operator over the bus; a console in the robot's own process passes `submit` to send its lines directly.

    Several threads may send lines at once. A motion goes on only while the thread that receives stops calls `ear.beat`,
    ten times a second. `streams` may be a second session, so that the robot's messages never delay the lines. `proof`
    is the session's token: it seals the lines, as a proof of their sender.
    """

    def __init__(
        self,
        session: Session,
        robot: str,
        source: str,
        *,
        role: Role = "operate",
        proof: Credentials | None = None,
        submit: Callable[[str, float], ConsoleResult] | None = None,
        streams: Session | None = None,
        listen: bool = True,
        answers_within_s: float = LINE_TIMEOUT_S,
    ) -> None:
        self.robot = robot
        self.on_end: Callable[[str, Ending], None] = lambda _line, _ending: None
        self.ear = Ear()
        self._session = session
        self._source = source
        self._role = role
        self._proof = proof
        self._submit = submit or self._ask
        self._answers_within_s = answers_within_s
        self._lock = threading.Lock()
        self._said = 0
        self._news = EventFilter(source)
        self._quiet_until = 0.0
        self._holder: LeaseKeeper | None = None
        self._latest: _Latest | None = _Latest(streams or session, robot) if listen else None

    def submit(self, line: str, waited_s: float = 0.0) -> ConsoleResult:
        """Send a line, hold the motion that it starts, and return its result; raise InputError or BusError with the
        reason.

        It was typed or written `waited_s` ago: it does not move a capability that somebody else has stopped since then.
        No motion is held if a later line was sent meanwhile.
        """
        line = clean(stop_in(line) or line)
        if not line:
            return ConsoleResult(code=0, text="")
        with self._lock:
            self._said += 1
            turn = self._said
        began = time.monotonic()
        if is_stop(line):
            self._cease()
        if (reason := emergency(line)) is not None:
            self._press(reason)
        result = self._submit(line, waited_s)
        self._news.answered(result)
        late_s = time.monotonic() - began
        if result.hold is not None and not late_s < LATE_ANSWER_S:
            return self._too_late(result.hold, late_s)
        if result.hold is not None:
            self._take(line, turn, result.hold)
        elif result.code == 0 and is_stop(line):
            self._quiet_until = time.monotonic() + SETTLE_S
        return result

    def words(self) -> list[JsonObject]:
        """Return the robot's words, for completion; empty if the robot does not answer."""
        try:
            data = self._submit("help", 0.0).data
        except (BusError, InputError):
            return []
        return [entry for entry in data if isinstance(entry, dict)] if isinstance(data, list) else []

    def telemetry(self) -> Telemetry:
        """Return the latest messages; empty if it does not listen."""
        return self._latest.telemetry() if self._latest else Telemetry()

    def events(self) -> list[Event]:
        """Return the events since the last call that are news to the operator of this console."""
        return self._news.sifted(self._latest.events()) if self._latest else []

    def held(self) -> LeaseKeeper | None:
        """Return the held motion."""
        holder = self._holder
        return holder if holder is not None and holder.ending is None else None

    def latest(self) -> LeaseKeeper | None:
        """Return the last held motion, whether or not it has ended."""
        return self._holder

    def release(self, why: str = LET_GO) -> None:
        """Stop our own motion, and any motion that a line still under way may start."""
        with self._lock:
            self._said += 1
            holder = self._holder
        if holder is not None and holder.ending is None:
            self._quiet_until = time.monotonic() + SETTLE_S
            holder.release(why)

    def _cease(self) -> None:
        """End the renewal of our motion: a stop is on its way, and may be delayed."""
        with self._lock:
            holder = self._holder
        if holder is not None and holder.ending is None:
            self._quiet_until = time.monotonic() + SETTLE_S
            holder.drop()

    def _press(self, reason: str) -> None:
        """Send the stop directly to the movers, in case the executive hangs. The line latches it there."""
        with contextlib.suppress(BusError):  # a closed session: the line reports that
            request = EstopRequest(engaged=True, reason=reason[:200])
            wire.put(self._session, keys.estop(self.robot), request, source=self._source, urgent=True)

    def close(self) -> None:
        """Stop our motion, and stop listening."""
        self.release()
        if self._holder is not None:
            self._holder.join()
        if self._latest is not None:
            self._latest.close()

    def _take(self, line: str, turn: int, hold: Hold) -> None:
        holder = LeaseKeeper(
            self._session, hold, self._source, self.ear, on_end=lambda ending: self._ended(line, ending)
        )
        with self._lock:
            late = turn != self._said
            before = None if late else self._holder
            if not late:
                self._holder = holder
        if late:
            stop(self._session, hold.stop_key, self._source, "another line was sent meanwhile")
            return
        if before is not None:
            before.drop()
        holder.start()

    def _too_late(self, hold: Hold, late_s: float) -> ConsoleResult:
        """Refuse a motion that was requested a while ago: it may be wrong now."""
        stop(self._session, hold.stop_key, self._source, "the answer came too late")
        return ConsoleResult(
            code=1,
            text=f"the answer came {late_s:.1f} s after the line, so nothing moves; say it again",
            reason_code="late",
        )

    def _ended(self, line: str, ending: Ending) -> None:
        expected = ending.code == "superseded" or time.monotonic() < self._quiet_until
        if not expected:
            self.on_end(line, ending)

    def _ask(self, line: str, waited_s: float) -> ConsoleResult:
        answered = threading.Event()
        question = wire.PendingQuery(
            self._session,
            keys.console(self.robot, self._role),
            line.encode(),
            timeout_s=STOP_TIMEOUT_S if is_stop(line) else self._answers_within_s,
            source=self._source,
            proof=self._proof,
            waited_s=waited_s,
            wake=answered.set,
        )
        while not (question.done or question.replies):
            answered.wait(1.0)
            answered.clear()
        if not question.replies:
            sent = "; the stop was sent, and is not confirmed" if emergency(line) is not None else ""
            switch = f"{sent}; if it moves, use the hardware switch" if is_stop(line) else ""
            shows = "'lbr status' (with --connect, if you used it) shows the reason"
            raise BusError(f"robot '{self.robot}' does not answer{switch}; {shows}")
        try:
            return Decoder(ConsoleResult).decode(question.replies[0].payload)
        except MalformedError as err:
            raise BusError(f"robot '{self.robot}' gave an answer that cannot be read ({err})") from None


class _Latest:
    """The newest message of each stream, decoded only when needed."""

    FRESH_S = 2.0

    def __init__(self, session: Session, robot: str) -> None:
        self._events = wire.Subscription(session, keys.event(robot), depth=256)
        self._status = _Slot(session, keys.status(robot), Status)
        self._drive = _Slot(session, keys.port(robot, "drive", "state"), DriveState)
        self._motors = _Slot(session, keys.port(robot, "motors", "state"), MotorsState)
        self._ranges = _Slot(session, keys.port(robot, "ranges", "readings"), Ranges)
        self._joints = _Slot(session, keys.port(robot, "joints", "state"), JointsState)
        self._power = _Slot(session, keys.port(robot, "power", "state"), PowerState)

    def telemetry(self) -> Telemetry:
        status, age_s = self._status.read(), self._status.age_s
        return Telemetry(
            status=status,
            status_age_s=age_s,
            drive=self._drive.read(self.FRESH_S),
            motors=self._motors.read(self.FRESH_S),
            ranges=self._ranges.read(self.FRESH_S),
            joints=self._joints.read(self.FRESH_S),
            power=self._power.read(self.FRESH_S),
        )

    def events(self) -> list[Event]:
        events = []
        for raw in self._events.take():
            try:
                events.append(Decoder(Event).decode(raw.payload))
            except MalformedError:
                continue
        return events

    def close(self) -> None:
        self._events.close()
        for slot in (self._status, self._drive, self._motors, self._ranges, self._joints, self._power):
            slot.close()


class _Slot(Generic[T]):
    def __init__(self, session: Session, key: str, kind: type[T]) -> None:
        self._decoder = Decoder(kind)
        self._feed = wire.Subscription(session, key)
        self._last: T | None = None
        self._seen = time.monotonic()

    @property
    def age_s(self) -> float:
        return time.monotonic() - self._seen

    def read(self, fresh_s: float | None = None) -> T | None:
        for raw in self._feed.take():
            try:
                self._last, self._seen = self._decoder.decode(raw.payload), time.monotonic()
            except MalformedError:
                continue
        return self._last if fresh_s is None or self.age_s < fresh_s else None

    def close(self) -> None:
        self._feed.close()
