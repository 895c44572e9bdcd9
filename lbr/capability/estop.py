"""The emergency stop inside a process that moves something: a latch fed by a session of its own."""

from collections.abc import Callable

import msgspec

from lbr.bus import keys, session, stamp, wire
from lbr.capability.config import ProcessConfig
from lbr.messages.system import EstopAcknowledgement, EstopRequest

_decoder = msgspec.json.Decoder(EstopRequest)


class EstopLatch:
    """Latches on anything that is not a well-formed "not engaged"; only the executive's sealed release lets go."""

    def __init__(self, config: ProcessConfig, wake: Callable[[], None]) -> None:
        self.engaged = config.estop.engaged
        self.reason = config.estop.reason
        self._name = config.name
        self._release_key = bytes.fromhex(config.release_key)
        self._wake = wake
        self._said: EstopAcknowledgement | None = None
        self._again = False
        self._noticed = False
        self._releases = 0
        self._session = session.open_client(config.endpoints)
        self._ack_key = keys.estop_acknowledgement(config.robot, config.name)
        self._pressed = wire.Subscription(self._session, keys.estop(config.robot), depth=8, wake=self._press)
        release = keys.estop_release(config.robot, config.name)
        self._release = wire.Served(self._session, release, wake, puts=False, source=config.name)

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Say whether the device has acknowledged the stop; sent when that changes or when the stop is repeated."""
        self._noticed = self.engaged
        said = EstopAcknowledgement(capability=self._name, engaged=self.engaged, stopped=stopped, reason=reason)
        if said != self._said or self._again:
            self._said, self._again = said, False
            wire.put(self._session, self._ack_key, said, source=self._name, urgent=True)

    def serve(self) -> None:
        """Answer releases; called by the process's loop."""
        for request in self._release.take():
            found = stamp.read(request.attachment)
            proven = stamp.genuine(found, request.payload, self._release_key) and found is not None
            if not proven or found is None or found.mono_ns <= self._releases:
                request.reply({"accepted": False, "reason": "only the executive releases"}, self._name)
            elif self.engaged and not self._noticed:  # a stop is never so short that nobody stopped
                request.reply({"accepted": False, "reason": "it has not stopped yet"}, self._name)
            else:
                self._releases = found.mono_ns
                self.engaged, self.reason, self._said, self._noticed = False, "", None, False
                request.reply({"accepted": True}, self._name)

    def close(self) -> None:
        """Leave the bus."""
        self._session.close()

    def _press(self) -> None:
        for message in self._pressed.take():
            reason = self._reason(message.payload)
            if reason is not None:
                self.reason = reason or "pressed"
                self.engaged = True
                self._again = True
        self._wake()

    @staticmethod
    def _reason(payload: bytes) -> str | None:
        try:
            request = _decoder.decode(payload)
        except msgspec.DecodeError:
            return "an emergency stop that could not be read"
        return request.reason if request.engaged else None


class NothingToStop:
    """The emergency stop of a capability that moves nothing: never engaged, costs no session."""

    engaged = False
    reason = ""

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Do nothing."""

    def serve(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""
