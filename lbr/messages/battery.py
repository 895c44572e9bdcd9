"""Messages on `battery/*`."""

from typing import Literal

from msgspec import Struct

BatteryLevel = Literal["unknown", "ok", "low", "critical"]


class BatteryState(Struct, frozen=True, kw_only=True):
    """The main battery. `rest_voltage_v`: without its load; `charge` (0 to 1) follows from it. `source`: `mains` while
    charging.
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
