"""Messages and rows of sensors that measure distances: single readings by name, and scans."""

from collections.abc import Iterable, Iterator, Mapping
from math import inf, isfinite, nan, pi
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct
from msgspec.structs import replace

from lbr.messages.rows import Fault, Others, Row
from lbr.messages.units import Name

RangeStatus = Literal["ok", "over_range", "invalid", "missing"]
RangeKind = Literal["ultrasonic", "infrared", "time_of_flight", "lidar"]
RING = ("forward", "back", "left", "right", "bottom")
"""Sensors with a field of their own in `Ranges`, which are the ring of the robot lbr."""
MOST_RAYS = 4096
LEVEL_RAD = 0.5
"""A sensor that looks further up or down than this does not see obstacles."""


class Ranges(Struct, frozen=True, kw_only=True):
    """Distances around the robot in metres; null is not measured, and `status` is the reason.

    The sensors are rows of `range_sensor`; those without a field are in `others_m`, and then only those with a value or
    status. `over_range`: nothing within reach. `invalid`: the sensor sent an error value. `missing`: the sensor does
    not exist or answer. `cycle_s`: the board's measuring cycle. `ages_s`: of each measurement. `rests`: the base stands
    and they are unchanged; they are reported twice a second until one changes.
    """

    forward_m: float | None
    back_m: float | None
    left_m: float | None
    right_m: float | None
    bottom_m: float | None
    status: dict[str, RangeStatus]
    cycle_s: float | None = None
    others_m: dict[str, float | None] = {}
    ages_s: dict[str, float] = {}
    rests: bool = False

    def metres(self, sensor: str) -> float | None:
        """Return the reading of a sensor; None without one."""
        if sensor in RING:
            found: float | None = getattr(self, f"{sensor}_m")
            return found
        return self.others_m.get(sensor)

    def tells_of(self, sensor: str) -> bool:
        """Return whether the message is about a sensor: one that it does not mention is unchanged."""
        if sensor in RING and not self.others_m:
            return True
        return sensor in self.status or sensor in self.others_m or self.metres(sensor) is not None


def ranges(
    metres: Mapping[str, float | None],
    status: Mapping[str, RangeStatus],
    cycle_s: float | None = None,
    ages_s: Mapping[str, float] | None = None,
) -> Ranges:
    """Return the message for sensors of any name."""
    around: dict[str, Any] = {f"{name}_m": metres.get(name) for name in RING}
    others = {name: value for name, value in metres.items() if name not in RING}
    return Ranges(**around, status=dict(status), cycle_s=cycle_s, others_m=others, ages_s=dict(ages_s or {}))


Reading = float | Literal["Infinity", "-Infinity"] | None
"""A distance in metres, or why it is not measured, by REP 117: nothing within reach, too near, unknown."""


class Scan(Struct, frozen=True, kw_only=True):
    """Many distances at once, all around a sensor: a LaserScan.

    Reading i is along `angle_min_rad + i * angle_increment_rad`, anticlockwise from the direction in the row of
    `sensor`. As in REP 117, "Infinity": nothing up to `range_max_m`; "-Infinity": nearer than `range_min_m`; null: not
    known. `scan_s`: how long a scan takes.
    """

    sensor: Name
    angle_min_rad: float
    angle_increment_rad: float
    range_min_m: float
    range_max_m: float
    ranges_m: Annotated[tuple[Reading, ...], Meta(max_length=MOST_RAYS)]
    scan_s: float | None = None

    @property
    def angle_max_rad(self) -> float:
        """Return the angle of the last reading."""
        return self.angle_min_rad + (len(self.ranges_m) - 1) * self.angle_increment_rad

    def metres(self) -> tuple[float, ...]:
        """Return the readings as numbers: infinite, minus infinite and NaN as REP 117 has them.

        Values beyond the sensor's own limits are not known.
        """
        return tuple(self._metres(reading) for reading in self.ranges_m)

    def _metres(self, reading: Reading) -> float:
        if reading is None:
            return nan
        if isinstance(reading, str):
            return inf if reading == "Infinity" else -inf
        return reading if self.range_min_m <= reading <= self.range_max_m else nan


