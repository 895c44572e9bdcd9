"""The decision that wheels and servos share: may this setpoint reach the motors? Pure: state, event and time.

A setpoint passes while it is fresh, its numbers are finite and its lease is not revoked. If a motion ends against its
sender's will, the lease that it quoted is revoked for good, so a late sender cannot just continue. `wheels.arming` and
`servos.gate` describe what their families add.
"""

from dataclasses import dataclass, replace
from typing import Generic, Literal, Protocol, Self, TypeVar

from lbr.messages.codes import ReasonCode

REVOKED_KEPT = 256
"""More leases than can end in the time that a late setpoint takes to arrive."""
Verdict = Literal["passes", "late", "not_finite", "revoked"]


class Setpoint(Protocol):
    """The facts of a setpoint that the gate needs."""

    @property
    def lease(self) -> str:
        """Return the identity of its lease; a setpoint without one cannot be revoked."""

    @property
    def born(self) -> float:
        """Return the older of its stamp and its arrival, in monotonic seconds."""

    @property
    def finite(self) -> bool:
        """Return whether all of its numbers are finite."""

    @property
    def neutral(self) -> bool:
        """Return whether it moves nothing, and so may pass under a revoked lease."""


S = TypeVar("S", bound=Setpoint)


@dataclass(frozen=True, slots=True)
class SetpointGate(Generic[S]):
    """The state: `setpoint` is the one in force, or None; then `reason` explains why, with its `code` if it has one."""

    setpoint: S | None = None
    reason: str = ""
    code: ReasonCode = ""
    dead: tuple[str, ...] = ()

    def judge(self, setpoint: S, now: float, valid_s: float) -> Verdict:
        """Return whether a setpoint passes, or the first reason against it."""
        if not setpoint.finite:
            return "not_finite"
        if not fresh(setpoint.born, now, valid_s):
            return "late"
        return "revoked" if setpoint.lease in self.dead and not setpoint.neutral else "passes"

    def closed(self, reason: str, lease: str = "", code: ReasonCode = "") -> Self:
        """Return the gate with no setpoint in force and the lease of the ended motion revoked."""
        return replace(self.revoked(lease), setpoint=None, reason=reason, code=code)

    def revoked(self, lease: str) -> Self:
        """Return the gate with a lease revoked for good."""
        if not lease or lease in self.dead:
            return self
        return replace(self, dead=(*self.dead, lease)[-REVOKED_KEPT:])


def fresh(born: float, now: float, valid_s: float) -> bool:
    """Return whether something born then is still valid; a time in the future is not."""
    age_s = now - born
    return -valid_s <= age_s < valid_s  # this way round, NaN means late
