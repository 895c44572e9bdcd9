"""The turn of a base about a point beside it until its outline meets an obstacle: in closed form, no steps."""

from math import acos, atan2, copysign, hypot, inf, sqrt, tau

ROUNDING_RAD = 1e-9


class Footprint:
    """A base that turns anticlockwise about (0, `radius_m`); x ahead, y left, from its middle (REP 103).

    The outline is a rectangle, `ahead_m` long and `aside_m` wide from its middle, rounded by a margin of `margin_m`.
    """

    def __init__(self, ahead_m: float, aside_m: float, margin_m: float, radius_m: float) -> None:
        self._ahead_m, self._aside_m, self._margin_m, self._radius_m = ahead_m, aside_m, margin_m, radius_m
        ends = [(x, y - radius_m) for x in (ahead_m, -ahead_m) for y in (aside_m, -aside_m)]
        self._corners = [(hypot(x, y), atan2(y, x)) for x, y in ends]
        self._nearest_m = max(0.0, abs(radius_m) - aside_m - margin_m)
        self._farthest_m = max(reach_m for reach_m, _ in self._corners) + margin_m

    def until_rad(self, x_m: float, y_m: float) -> float:
        """Return the angle of the turn until a point is within the margin; infinite if it never is.

        A point within the margin now allows no approach, but every retreat. A point within the outline itself blocks no
        motion.
        """
        y_m -= self._radius_m
        reach_m = hypot(x_m, y_m)
        out_m = abs(x_m) - self._ahead_m, abs(y_m + self._radius_m) - self._aside_m
        if hypot(max(0.0, out_m[0]), max(0.0, out_m[1])) < self._margin_m:
            return 0.0 if self._comes_nearer(x_m, y_m, out_m) else inf
        if not self._nearest_m < reach_m < self._farthest_m:
            return inf
        bearing = atan2(y_m, x_m) + ROUNDING_RAD
        return min([(bearing - entry) % tau for entry in self._entries(reach_m)], default=inf)

    def _comes_nearer(self, x_m: float, y_m: float, out_m: tuple[float, float]) -> bool:
        """Return whether a point comes nearer: seen from the base it moves clockwise about the turn's centre, at (y,
        -x)."""
        ahead_m, aside_m = max(0.0, out_m[0]), max(0.0, out_m[1])
        return copysign(ahead_m, x_m) * y_m - copysign(aside_m, y_m + self._radius_m) * x_m < 0.0

    def _entries(self, reach_m: float) -> list[float]:
        """Return the angles, on a circle about the centre of the turn, at which a point enters the rounded outline."""
        ahead_m, aside_m, radius_m, margin_m = self._ahead_m, self._aside_m, self._radius_m, self._margin_m
        square, edge_m, angles = reach_m * reach_m, self._ahead_m + self._margin_m, []
        if reach_m > edge_m:
            along_m = sqrt(square - edge_m * edge_m)
            if abs(radius_m - along_m) <= aside_m:
                angles.append(atan2(-along_m, edge_m))
            if abs(radius_m + along_m) <= aside_m:
                angles.append(atan2(along_m, -edge_m))
        for side in (1.0, -1.0):
            edge_m = side * (aside_m + margin_m) - radius_m
            beyond = square - edge_m * edge_m
            if beyond > 0.0 and (along_m := sqrt(beyond)) <= ahead_m:
                angles.append(atan2(edge_m, side * along_m))
        for corner_m, angle in self._corners:
            if -margin_m < reach_m - corner_m < margin_m:
                angles.append(angle + self._beside_rad(reach_m, corner_m))
        return angles

    def _beside_rad(self, reach_m: float, corner_m: float) -> float:
        cosine = (reach_m * reach_m + corner_m * corner_m - self._margin_m**2) / (2.0 * reach_m * corner_m)
        return acos(max(-1.0, min(1.0, cosine)))
