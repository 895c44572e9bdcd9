"""A held motion: repeats a command under its lease, and lets the lease expire by ending the repetition."""

import contextlib
import threading
import time
from collections.abc import Callable

import msgspec

from lbr.bus import wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.console.ear import Ear
from lbr.errors import BusError, MalformedError
from lbr.leases.client import LeaseClient, LeaseTarget
from lbr.leases.over_session import OverSession
from lbr.messages.codes import Code
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.system import Hold

PERIOD_S = 0.1
SILENCE_S = 1.0
RESULT_WAIT_S = 0.5
STOP_WAIT_S = 1.0
JOIN_S = 1.0

_results = Decoder(GoalResult)


class Ending(msgspec.Struct, frozen=True, kw_only=True):
    """The end of a held motion, for people and as a code; `good`: it was meant to end so."""

    good: bool
    text: str
    code: str = ""


class LeaseKeeper:
    """Renews one hold at 10 Hz from a thread of its own, until it ends by itself, is released or dropped.

    It ends and stops the motion once `ear` is deaf: another thread receives stops, and may hang.
    """

    def __init__(
        self,
        session: Session,
        hold: Hold,
        source: str,
        ear: Ear,
        *,
        on_end: Callable[[Ending], None] = lambda _ending: None,
    ) -> None:
        self.hold = hold
        self.ending: Ending | None = None
        self._session = session
        self._source = source
        self._ear = ear
        self._on_end = on_end
        self._started = time.monotonic()
        self._wake = threading.Event()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._questions: list[wire.PendingQuery] = []
        self._thread = threading.Thread(target=self._run, name="hold", daemon=True)

    @property
    def elapsed_s(self) -> float:
        """Return how long the motion has been held."""
        return time.monotonic() - self._started

    def start(self) -> None:
        """Begin to renew."""
        self._thread.start()

    def release(self, why: str = "released") -> None:
        """End the renewal and stop the motion; return once it is acknowledged, or after a second."""
        self.drop(why, "stopped")
        stop(self._session, self.hold.stop_key, self._source, why)

    def drop(self, why: str = "superseded", code: Code = "superseded") -> None:
        """End the renewal, without a stop: another command has replaced this one."""
        self._end(Ending(good=True, text=why, code=code))

    def wait(self, timeout_s: float | None = None) -> Ending | None:
        """Wait for the end; None if the motion still goes on."""
        self._ended.wait(timeout_s)
        return self.ending

    def join(self) -> None:
        """Wait until its thread no longer uses the session, which must not close before that."""
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(JOIN_S)

    def _run(self) -> None:
        try:
            self._renew_until_ended()
        except Exception as err:  # noqa: BLE001 - those who wait for the end must be told
            self._end(
                Ending(good=False, text=f"the bus is gone ({err}); the robot has stopped by itself", code="unreachable")
            )

    def _renew_until_ended(self) -> None:
        hold = self.hold
        lease = self._lease()
        results = wire.Subscription(self._session, hold.result_key, depth=8, wake=self._wake.set) if hold.goal else None
        try:
            due = time.monotonic()
            asked = 0
            while self.ending is None:
                if why := self._ear.deaf(self._started):
                    self._give_up(why)
                    return
                if time.monotonic() >= due:
                    self._renew(lease)
                    due += PERIOD_S * max(1, int((time.monotonic() - due) / PERIOD_S))
                if hold.goal and asked < 1 + lease.lost:  # the result may have been published before this subscribed
                    self._ask_result()
                    asked += 1
                self._wake.wait(max(0.0, min(due - time.monotonic(), PERIOD_S)))
                self._wake.clear()
                for payload in (*self._answered(), *(raw.payload for raw in (results.take() if results else ()))):
                    self._hear(lease, payload)
                lease.step()
                self._look_for_the_end(lease)
        finally:
            if results is not None:
                results.close()

    def _renew(self, lease: LeaseClient) -> None:
        with self._lock:  # after the end, nothing is sent: later messages are dated after the last renewal
            if self.ending is None:
                lease.send(self.hold.payload)

    def _lease(self) -> LeaseClient:
        hold = self.hold
        target = LeaseTarget(
            "motion",
            silent="the robot does not answer; it has stopped by itself",
            silent_s=hold.ttl_s + SILENCE_S,
            result_s=RESULT_WAIT_S,
        )
        over = OverSession(self._session, self._source, {"motion": hold.key}, wake=self._wake.set)
        given = CommandReply(accepted=True, lease=hold.lease, ttl_s=hold.ttl_s, goal=hold.goal)
        return LeaseClient(over, target, given=given)

    def _give_up(self, why: str) -> None:
        self._end(Ending(good=False, text=f"stopped: {why}", code="holder_gone"))
        stop(self._session, self.hold.stop_key, self._source, why)

    def _ask_result(self) -> None:
        key, wake = self.hold.result_key, self._wake.set
        question = wire.PendingQuery(self._session, key, b"", timeout_s=SILENCE_S, source=self._source, wake=wake)
        self._questions.append(question)

    def _answered(self) -> list[bytes]:
        found = [question for question in self._questions if question.done or question.replies]
        self._questions = [question for question in self._questions if question not in found]
        return [raw.payload for question in found for raw in question.replies]

    def _hear(self, lease: LeaseClient, payload: bytes) -> None:
        with contextlib.suppress(MalformedError):
            lease.hear(_results.decode(payload))

    def _look_for_the_end(self, lease: LeaseClient) -> None:
        if lease.result is not None:
            self._end(Ending(good=lease.good, text=describe(lease.result), code=lease.result.code))
        elif lease.ended is not None:
            self._end(Ending(good=False, text=lease.ended.text, code=lease.ended.code))
        elif not self.elapsed_s <= self.hold.max_run_s and self.ending is None:
            text = f"stopped after {self.hold.max_run_s:g} s, the longest one line may move"
            stop(self._session, self.hold.stop_key, self._source, text)
            self._end(Ending(good=True, text=text, code="time_over"))

    def _end(self, ending: Ending) -> None:
        with self._lock:
            if self.ending is not None:
                return
            self.ending = ending
        self._ended.set()
        self._wake.set()
        self._on_end(ending)


def stop(session: Session, key: str, source: str, reason: str = "") -> bool:
    """Send a stop; return whether it was acknowledged within a second."""
    try:
        return bool(wire.ask(session, key, StopCommand(reason=reason[:200]), source=source, timeout_s=STOP_WAIT_S))
    except BusError:
        return False


def describe(result: GoalResult) -> str:
    """Return in one line how a bounded move or a turn ended."""
    if result.result == "reached" and (result.turned_deg is not None or result.range_cm is None):
        return result.reason or f"done after {result.elapsed_s:.1f} s"
    at = f" at {result.range_cm:g} cm" if result.range_cm is not None else ""
    planned = result.result in {"reached", "interval"}
    why = f": {result.reason}" if result.reason and result.reason != result.result and not planned else ""
    said = {"reached": "range reached", "interval": "time is over"}.get(result.result, result.result)
    return f"{said}{at} after {result.elapsed_s:.1f} s{_how_far(result)}{why}"


def _how_far(result: GoalResult) -> str:
    """Return how far the base has moved by then."""
    if result.turned_deg is not None:
        return f", turned {result.turned_deg:.1f} degrees"
    return f", drove {abs(result.distance_m):.2f} m" if result.distance_m is not None else ""
