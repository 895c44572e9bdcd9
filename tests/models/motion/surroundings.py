"""What a careful onlooker knows of the distances around the base: free for certain, blocked for certain, or neither."""

from math import inf, isfinite, nan

SIDES = ("forward", "back", "left", "right")
STOP_M = {"forward": 0.25, "back": 0.25, "left": 0.20, "right": 0.20}
FROZEN_AFTER_M = {"forward": 0.10, "back": 0.10, "left": 0.30, "right": 0.30}
OLDEST_S = 0.3
MEMORY_S, MEMORY_REACH_M = 1.0, 1.2
"""For how long arcs and spins may be held up by what was seen within reach; what they are, the onlooker does not say."""
REACTION_S, BRAKE_MPS2 = 0.3, 1.5
SLACK = 1e-6
GUARDED: dict[float, tuple[str, ...]] = {
    0.0: ("forward",),
    30.0: ("forward", "right"),
    -30.0: ("forward", "left"),
    90.0: ("left", "right"),
    -90.0: ("left", "right"),
    150.0: ("back", "left"),
    180.0: ("back",),
    210.0: ("back", "right"),
}
"""Which sensors look where a motion at these angles goes."""


class Sight:
    """One sensor: its last distance (infinite: nothing near; NaN: unknown), and whether two readings agreed on it."""

    def __init__(self, side: str) -> None:
        self.side = side
        self.value_m = nan
        self.seen = -inf
        self.sure = True
        self.mark_m = self.idle_m = 0.0
        self.repeats = 0

    def see(self, value_m: float, at: float, travelled_m: float, *, twice: bool) -> None:
        """Take in a reading; `twice` when it was confirmed at once."""
        if at < self.seen:
            return
        known = self.value_m == self.value_m and value_m == value_m
        nearer = value_m <= self.value_m
        self.sure = twice or not known or (nearer and self.sure)
        for _ in range(2 if twice else 1):
            same = value_m == self.value_m and isfinite(value_m)
            self.repeats = self.repeats + 1 if same else 0
            self.mark_m = self.mark_m if same else travelled_m
            self.idle_m = travelled_m - self.mark_m
            self.value_m = value_m
        self.seen = at

    def unknown(self, now: float) -> bool:
        """Say whether there is no reading to go by."""
        return not (now - self.seen <= OLDEST_S and self.value_m == self.value_m)

    def frozen(self) -> bool | None:
        """Say whether the reading stood still although the base moved; None on the edge of it."""
        if self.repeats < 2:
            return False
        beyond_m = self.idle_m - FROZEN_AFTER_M[self.side]
        return None if abs(beyond_m) < SLACK else beyond_m > 0.0

    def blocked(self, now: float) -> bool | None:
        """Say whether the base must not move that way; None when that cannot be told."""
        if self.unknown(now):
            return True
        frozen = self.frozen()
        near = self.value_m <= STOP_M[self.side]
        if frozen or near:
            return True
        return None if frozen is None or not self.sure else False


class Surroundings:
    """All sensors, and how far the base came by its own estimate."""

    def __init__(self) -> None:
        self.sights = {side: Sight(side) for side in SIDES}
        self.along_m = self.turned_m = 0.0
        self.near_at = -inf

    def forget(self, now: float) -> None:
        """Know nothing any more but that something was near, if it was."""
        self.near_at = self.near_at if self.near_at == -inf else now
        self.sights = {side: Sight(side) for side in SIDES}

    def drove(self, left: float, right: float, seconds: float) -> None:
        """Count how far the base came."""
        self.along_m += abs(left + right) * seconds / 2
        self.turned_m += abs(left - right) * seconds / 2

    def see(self, distances: dict[str, float], at: float, *, twice: bool) -> None:
        """Take in what every sensor says."""
        if any(value_m < MEMORY_REACH_M for value_m in distances.values()) and at == at and not at < self.near_at:
            self.near_at = at
        for side, sight in self.sights.items():
            along = side in {"forward", "back"}
            sight.see(distances[side], at, self.along_m if along else self.turned_m, twice=twice)

    def blocked(self, angle_deg: float, now: float) -> bool | None:
        """Say whether a motion at this angle must not start."""
        verdicts = [self.sights[side].blocked(now) for side in GUARDED[angle_deg]]
        if True in verdicts:
            return True
        return None if None in verdicts or self._remembers(angle_deg, now) else False

    def free(self, angle_deg: float, now: float) -> bool:
        """Say whether nothing at all is near in the way of a motion at this angle."""
        sights = [self.sights[side] for side in GUARDED[angle_deg]]
        far = all(sight.blocked(now) is False and sight.value_m > 0.8 for sight in sights)
        return far and not self._remembers(angle_deg, now)

    def too_fast(self, left: float, right: float, now: float) -> str:
        """Return why the base must not move like this, or nothing."""
        ahead, turn = (left + right) / 2, (left - right) / 2
        if abs(ahead) <= 0.03 * (abs(ahead) + abs(turn)):
            return ""
        sight = self.sights["forward" if ahead > 0.0 else "back"]
        if sight.blocked(now):
            return f"it drives towards what is not free: {sight.side} {sight.value_m}"
        speed = abs(ahead)
        room_m = sight.value_m - STOP_M[sight.side]
        if sight.sure and speed * REACTION_S + speed * speed / (2 * BRAKE_MPS2) > room_m + SLACK:
            return f"{speed:.2f} m/s is too fast for {room_m:.2f} m {sight.side}"
        return ""

    def _remembers(self, angle_deg: float, now: float) -> bool:
        """Say whether a motion at this angle may be held up by what was near; straight motion never is."""
        return len(GUARDED[angle_deg]) > 1 and not now - self.near_at >= MEMORY_S
