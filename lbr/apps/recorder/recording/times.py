"""Parses times as people write them: `10m` ago, `14:02`, `yesterday 9:30`, or ISO 8601. Pure."""

import re
from datetime import datetime, timedelta

from lbr.errors import InputError

HOW = "such as 10m (ago), 14:02, 14:02:30, 'yesterday 9:30', '2026-03-14 15:09' or now"
_AGO = re.compile(r"(?P<number>\d+(?:\.\d+)?)\s*(?P<unit>ms|s|min|m|h|d)?(?:\s+ago)?")
_CLOCK = re.compile(
    r"(?:(?P<day>today|yesterday)\s+)?(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2}(?:\.\d+)?))?"
)
_UNIT_S = {"ms": 0.001, "s": 1.0, None: 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
MOST_S = 100 * 366 * 86400.0


def seconds(text: str) -> float | None:
    """Return a duration in seconds, None for anything but `90`, `90s`, `10m`, `2h`, `3d`."""
    found = _AGO.fullmatch(text.strip().lower())
    if found is None:
        return None
    length = float(found["number"]) * _UNIT_S[found["unit"]]
    return length if length <= MOST_S else None


def moment_ns(text: str, now_ns: int) -> int:
    """Parse a time relative to now, in nanoseconds since 1970; raise InputError with examples.

    A time of day is the last one past, of today or yesterday, in this machine's time zone.
    """
    words = text.strip().lower()
    if words in {"now", ""}:
        return now_ns
    ago = seconds(words)
    if ago is not None:
        return max(0, now_ns - round(ago * 1e9))
    found = _CLOCK.fullmatch(words)
    try:
        at = _of_clock(found, now_ns) if found else datetime.fromisoformat(text.strip().upper())
        return max(0, round(at.timestamp() * 1e6) * 1000)
    except (ValueError, OverflowError, OSError):
        raise InputError(f"'{text[:60]}' is no time; say it {HOW}") from None


def text(wall_ns: int, now_ns: int) -> str:
    """Format a time for people; today's without the date."""
    at, now = (datetime.fromtimestamp(ns / 1e9).astimezone() for ns in (wall_ns, now_ns))
    return f"{at:%H:%M:%S}" if at.date() == now.date() else f"{at:%Y-%m-%d %H:%M:%S}"


def length(seconds_: float) -> str:
    """Format a duration for people."""
    if seconds_ < 90:
        return f"{seconds_:.0f} s"
    if seconds_ < 5400:
        return f"{seconds_ / 60:.0f} min"
    return f"{seconds_ / 3600:.1f} h" if seconds_ < 172800 else f"{seconds_ / 86400:.1f} days"


def _of_clock(match: re.Match[str], now_ns: int) -> datetime:
    now = datetime.fromtimestamp(now_ns / 1e9).astimezone()
    second = float(match["second"] or 0)
    at = now.replace(
        hour=int(match["hour"]), minute=int(match["minute"]), second=int(second), microsecond=int(second % 1 * 1e6)
    )
    if match["day"] == "yesterday" or (match["day"] is None and at > now):
        at -= timedelta(days=1)
    return at
