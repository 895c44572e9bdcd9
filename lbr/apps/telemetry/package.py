"""Makes the package of the newest message of each source. Pure."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from msgspec import Struct

from lbr.capability.context import Received
from lbr.messages.attitude import AttitudeState
from lbr.messages.camera import CamerasState
from lbr.messages.imu import ImuSample
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.telemetry import (
    AmperagesPart,
    BatteryPart,
    CameraPart,
    CamerasPart,
    CountsPart,
    DockSignalPart,
    ImuPart,
    RangesPart,
    Telemetry,
    VoltagesPart,
)

P = TypeVar("P")
S = TypeVar("S", bound=Struct)
Latest = Callable[[str], Received | None]


def package(latest: Latest, now: float, time_s: float) -> Telemetry:
    """Make the package of `latest` of each source; `now` is by the clock that dates messages."""

    def part(port: str, make: Callable[[Any, float], P]) -> P | None:
        received = latest(port)
        return None if received is None else make(received.message, _age_s(received, now))

    return Telemetry(
        time_s=round(time_s, 3),
        ranges=part("ranges", _same(RangesPart)),
        imu=_imu(latest("imu"), latest("attitude"), now),
        amperages=part("motors", _amperages),
        battery=part("battery", _same(BatteryPart)),
        counts=_counts(latest("motors"), latest("odometry"), now),
        voltages=part("motors", _voltages),
        dock_signal=part("dock", _same(DockSignalPart)),
        cameras=part("cameras", _cameras),
    )


def is_complete(latest: Latest, wired: Iterable[str]) -> bool:
    """Return whether each of these sources has a value for its part."""
    return all((received := latest(port)) is not None and _has_value(port, received.message) for port in wired)


def _has_value(port: str, message: Any) -> bool:
    if port == "attitude":
        return message.heading_deg is not None
    if port == "battery":
        return message.voltage_v is not None
    return port != "motors" or message.amps_left_a is not None


def _age_s(received: Received, now: float) -> float:
    return round(max(0.0, received.age_s(now)), 3)


def _oldest_s(now: float, *sources: Received | None) -> float | None:
    return max((_age_s(received, now) for received in sources if received is not None), default=None)


def _same(kind: type[S]) -> Callable[[Struct, float], S]:
    """Return a function that makes a part from a message with the same field names."""
    names = [name for name in kind.__struct_fields__ if name != "age_s"]
    return lambda message, age_s: kind(age_s=age_s, **{name: getattr(message, name) for name in names})


def _imu(imu: Received | None, attitude: Received | None, now: float) -> ImuPart | None:
    age_s = _oldest_s(now, imu, attitude)
    if age_s is None:
        return None
    sample: ImuSample | None = imu.message if imu is not None else None
    state: AttitudeState | None = attitude.message if attitude is not None else None
    return ImuPart(
        age_s=age_s,
        gyro_rps=sample.gyro_rps if sample else None,
        accel_mps2=sample.accel_mps2 if sample else None,
        mag_ut=sample.mag_ut if sample else None,
        temperature_c=sample.temperature_c if sample else None,
        heading_deg=state.heading_deg if state else None,
        orientation=state.orientation if state else None,
        turned_deg=state.turned_deg if state else None,
    )


def _amperages(motors: MotorsState, age_s: float) -> AmperagesPart:
    return AmperagesPart(age_s=age_s, left_a=motors.amps_left_a, right_a=motors.amps_right_a)


def _counts(motors: Received | None, odometry: Received | None, now: float) -> CountsPart | None:
    if motors is None:
        return None
    state: MotorsState = motors.message
    travelled: OdometryState | None = odometry.message if odometry is not None else None
    return CountsPart(
        age_s=_oldest_s(now, motors, odometry) or 0.0,
        left=state.counts_left,
        right=state.counts_right,
        distance_m=travelled.distance_m if travelled is not None else None,
    )


def _voltages(motors: MotorsState, age_s: float) -> VoltagesPart:
    return VoltagesPart(age_s=age_s, battery_v=motors.voltage_v, internal_v=motors.internal_v, output_v=motors.output_v)


def _cameras(cameras: CamerasState, age_s: float) -> CamerasPart:
    parts = {
        name: CameraPart(device=camera.device, on=camera.on, phase=camera.phase, reason=camera.reason)
        for name, camera in cameras.cameras.items()
    }
    return CamerasPart(age_s=age_s, selected=cameras.selected, cameras=parts)
