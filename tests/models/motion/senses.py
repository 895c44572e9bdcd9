"""How a careful onlooker takes attitude and odometry: known and fresh, or not to be moved by."""

from math import inf, isfinite, nan

FULL_DPS, FULL_MPS = 400.0, 1.0
OLDEST_S = {"attitude": 0.2, "odometry": 0.3}
JUMP = {"attitude": (5.0, 1.5 * FULL_DPS), "odometry": (0.2, 2.0 * FULL_MPS)}


class Sense:
    """Attitude or odometry: the last value told (degrees turned, metres driven), and whether it can be believed."""

    __slots__ = ("believed", "epoch", "heading_deg", "history", "kind", "seen", "stalled", "value")

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.forget()

    def forget(self) -> None:
        """Know nothing any more."""
        self.believed = self.stalled = False
        self.epoch = ""
        self.value = self.heading_deg = self.seen = nan
        self.history: list[tuple[float, float]] = []

    def hear(self, told: dict[str, object], at: float) -> None:
        """Take in what was told, measured at a time that is past."""
        valid, epoch, value = bool(told["valid"]), str(told["epoch"]), _number(told["value"])
        if valid and epoch == self.epoch and at <= self.seen:
            return  # overtaken
        sane = valid and isfinite(value) and isfinite(at) and isfinite(_number(told.get("speed", 0.0)))
        if sane and self.believed and epoch == self.epoch:
            base, share = JUMP[self.kind]
            sane = abs(value - self.value) <= base + share * (at - self.seen)
        if epoch != self.epoch or not sane:
            self.history.clear()
        self.believed, self.epoch, self.value, self.seen = sane, epoch, value, at
        heading_deg = _number(told.get("heading"))
        self.heading_deg = heading_deg if 0.0 <= heading_deg <= 360.0 else nan
        self.stalled = bool(told.get("stalled", False))
        self.history = [*self.history[-199:], (at, value)]

    def known(self, now: float) -> bool:
        """Say whether it can be moved by."""
        return self.believed and now - self.seen <= OLDEST_S[self.kind]

    def range_over(self, seconds: float) -> float:
        """Return how far the values of the last moments lie apart; infinite if they do not reach back so far."""
        since = self.seen - seconds
        recent = [value for at, value in self.history if at >= since - 1e-6]
        reaches = bool(self.history) and self.history[0][0] <= since + 0.1
        return max(recent) - min(recent) if recent and reaches else inf


class Body:
    """A body on two wheels that does at once what they are told: `gain` is how much of it, `side` to which side."""

    def __init__(self) -> None:
        self.turned_deg = self.way_m = self.speed_mps = 0.0
        self.north_deg = 77.0
        self.gain = 1.0
        self.epochs = {"attitude": 1, "odometry": 1}

    def drove(self, left: float, right: float, seconds: float) -> None:
        """Move for a while."""
        self.turned_deg += self.gain * (left - right) / 2 * FULL_DPS * seconds
        self.speed_mps = self.gain * (left + right) / 2 * FULL_MPS
        self.way_m += self.speed_mps * seconds

    def attitude(self) -> dict[str, object]:
        """Return what an attitude that works tells."""
        heading_deg = (self.turned_deg + self.north_deg) % 360.0
        epoch = f"a{self.epochs['attitude']}"
        return {"valid": True, "epoch": epoch, "value": self.turned_deg, "heading": heading_deg}

    def odometry(self) -> dict[str, object]:
        """Return what an odometry that works tells."""
        epoch = f"o{self.epochs['odometry']}"
        return {"valid": True, "epoch": epoch, "value": self.way_m, "speed": self.speed_mps, "stalled": False}


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else nan
