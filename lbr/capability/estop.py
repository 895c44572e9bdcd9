"""The emergency stop inside a process that moves something: a latch fed by a session of its own."""

import threading
from collections import deque
from collections.abc import Callable

from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.transport import Transport
from lbr.capability.config import ProcessConfig
from lbr.capability.send_times import SendTimes
from lbr.errors import MalformedError
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply, refused
from lbr.messages.system import EstopAcknowledgement, EstopRelease, EstopRequest

FOLLOWS_S = 0.3
"""The wait of a release for movers that are not armed yet; a device may be missing."""
PRESSED_AGAIN = Reason("estop", "it was pressed again meanwhile")
_decoder = Decoder(EstopRequest)
_release_words = Decoder(EstopRelease)


class EstopLatch:
    """Latches on anything that is not a well-formed "not engaged"; only the executive's sealed release unlatches it.

    `by` was the last to press or reset it. `follows` is whether the mover would accept a command after a release; the
    answer to a release waits for that, for a short time. `within_s` is how long the device may take to acknowledge.
    """

    def __init__(self, config: ProcessConfig, wake: Callable[[], None], within_s: float, bus: Transport) -> None:
        self.engaged = config.estop.engaged
        self.reason = config.estop.reason
        self.by, self.follows = "", True
        self._released: deque[tuple[wire.Request, float]] = deque()
        self._name = config.name
        self._release_key = bytes.fromhex(config.release_key)
        self._wake = wake
        self._within_s = within_s
        self._sent: EstopAcknowledgement | None = None
        self._again = False
        self._noticed = False
        self._lock = threading.Lock()
        self._releases = SendTimes()
        self._pressed_ns = self._released_ns = int(bus.clock() * 1e9)
        self._bus = bus
        self._ack_key = keys.estop_acknowledgement(config.robot, config.name)
        self._presses = bus.subscribe(keys.estop(config.robot), depth=8, wake=self._press)
        release = keys.estop_release(config.robot, config.name)
        self._release = bus.serve(release, wake, puts=False, source=config.name)

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Report whether the device has acknowledged the stop, at each change and each repetition of the stop."""
        with self._lock:
            self._noticed = self.engaged
        answer = EstopAcknowledgement(
            capability=self._name, engaged=self.engaged, stopped=stopped, reason=reason, within_s=self._within_s
        )
        if answer != self._sent or self._again:
            self._sent, self._again = answer, False
            self._bus.put(self._ack_key, answer, source=self._name)

    def serve(self) -> None:
        """Answer releases; the process's loop calls it."""
        self._answer_releases()
        for request in self._release.take():
            with self._lock:
                why_not = self._why_not(request)
                if not why_not:
                    self.by, self.follows = _released_by(request.payload), True
                    self.engaged, self.reason, self._sent, self._noticed = False, "", None, False
            if why_not:
                request.reply(refused(why_not), self._name)
            else:
                self._released.append((request, self._bus.clock() + FOLLOWS_S))

    def _answer_releases(self) -> None:
        """Answer the releases of earlier rounds: by now, `follows` is up to date."""
        while self._released and (self.engaged or self.follows or self._bus.clock() >= self._released[0][1]):
            request, _until = self._released.popleft()
            request.reply(refused(PRESSED_AGAIN) if self.engaged else CommandReply(accepted=True), self._name)

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _press(self) -> None:
        for message in self._presses.take():
            reason = _reason(message.payload)
            if reason is not None:
                with self._lock:
                    self._noticed = self._noticed and self.engaged
                    self.by = _source(message)
                    self.reason, self.engaged, self._again = reason or "pressed", True, True
                    self._pressed_ns = max(self._pressed_ns, _sent_ns(message))
        self._wake()

    def _why_not(self, request: wire.Request) -> Reason | None:
        """Return why a release is invalid: it must be the executive's, be new, and come after the last press."""
        sent = stamp.read(request.attachment)
        if sent is None or not stamp.genuine(sent, request.payload, self._release_key):
            return Reason("denied", "only the executive releases")
        sent_ns = int(stamp.sent_s(sent, request.arrived) * 1e9)
        if not self._releases.newer(sent) or sent_ns <= max(self._released_ns, self._pressed_ns):
            return PRESSED_AGAIN
        if self.engaged and not self._noticed:  # a stop always lasts long enough to stop everything
            return Reason("not_ready", "it has not stopped yet")
        self._released_ns = sent_ns
        return None


def _reason(payload: bytes) -> str | None:
    try:
        request = _decoder.decode(payload)
    except MalformedError:
        return "an emergency stop that could not be read"
    return request.reason if request.engaged else None


def _source(message: wire.RawMessage) -> str:
    found = stamp.read(message.attachment)
    return found.source[:80] if found is not None else ""


def _released_by(payload: bytes) -> str:
    try:
        return _release_words.decode(payload).by
    except MalformedError:
        return ""


def _sent_ns(message: wire.RawMessage) -> int:
    """Return when a press was made: one that was long on its way must not undo a later release."""
    return int(stamp.sent_s(stamp.read(message.attachment), message.arrived) * 1e9)


class NothingToStop:
    """The emergency stop of a capability that moves nothing: never engaged, costs no session."""

    engaged = False
    reason = by = ""
    follows = True

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Do nothing."""

    def serve(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""
