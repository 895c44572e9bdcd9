"""The telemetry in the names and units of the robot lbr's first program. Pure.

A value that was never measured is not made up: its part is left out, or it is null. Distances keep the ring's own
numbers, for clients that compare with them. They are `over_range_cm` for nothing within reach, 0 for a missing or
failing sensor, and -1 without a fresh reading.
"""

import time
from collections.abc import Callable, Mapping
from math import degrees
from typing import Any, TypeVar

from lbr.capability.context import Received
from lbr.messages.schema import JsonObject
from lbr.messages.sensing import Ranges
from lbr.messages.telemetry import AmperagesPart, BatteryPart, CountsPart, ImuPart, Telemetry, VoltagesPart

SENSORS = {"Forward": "forward", "Left": "left", "Right": "right", "Back": "back", "Bottom": "bottom"}
STALE_S = 2.0
"""The age limit of distances, which are measured ten times a second."""
GRAVITY_MPS2 = 9.81
GYRO_SIGNS = (-1, 1, -1)
"""Clockwise is positive, as is nose down."""
LOW_V = 10.6
"""The voltage below which the voltages are included: as an alarm, and at no other time."""
LASTING = ("amperages", "Bat", "Count")
"""Parts that keep their last values, as `MPU` does: state machines read them in every round."""
OFF = {"device": "", "status": "off"}
P = TypeVar("P", ImuPart, AmperagesPart, BatteryPart, CountsPart, VoltagesPart)


def package(
    telemetry: Received | None, ranges: Received | None, now: float, wall: float, over_range_cm: int
) -> dict[str, object]:
    """Return the telemetry, `now` by the clock of messages' dates and `wall` in seconds since 1970."""
    telling: dict[str, object] = {}
    if ranges is not None:
        age_s = ranges.age_s(now)
        telling["Ranges"] = _ranges(ranges.message, over_range_cm, fresh=age_s <= STALE_S)
        telling["Timestamp"] = round(wall - age_s, 3)
    if telemetry is None:
        return telling
    parts: Telemetry = telemetry.message
    more_s = telemetry.age_s(now)

    def add(name: str, part: P | None, make: Callable[[P, float], object]) -> None:
        made = make(part, round(wall - more_s - part.age_s, 3)) if part is not None else None
        if made is not None:
            telling[name] = made

    add("MPU", parts.imu, _mpu)
    add("amperages", parts.amperages, _amperages)
    add("Bat", parts.battery, _battery)
    add("Count", parts.counts, _count)
    add("voltages", parts.voltages, _voltages)
    if parts.dock_signal is not None:
        seen, at = parts.dock_signal, wall - more_s - parts.dock_signal.age_s
        telling["dockSignal"] = {"time": round(at, 3), "left": int(seen.left), "right": int(seen.right)}
    if parts.cameras is not None:
        telling["cameras"] = cameras(telemetry)
    return telling


def lasting(before: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, object]:
    """Return the telemetry, completed with previous parts; each of these keeps its own old time."""
    completed = {**{name: before[name] for name in LASTING if name in before}, **now}
    if imu := _lasting_imu(before.get("MPU", {}), now.get("MPU", {})):
        completed["MPU"] = imu
    return completed


def cameras(telemetry: Received | None) -> dict[str, object]:
    """Return the cameras and their switches; `off` means no camera."""
    part = telemetry.message.cameras if telemetry is not None else None
    if part is None:
        return {}
    states = {
        name: {"device": camera.device, "status": "on" if camera.on else "off"} for name, camera in part.cameras.items()
    }
    return {**states, "off": dict(OFF)}


def with_beams(telemetry: JsonObject, seen: Mapping[str, float], wall: float) -> dict[str, object]:
    """Return the package with beams of the dock reported by others: the age of each beam, in seconds."""
    if not seen:
        return telemetry
    signal = telemetry.get("dockSignal", {"left": 0, "right": 0, "time": 0.0})
    newest = round(wall - min(seen.values()), 3)
    merged = {name: 1 if name in seen else signal[name] for name in ("left", "right")}
    return {**telemetry, "dockSignal": {"time": max(newest, signal["time"]), **merged}}


def _lasting_imu(before: Mapping[str, object], now: Mapping[str, object]) -> dict[str, object]:
    """Return the inertial unit's values, completed with previous ones: as old as the oldest."""
    kept = {name: one for name, one in before.items() if one is not None and now.get(name) is None}
    return {**now, **kept, "time": before["time"]} if kept else dict(now)


def _ranges(ranges: Ranges, over_range_cm: int, *, fresh: bool) -> dict[str, int]:
    cycle_ms = round(1000 * ranges.cycle_s) if ranges.cycle_s is not None and fresh else 0
    found = {name: _cm(ranges, sensor, over_range_cm) if fresh else -1 for name, sensor in SENSORS.items()}
    return {**found, "Deltat": cycle_ms}


def _cm(ranges: Ranges, sensor: str, over_range_cm: int) -> int:
    metres = ranges.metres(sensor)
    if metres is not None:
        return int(round(100 * metres, 6))
    return over_range_cm if ranges.status.get(sensor) == "over_range" else 0


def _mpu(part: ImuPart, at: float) -> dict[str, object]:
    gyro = _gyro(part)
    accel, quaternion = part.accel_mps2, part.orientation
    return {
        "gyro": None if gyro is None else [*gyro, at],
        "accel": None if accel is None else [round(one / GRAVITY_MPS2, 4) for one in accel],
        "mag": None if part.mag_ut is None else [round(one, 4) for one in part.mag_ut],
        "heading": None if part.heading_deg is None else round(part.heading_deg, 1) % 360,
        "temp": None if part.temperature_c is None else round(part.temperature_c, 1),
        "time": at,
        "quat": None if quaternion is None else "{:.3f} {:+.3f}i {:+.3f}j {:+.3f}k".format(*quaternion),
        "qangle": None if part.turned_deg is None else round(part.turned_deg, 2),
    }


def _gyro(part: ImuPart) -> list[float] | None:
    if part.gyro_rps is None:
        return None
    return [round(sign * degrees(one), 3) + 0.0 for sign, one in zip(GYRO_SIGNS, part.gyro_rps, strict=True)]


def _amperages(part: AmperagesPart, at: float) -> dict[str, object] | None:
    if part.left_a is None or part.right_a is None:
        return None  # an unmeasured current is not sent as 0: state machines wait for that
    return {"leftMotor": round(part.left_a, 1) + 0.0, "rightMotor": round(part.right_a, 1) + 0.0, "time": _text(at)}


def _battery(part: BatteryPart, _at: float) -> dict[str, object] | None:
    if part.voltage_v is None:
        return None
    level = None if part.charge is None else round(part.charge, 2)
    return {"voltage": round(part.voltage_v, 2), "level": level, "source": "AC" if part.source == "mains" else "BAT"}


def _count(part: CountsPart, at: float) -> dict[str, object] | None:
    if part.left is None or part.right is None:
        return None
    return {"left": part.left, "right": part.right, "time": at}


def _voltages(part: VoltagesPart, at: float) -> dict[str, object] | None:
    if part.battery_v is None or not part.battery_v < LOW_V:
        return None
    return {
        "mainBattery": part.battery_v,
        "internal": part.internal_v,
        "vout": part.output_v,
        "time": _text(at),
    }


def _text(at: float) -> str:
    """Return a time as C's asctime formats it, in the robot's time zone."""
    return time.asctime(time.localtime(at))
