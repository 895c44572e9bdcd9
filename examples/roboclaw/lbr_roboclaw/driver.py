"""A RoboClaw on its serial line, and the capability that drives two wheels by it."""

import struct
from collections.abc import Callable
from math import inf, isfinite

from lbr.capability.context import Device
from lbr.drivers.serial_line import SerialLine, open_line
from lbr.drivers.wheels.capability import Wheels
from lbr.drivers.wheels.contract import GuardStop, Measured
from lbr.errors import DeviceError
from lbr_roboclaw import protocol as wire
from lbr_roboclaw.kind import Motor, RoboclawSettings

SETUP_TRIES = 5
LOST_IN_A_ROW = 4
PACKET_PAUSE_S = 0.012
"""After 10 ms without a byte, the controller drops an incomplete request."""
BELIEVED_S = 1.0
ROTATION = (wire.STATUS, wire.CURRENTS, wire.ENCODERS, wire.STATUS, wire.BATTERY, wire.TEMPERATURE, wire.GET_TIMEOUT)


class Controller:
    """One RoboClaw on an open line; see `lbr.drivers.wheels.contract.WheelController`.

    Its acknowledgement is one byte without reference to a request. After a lost answer, an acknowledgement therefore
    counts only once an answer with a CRC has shown that both sides are in step again.
    """

    def __init__(
        self, line: SerialLine, settings: RoboclawSettings, clock: Callable[[], float], beat: Callable[[], None]
    ) -> None:
        self.lost = 0
        self.refused = 0  # it is silent instead
        self.applied: tuple[float, ...] = (0.0, 0.0)
        self.asked: tuple[float, ...] = (0.0, 0.0)
        self.resting = False
        self.turning = False
        self.firmware = ""
        self._line = line
        self._settings = settings
        self._clock = clock
        self._beat = beat
        self._known = False
        self._in_step = True
        self._lost_in_a_row = 0
        self._fed = -inf
        self._turn = 0
        self._read: dict[int, tuple[bytes, float]] = {}

    def open(self) -> None:
        """Identify it, write zero, then set its watchdog and read it back."""
        self._line.drop_output()
        self._line.low_latency()
        version = self._insist(wire.VERSION, "does not answer; check cable, power, address and packet serial mode")
        self.firmware = version.rstrip(b"\n\0").decode("ascii", "replace")
        if "RoboClaw" not in self.firmware:
            raise self._wrong(f"says it is '{self.firmware}', and no RoboClaw; correct the address of its row")
        self._known = True
        if not any(self.stop() for _ in range(SETUP_TRIES)):
            raise self._wrong("does not acknowledge zero")
        steps = self._settings.watchdog_ms // wire.TIMEOUT_STEP_MS
        self._write(wire.request(self._settings.address, wire.SET_TIMEOUT, bytes((steps,))))
        if (found := self._insist(wire.GET_TIMEOUT, "does not tell its serial timeout")[0]) != steps:
            raise self._wrong(f"has a serial timeout of {found / 10:g} s, not the {steps / 10:g} s that were set")
        self._insist(wire.STATUS, "does not tell its status")

    def close(self) -> bool:
        """Write zero and close the line; return whether that was acknowledged, or no motor can turn."""
        try:
            return not self._known or any(self._zeroed() for _ in range(3))
        except DeviceError:
            return True  # the line is gone, for all its users
        finally:
            self._line.close()

    def fileno(self) -> int:
        """Return the descriptor of its line."""
        return self._line.fileno()

    @property
    def guard_stop(self) -> GuardStop:
        """Return the bytes with which its guard stops it."""
        return GuardStop(wire.duty(self._settings.address, 0.0, 0.0), wire.ACKNOWLEDGED)

    def drive(self, *powers: float) -> None:
        """Write the power of left and right; after a lost answer, ask a harmless question first."""
        if not all(map(isfinite, powers)):
            self.stop()
            return
        if not self._in_step and self._ask(wire.STATUS) is None:
            self._complain()
            return
        self.turning = self.turning or any(powers)
        if self._power(*powers):
            self.turning = any(powers)

    def stop(self) -> bool:
        """Write zero; return whether it was acknowledged."""
        stopped = self._zeroed()
        self._complain()
        return stopped

    emergency_stop = stop
    """It has no latch that the line could set: the robot's own keeps it at zero."""
    release = stop

    def poll(self) -> None:
        """Ask for the next value of the rotation."""
        self._ask(ROTATION[self._turn % len(ROTATION)])
        self._turn += 1
        self._complain()
        steps = self._fresh(wire.GET_TIMEOUT)
        if steps is not None and steps[0] * wire.TIMEOUT_STEP_MS != self._settings.watchdog_ms:
            raise self._wrong("has lost its serial timeout, as after a restart; opening it again")

    @property
    def fed_s_ago(self) -> float:
        """Return the seconds since a motor command was last written."""
        return self._clock() - self._fed

    @property
    def faults(self) -> tuple[str, ...] | None:
        """Return the names of its faults; None: not known."""
        status = self._fresh(wire.STATUS)
        return None if status is None else wire.faults(status)

    @property
    def grave(self) -> tuple[str, ...]:
        """Return the faults that the row does not tolerate."""
        return tuple(name for name in self.faults or () if name not in self._settings.tolerated_faults)

    def faults_after(self, when: float) -> tuple[str, ...] | None:
        """Return no faults: it keeps no latch that could be lost."""

    def measured(self) -> Measured:
        """Return its last measurements."""
        battery, heat = self._numbers(wire.BATTERY, ">H"), self._numbers(wire.TEMPERATURE, ">H")
        amps, counts = self._numbers(wire.CURRENTS, ">hh"), self._numbers(wire.ENCODERS, ">ii")
        left, right = self._settings.left, self._settings.right
        return Measured(
            voltage_v=battery[0] / 10 if battery else None,
            temperature_c=heat[0] / 10 if heat else None,
            amps_left_a=amps[left.channel - 1] * left.direction / 100 if amps else None,
            amps_right_a=amps[right.channel - 1] * right.direction / 100 if amps else None,
            counts_left=counts[left.channel - 1] * left.direction if counts else None,
            counts_right=counts[right.channel - 1] * right.direction if counts else None,
            faults=self.faults or (),
        )

    def _zeroed(self) -> bool:
        """Write zero; if an acknowledgement would prove nothing, read back that no motor has power."""
        stopped = self._power(0.0, 0.0)
        if not self._in_step:
            stopped = self._ask(wire.PWM) == bytes(4)
        if stopped:
            self.applied, self.resting, self.turning = (0.0, 0.0), True, False
        return stopped

    def _power(self, left: float, right: float) -> bool:
        self.asked, self.resting, self._fed = (left, right), False, self._clock()
        channels = [0.0, 0.0]
        for motor, power in ((self._settings.left, left), (self._settings.right, right)):
            channels[motor.channel - 1] = self._limited(motor, power) * motor.direction
        done = self._write(wire.duty(self._settings.address, channels[0], channels[1]))
        if done:
            self.applied = (self._limited(self._settings.left, left), self._limited(self._settings.right, right))
        return done

    @staticmethod
    def _limited(motor: Motor, power: float) -> float:
        return max(-motor.max_power, min(motor.max_power, power))

    def _write(self, request: bytes) -> bool:
        """Write a request with an acknowledgement; return whether that came."""
        trusted = self._in_step
        heard = self._exchange(request, lambda heard: heard or None, 1)
        self._in_step = trusted and heard == wire.ACKNOWLEDGED
        return self._in_step

    def _ask(self, command: int) -> bytes | None:
        """Ask for a value, whose CRC shows that both sides are in step."""
        address = self._settings.address
        data = self._exchange(
            wire.request(address, command), lambda heard: wire.answered(address, command, heard), wire.longest(command)
        )
        if data is not None:
            self._in_step = True
            self._read[command] = (data, self._clock())
        return data

    def _exchange(self, request: bytes, understood: Callable[[bytes], bytes | None], most: int) -> bytes | None:
        """Write a request and return the decoded answer; None without one in time."""
        self._line.drop_input()
        self._beat()
        self._line.write(request)
        until, heard = self._clock() + self._settings.reply_timeout_s, b""
        while len(heard) <= most and (left_s := until - self._clock()) > 0.0:
            heard += self._line.read(left_s)
            if (found := understood(heard)) is not None:
                self._lost_in_a_row = 0
                return found
        self.lost += 1
        self._lost_in_a_row += 1
        self._in_step = False
        self._line.drop_output()
        return None

    def _insist(self, command: int, trouble: str) -> bytes:
        """Ask until it answers; a first request may complete a half-written one."""
        for _ in range(SETUP_TRIES):
            if (data := self._ask(command)) is not None:
                return data
            self._line.read(PACKET_PAUSE_S)
        raise self._wrong(trouble)

    def _complain(self) -> None:
        if self._lost_in_a_row >= LOST_IN_A_ROW:
            raise self._wrong(f"left {self._lost_in_a_row} commands unanswered; check cable and power")

    def _wrong(self, trouble: str) -> DeviceError:
        return DeviceError(f"{self._line.name} {trouble}")

    def _fresh(self, command: int) -> bytes | None:
        data, taken = self._read.get(command, (b"", -inf))
        return data if self._clock() - taken < BELIEVED_S else None

    def _numbers(self, command: int, form: str) -> tuple[int, ...] | None:
        data = self._fresh(command)
        return None if data is None else struct.unpack(form, data)


class Roboclaw(Wheels[RoboclawSettings]):
    """Two wheels on a RoboClaw."""

    def connect(self, device: Device, beat: Callable[[], None]) -> Controller:
        """Open its serial line."""
        return Controller(open_line(device, self.ctx.settings.baud), self.ctx.settings, self.ctx.clock, beat)
