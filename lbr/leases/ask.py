"""A request, resolved once against the present leases. All checks and grants use the result."""

from math import inf, isfinite, isnan
from typing import Generic, Literal

from msgspec import Struct

from lbr.leases.lease import Lease, LeaseRequest, LeaseTable, M

Intent = Literal["stop", "renewal", "change", "offer", "begin"]
"""`begin` also confirms an offer."""


class Ask(Struct, Generic[M], frozen=True, kw_only=True):
    """A request resolved against the `leases` at the time `now`.

    `quotes` is the lease or offer that it quotes. `sent` is the latest possible time of sending, on our clock. The
    sender's clock is behind ours by `behind_s` at most; infinite if unknown.
    """

    request: LeaseRequest
    leases: LeaseTable[M]
    now: float
    wants: Intent
    quotes: Lease[M] | None
    sent: float
    behind_s: float
    ttl_s: float

    @property
    def confirms(self) -> Lease[M] | None:
        """Return the offer that it confirms. The motion must be just the offered one."""
        offer = self.quotes if self.wants == "begin" else None
        return offer if offer is not None and offer.content == self.request.content else None

    @property
    def streams(self) -> bool:
        """Return whether the holder sends without its lease, and has never quoted that lease."""
        lease, request = self.leases.live, self.request
        return lease is not None and lease.source == request.source and isnan(lease.renewed) and not request.lease


def resolve(leases: LeaseTable[M], request: LeaseRequest, now: float) -> Ask[M]:
    """Return a request resolved against the leases.

    The quickest message under the same lease dates a remote sender's clock. So a message that a network failure has
    delayed never looks new afterwards.
    """
    lease = quoted(leases, request)
    behind_s = _behind_s(request, lease)
    return Ask(
        request=request,
        leases=leases,
        now=now,
        wants=_wants(leases, request, lease),
        quotes=lease,
        sent=request.received if behind_s == inf else request.sender_s + behind_s,
        behind_s=behind_s,
        ttl_s=leases.ttl_s if request.ttl_s is None else request.ttl_s,
    )


def quoted(leases: LeaseTable[M], request: LeaseRequest) -> Lease[M] | None:
    """Return the lease or offer that a request quotes. Offers are those of the last event."""
    known = (leases.live, *leases.offers)
    return next((lease for lease in known if lease is not None and lease.id == request.lease), None)


def _wants(leases: LeaseTable[M], request: LeaseRequest, lease: Lease[M] | None) -> Intent:
    """Return the intent of a request. To stand still without a lease is a stop, from any sender."""
    if not request.moves and not request.lease:
        return "stop"
    if lease is None:
        return "offer" if request.remote else "begin"
    if lease is not leases.live:
        return "begin"
    return "renewal" if request.content == lease.content else "change"


def _behind_s(request: LeaseRequest, lease: Lease[M] | None) -> float:
    if not (request.remote and isfinite(request.sender_s)):
        return inf
    seen_s = request.received - request.sender_s
    return seen_s if lease is None or lease.source != request.source else min(seen_s, lease.offset_s)
