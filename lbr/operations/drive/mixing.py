"""The mixing of power and angle into the powers of two wheels."""

from math import cos, fmod, radians, sin

from lbr.operations.drive.settings import DriveSettings

FULL = 1000


def mix(power: float, angle_deg: float, settings: DriveSettings) -> tuple[float, float]:
    """Return the powers of the left and the right wheel, forward positive; clockwise turns the left one forward."""
    straight = fmod(angle_deg, 180.0) == 0.0
    angle = radians(angle_deg + settings.heading_offset_deg if straight else angle_deg)
    throttle, steering = cos(angle), sin(angle)
    if (
        settings.reverse_steering == "travel" and throttle < -1e-9 and not straight
    ):  # the cosine of 90 degrees is not quite 0
        steering = -steering
    combine = _clamped if settings.mixing == "clamped" else _normalised
    return combine(power, throttle, steering)


def _normalised(power: float, throttle: float, steering: float) -> tuple[float, float]:
    scale = power / max(1.0, abs(throttle) + abs(steering))
    return round((throttle + steering) * scale, 6), round((throttle - steering) * scale, 6)


def _clamped(power: float, throttle: float, steering: float) -> tuple[float, float]:
    ahead, turn = int(throttle * power * FULL), int(steering * power * FULL)
    return _clamp(ahead + turn) / FULL, _clamp(ahead - turn) / FULL


def _clamp(thousandths: int) -> int:
    return max(-FULL, min(FULL, thousandths))
