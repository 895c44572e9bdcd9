"""Messages on `dock/*`: the infrared signals of a charging dock."""

from msgspec import Struct


class DockSignal(Struct, frozen=True, kw_only=True):
    """The visible beams of the dock, each for the driver's time to live, and the ages of all, null: never seen."""

    left: bool
    right: bool
    power: bool
    left_age_s: float | None = None
    right_age_s: float | None = None
    power_age_s: float | None = None


class DockHeard(Struct, frozen=True, kw_only=True):
    """Another program sees a beam now."""

    left: bool = False
    right: bool = False
    power: bool = False
