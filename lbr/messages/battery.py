"""Messages on `battery/*`."""

from typing import Literal

from msgspec import Struct

BatteryLevel = Literal["unknown", "ok", "low", "critical"]


class BatteryState(Struct, frozen=True, kw_only=True):
    """The main battery. `rest_voltage_v` is what it would show without its load, and `charge` (0 to 1) comes from that.

    `source` is what feeds the robot: `mains` while it is being charged.
    """

    valid: bool
    reason: str = ""
    voltage_v: float | None = None
    rest_voltage_v: float | None = None
    current_a: float | None = None
    charge: float | None = None
    charging: bool | None = None
    source: Literal["battery", "mains"] | None = None
    level: BatteryLevel = "unknown"
