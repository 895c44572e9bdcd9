"""The one decision that wheels and servos share: may this setpoint reach motors? Pure: state, event and time.

A setpoint passes while it is fresh, its numbers are finite and its lease is not revoked. A motion that ends without its
sender's will revokes the lease that it quoted, for good: a sender that was late cannot go on as if nothing had been.
`wheels.arming` and `servos.gate` say what their families add.
"""

from dataclasses import dataclass, replace
from typing import Generic, Literal, Protocol, Self, TypeVar

REVOKED_KEPT = 256
"""More leases than end in the time that a late setpoint can take to arrive."""
Verdict = Literal["passes", "late", "not_finite", "revoked"]


class Setpoint(Protocol):
    """The facts of a setpoint that the gate needs."""

    @property
    def lease(self) -> str:
        """Return what tells its lease from others; a setpoint without cannot be revoked."""

    @property
    def born(self) -> float:
        """The older of its stamp and its arrival, in monotonic seconds."""

    @property
    def finite(self) -> bool:
        """Return whether all of its numbers are finite."""

    @property
    def neutral(self) -> bool:
        """Return whether it asks for nothing that moves, and so may pass under a revoked lease."""


S = TypeVar("S", bound=Setpoint)


@dataclass(frozen=True, slots=True)
class SetpointGate(Generic[S]):
    """The state: `setpoint` is in force exactly while it is not None, and `reason` explains None."""

    setpoint: S | None = None
    reason: str = ""
    dead: tuple[str, ...] = ()

    def judge(self, setpoint: S, now: float, valid_s: float) -> Verdict:
        """Return whether a setpoint passes, or the first reason against it."""
        if not setpoint.finite:
            return "not_finite"
        if not fresh(setpoint.born, now, valid_s):
            return "late"
        return "revoked" if setpoint.lease in self.dead and not setpoint.neutral else "passes"

    def closed(self, reason: str, lease: str = "") -> Self:
        """Have nothing in force any more, and revoke the lease of the motion that ends."""
        return replace(self.revoked(lease), setpoint=None, reason=reason)

    def revoked(self, lease: str) -> Self:
        """Have a lease move nothing ever again."""
        if not lease or lease in self.dead:
            return self
        return replace(self, dead=(*self.dead, lease)[-REVOKED_KEPT:])


def fresh(born: float, now: float, valid_s: float) -> bool:
    """Return whether something born then is believed now; what comes from the future is not."""
    age_s = now - born
    return -valid_s <= age_s < valid_s  # this way round, NaN means late
