"""Settings of a row of kind `drive`."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.drive import Direction
from lbr.messages.units import Name, basic

Metres = Annotated[float, Meta(gt=0.0, le=10.0)]
Seconds = Annotated[float, Meta(gt=0.0, le=10.0)]


class Rule(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Slow down for obstacles seen by `sensor` when moving towards `direction`, and stop `stop_m` before them.

    The sensor is a row of `range_sensor`; of a scan, obstacles in the way count. A stop is held until there are
    `margin_m` more. A reading counts as an obstacle if it is older than `max_age_s`, or unchanged over `frozen_after_m`
    of driving (side sensors: of turning, at the wheels).
    """

    direction: Direction
    sensor: Name
    stop_m: Annotated[Metres, basic("distances", "Distance kept", description="left free when it stops")] = 0.25
    margin_m: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.05
    max_age_s: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.3
    frozen_after_m: Metres = 0.10


DEFAULT_RULES = (
    Rule(direction="forward", sensor="forward"),
    Rule(direction="back", sensor="back"),
    Rule(direction="left", sensor="left", stop_m=0.20, frozen_after_m=0.30),
    Rule(direction="right", sensor="right", stop_m=0.20, frozen_after_m=0.30),
)


class DriveSettings(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings of the motion of a base.

    `mixing`: `normalised` keeps the shape of arcs, no wheel above the requested power; `clamped` sums and clamps in
    thousandths. `reverse_steering`: in reverse, `rotation` keeps the sense of rotation, `travel` the side of the curve.
    `heading_offset_deg`: added straight ahead and straight back. Rows of `wheel` replace `track_m`.
    """

    rate_hz: Annotated[float, Meta(ge=50.0, le=100.0)] = 50.0
    max_power: Annotated[float, basic("speed", "Top speed", gt=0.0, le=1.0, description="share of full power")] = 1.0
    accel_per_s: Annotated[float, Meta(gt=0.0, le=50.0, description="growth of each wheel's power")] = 2.0
    ttl_s: Annotated[float, Meta(gt=0.0, le=1.0, description="life of a lease between renewals")] = 0.3
    max_run_s: Annotated[float, Meta(gt=0.0, le=3600.0, description="longest motion without a changed command")] = 30.0
    blocked_s: Annotated[float, Meta(gt=0.0, le=3600.0, description="a stop by a rule for so long ends the motion")] = (
        1.0
    )
    motors_max_age_s: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.3
    checks_timeout_s: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.1
    mixing: Literal["normalised", "clamped"] = "normalised"
    reverse_steering: Literal["rotation", "travel"] = "rotation"
    heading_offset_deg: Annotated[float, Meta(ge=-8.0, le=8.0)] = 0.0
    max_speed_mps: Annotated[float, Meta(gt=0.0, le=10.0, description="speed at full power")] = 1.0
    reaction_s: Annotated[float, Meta(gt=0.0, le=2.0, description="from something appearing to braking")] = 0.3
    brake_mps2: Annotated[float, Meta(gt=0.0, le=20.0)] = 1.5
    rules: tuple[Rule, ...] = DEFAULT_RULES
    body_length_m: Annotated[float, Meta(gt=0.0, le=5.0, description="of the base, centred between the wheels")] = 0.43
    body_width_m: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.30
    track_m: Annotated[float, Meta(gt=0.0, le=5.0, description="between the wheels, by a turn on the spot")] = 0.27
    memory_s: Annotated[
        float,
        Meta(ge=0.0, le=60.0, description="how long arcs and spins heed a lost sight; 0: not"),
    ] = 10.0
    memory_reach_m: Annotated[float, Meta(gt=0.0, le=3.0, description="what is farther away is not remembered")] = 1.2
    memory_aside_m: Annotated[
        float, Meta(ge=0.0, le=1.0, description="how far a sight reaches to both sides of the axis")
    ] = 0.3
    memory_margin_m: Annotated[
        float, Meta(ge=0.0, le=1.0, description="kept between the outline and what is remembered")
    ] = 0.1
    memory_stop_m: Annotated[float, Meta(ge=0.0, le=1.0, description="way of the faster wheel left at that stop")] = 0.1
    memory_hold_m: Annotated[float, Meta(ge=0.0, le=1.0, description="that stop holds until there is so much more")] = (
        0.05
    )
    max_turn_dps: Annotated[float, Meta(gt=0.0, le=1000.0, description="of a spin at full power")] = 400.0
    turn_power: Annotated[
        float, basic("speed", "Speed of turns", gt=0.0, le=1.0, description="greatest power of a turn")
    ] = 0.2
    turn_min_power: Annotated[
        float, Meta(gt=0.0, le=1.0, description="least that turns the base, most of a correction")
    ] = 0.05
    turn_brake_dps2: Annotated[float, Meta(gt=0.0, le=5000.0, description="how hard a turn slows down")] = 150.0
    turn_lag_s: Annotated[float, Meta(ge=0.0, le=1.0, description="from a new power to its first effect")] = 0.12
    turn_tolerance_deg: Annotated[float, Meta(ge=0.2, le=45.0)] = 1.0
    turn_settle_s: Annotated[float, Meta(ge=0.0, le=2.0, description="rest at the target ends a turn")] = 0.2
    turn_stuck_s: Annotated[float, Meta(gt=0.0, le=10.0, description="power without a turn is a fault")] = 1.0
    turn_spare_s: Annotated[
        float, Meta(ge=0.5, le=60.0, description="for a turn beyond twice its time at turn_power")
    ] = 4.0
    attitude_max_age_s: Annotated[float, Meta(gt=0.0, le=0.5)] = 0.2
    creep_power: Annotated[float, Meta(gt=0.0, le=1.0, description="least that drives the base, near the end")] = 0.06
    distance_tolerance_m: Annotated[float, Meta(ge=0.005, le=1.0)] = 0.02
