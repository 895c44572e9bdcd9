"""The controller as a device: started in a safe order, driven one command at a time, stopped in every case."""

import re
from collections.abc import Callable
from math import inf, isfinite

from lbr.drivers.echoed_lines import MAX_LINE_BYTES, query
from lbr.drivers.roboteq import RoboteqSettings, Wheel
from lbr.drivers.roboteq import protocol as wire
from lbr.drivers.roboteq.exchange import Exchange, Line, Outcome
from lbr.drivers.roboteq.readings import setting
from lbr.drivers.roboteq.telemetry import Telemetry
from lbr.drivers.wheels.contract import EMERGENCY_STOP, GuardStop, Measured
from lbr.errors import DeviceError

PATIENCE_S = 0.005
URGENT_PATIENCE_S = 0.03
SETUP_TIMEOUT_S = 0.1
CLOSING_TIMEOUT_S = 0.02
SETUP_TRIES = 3
LOST_IN_A_ROW = 4
REFUSED_IN_A_ROW = 5
ROTATION: tuple[bytes, ...] = (
    *(query(name) for name in ("FF", "A", "C", "V", "FF", "A", "C", "T", "FF")),
    wire.read_setting("RWD"),
)


class Controller:
    """One Roboteq on an open line. Every problem with it is a DeviceError with its cure.

    `turning` is true from before a power is written until zero is acknowledged. `beat` is called before every write.
    """

    def __init__(
        self,
        line: Line,
        settings: RoboteqSettings,
        clock: Callable[[], float],
        beat: Callable[[], None] = lambda: None,
    ) -> None:
        self.firmware = ""
        self.model = ""
        self.applied: tuple[float, ...] = (0.0, 0.0)
        self.asked: tuple[float, ...] = (0.0, 0.0)
        self.resting = False
        self.turning = False
        self.refused = 0
        self.lost = 0
        self.telemetry = Telemetry(settings, clock)
        self._line = line
        self._settings = settings
        self._clock = clock
        self._beat = beat
        self._exchange = Exchange(line, clock)
        self._lost_in_a_row = 0
        self._refused_in_a_row = 0
        self._fed = -inf
        self._turn = 0
        self._foreign_watchdogs = 0
        self._known = False

    def open(self) -> None:
        """Identify it, write zero, then write the settings on which safety rests and read them back."""
        self._line.drop_output()
        self._line.drop_input()
        self._identify()
        self._insist(wire.STOP, "did not acknowledge zero")
        self._insist(wire.write_setting("ECHOF", 0 if self._settings.echo else 1), "refuses to set its echo")
        self._exchange.learn_echo()
        self._insist(wire.write_setting("RWD", self._settings.watchdog_ms), "refuses to set its watchdog")
        self._verify("RWD", self._settings.watchdog_ms, "watchdog, in ms")
        if self._settings.mixing_mode is not None:
            self._verify("MXMD", self._settings.mixing_mode, "mixing mode; set it with Roboteq's utility")
        self._ask(query("FF"), SETUP_TRIES)

    def drive(self, *powers: float) -> None:
        """Write the power of left and right, unless an answer is still due; after a gap, zero first."""
        left_power, right = powers if all(map(isfinite, powers)) else (0.0, 0.0)
        if not self._settle(PATIENCE_S) or not self._responds():
            return
        if self._gap():
            self.stop()
            return
        self.asked = (left_power, right)
        self._send(self._motors(left_power, right))
        self._settle(PATIENCE_S)

    def stop(self) -> bool:
        """Write zero as soon as the line is free; return whether it was acknowledged."""
        self.asked = (0.0, 0.0)
        stopped = self._urgent(wire.STOP)
        self._complain()
        return stopped

    def emergency_stop(self) -> bool:
        """Cut the power stage and write zero; return whether the cut was acknowledged."""
        self.asked = (0.0, 0.0)
        cut = self._urgent(wire.EMERGENCY_STOP)
        self._urgent(wire.STOP)
        self._complain()
        return cut

    def release(self) -> bool:
        """Write zero, then end the emergency stop; return whether both were acknowledged."""
        if not self.stop() or not self._urgent(wire.RELEASE):
            return False
        self.telemetry.forget_faults()
        self._ask(query("FF"), 1)
        return True

    def fileno(self) -> int:
        """Return the descriptor of its line."""
        return self._line.fileno()

    @property
    def guard_stop(self) -> GuardStop:
        """Return the bytes that its guard writes to stop it."""
        return GuardStop(wire.STOP, wire.ACKNOWLEDGED)

    @property
    def faults(self) -> tuple[str, ...] | None:
        """Names of the set fault bits; None if unknown."""
        return self.telemetry.faults

    @property
    def grave(self) -> tuple[str, ...]:
        """Names of the set fault bits that the row does not tolerate."""
        return tuple(name for name in self.faults or () if name not in self._settings.tolerated_faults)

    def faults_after(self, when: float) -> tuple[str, ...] | None:
        """Return the fault bits if they were read after `when`."""
        return self.telemetry.faults_after(when)

    def measured(self) -> Measured:
        """Return the last measurements, as long as they are fresh enough."""
        return self.telemetry.measured()

    def poll(self) -> None:
        """Send the next query of the rotation, if no answer is due."""
        if not self._settle(0.0):
            return
        query = ROTATION[self._turn % len(ROTATION)]
        self._turn += 1
        self._send(query)
        self._settle(PATIENCE_S)

    @property
    def fed_s_ago(self) -> float:
        """Seconds since a motor command was last written."""
        return self._clock() - self._fed

    def close(self) -> bool:
        """Write zero and close the line; return whether it was acknowledged, or no motor can turn."""
        try:
            return not self._known or self._zeroed()
        except DeviceError:
            return True  # the line is gone, for its other holders too
        finally:
            self._line.close()

    def _zeroed(self) -> bool:
        tries = 1 if self._lost_in_a_row else 3
        if any(self._urgent(wire.STOP, CLOSING_TIMEOUT_S) for _ in range(tries)):
            return True
        self._line.drop_output()  # closing a line waits for its output, for half a minute
        return False

    def _identify(self) -> None:
        said = self._ask(query("FID"), SETUP_TRIES)
        if said is None or said.value is None:
            raise DeviceError(self._sentence(f"{self._babbles}does not answer ?FID; check cable, power and address"))
        self.firmware = _text(said)
        self.model = _text(self._ask(query("TRN"), 1))
        for field, identity, pattern in (
            ("firmware", self.firmware, self._settings.firmware),
            ("model", self.model, self._settings.model),
        ):
            if not re.search(pattern, identity):
                raise DeviceError(
                    self._sentence(f"says {field} '{identity}', expected /{pattern}/; correct the address or `{field}`")
                )
        if wire.is_inertial_unit(f"{self.firmware} {self.model}"):
            what = f"has firmware '{self.firmware}': it is an inertial unit (kind riox); correct the address"
            raise DeviceError(self._sentence(what))
        self._known = True

    def _insist(self, command: bytes, trouble: str) -> None:
        for _ in range(SETUP_TRIES):
            if self._urgent(command, SETUP_TIMEOUT_S):
                return
        raise DeviceError(self._sentence(f"{trouble} ({command.decode('ascii').strip()})"))

    def _verify(self, name: str, expected: int, meaning: str) -> None:
        outcome = self._ask(wire.read_setting(name), SETUP_TRIES)
        value = setting(outcome.value.text) if outcome and outcome.value else None
        if value != expected:
            said = "no number" if value is None else str(value)
            raise DeviceError(self._sentence(f"answers ~{name} with {said}, expected {expected} ({meaning})"))

    def _ask(self, query: bytes, tries: int) -> Outcome | None:
        """Query, several times: the first may end a half-written line, and be refused with it."""
        for _ in range(tries):
            self._send(query, SETUP_TIMEOUT_S)
            outcome = self._exchange.finish(SETUP_TIMEOUT_S)
            if outcome.value is not None:
                self._note(outcome)
                return outcome
        return None

    def _urgent(self, command: bytes, timeout_s: float | None = None) -> bool:
        """Write a command, after the one in progress if that ends soon; return whether it was acknowledged."""
        self._line.drop_output()
        limit = self._settings.reply_timeout_s if timeout_s is None else timeout_s
        if self._exchange.busy:
            self._note(self._exchange.finish(min(limit, URGENT_PATIENCE_S)))
        self._send(command, limit)
        outcome = self._exchange.finish(limit)
        self._note(outcome)
        return outcome.result == "acknowledged"

    def _send(self, command: bytes, timeout_s: float | None = None) -> None:
        if command[:1] == b"!":
            self._fed = self._clock()
            self.resting = False
            self.turning = self.turning or (command.startswith(b"!M ") and command != wire.STOP)
        self._beat()
        self._exchange.send(command, self._settings.reply_timeout_s if timeout_s is None else timeout_s)

    def _settle(self, budget_s: float) -> bool:
        """Wait for the exchange in progress, within the budget; return whether the line is free."""
        outcome = self._exchange.wait(budget_s)
        if outcome is not None:
            self._note(outcome)
            self._complain()
        return not self._exchange.busy

    def _responds(self) -> bool:
        """Return whether it answers; after a lost answer query it first, so that commands do not pile up at a deaf
        controller."""
        if self._lost_in_a_row:
            self._send(query("FF"))
            self._settle(PATIENCE_S)
        return not self._lost_in_a_row and not self._exchange.busy

    def _note(self, outcome: Outcome) -> None:
        if outcome.result == "lost":
            self.lost += 1
            self._lost_in_a_row += 1
            self._line.drop_output()
            return
        self._lost_in_a_row = 0
        if outcome.value is not None:
            self.telemetry.take(outcome.value)
            if outcome.value.name == "RWD":
                self._note_watchdog()
        elif outcome.command.startswith(b"!"):
            self._note_command(outcome)

    def _note_watchdog(self) -> None:
        if self.telemetry.watchdog_ms == self._settings.watchdog_ms:
            self._foreign_watchdogs = 0
            return
        self._foreign_watchdogs += 1
        self._turn = ROTATION.index(wire.read_setting("RWD"))

    def _note_command(self, outcome: Outcome) -> None:
        if outcome.result == "refused":
            self.refused += 1
            self._refused_in_a_row += 1
            return
        self._refused_in_a_row = 0
        if outcome.command.startswith(b"!M "):
            self.applied = self._powers(outcome.command)
            self.resting = outcome.command == wire.STOP
            self.turning = self.turning and not self.resting

    def _complain(self) -> None:
        if self._lost_in_a_row >= LOST_IN_A_ROW:
            left = f"{self._babbles}left {self._lost_in_a_row} commands unanswered"
            raise DeviceError(self._sentence(f"{left}; check cable and power"))
        latched = EMERGENCY_STOP in (self.telemetry.faults or ())
        if self._refused_in_a_row >= REFUSED_IN_A_ROW and not latched:
            raise DeviceError(self._sentence(f"refused {self._refused_in_a_row} commands in a row; check its set-up"))
        if self._foreign_watchdogs >= 2:  # a single one may be a misread digit
            found, expected = self.telemetry.watchdog_ms, self._settings.watchdog_ms
            raise DeviceError(self._sentence(f"has a watchdog of {found} ms, expected {expected}: was reset"))

    @property
    def _babbles(self) -> str:
        heard = self._exchange.babble_bytes
        return f"babbles ({heard} bytes that answer nothing) and " if heard > MAX_LINE_BYTES else ""

    def _gap(self) -> bool:
        return not self.fed_s_ago < self._settings.watchdog_ms / 1000.0

    def _motors(self, left: float, right: float) -> bytes:
        settings = self._settings
        values = {
            wheel.channel: wire_value(power, wheel) for power, wheel in ((left, settings.left), (right, settings.right))
        }
        return wire.motors(values[1], values[2])

    def _powers(self, command: bytes) -> tuple[float, float]:
        values = [int(field) for field in command.split()[1:]]
        left_power, right = (
            values[wheel.channel - 1] * wheel.direction / wire.FULL_SCALE
            for wheel in (self._settings.left, self._settings.right)
        )
        return left_power, right

    def _sentence(self, what: str) -> str:
        return f"device '{self._settings.device}': the controller {what}"


def wire_value(power: float, wheel: Wheel) -> int:
    """Return the number for a wheel's channel at a power, forward positive; the last limit before the wire."""
    if not isfinite(power):
        return 0
    limited = max(-wheel.max_power, min(wheel.max_power, power * wheel.trim))
    return round(limited * wire.FULL_SCALE) * wheel.direction


def _text(outcome: Outcome | None) -> str:
    return outcome.value.text.strip() if outcome and outcome.value else ""
