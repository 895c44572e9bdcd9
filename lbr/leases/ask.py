"""A request as the leases of now have it, resolved once where it comes in: every check and every grant goes by that."""

from math import inf, isfinite, isnan
from typing import Generic, Literal

from msgspec import Struct

from lbr.leases.lease import Lease, LeaseRequest, LeaseTable, M

Intent = Literal["stop", "renewal", "change", "offer", "begin"]
"""`begin` also confirms an offer."""


class Ask(Struct, Generic[M], frozen=True, kw_only=True):
    """What a request `wants` of the `leases` as they are `now`.

    `quotes` is the lease or the offer whose lease it quotes, `sent` when it was sent at the latest, on our clock. The
    sender's clock is behind that by `behind_s` at most; infinite if that cannot be told.
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
        """Return the offer that it confirms, asking for exactly what was offered."""
        offer = self.quotes if self.wants == "begin" else None
        return offer if offer is not None and offer.what == self.request.what else None

    @property
    def streams(self) -> bool:
        """Say whether its sender asks without its lease, and has never quoted the lease that it holds by."""
        lease, request = self.leases.live, self.request
        return lease is not None and lease.source == request.source and isnan(lease.renewed) and not request.lease


def resolve(leases: LeaseTable[M], request: LeaseRequest, now: float) -> Ask[M]:
    """Return a request with what the leases say of it.

    A remote sender's clock is read by the quickest message under the same lease: nothing sent later came sooner, so
    what a partition held back cannot pass for new when it heals.
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
    """Return the lease or the offer whose lease a request quotes; an offer stands as of the last event."""
    known = (leases.live, *leases.offers)
    quotes = (lease for lease in known if lease is not None and lease.id == request.lease)
    return next(quotes, None) if request.lease else None


def _wants(leases: LeaseTable[M], request: LeaseRequest, lease: Lease[M] | None) -> Intent:
    """Return what a request wants: standing still without a lease is a stop, by whomever."""
    if not request.moves and not request.lease:
        return "stop"
    if lease is None:
        return "offer" if request.remote else "begin"
    if lease is not leases.live:
        return "begin"
    return "renewal" if request.what == lease.what else "change"


def _behind_s(request: LeaseRequest, lease: Lease[M] | None) -> float:
    if not (request.remote and isfinite(request.sender_s)):
        return inf
    seen_s = request.received - request.sender_s
    return seen_s if lease is None or lease.source != request.source else min(seen_s, lease.offset_s)
