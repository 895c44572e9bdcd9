"""The message on `telemetry/package`: all the robot's readings, nested.

Parts and nesting are those of the original package of lbr robots. Its names for a program that needs them:

| here | there |
|---|---|
| `time_s` | `Timestamp` |
| `ranges.forward_m`, `left_m`, `right_m`, `back_m`, `bottom_m` | `Ranges.Forward` …, whole centimetres |
| `ranges.cycle_s` | `Ranges.Deltat`, milliseconds |
| `imu.gyro_rps` | `MPU.gyro`, degrees a second, and a fourth number, the time |
| `imu.accel_mps2` | `MPU.accel`, multiples of 9.81 |
| `imu.mag_ut`, `heading_deg`, `temperature_c` | `MPU.mag`, `heading`, `temp` |
| `imu.orientation` | `MPU.quat`, as text such as `1.000 +0.000i +0.000j +0.000k` |
| `imu.turned_deg` | `MPU.qangle` |
| `amperages.left_a`, `right_a` | `amperages.leftMotor`, `rightMotor` |
| `battery.voltage_v`, `charge` | `Bat.voltage`, `level` |
| `battery.source`: `battery`, `mains` | `Bat.source`: `BAT`, `AC` |
| `counts.left`, `right` | `Count.left`, `right` |
| `voltages.battery_v`, `internal_v`, `output_v` | `voltages.mainBattery`, `internal`, `vout` |
| `dock_signal.left`, `right` | `dockSignal.left`, `right`: 1, 0 |
| `cameras.cameras.NAME.device`, `on` | `cameras.NAME.device`, `status`: `on`, `off` |

The time of a part there is `time_s` less `age_s` here.
"""

from typing import Literal

from msgspec import Struct

from lbr.messages.battery import BatteryLevel
from lbr.messages.units import Quaternion, Vector


class RangesPart(Struct, frozen=True, kw_only=True):
    """Distances around the robot, other sensors' in `others_m`; null: not measured."""

    age_s: float
    forward_m: float | None
    left_m: float | None
    right_m: float | None
    back_m: float | None
    bottom_m: float | None
    cycle_s: float | None
    others_m: dict[str, float | None] = {}


class ImuPart(Struct, frozen=True, kw_only=True):
    """The readings of the inertial unit, along its own axes, and their attitude; as old as the older."""

    age_s: float
    gyro_rps: Vector | None = None
    accel_mps2: Vector | None = None
    mag_ut: Vector | None = None
    temperature_c: float | None = None
    heading_deg: float | None = None
    orientation: Quaternion | None = None
    turned_deg: float | None = None


class AmperagesPart(Struct, frozen=True, kw_only=True):
    """Currents of the motors, forward positive."""

    age_s: float
    left_a: float | None
    right_a: float | None


class BatteryPart(Struct, frozen=True, kw_only=True):
    """The main battery; `charge` is 0 to 1."""

    age_s: float
    voltage_v: float | None
    charge: float | None
    charging: bool | None
    source: Literal["battery", "mains"] | None
    level: BatteryLevel


class CountsPart(Struct, frozen=True, kw_only=True):
    """Counts of the wheels' encoders, and the distance by odometry, backwards negative; as old as the older."""

    age_s: float
    left: int | None
    right: int | None
    distance_m: float | None = None


class VoltagesPart(Struct, frozen=True, kw_only=True):
    """The motor controller's battery, own supply and 5 V output."""

    age_s: float
    battery_v: float | None
    internal_v: float | None
    output_v: float | None


class DockSignalPart(Struct, frozen=True, kw_only=True):
    """The visible beams of the dock."""

    age_s: float
    left: bool
    right: bool
    power: bool


class CameraPart(Struct, frozen=True, kw_only=True):
    """One camera."""

    device: str
    on: bool
    phase: str
    reason: str = ""


class CamerasPart(Struct, frozen=True, kw_only=True):
    """The camera that is on, or `off`, and the state of each."""

    age_s: float
    selected: str
    cameras: dict[str, CameraPart]


class Telemetry(Struct, frozen=True, kw_only=True):
    """The nested package of the robot's readings. A part is null until its first reading.

    `age_s`: of a part; a silent source keeps its last reading. `time_s`: of the package, in seconds since 1970.
    `complete`: every wired part has the readings that clients expect.
    """

    time_s: float
    ranges: RangesPart | None = None
    imu: ImuPart | None = None
    amperages: AmperagesPart | None = None
    battery: BatteryPart | None = None
    counts: CountsPart | None = None
    voltages: VoltagesPart | None = None
    dock_signal: DockSignalPart | None = None
    cameras: CamerasPart | None = None
    complete: bool = False
