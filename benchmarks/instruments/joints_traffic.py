"""A client that keeps moving all joints, and the analysis of the states that come back."""

import threading
import time
from collections import Counter
from contextlib import suppress
from itertools import pairwise
from math import nan
from typing import Any

import msgspec

from lbr.bus import wire
from lbr.errors import BusError
from lbr.messages.joints import JointsState
from tests.support.figures import percentile
from tests.support.robot import Robot
from tests.support.waiting import until

PERIOD_S = 0.01
SPEED_RPS = 1.0
MOST_RAD = 0.3
AHEAD_S = 0.1
"""The time that each command looks ahead; the next one comes before it is reached."""

PAUSE_S = 0.5


class Client:
    """Commands all joints at 100 Hz under one lease, and goes on whatever the answers."""

    def __init__(self, robot: Robot, ways: dict[str, tuple[float, float]]) -> None:
        self._robot = robot
        self._ways = ways
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._lease = ""
        self.late_ms: list[float] = []
        """The delay of each command."""
        self.refused: Counter[str] = Counter()
        """The reasons for which a motion could not restart."""

    def start(self) -> "Client":
        """Begin to move, once that is accepted."""
        until(self.again, limit_s=10.0, what="a motion that is accepted")
        self._thread.start()
        return self

    def again(self) -> bool:
        """Ask for a lease, after a pause, as an insistent sender is refused; return whether it was granted."""
        self._lease = ""
        pass_time(PAUSE_S)
        reply = self._robot.ask("joints/command", self._command(time.monotonic()), source="bench")
        accepted = reply is not None and reply["accepted"]
        self._lease = reply["lease"] if accepted else ""
        if not accepted:
            self.refused[reply["reason"] if reply is not None else "no answer"] += 1
        return bool(accepted)

    def cease(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._over.wait(max(0.0, due - time.monotonic())):
            now = time.monotonic()
            self.late_ms.append((now - due) * 1e3)
            if lease := self._lease:
                with suppress(BusError):
                    self._robot.put("joints/command", self._command(now) | {"lease": lease}, source="bench")
            due = max(due + PERIOD_S, now)

    def _command(self, now: float) -> dict[str, Any]:
        then = now + AHEAD_S
        positions = {name: middle + most * _saw(then * SPEED_RPS / most) for name, (middle, most) in self._ways.items()}
        return {"positions": positions, "duration_s": AHEAD_S, "interpolation": "linear"}


class Watched:
    """The analysis of the joints' states."""

    def __init__(self) -> None:
        self.ended = 0
        """The number of motions that ended and were restarted."""
        self._reasons: Counter[str] = Counter()
        self._moved_at = nan
        self._longest_s = 0.0
        self._arrived: list[float] = []
        self._measured: list[float] = []
        self._ages_ms: list[float] = []
        self._lost = 0
        self._last = -1
        self._still = self._unmeasured = self._old = 0

    def take(self, messages: list[wire.RawMessage]) -> bool:
        """Add states; return whether there is still a motion."""
        holder: str | None = "bench"
        for message in messages:
            state = msgspec.json.decode(message.payload, type=JointsState)
            holder = state.holder
            if state.sequence == self._last:
                continue  # published for another reason than a sweep
            self._lost += max(0, state.sequence - self._last - 1) if self._last >= 0 else 0
            self._last = state.sequence
            self._arrived.append(message.arrived)
            self._measured.append(state.measured_s)
            self._still += not state.moving
            if holder is None:
                self._reasons[state.reason] += 1
            if state.moving or not self._measured[1:]:
                self._moved_at = state.measured_s
            self._longest_s = max(self._longest_s, state.measured_s - self._moved_at)
            ages_ms = [joint.age_s * 1e3 for joint in state.joints.values() if joint.age_s is not None]
            newest_ms = min(ages_ms, default=0.0)
            self._unmeasured += len(state.joints) - len(ages_ms)
            self._old += sum(age_ms - newest_ms > PERIOD_S * 1e3 for age_ms in ages_ms)
            self._ages_ms += ages_ms
        return holder is not None

    def figures(self) -> dict[str, Any]:
        """Return the figures to print."""
        slots = sum(max(0, round(error_ms / (PERIOD_S * 1e3))) for error_ms in gaps_ms(self._measured))
        passed_s = self._measured[-1] - self._measured[0] if len(self._measured) > 1 else nan
        return {
            "states": len(self._measured),
            "states per second": (len(self._measured) - 1) / passed_s,
            "period error of sweeps, ms": errors(self._measured),
            "period error of states at a client, ms": errors(self._arrived),
            "cycles without a sweep": slots,
            "sweeps that no state told of": self._lost,
            "states while nothing moved": self._still,
            "motions that ended": self.ended,
            "longest without a motion, s": self._longest_s,
            "states without a holder, by reason": dict(self._reasons.most_common(8)),
            "joints older than a sweep": self._old,
            "share of joints older than a sweep": self._old / max(1, len(self._ages_ms)),
            "age of a joint, ms": summary(self._ages_ms),
            "joints not measured at all": self._unmeasured,
        }


def way(lower: float, upper: float) -> tuple[float, float]:
    """Return the middle of a joint's range and the distance to each side."""
    lower, upper = max(lower, -MOST_RAD), min(upper, MOST_RAD)
    return (lower + upper) / 2, (upper - lower) * 0.45


def _saw(phase: float) -> float:
    """Return a triangle of slope 1 between -1 and 1."""
    return abs((phase + 1.0) % 4.0 - 2.0) - 1.0


def pass_time(seconds: float) -> None:
    threading.Event().wait(seconds)


def gaps_ms(times: list[float]) -> list[float]:
    return [(later - earlier - PERIOD_S) * 1e3 for earlier, later in pairwise(times)]


def errors(times: list[float]) -> dict[str, float]:
    return summary([abs(error_ms) for error_ms in gaps_ms(times)])


def summary(samples: list[float]) -> dict[str, float]:
    return {which: round(percentile(samples, which), 3) for which in ("p50", "p99", "max")}
