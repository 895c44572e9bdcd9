"""The robot's streams as messages of ROS (REP 103, 105, 117): fields by name; missing ones are zero. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from math import inf, nan, pi, tan

from lbr.apps.bodies import turning
from lbr.apps.bodies.parts import Link, RobotModel, Sensor
from lbr.apps.bodies.turning import Place
from lbr.apps.ros2.codec import header, stamp
from lbr.bus.pictures import size_px
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.drive import DriveState
from lbr.messages.imu import ImuSample
from lbr.messages.joints import JointsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges, RangeSensor, Scan

ODOM, BASE = "odom", "base_link"
UNKNOWN = (-1.0, *(0.0,) * 8)
"""The covariance of a value that is not measured."""
CAMERA = "camera_"
"""The prefix of a body's camera in its name as a capability."""
LENS = Place(turn=(0.5, -0.5, 0.5, -0.5))
"""The turn to a camera's axes in ROS: z ahead, x to the right, y down."""
ULTRASOUND, INFRARED = 0, 1
CHARGING, DISCHARGING, NOT_CHARGING = 1, 2, 3
OK, WARN, ERROR, STALE = range(4)
Fields = dict[str, object]


def odometry(state: OdometryState, at_ns: int) -> Fields:
    """Return an Odometry."""
    return {
        "header": header(at_ns, ODOM),
        "child_frame_id": BASE,
        "pose": {"pose": pose(base(state))},
        "twist": {
            "twist": {
                "linear": {"x": state.speed_mps, "y": state.aside_mps},
                "angular": {"z": state.turn_rps},
            }
        },
    }


def base(state: OdometryState) -> Place:
    """Return the place of the base."""
    return Place((state.x_m or 0.0, state.y_m or 0.0, 0.0), turning.about((0.0, 0.0, 1.0), state.yaw_rad or 0.0))


def moving(model: RobotModel, angles: Mapping[str, float], at_ns: int) -> list[Fields]:
    """Return the transforms of links that joints move."""
    return [
        transform(parent(link, model), link.name, placed(link, angles.get(link.joint, 0.0), model), at_ns)
        for link in model.links
        if moves(link, model)
    ]


def fixed(model: RobotModel, sensors: Iterable[RangeSensor], at_ns: int) -> list[Fields]:
    """Return the transforms of fixed links, cameras and range sensors."""
    links = [
        transform(parent(link, model), link.name, placed(link, 0.0, model), at_ns)
        for link in model.links
        if not moves(link, model) and link.name != BASE
    ]
    eyes = [
        transform(
            sensor.link or BASE,
            CAMERA + sensor.name,
            Place(sensor.xyz, turning.by_euler(sensor.rpy, "XYZ")).then(LENS),
            at_ns,
        )
        for sensor in model.sensors
        if sensor.kind == "camera"
    ]
    return [*links, *eyes, *(transform(BASE, frame(sensor), _seat(sensor), at_ns) for sensor in sensors)]


def moves(link: Link, model: RobotModel) -> bool:
    """Return whether a joint with a row moves a link; wheels are drawn without their turning."""
    joint = model.joints.get(link.joint) if link.joint else None
    return joint is not None and joint.kind != "wheel"


def parent(link: Link, model: RobotModel) -> str:
    """Return the parent frame of a link."""
    return link.parent if any(link.parent == one.name for one in model.links) else BASE


def placed(link: Link, value: float, model: RobotModel) -> Place:
    """Return the place of a link in its parent, with its joint at a value."""
    at = Place(link.origin_xyz, turning.by_euler(link.origin_rpy, "XYZ"))
    joint = model.joints.get(link.joint)
    if joint is not None and joint.kind == "slide":
        x, y, z = link.axis
        return at.then(Place((x * value, y * value, z * value)))
    return at.then(Place(turn=turning.about(link.axis, value))) if link.joint and value else at


def frame(sensor: RangeSensor) -> str:
    """Return the frame of a range sensor."""
    return f"{sensor.name}_range"


def _seat(sensor: RangeSensor) -> Place:
    turn = turning.product(
        turning.about((0.0, 0.0, 1.0), sensor.yaw_rad), turning.about((0.0, 1.0, 0.0), sensor.pitch_rad)
    )
    return Place((sensor.x_m, sensor.y_m, sensor.z_m), turn)


def transform(parent_: str, child: str, at: Place, at_ns: int) -> Fields:
    """Return a TransformStamped."""
    place = pose(at)
    return {
        "header": header(at_ns, parent_),
        "child_frame_id": child,
        "transform": {"translation": place["position"], "rotation": place["orientation"]},
    }


def pose(at: Place) -> Fields:
    """Return a Pose."""
    return {"position": _xyz(at.xyz), "orientation": _turn(at.turn)}


def joint_states(state: JointsState, at_ns: int) -> Fields:
    """Return a JointState of the measured joints; an unknown speed is NaN."""
    measured = {name: joint for name, joint in state.joints.items() if joint.position_rad is not None}
    return {
        "header": header(at_ns, ""),
        "name": list(measured),
        "position": [joint.position_rad for joint in measured.values()],
        "velocity": [nan if joint.speed_rps is None else joint.speed_rps for joint in measured.values()],
    }


