"""The contract between a controller of wheels and the capability that drives it."""

from typing import NamedTuple, Protocol, TypedDict

EMERGENCY_STOP = "emergency_stop"
"""The fault of an engaged emergency stop of the controller's own."""


class GuardStop(NamedTuple):
    """The bytes by which the guard stops the motors, and the controller's acknowledgement; empty if it sends none."""

    request: bytes
    acknowledged: bytes = b""


class Measured(TypedDict, total=False):
    """The measured fields of MotorsState; a missing field, or None, is not measured.

    A controller of motors other than `left` and `right` fills `motor_amps_a` and `motor_counts`, in their order.
    """

    voltage_v: float | None
    internal_v: float | None
    output_v: float | None
    amps_left_a: float | None
    amps_right_a: float | None
    counts_left: int | None
    counts_right: int | None
    temperature_c: float | None
    faults: tuple[str, ...]
    motor_amps_a: tuple[float | None, ...]
    motor_counts: tuple[int | None, ...]


class WheelController(Protocol):
    """A controller of some motors on its line. Powers are -1..1, forward positive. Every problem is a DeviceError with
    its cure.

    A call usually takes a few milliseconds, and never delays a stop by more than 30 ms: the same loop stops the wheels.
    An unacknowledged command counts as lost, and the capability repeats it. The controller calls `beat`, which it gets
    from `connect`, before every write.
    """

    lost: int
    """Unanswered commands since it was opened."""
    refused: int
    """Refused commands since it was opened."""
    applied: tuple[float, ...]
    """The power of each motor that the controller acknowledged last, in the order of `Wheels.motors`."""
    asked: tuple[float, ...]
    """The powers that were written last."""
    resting: bool
    """True once zero was acknowledged, until the next write."""
    turning: bool
    """True if a wheel may turn: from before a power is written until zero was acknowledged. The guard relies on it."""

    def open(self) -> None:
        """Identify it, write zero, then write the settings on which safety rests, above all its watchdog, and read them
        back."""

    def close(self) -> bool:
        """Write zero and close the line; return whether it was acknowledged, or nothing can turn.

        It must not raise, even if the line is lost, and must not leave the line open. It must not return True for a
        zero that was only written: the guard would be dismissed, and the motors not stopped. It must not end an
        emergency stop.
        """

    def fileno(self) -> int:
        """Return the descriptor of its line, which the guard holds too."""

    @property
    def guard_stop(self) -> GuardStop:
        """Return the bytes that its guard writes to stop it."""

    def drive(self, *powers: float) -> None:
        """Write the power of each motor; if one is not finite, zero to all."""

    def stop(self) -> bool:
        """Write zero as soon as the line is free; return whether it was acknowledged."""

    def emergency_stop(self) -> bool:
        """Cut the power, by its own latch if it has one, and write zero; return whether the cut was acknowledged."""

    def release(self) -> bool:
        """Write zero, then end its emergency stop; return whether both were acknowledged."""

    def poll(self) -> None:
        """Query its next measured value, unless an answer is due."""

    @property
    def fed_s_ago(self) -> float:
        """Return the seconds since a motor command was last written; inf before the first."""

    @property
    def faults(self) -> tuple[str, ...] | None:
        """Return its faults by name, EMERGENCY_STOP among them; None if unknown, so that nothing may move."""

    @property
    def grave(self) -> tuple[str, ...]:
        """Return its faults that forbid motion."""

    def faults_after(self, when: float) -> tuple[str, ...] | None:
        """Return the faults if they were read after `when`; None if it keeps no latch that could be lost."""

    def measured(self) -> Measured:
        """Return the last measurements, as long as they are fresh enough."""
