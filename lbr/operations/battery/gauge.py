"""The battery's state from the motor controller's measurements. Pure: time comes with each measurement."""

from collections import deque
from math import exp, inf, isfinite

from lbr.messages.battery import BatteryLevel, BatteryState
from lbr.messages.motors import MotorsState
from lbr.operations.battery import BatterySettings, charge_at

MEDIAN_OF = 5
MEDIAN_LEAST = 3
"""The number of values that outvotes a single wrong one; the start does not wait for more."""
LEAST_V, MOST_V = 1.0, 100.0


class Gauge:
    """One battery. Voltages that are not finite are ignored, and old ones expire."""

    def __init__(self, settings: BatterySettings) -> None:
        self._settings = settings
        self._moved = False
        self._counts: tuple[int | None, ...] = (None,)
        self._recent: deque[float] = deque(maxlen=MEDIAN_OF)
        self._seen = -inf
        self._current_a: float | None = None
        self._terminal = Smooth(settings.filter_s)
        self._rest = Smooth(settings.filter_s)
        self._charger = _Charger(settings)
        self._level: BatteryLevel = "unknown"

    def see(self, motors: MotorsState, now: float) -> None:
        """Add a measurement."""
        settings, voltage_v = self._settings, motors.voltage_v
        self._moved = self._moved or _moves(motors, self._counts)
        self._counts = tuple(motor.counts for motor in motors.each.values())
        if voltage_v is None or not LEAST_V < voltage_v < MOST_V:  # this way round, NaN is ignored
            return
        if not now - self._seen <= settings.max_age_s:
            self._begin_anew()
        self._seen = now
        self._current_a = _drawn_a(motors)
        load_a = max(0.0, self._current_a or 0.0) + settings.idle_a
        self._recent.append(voltage_v + load_a * settings.internal_ohm)
        self._terminal.take(voltage_v, now)
        if len(self._recent) < MEDIAN_LEAST:
            return
        middle, ordered = len(self._recent) // 2, sorted(self._recent)
        rest_v = self._rest.take((ordered[middle] + ordered[~middle]) / 2, now)
        self._charger.see(rest_v, moving=self._moved, now=now)
        self._moved = False
        self._level = self._next_level(rest_v)

    def state(self, now: float) -> BatteryState:
        """Return the state of the battery."""
        reason = self._why_unknown(now)
        rest_v, terminal_v = self._rest.value, self._terminal.value
        if reason or rest_v is None or terminal_v is None:
            return BatteryState(valid=False, reason=reason)
        charging = self._charger.charging
        return BatteryState(
            valid=True,
            reason="on a charger the voltage does not show the charge" if charging else "",
            voltage_v=round(terminal_v, 2),
            rest_voltage_v=round(rest_v, 2),
            current_a=None if self._current_a is None else round(self._current_a, 2),
            charge=None if charging else round(charge_at(rest_v, self._settings.table), 3),
            charging=charging,
            source="mains" if charging else "battery",
            level=self._level,
        )

    def _why_unknown(self, now: float) -> str:
        age_s = now - self._seen
        if self._seen == -inf:
            return "no voltage was measured yet"
        if not age_s <= self._settings.max_age_s:
            return f"no voltage was measured for {age_s:.0f} s"
        return "measuring began just now" if self._rest.value is None else ""

    def _begin_anew(self) -> None:
        """Discard the values from before a gap: they do not describe the time after it."""
        self._recent.clear()
        self._terminal = Smooth(self._settings.filter_s)
        self._rest = Smooth(self._settings.filter_s)
        self._charger = _Charger(self._settings)
        self._level = "unknown"

    def _next_level(self, rest_v: float) -> BatteryLevel:
        settings = self._settings
        if self._charger.charging:
            return "ok"
        critical_v = settings.critical_v + (settings.critical_margin_v if self._level == "critical" else 0.0)
        if rest_v < critical_v:
            return "critical"
        low = settings.low_charge + (settings.low_margin if self._level in {"low", "critical"} else 0.0)
        return "low" if charge_at(rest_v, settings.table) < low else "ok"


class Smooth:
    """A first-order low pass; the first value counts at once."""

    def __init__(self, time_constant_s: float) -> None:
        self.value: float | None = None
        self._time_constant_s = time_constant_s
        self._at = 0.0

    def take(self, value: float, now: float) -> float:
        """Return the smoothed value after this one."""
        before, elapsed_s = self.value, max(0.0, now - self._at)
        self._at = now
        share = 1.0 if before is None or not self._time_constant_s else 1.0 - exp(-elapsed_s / self._time_constant_s)
        self.value = value if before is None else before + (value - before) * share
        return self.value


class _Charger:
    """Detects a charger. Without one, a battery may keep its voltage for a while, but never raises it."""

    def __init__(self, settings: BatterySettings) -> None:
        self.charging = False
        self._settings = settings
        self._lowest_v = -inf  # since it last drove; before that, the voltage alone decides
        self._since: float | None = None

    def see(self, rest_v: float, *, moving: bool, now: float) -> None:
        """Add a voltage at rest."""
        settings = self._settings
        if moving:
            self.charging, self._since, self._lowest_v = False, None, rest_v
            return
        self._lowest_v = min(self._lowest_v, rest_v)
        if self.charging:
            self._after(now, settings.discharging_after_s, so=rest_v < settings.discharging_v)
        else:
            risen = rest_v >= self._lowest_v + settings.charging_rise_v
            self._after(now, settings.charging_after_s, so=risen and rest_v > settings.charging_v)

    def _after(self, now: float, wait_s: float, *, so: bool) -> None:
        if not so:
            self._since = None
            return
        self._since = now if self._since is None else self._since
        if now - self._since >= wait_s:
            self.charging, self._since = not self.charging, None
            if not self.charging:
                self._lowest_v = inf


def _moves(motors: MotorsState, before: tuple[int | None, ...]) -> bool:
    """Return whether the motors move the base: pushing against an obstacle does not count."""
    each = motors.each.values()
    if not any(motor.power for motor in each):
        return False
    now = tuple(motor.counts for motor in each)
    return None in now or None in before or now != before


def _drawn_a(motors: MotorsState) -> float | None:
    """Return the current that the motors draw from the battery: each motor's current times its duty cycle."""
    pairs = ((motor.amps_a, motor.power) for motor in motors.each.values())
    parts = [amps * duty for amps, duty in pairs if amps is not None and isfinite(amps)]
    return sum(parts) if parts else None