def imu(sample: ImuSample, attitude: AttitudeState | None, at_ns: int) -> Fields:
    """Return an Imu, with the robot's own orientation if it is known."""
    turn = attitude.orientation if attitude is not None and attitude.valid else None
    return {
        "header": header(at_ns, BASE),
        "orientation": _turn(turn or turning.NO_TURN),
        "angular_velocity": _xyz(sample.gyro_rps or (0.0, 0.0, 0.0)),
        "linear_acceleration": _xyz(sample.accel_mps2 or (0.0, 0.0, 0.0)),
        **({} if turn else {"orientation_covariance": UNKNOWN}),
        **({} if sample.gyro_rps else {"angular_velocity_covariance": UNKNOWN}),
        **({} if sample.accel_mps2 else {"linear_acceleration_covariance": UNKNOWN}),
    }


def laser_scan(scan: Scan, sensor: RangeSensor, at_ns: int) -> Fields:
    """Return a LaserScan, dated by its first ray."""
    took_s = scan.scan_s or 0.0
    return {
        "header": header(at_ns - round(took_s * 1e9), frame(sensor)),
        "angle_min": scan.angle_min_rad,
        "angle_max": scan.angle_max_rad,
        "angle_increment": scan.angle_increment_rad,
        "time_increment": took_s / max(1, len(scan.ranges_m)),
        "scan_time": took_s,
        "range_min": scan.range_min_m,
        "range_max": scan.range_max_m,
        "ranges": scan.metres(),
    }


def range_(ranges: Ranges, sensor: RangeSensor, at_ns: int) -> Fields | None:
    """Return a Range of a sensor; None if it measured nothing."""
    metres = ranges.metres(sensor.name)
    if metres is None and ranges.status.get(sensor.name) != "over_range":
        return None
    return {
        "header": header(at_ns - round(ranges.ages_s.get(sensor.name, 0.0) * 1e9), frame(sensor)),
        "radiation_type": ULTRASOUND if sensor.kind == "ultrasonic" else INFRARED,
        "field_of_view": min(sensor.fov_rad, 2 * pi),
        "min_range": sensor.min_m,
        "max_range": sensor.max_m,
        "range": inf if metres is None else metres,
    }


def battery(state: BatteryState, at_ns: int) -> Fields:
    """Return a BatteryState; unknown values are NaN, and a current that flows out is negative."""
    charging = {True: CHARGING, False: NOT_CHARGING if state.source == "mains" else DISCHARGING, None: 0}
    return {
        "header": header(at_ns, ""),
        "voltage": _known(state.voltage_v),
        "temperature": nan,
        "current": nan if state.current_a is None else -state.current_a,
        "charge": nan,
        "capacity": nan,
        "design_capacity": nan,
        "percentage": _known(state.charge),
        "power_supply_status": charging[state.charging],
        "present": state.voltage_v is not None,
    }


def picture(data: bytes, camera: str, at_ns: int) -> Fields:
    """Return a CompressedImage."""
    return {"header": header(at_ns, camera), "format": "jpeg", "data": data}


def camera_info(data: bytes, camera: str, body: Sensor | None, at_ns: int) -> Fields:
    """Return a CameraInfo of a picture; without a known field of view, that of an uncalibrated camera.

    The lens is assumed to have no distortion, and its centre that of the picture.
    """
    width, height = size_px(data) or (0, 0)
    fields: Fields = {"header": header(at_ns, camera), "width": width, "height": height}
    if body is None or not body.fov_rad or not height:
        return fields
    f, x, y = height / 2 / tan(body.fov_rad / 2), width / 2, height / 2
    return fields | {
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": [f, 0.0, x, 0.0, f, y, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [f, 0.0, x, 0.0, 0.0, f, y, 0.0, 0.0, 0.0, 1.0, 0.0],
    }


def diagnostics(robot: str, states: Mapping[str, object], at_ns: int) -> Fields:
    """Return a DiagnosticArray with the state of each part; a missing state is stale."""
    return {
        "header": {"stamp": stamp(at_ns)},
        "status": [_status(robot, name, state) for name, state in sorted(states.items())],
    }


def _status(robot: str, name: str, state: object) -> Fields:
    reason, code = getattr(state, "reason", ""), getattr(state, "code", "")
    if state is None:
        level, reason = STALE, "nothing comes from it"
    elif isinstance(state, DriveState):
        level = ERROR if state.estop else WARN if state.limited_by else OK
    elif isinstance(state, JointsState):
        level = ERROR if state.estop or any(joint.faults for joint in state.joints.values()) else OK
    elif isinstance(state, BatteryState) and state.valid:
        level = {"low": WARN, "critical": ERROR}.get(state.level, OK)
    else:
        level = OK if getattr(state, "valid", True) else WARN
    values = {"code": code, **({"level": state.level} if isinstance(state, BatteryState) else {})}
    return {
        "level": level,
        "name": f"{robot}: {name}",
        "message": reason or ("" if level != OK else "OK"),
        "hardware_id": robot,
        "values": [{"key": key, "value": value} for key, value in values.items() if value],
    }


def _known(value: float | None) -> float:
    return nan if value is None else value


def _xyz(xyz: Sequence[float]) -> Fields:
    return dict(zip("xyz", xyz, strict=True))


def _turn(turn: Sequence[float]) -> Fields:
    return dict(zip("wxyz", turn, strict=True))
