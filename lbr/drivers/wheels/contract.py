"""The duties of a controller of wheels for the capability that drives it."""

from typing import NamedTuple, Protocol, TypedDict

EMERGENCY_STOP = "emergency_stop"
"""The fault that says that the controller's own emergency stop is engaged."""


class GuardStop(NamedTuple):
    """The bytes by which the guard stops the motors, and the controller's acknowledgement; empty: it gives none."""

    request: bytes
    acknowledged: bytes = b""


class Measured(TypedDict, total=False):
    """The measured fields of MotorsState; what is left out, or None, is not measured.

    A controller of other motors than `left` and `right` tells of each in `motor_amps_a` and `motor_counts`, in their
    order.
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

    No call may take longer than a few milliseconds in the usual case, nor hold up a stop for longer than 30 ms ever:
    the loop that calls it is what stops the wheels. Commands that are not acknowledged count as lost, and are repeated
    by the capability. `beat`, which it gets from `connect`, is to be called before everything that is written.
    """

    lost: int
    """Commands that nothing answered since it was opened."""
    refused: int
    """Commands that the controller refused since it was opened."""
    applied: tuple[float, ...]
    """The power of each motor that the controller acknowledged last, in the order of `Wheels.motors`."""
    asked: tuple[float, ...]
    """The powers that were written last."""
    resting: bool
    """True once zero was acknowledged, and nothing was written since."""
    turning: bool
    """True if a wheel may turn: from before a power is written until zero was acknowledged. The guard goes by it."""

    def open(self) -> None:
        """Identify it, write zero, then set and read back what safety rests on, its own watchdog above all."""

    def close(self) -> bool:
        """Write zero and close the line; return whether it was acknowledged, or nothing is there to be stopped.

        It may not raise, also where the line is gone, and not leave the line open. It may not return true for a zero
        that was only written: its guard is dismissed then, and nobody stops the motors. It may not end an emergency
        stop.
        """

    def fileno(self) -> int:
        """Return the descriptor of its line, which the guard holds too."""

    @property
    def guard_stop(self) -> GuardStop:
        """Return what its guard writes to stop it."""

    def drive(self, *powers: float) -> None:
        """Write the power of each motor; if one is not finite, zero to all."""

    def stop(self) -> bool:
        """Write zero as soon as the line is free; return whether it was acknowledged."""

    def emergency_stop(self) -> bool:
        """Cut the power, by a latch of its own where it has one, and write zero; return whether that was
        acknowledged."""

    def release(self) -> bool:
        """Write zero, then end its emergency stop; return whether both were acknowledged."""

    def poll(self) -> None:
        """Ask for the next of the values that it measures, unless an answer is due."""

    @property
    def fed_s_ago(self) -> float:
        """Return the seconds since a motor command was last written; inf before the first."""

    @property
    def faults(self) -> tuple[str, ...] | None:
        """Return what it complains of, by name; EMERGENCY_STOP is one of them. None: not known, so that nothing may
        move."""

    @property
    def grave(self) -> tuple[str, ...]:
        """Return those of its faults with which nothing may move."""

    def faults_after(self, when: float) -> tuple[str, ...] | None:
        """Return the faults if they were read after that; None where it keeps no latch that could be lost."""

    def measured(self) -> Measured:
        """Return what it measured last, for as long as that can be believed."""
