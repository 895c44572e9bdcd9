"""The twin of a device on a serial line: input to it, output from it, while its cable is plugged in."""

from typing import Protocol, TypeVar

from lbr.capability.context import Device
from lbr.simulation.faults import Faults
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, plug

F = TypeVar("F", bound=Faults)


class Emulated(Protocol[F]):
    """A device by its bytes."""

    faults: F

    def poll(self, now: float) -> bytes:
        """Return the bytes that have crossed the line to the host so far."""

    def next_due(self) -> float | None:
        """Return when it next acts by itself."""


class LineTwin(PortTwin[PtyPort, F]):
    """A device that sends by itself; one with an input overrides `hear`."""

    def __init__(self, device: Device, faults: F, emulated: Emulated[F]) -> None:
        super().__init__(device.name, PtyPort(device.address), faults)
        self._emulated = emulated

    @property
    def reads(self) -> bool:
        """Return whether it reads its input: not with the fault `stop_reading`."""
        return not getattr(self._faults, "stop_reading", False)

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it reads next; None without one."""
        return super().watched() if self.reads else None

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        if self._emulated.faults is not self._faults:
            self._emulated.faults = self._faults
        was_plugged = self.port.plugged
        plug(self.port, present=self.present(now))
        if self.port.plugged != was_plugged:
            self.cable(now)
        if answer := self.hear(self.port.read() if self.reads else b"", now):
            self.say(answer, now)

    def next_due(self) -> float | None:
        """Return when it next acts by itself."""
        return self._emulated.next_due()

    def present(self, now: float) -> bool:  # noqa: ARG002
        """Return whether the host sees the port."""
        return not self._faults.unplug

    def cable(self, now: float) -> None:
        """Note that the cable was just plugged in or pulled out; most devices do not notice."""

    def hear(self, data: bytes, now: float) -> bytes:  # noqa: ARG002
        """Receive bytes, if any; return the bytes that have crossed the line back."""
        return self._emulated.poll(now)

    def say(self, data: bytes, now: float) -> None:  # noqa: ARG002
        """Send bytes on the line."""
        self.port.write(data)
