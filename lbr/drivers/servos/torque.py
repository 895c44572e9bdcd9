"""The torque policy common to all servos, on any wire: which are released, and when all stop."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Generic, TypeVar

from lbr.drivers.servos.gate import ServoGate, first

FOUND_S = 0.5
"""The time for which a servo that was found with torque keeps it until its mover knows of it. A few rounds of state and
setpoint, so that a late servo keeps its torque after a restart. Chosen, not measured."""
RELEASED = "was released; switch its torque off, then on"


@dataclass(slots=True)
class Target:
    """The order for one servo. `known`: whether its torque (`on`) is known.

    `blocked`: why it gets no torque until a setpoint requests none. `adrift`: it is held as soon as its position is
    measured. `found_at`: the time of its first answer; its mover may not know yet that it has torque.
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
        """Allow torque again: a setpoint requested none."""
        self.blocked = ""


T = TypeVar("T", bound=Target)


class Torque(ABC, Generic[T]):
    """The orders for all servos of a line."""

    def __init__(self, servos: Collection[int], target: Callable[[int], T], clock: Callable[[], float]) -> None:
        self.servos = {servo: target(servo) for servo in servos}
        self._clock = clock
        self._gate = first(clock())
        self.guarded = True
        """True if a guard would release the servos after this driver's death; otherwise no servo gets torque."""

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque, is getting it, or may have it."""
        return any(target.energised for target in self._all())

    @abstractmethod
    def release(self, why: str) -> None:
        """Switch off, at once, every servo that may have torque."""

    @abstractmethod
    def off(self, targets: Sequence[T], why: str) -> None:
        """Switch the torque of these servos off; `why` blocks it until a setpoint requests none."""

    def advance(self, gate: ServoGate, strength: float) -> bool:
        """Release servos that are not wanted or whose hold is over; return whether a stop came since the last call."""
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
