"""The message on `telemetry/package`: everything the robot knows of itself."""

from msgspec import Struct


class Telemetry(Struct, frozen=True, kw_only=True):
    """The nested package of the robot's readings."""
