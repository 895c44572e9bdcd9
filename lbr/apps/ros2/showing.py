"""Publishes the robot's streams in ROS while nodes subscribe to them, dated by their measurement."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from math import inf

from lbr.apps.bodies.parts import RobotModel
from lbr.apps.ros2 import codec, conversion, topics
from lbr.apps.ros2.conversion import Fields
from lbr.apps.ros2.kind import Ros2Settings
from lbr.apps.ros2.topics import DESCRIPTION, DIAGNOSTICS, IMU, JOINT_STATES, ODOM, TF, TF_STATIC
from lbr.apps.ros2.urdf import urdf
from lbr.apps.ros2.wire import Port
from lbr.capability.context import Context, Received
from lbr.messages.attitude import AttitudeState
from lbr.messages.joints import JointsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges, RangeSensor, Scan

DIAGNOSTICS_S = 1.0
OLD_S = 3.0
PARTS = ("odometry", "attitude", "joints", "battery", "drive")


class Showing:
    """Publishes the `wanted` topics; call `step` at the loop's rate."""

    def __init__(
        self,
        ctx: Context[Ros2Settings],
        ports: Mapping[str, Port],
        model: RobotModel,
        sensors: tuple[RangeSensor, ...],
        publish: Callable[[str, bytes], None],
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._ctx = ctx
        self._ports = ports
        self._model = model
        self._sensors = {sensor.name: sensor for sensor in sensors}
        self._scans = topics.scan_topics(ctx.sources, sensors)
        self._of_cameras = [
            of(camera) for camera in ctx.sources("frames") for of in (topics.picture_topic, topics.info_topic)
        ]
        self._eyes = {conversion.CAMERA + sensor.name: sensor for sensor in model.sensors if sensor.kind == "camera"}
        self._publish = publish
        self._wall_ns = wall_ns
        self._next: dict[str, float] = {}
        self._diagnosed_s = -inf
        self.wanted: frozenset[str] = frozenset()

    def begin(self) -> None:
        """Publish the fixed transforms and the body: once for each connection, also for later subscribers."""
        now_ns = self._wall_ns()
        self._send(TF_STATIC, {"transforms": conversion.fixed(self._model, self._sensors.values(), now_ns)})
        self._send(DESCRIPTION, {"data": urdf(self._model)})

    def subscribed(self, there: Callable[[str, str], bool]) -> None:
        """Note the topics with subscribers."""
        self.wanted = frozenset(
            name for name, port in self._ports.items() if port.kind == "MP" and there(port.topic, port.type)
        )

    def step(self, now: float) -> None:
        """Publish new messages."""
        if not self.wanted:
            return
        for topic, fields in self._made(now):
            if topic in self.wanted:
                self._send(topic, fields)

    def _made(self, now: float) -> Iterator[tuple[str, Fields]]:
        for port, show in self._shows.items():
            if not self._ctx.sources(port):
                continue
            newest = self._ctx.take(port)[-1:] if port not in {"scans", "ranges"} else self._ctx.take(port)
            for received in newest:
                yield from show(received, now)
        if DIAGNOSTICS in self.wanted and now - self._diagnosed_s >= DIAGNOSTICS_S:
            self._diagnosed_s = now
            states = {one: self._state(one, now) for one in PARTS if self._ctx.sources(one)}
            yield DIAGNOSTICS, conversion.diagnostics(self._ctx.robot, states, self._wall_ns())
        if not self.wanted.isdisjoint(self._of_cameras):
            yield from self._pictures(now)

    @property
    def _shows(self) -> Mapping[str, Callable[[Received, float], Iterable[tuple[str, Fields]]]]:
        return {
            "odometry": self._odometry,
            "joints": self._joints,
            "imu": self._imu,
            "battery": self._battery,
            "ranges": self._ranges,
            "scans": self._scan,
        }

    def _odometry(self, received: Received, now: float) -> Iterator[tuple[str, Fields]]:
        state: OdometryState = received.message
        if not state.valid or state.x_m is None or not self._due("odometry", now):
            return
        at_ns = self._at_ns(received.arrived if state.counted_s is None else state.counted_s)
        yield ODOM, conversion.odometry(state, at_ns)
        placed = conversion.transform(conversion.ODOM, conversion.BASE, conversion.base(state), at_ns)
        yield TF, {"transforms": [placed]}

    def _joints(self, received: Received, now: float) -> Iterator[tuple[str, Fields]]:
        state: JointsState = received.message
        if not self._due("joints", now):
            return
        at_ns = self._at_ns(state.measured_s)
        angles = {name: one.position_rad for name, one in state.joints.items() if one.position_rad is not None}
        yield JOINT_STATES, conversion.joint_states(state, at_ns)
        yield TF, {"transforms": conversion.moving(self._model, angles, at_ns)}

    def _imu(self, received: Received, now: float) -> Iterator[tuple[str, Fields]]:
        if received.message.valid and self._due(IMU, now):
            attitude = self._state("attitude", now)
            assert attitude is None or isinstance(attitude, AttitudeState)
            yield IMU, conversion.imu(received.message, attitude, self._at_ns(received.message.time_s))

    def _battery(self, received: Received, now: float) -> Iterator[tuple[str, Fields]]:
        if received.message.valid and self._due("battery", now):
            yield topics.BATTERY, conversion.battery(received.message, self._at_ns(received.arrived))

    def _ranges(self, received: Received, now: float) -> Iterator[tuple[str, Fields]]:
        ranges: Ranges = received.message
        for name, sensor in self._sensors.items():
            topic = topics.range_topic(name)
            if topic in self.wanted and ranges.tells_of(name):
                fields = conversion.range_(ranges, sensor, self._at_ns(received.arrived))
                if fields is not None and self._due(topic, now):
                    yield topic, fields

    def _scan(self, received: Received, now: float) -> Iterator[tuple[str, Fields]]:
        scan: Scan = received.message
        topic = self._scans.get(scan.sensor, "")
        if topic in self.wanted and self._due(topic, now):
            yield topic, conversion.laser_scan(scan, self._sensors[scan.sensor], self._at_ns(received.arrived))

    def _pictures(self, now: float) -> Iterator[tuple[str, Fields]]:
        for received in self._ctx.take("frames"):
            camera, data, at_ns = received.source, received.message.data, self._at_ns(received.arrived)
            if self._due(topics.picture_topic(camera), now):
                yield topics.picture_topic(camera), conversion.picture(data, camera, at_ns)
                yield topics.info_topic(camera), conversion.camera_info(data, camera, self._eyes.get(camera), at_ns)

    def _state(self, port: str, now: float) -> object:
        """Return the newest state of a part; None if it is missing or old."""
        newest = self._ctx.latest(port)
        return newest.message if newest is not None and newest.age_s(now) <= OLD_S else None

    def _at_ns(self, mono_s: float) -> int:
        """Convert a monotonic time to the wall clock."""
        return self._wall_ns() - round((self._ctx.clock() - mono_s) * 1e9)

    def _due(self, name: str, now: float) -> bool:
        """Return whether it is due again, at the row's rate."""
        if now < self._next.get(name, now):
            return False
        self._next[name] = now + 0.9 / self._ctx.settings.rate_hz
        return True

    def _send(self, topic: str, fields: Fields) -> None:
        self._publish(topic, codec.encode(self._ports[topic].type, fields))
