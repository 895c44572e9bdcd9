"""The true rate of a stream, from its publishers' stamps, however slow the measuring process is."""

import itertools
from collections.abc import Iterable, Sequence

from msgspec import Struct

from lbr.bus import stamp as stamps
from lbr.bus.probe import Arrival
from lbr.messages.system import Stamp

NS = 1e9


class Rate(Struct, frozen=True, kw_only=True):
    """One publisher of a stream.

    `publisher_hz`, periods and loss are by its own sequence numbers and clock, and null without them. Ages are null
    across machines, whose clocks cannot be compared.
    """

    key: str
    source: str
    received: int
    received_hz: float
    publisher_hz: float | None
    lost: int | None
    lost_percent: float | None
    period_p50_ms: float | None
    period_p99_ms: float | None
    age_p50_ms: float | None
    age_p99_ms: float | None
    bytes_per_s: float


def measure(arrivals: Iterable[Arrival], seconds: float, *, boot: str = "") -> list[Rate]:
    """Return the rate of each publisher among the arrivals within `seconds`."""
    groups: dict[tuple[str, str], list[tuple[Arrival, Stamp | None]]] = {}
    for arrival in arrivals:
        stamp = stamps.read(arrival.attachment)
        groups.setdefault((arrival.key, stamp.source if stamp else "unstamped"), []).append((arrival, stamp))
    here = boot or stamps.boot_id()
    return [_rate(key, source, group, seconds, here) for (key, source), group in sorted(groups.items())]


def _rate(key: str, source: str, group: list[tuple[Arrival, Stamp | None]], seconds: float, boot: str) -> Rate:
    run = _newest_run([stamp for _, stamp in group if stamp is not None and stamp.seq > 0])
    steps = [(later.seq - sooner.seq, later.mono_ns - sooner.mono_ns) for sooner, later in itertools.pairwise(run)]
    sent, took_ns = sum(step for step, _ in steps), sum(ns for _, ns in steps)
    lost = sent - len(steps) if steps else None
    periods = sorted(ns / step / 1e6 for step, ns in steps)
    ages = sorted(
        (arrival.arrived_ns - stamp.mono_ns) / 1e6
        for arrival, stamp in group
        if stamp is not None and stamp.boot == boot
    )
    return Rate(
        key=key,
        source=source,
        received=len(group),
        received_hz=round(len(group) / seconds, 2) if seconds > 0 else 0.0,
        publisher_hz=round(sent * NS / took_ns, 2) if took_ns > 0 else None,
        lost=lost,
        lost_percent=round(100 * lost / sent, 2) if lost is not None and sent else None,
        period_p50_ms=_percentile(periods, 0.50),
        period_p99_ms=_percentile(periods, 0.99),
        age_p50_ms=_percentile(ages, 0.50),
        age_p99_ms=_percentile(ages, 0.99),
        bytes_per_s=round(sum(arrival.size for arrival, _ in group) / seconds, 1) if seconds > 0 else 0.0,
    )


def _newest_run(run: Sequence[Stamp]) -> list[Stamp]:
    """Return the stamps since the publisher last started: its numbers rise."""
    newest: list[Stamp] = []
    for stamp in run:
        if newest and (stamp.seq <= newest[-1].seq or stamp.boot != newest[-1].boot):
            newest = []
        newest.append(stamp)
    return newest


def _percentile(ordered: Sequence[float], part: float) -> float | None:
    return round(ordered[min(len(ordered) - 1, int(len(ordered) * part))], 3) if ordered else None
