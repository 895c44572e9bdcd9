"""The policy of torque that holds for all servos, whatever their orders are on the wire: who is released, and when all
stop."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Generic, TypeVar

from lbr.drivers.servos.gate import ServoGate, first

FOUND_S = 0.5
"""The time that a servo that was found with torque keeps it until its mover knows of it: a few rounds of state and
setpoint, so that a late servo keeps its torque after a restart. Chosen, not measured."""
RELEASED = "was released; switch its torque off, then on"


@dataclass(slots=True)
class Target:
    """The order for one servo. `known`: whether it is known if it has torque (`on`).

    `blocked`: why it gets no torque before a setpoint had it without. `adrift`: it is to be held where it is as
    soon as that is measured. `found_at`: the time of its first answer, with torque that its mover may not know of yet.
    """

    id: int
    known: bool = False
    on: bool = False
    adrift: bool = False
    blocked: str = ""
    trouble: str = ""
    found_at: float = -inf

    @property
    def energised(self) -> bool:
        """Return whether it has torque, is getting it, or may have it."""
        return self.on

    def unblock(self) -> None:
        """Let it get torque again: a setpoint had it without."""
        self.blocked = ""


T = TypeVar("T", bound=Target)


class Torque(ABC, Generic[T]):
    """The orders for all servos of a line."""

    def __init__(self, servos: Collection[int], target: Callable[[int], T], clock: Callable[[], float]) -> None:
        self.servos = {servo: target(servo) for servo in servos}
        self._clock = clock
        self._gate = first(clock())
        self.guarded = True
        """True if a guard would release the servos after this driver's death; before, no servo gets torque."""

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque, is getting it, or may have it."""
        return any(target.energised for target in self._all())

    @abstractmethod
    def release(self, why: str) -> None:
        """Take the torque off every servo that may have it, at once."""

    @abstractmethod
    def off(self, targets: Sequence[T], why: str) -> None:
        """Take the torque off these servos; `why` keeps them without until a setpoint had them so."""

    def advance(self, gate: ServoGate, strength: float) -> bool:
        """Release those whose torque is over, or that are not wanted; return whether a stop came since the last
        time."""
        unwanted = [target for target in self._all() if gate.seen and target.id not in gate.wanted]
        for target in unwanted:
            target.unblock()
        if strength > 0.0:
            late = self._clock() - FOUND_S
            self.off([target for target in unwanted if target.energised and target.found_at < late], "")
        else:
            self.off([target for target in self._all() if target.energised], RELEASED)
        before, self._gate = self._gate, gate
        return gate.stopped_since(before)

    def _all(self) -> Iterable[T]:
        return self.servos.values()
