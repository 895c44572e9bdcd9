"""The meaning of a reading of the supply: the deciding voltage and its thresholds, or the reason for neither. Pure."""

from dataclasses import dataclass
from math import isfinite

from lbr.messages.power import UpsState
from lbr.operations.power import PowerSettings


@dataclass(frozen=True, slots=True)
class View:
    """The deciding voltage, and its thresholds; `source` names its supply. With `trouble` there is no voltage."""

    trouble: str = ""
    source: str = ""
    volts: float = 0.0
    warn_v: float = 0.0
    shutdown_v: float = 0.0
    hysteresis_v: float = 0.0
    backed: bool = False

    @property
    def low(self) -> bool:
        """Return whether the computer must be shut down if this continues."""
        return not self.trouble and self.volts < self.shutdown_v

    @property
    def wanting(self) -> bool:
        """Return whether people should be warned."""
        return not self.trouble and (self.volts < self.warn_v or self.backed)

    @property
    def well(self) -> bool:
        """Return whether the voltage is good enough to end a pending shutdown."""
        return not self.trouble and self.volts >= self.shutdown_v + self.hysteresis_v

    @property
    def fine(self) -> bool:
        """Return whether the voltage is good enough to end a warning."""
        return not self.trouble and not self.backed and self.volts >= self.warn_v + self.hysteresis_v

    @property
    def text(self) -> str:
        """The voltage in words."""
        return self.trouble or f"{self.source} {self.volts:.2f} V"


def look(ups: UpsState, warn_v: float, shutdown_v: float, settings: PowerSettings) -> View:
    """Return the meaning of a reading, with the thresholds for the external supply; an invalid reading is trouble."""
    if not ups.valid:
        return View(trouble=ups.reason or "the supply is not read")
    external_v = ups.external_v
    if external_v is None or not isfinite(external_v) or external_v < 0.0:
        return View(trouble="the external voltage was not measured")
    if not settings.battery_backs or external_v >= settings.absent_v:
        return View("", "external supply", external_v, warn_v, shutdown_v, settings.hysteresis_v)
    battery_v = ups.battery_v
    if battery_v is None or not isfinite(battery_v) or battery_v <= 0.0:
        return View(trouble="the external supply is disconnected, and the battery was not measured")
    warn_v, shutdown_v = settings.battery_warn_v, settings.battery_shutdown_v
    source = "the external supply is disconnected; battery"
    return View("", source, battery_v, warn_v, shutdown_v, settings.battery_hysteresis_v, backed=True)
