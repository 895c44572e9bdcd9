"""The emergency stop: stores the latch, repeats it until every device has acknowledged it, and releases it.

Movers receive the stop directly on sessions of their own: a message on `@estop` does not need the executive to reach
them.
"""

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from math import inf

from msgspec.structs import replace

from lbr.bus import keys, session, stamp, wire
from lbr.bus.codec import Decoder
from lbr.errors import LbrError, MalformedError
from lbr.executive.service.journal import Journal, sender
from lbr.executive.services import Service
from lbr.leases.halts import Halts
from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE
from lbr.messages.system import EstopAcknowledgement, EstopRelease, EstopRequest, EstopState

REPEAT_S = 0.05
REPEAT_LATER_S = 1.0
REPEAT_FOR_S = 5.0
SHORTEST_S = 0.2
ACKNOWLEDGE_LIMIT_S = 0.5
RELEASE_S = 1.0
ALONE_S = 0.5
"""For so long, a mover may report its latch before the same press arrives here."""
MOST_RESETS = 4
RELEASED = "emergency stop released; the next command may move the robot"
NOT_SAVED = "the emergency stop's latch is not on the disk"
_requests = Decoder(EstopRequest)
_acknowledgements = Decoder(EstopAcknowledgement)


class Emergency(Service):
    """`movers()` names the capabilities that must acknowledge; `persist(engaged, reason)` must write to the disk."""

    def __init__(
        self,
        robot: str,
        connect: Callable[[], session.Session],
        state: EstopState,
        journal: Journal,
        *,
        movers: Callable[[], Iterable[str]],
        seal: Callable[[str], str],
        persist: Callable[[bool, str], None],
        wake: Callable[[], None],
    ) -> None:
        self._robot = robot
        self._engaged, self._reason, self._source = state.engaged, state.reason, state.source
        self._movers = movers
        self._seal = seal
        self._persist = persist
        self._journal = journal
        self._wake = wake
        self._stopped: set[str] = set()
        self._within_s: dict[str, float] = {}
        self._begun: dict[str, float] = {}
        self._announced: tuple[bool, tuple[str, ...]] = (True, ())
        self._changed, self._answered = threading.Condition(), threading.Condition()
        self._repeat_at = 0.0
        self._repeat_until = 0.0
        self._latched_at = time.monotonic() if state.engaged else -inf
        self._alone: dict[str, float] = {}
        self._count = 0
        self._halts = Halts()
        self._releasing = 0
        self._unsaved = state.engaged  # store it at the other place, too, if only one had it
        self._save_tried = True
        self._save_at = 0.0
        self._news: deque[tuple[str, str, str, str]] = deque(maxlen=100)
        self._pool = ThreadPoolExecutor(max_workers=MOST_RESETS, thread_name_prefix="reset")
        self._session = connect()
        self._presses = wire.Subscription(self._session, keys.estop(robot), depth=64, wake=self._hear_presses)
        acknowledgements = keys.estop_acknowledgement(robot, "*")
        self._said = wire.Subscription(self._session, acknowledgements, depth=64, wake=self._hear_acknowledgements)
        self._latest = wire.ComputedReply(self._session, keys.estop(robot), self.state)
        self._resets = wire.QueryServer(
            self._session, keys.estop_reset(robot), self._hear_resets, puts=False, source="executive"
        )

    def state(self) -> EstopState:
        """Return the latch and its acknowledgements; may be called from any thread."""
        if not self._engaged:
            return EstopState(engaged=False, reason="")
        movers = set(self._movers())
        waiting = sorted(movers - self._stopped)
        late = () if self._releasing else (name for name in waiting if time.monotonic() >= self._deadline(name))
        return in_words(
            EstopState(
                engaged=True,
                reason=self._reason,
                source=self._source,
                acknowledged=tuple(sorted(movers & self._stopped)),
                waiting=tuple(waiting),
                overdue=tuple(late),
            )
        )

    def press(self, reason: str, source: str) -> EstopState:
        """Latch, and wait until every mover's device has acknowledged, at most for the time in their rows; from any
        thread.

        Movers do not wait for the disk. The sender of the stop does, unless the disk fails.
        """
        wire.put(
            self._session,
            keys.estop(self._robot),
            EstopRequest(engaged=True, reason=reason),
            source=source,
            urgent=True,
        )
        until = time.monotonic() + ACKNOWLEDGE_LIMIT_S
        with self._changed:
            while not self._latched():
                last = max((self._deadline(name) for name in self.state().waiting), default=until)
                if not self._changed.wait(max(until, last) - time.monotonic()):
                    break
        return self.state()

    def release(self, source: str, written_s: float) -> Reason | None:
        """Release every mover, then the latch; return why not, or None. From any thread but the executive's own.

        A reset that was written before somebody else than `source` pressed the stop releases nothing. A press meanwhile
        wins: movers that were already released are latched again. The caller waits for the disk, unless that fails or
        takes half a second. A stop always lasts long enough to interrupt a stream of commands.
        """
        with self._changed:
            presses, (at, who) = self._count, self._halts.by_others(source)
        if not written_s > at:  # this way round, NaN counts as too early
            return Reason("stopped_since", f"{STOPPED_SINCE}by {who}")
        time.sleep(max(0.0, min(SHORTEST_S, self._latched_at + SHORTEST_S - time.monotonic())))
        with self._changed:
            self._announce()
            self._releasing += 1  # a repetition now would latch again the movers that are being released
        try:
            why_not = self._release(source)
        except LbrError as err:
            why_not = f"{err}; it stays latched"
        with self._changed:
            self._releasing -= 1
            if not why_not and presses != self._count:
                why_not = "the emergency stop was pressed again meanwhile; it stays latched"
            if why_not:
                self._latched_at = time.monotonic()
                self._repeat_until = self._latched_at + REPEAT_FOR_S if self._engaged else 0.0
                self._stopped.clear()
            else:
                self._engaged, self._reason, self._source, self._repeat_until = False, "", "", 0.0
                self._stopped.clear()
                self._alone.clear()
                self._unsaved, self._save_tried, self._save_at = True, False, 0.0
                self._news.append(("estop_reset", "executive", f"emergency stop released by {source}", "warning"))
        self._wake()
        with self._changed:
            self._changed.wait_for(lambda: self._save_tried, ACKNOWLEDGE_LIMIT_S)
        return Reason("refused", why_not) if why_not else None

    def forget(self, name: str) -> None:
        """Remove a mover's acknowledgement: its process is a new one."""
        with self._changed:
            self._stopped.discard(name)
            self._alone.pop(name, None)
            self._begun[name] = time.monotonic()

    def _deadline(self, name: str) -> float:
        """Return until when a mover's device may acknowledge, counted from the latch or its process's start."""
        within_s = self._within_s.get(name, ACKNOWLEDGE_LIMIT_S)
        return max(self._latched_at, self._begun.get(name, -inf)) + within_s

    def _release(self, source: str) -> str:
        """Release all movers at once, as some answer only once those that they follow are armed; return why not."""
        payload = wire.encode(EstopRelease(by=source))
        asked = {name: self._asked_to_release(name, payload) for name in self._movers()}
        until = time.monotonic() + RELEASE_S
        with self._answered:
            self._answered.wait_for(lambda: all(one.done for one in asked.values()), until - time.monotonic())
        return next((why for name, one in asked.items() if (why := _not_released(name, one))), "")

    def _asked_to_release(self, name: str, payload: bytes) -> wire.PendingQuery:
        key = keys.estop_release(self._robot, name)
        sealed = stamp.make("executive", 0, payload, bytes.fromhex(self._seal(key)))
        return wire.PendingQuery(
            self._session,
            key,
            payload,
            timeout_s=RELEASE_S,
            source="executive",
            attachment=sealed,
            wake=self._hear_of_releases,
        )

    def _hear_of_releases(self) -> None:
        with self._answered:
            self._answered.notify_all()

    def step(self, now: float) -> float:
        """Store news, repeat the stop until it is acknowledged; return when to be called again."""
        with self._changed:
            if now >= min(self._alone.values(), default=inf) + ALONE_S:
                name = next(iter(self._alone))
                self._latch("it received a stop that did not arrive here", name, now)
            self._announce()
        while self._news:
            self._journal.happened(*self._news.popleft())
        if self._unsaved and now >= self._save_at:
            self._save(now)
        with self._changed:
            return self._repeat(now) if self._engaged and self.state().waiting else now + ALONE_S

    def _announce(self) -> None:
        """Report that all have acknowledged, or the overdue movers: each once."""
        state = self.state()
        found = (not state.waiting, state.overdue)
        if found == self._announced or self._releasing:
            return
        self._announced = found
        if state.overdue:
            self._news.append(("estop_overdue", "executive", state.text, "error"))
        elif state.engaged and not state.waiting:
            self._news.append(("estop_acknowledged", "executive", state.text, "info"))

    def _repeat(self, now: float) -> float:
        if now >= self._repeat_at:
            self._repeat_at = now + (REPEAT_S if now < self._repeat_until else REPEAT_LATER_S)
            if not self._releasing:
                request = EstopRequest(engaged=True, reason=self._reason)
                wire.put(
                    self._session,
                    keys.estop(self._robot),
                    request,
                    source=self._source or "executive",
                    urgent=True,
                    to_others=True,  # a stop that is received here counts as a press
                )
        return self._repeat_at

    def close(self) -> None:
        """Store a latch that is not stored yet, and leave the bus."""
        if self._unsaved:
            self._save(time.monotonic())
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._session.close()

    def _latched(self) -> bool:
        return self._engaged and self._save_tried and not self.state().waiting

    def _save(self, now: float) -> None:
        with self._changed:
            self._unsaved, why = False, ""
            engaged, reason = self._engaged, self._reason
        try:
            self._persist(engaged, reason)
        except LbrError as err:
            why = str(err)
        self._journal.trouble(NOT_SAVED, why)
        with self._changed:
            if not self._unsaved:  # or it has changed meanwhile, and that is not stored yet
                self._save_tried = True
            if why:
                self._unsaved, self._save_at = True, now + 1.0
            self._changed.notify_all()

    def _hear_presses(self) -> None:
        """Latch at once, on the bus's own thread; the executive's thread may be waiting for the disk."""
        with self._changed:
            for raw in self._presses.take():
                self._pressed(raw, time.monotonic())
            self._changed.notify_all()
        self._wake()

    def _hear_resets(self) -> None:
        for request in self._resets.take():
            with contextlib.suppress(RuntimeError):  # it is closed: the robot shuts down
                self._pool.submit(self._answer_reset, request)

    def _answer_reset(self, request: wire.Request) -> None:
        found = stamp.read(request.attachment)
        waited_s = found.waited_s if found is not None else 0.0
        why_not = self.release(sender(found), stamp.sent_s(found, request.arrived) - waited_s)
        request.reply({"accepted": why_not is None, "reason": why_not.text if why_not else RELEASED}, "executive")

    def _hear_acknowledgements(self) -> None:
        with self._changed:
            for raw in self._said.take():
                self._note(raw)
            self._changed.notify_all()
        self._wake()

    def _pressed(self, raw: wire.RawMessage, now: float) -> None:
        source = sender(stamp.read(raw.attachment))
        try:
            request = _requests.decode(raw.payload)
        except MalformedError:
            request = EstopRequest(engaged=True, reason="an emergency stop that could not be read")
        if not request.engaged:
            text = f"{source} put 'not engaged' on @estop; only a query on @estop/reset releases it"
            self._news.append(("refused", "estop", text, "warning"))
            return
        self._latch(request.reason or "pressed", source, now)

    def _latch(self, reason: str, source: str, now: float) -> None:
        self._count += 1
        self._halts = self._halts.noted(now, source[:80])
        self._alone.clear()
        self._repeat_until = now + REPEAT_FOR_S
        if not self._engaged:
            self._stopped.clear()
            self._announced = False, ()  # all may have acknowledged before the next look
            self._latched_at = now
            self._engaged, self._reason, self._source = True, reason, source[:80]
            self._unsaved, self._save_tried, self._save_at = True, False, 0.0
            self._news.append(("estop", "executive", f"emergency stop by {source}: {self._reason}", "error"))

    def _note(self, raw: wire.RawMessage) -> None:
        try:
            acknowledgement = _acknowledgements.decode(raw.payload)
        except MalformedError:
            return
        mover = raw.key.rpartition("/")[2]  # the bus guarantees whose key it is; the content proves nothing
        self._within_s[mover] = acknowledgement.within_s
        (self._stopped.add if acknowledgement.stopped and acknowledgement.engaged else self._stopped.discard)(mover)
        if acknowledgement.engaged and not self._engaged and not self._releasing:
            self._alone.setdefault(mover, time.monotonic())
        else:
            self._alone.pop(mover, None)


def in_words(state: EstopState) -> EstopState:
    """Return the latch with its text: who has acknowledged it, still has time to, or has not."""
    if state.overdue:
        how = f"{', '.join(state.overdue)} has not acknowledged: use the hardware switch"
    elif state.waiting:
        how = f"waiting for {', '.join(state.waiting)}"
    else:
        how = f"acknowledged by {', '.join(state.acknowledged)}"
    return replace(state, text=f"emergency stop: {how}")


def _not_released(name: str, asked: wire.PendingQuery) -> str:
    if any(b'"accepted":true' in answer.payload for answer in asked.replies):
        return ""
    why = "; ".join(answer.payload.decode(errors="replace") for answer in asked.replies) or "no answer"
    return f"'{name}' did not release its emergency stop ({why}); it stays latched"
