"""Messages on `dock/*`: the infrared signals of a charging dock."""

from msgspec import Struct


class DockSignal(Struct, frozen=True, kw_only=True):
    """Which of the dock's beams is seen; each counts for as long as the driver's time to live says.

    The ages are seconds since each was last seen; null: never.
    """

    left: bool
    right: bool
    power: bool
    left_age_s: float | None = None
    right_age_s: float | None = None
    power_age_s: float | None = None


class DockHeard(Struct, frozen=True, kw_only=True):
    """Another program has seen a beam, now."""

    left: bool = False
    right: bool = False
    power: bool = False