def readings(metres: Iterable[float]) -> tuple[Reading, ...]:
    """Return numbers, some infinite or NaN, as readings of a scan."""
    return tuple(_reading(value) for value in metres)


def _reading(value: float) -> Reading:
    if isfinite(value):
        return value
    return "Infinity" if value == inf else "-Infinity" if value == -inf else None


def _level(row: "RangeSensor", _: Others) -> Iterator[Fault]:
    if row.rays > 1 and abs(row.pitch_rad) > LEVEL_RAD:
        yield "pitch_rad", f"is beyond {LEVEL_RAD:g}: a scan is taken to be level"


Metres = Annotated[float, Meta(ge=-5.0, le=5.0)]


class RangeSensor(Row, frozen=True, kw_only=True):
    """Sensors of distance: the place of each on the base, its direction, width and reach. Axes are REP 103's: x ahead,
    y left, from the middle between the wheels; angles are anticlockwise."""

    TABLE = "range_sensor"
    KEY = ("name",)
    ASCENDING = (("min_m", "max_m"),)
    CHECKS = (_level,)

    name: Annotated[Name, "its name in readings, scans and rules"]
    kind: Annotated[RangeKind, "how it measures"]
    x_m: Annotated[Metres, "ahead of the middle between the wheels"] = 0.0
    y_m: Annotated[Metres, "to the left of it"] = 0.0
    z_m: Annotated[float, Meta(ge=0.0, le=5.0), "how far above the floor"] = 0.2
    yaw_rad: Annotated[float, Meta(ge=-7.0, le=7.0), "its direction: 0 ahead, 1.5708 left"] = 0.0
    pitch_rad: Annotated[float, Meta(ge=-2.0, le=2.0), "downwards; beyond 0.5 it sees no obstacles"] = 0.0
    fov_rad: Annotated[float, Meta(gt=0.0, le=6.2832), "its whole width; 6.2832: all around"] = 0.4
    min_m: Annotated[float, Meta(ge=0.0, le=100.0), "it measures nothing nearer"] = 0.02
    max_m: Annotated[float, Meta(gt=0.0, le=100.0), "a number above this is a fault"] = 4.0
    rays: Annotated[int, Meta(ge=1, le=MOST_RAYS), "1: one distance; more: a scan of so many"] = 1
    stop_m: (
        Annotated[
            float,
            Meta(gt=0.0, le=10.0),
            "the base stops at this distance; NULL: only rules that name the sensor stop it",
        ]
        | None
    ) = 0.25

    @property
    def level(self) -> bool:
        """Return whether it sees obstacles, rather than the floor or the ceiling."""
        return abs(self.pitch_rad) <= LEVEL_RAD

    @property
    def round(self) -> bool:
        """Return whether it sees all around."""
        return self.fov_rad > 2 * pi - 0.01

    @property
    def first_rad(self) -> float:
        """Return the angle of the first ray of a scan, anticlockwise from the direction of the sensor."""
        return -pi if self.round else -self.fov_rad / 2

    @property
    def step_rad(self) -> float:
        """Return the angle from a ray of a scan to the next one."""
        return 2 * pi / self.rays if self.round else self.fov_rad / max(1, self.rays - 1)

    def angles(self) -> tuple[float, ...]:
        """Return the angles of all rays of a scan."""
        return tuple(self.first_rad + number * self.step_rad for number in range(self.rays))


def ring(length_m: float, width_m: float, height_m: float = 0.3) -> tuple[RangeSensor, ...]:
    """Return the ring of the robot lbr on a base of this size: ahead, behind, to both sides and down."""
    ahead_m, aside_m = length_m / 2, width_m / 2
    places = (
        ("forward", ahead_m, 0.0, 0.0),
        ("back", -ahead_m, 0.0, pi),
        ("left", 0.0, aside_m, pi / 2),
        ("right", 0.0, -aside_m, -pi / 2),
    )
    down = RangeSensor(
        name="bottom", kind="ultrasonic", z_m=height_m, pitch_rad=pi / 2, min_m=0.17, max_m=8.0, stop_m=None
    )
    level = [replace(down, name=name, x_m=x_m, y_m=y_m, yaw_rad=yaw, pitch_rad=0.0) for name, x_m, y_m, yaw in places]
    return (*level, down)
