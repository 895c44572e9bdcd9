"""Messages on `dock/*`: the infrared signals of a charging dock."""

from msgspec import Struct


class DockSignal(Struct, frozen=True, kw_only=True):
    """The dock's beams that are seen, each for the driver's time to live; ages since each was last seen, null: never."""

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
