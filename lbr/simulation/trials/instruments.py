"""The reports of a robot's drivers on the simulated world, with their rates and faults."""

from collections.abc import Mapping
from math import atan2, degrees, hypot, inf, radians, remainder, tau
from random import Random

from lbr.bus import keys
from lbr.capability.config import ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.stage import ROUND_S, Stage
from lbr.messages.attitude import AttitudeState
from lbr.messages.dock import DockSignal
from lbr.messages.motors import MotorSetpoint, MotorsState, MotorState
from lbr.messages.sensing import Ranges, RangeStatus, ranges
from lbr.messages.sighting import SightingState
from lbr.simulation.engine import Engine
from lbr.simulation.trials.faults import Faults

MOTORS_S, RANGES_S, ATTITUDE_S, DOCK_S, SIGHTING_S = 0.06, 0.1, 0.04, 0.11, 0.07
"""The intervals of reports, as measured on a running robot; a beam comes nine times a second."""
SETPOINT_S = 0.1
"""The motor driver ignores an older setpoint."""
BEAM_S = 1.5
TURN_NOISE_DPS = 0.1
EYE, FIELD_DEG = "front", (72.0, 45.0)
"""The camera that looks for a ball, with the width and height of its field; nothing hides a ball here."""
BEARING_NOISE_DEG, DISTANCE_NOISE = 0.5, 0.03


class Instruments:
    """Publishes the known messages on the keys of capabilities that are not on the stage.

    `pose` is the truth about the robot at the end of the last round.
    """

    def __init__(
        self,
        board: Stage,
        others: Mapping[str, tuple[ProcessConfig, Kind]],
        engine: Engine,
        random: Random,
        faults: Faults,
        compass_error_deg: float,
    ) -> None:
        self._board = board
        self._engine = engine
        self._random = random
        self._faults = faults
        self._compass_error_deg = compass_error_deg
        self._began_s = board.now
        self.pose = engine.pose()
        self._turned = degrees(self.pose.yaw_rad)
        self._rate_dps = 0.0
        self._seen: dict[str, float] = {}
        self._setpoint, self._setpoint_s = MotorSetpoint(left=0.0, right=0.0), -inf
        self._share = {"left": 1.0, "right": 1.0}
        self._slipped_s = -inf
        self._counts: dict[str, float] = {}
        self._before: dict[str, int] = {}
        tellers = {MotorsState: (MOTORS_S, self._motors), Ranges: (RANGES_S, self._ranges),
                   AttitudeState: (ATTITUDE_S, self._attitude), DockSignal: (DOCK_S, self._dock),
                   SightingState: (SIGHTING_S, self._sighting)}  # fmt: skip
        self._due: list[list[float]] = []
        self._tell = []
        for name, (config, kind) in sorted(others.items()):
            for output, message in kind.outputs.items():
                if message in tellers and output in config.outputs:
                    period_s, tell = tellers[message]
                    board.names.add(name)
                    self._due.append([board.now + random.uniform(0.0, period_s), period_s])
                    self._tell.append((keys.port(board.robot, name, output), name, tell))
            for port, message in kind.setpoints.items():
                if message is MotorSetpoint:
                    board.listen(keys.port(board.robot, name, port), MotorSetpoint, self._take)

    def round(self) -> None:
        """Move the world for one round, and publish the states that are due."""
        now = self._board.now
        self._slip(now)
        self._engine.drive(self.powers, ROUND_S)
        self.pose = self._engine.pose()
        yaw = degrees(self.pose.yaw_rad)
        turned = degrees(remainder(radians(yaw - self._turned), tau))
        self._turned += turned
        self._rate_dps = -turned / ROUND_S
        for due, (key, name, tell) in zip(self._due, self._tell, strict=True):
            if now >= due[0]:
                due[0] += due[1]
                message = tell(now)
                if message is not None:
                    self._board.put(key, message, name)

    @property
    def powers(self) -> dict[str, float]:
        """Return the present power of each motor."""
        if self._board.now - self._setpoint_s > SETPOINT_S:
            return {}
        setpoint = self._setpoint
        given = dict(setpoint.motors) or {"left": setpoint.left, "right": setpoint.right}
        return {motor: power * self._share.get(motor, 1.0) for motor, power in given.items()}

    def _take(self, setpoint: MotorSetpoint) -> None:
        self._setpoint, self._setpoint_s = setpoint, self._board.now

    def _slip(self, now: float) -> None:
        if self._faults.slip and now - self._slipped_s > 2.0:
            self._slipped_s = now
            self._share = {side: self._random.uniform(1.0 - self._faults.slip, 1.0) for side in self._share}

    def _motors(self, now: float) -> MotorsState:
        sensed = self._engine.sensed()
        fresh = now - self._setpoint_s <= SETPOINT_S
        for motor, measured in sensed.motors.items():
            gone = measured.counts - self._before.get(motor, measured.counts)
            self._before[motor] = measured.counts
            self._counts[motor] = self._counts.get(motor, measured.counts) + gone / self._share.get(motor, 1.0)
        amps = {motor: measured.amps_a for motor, measured in sensed.motors.items()}
        counts = {motor: round(count) for motor, count in self._counts.items()}
        given = self._setpoint.motors if fresh else {}
        return MotorsState(
            left=self._setpoint.left if fresh else 0.0,
            right=self._setpoint.right if fresh else 0.0,
            armed=True,
            reason="",
            estop=False,
            voltage_v=round(sensed.battery_v, 1),
            amps_left_a=round(amps.get("left", 0.0), 1),
            amps_right_a=round(amps.get("right", 0.0), 1),
            counts_left=counts.get("left"),
            counts_right=counts.get("right"),
            motors={
                motor: MotorState(power=given[motor], amps_a=round(amps.get(motor, 0.0), 1), counts=counts.get(motor))
                for motor in given
            },
        )

    def _ranges(self, now: float) -> Ranges | None:
        if now - self._began_s >= self._faults.blind_s:
            return None
        metres = self._engine.ranges_m
        status: dict[str, RangeStatus] = {name: "over_range" if one is None else "ok" for name, one in metres.items()}
        return ranges(metres, {"bottom": "missing", **status}, RANGES_S)

    def _attitude(self, now: float) -> AttitudeState | None:
        if now - self._began_s >= self._faults.lost_s:
            return None
        rate_dps = self._rate_dps + self._random.gauss(0.0, TURN_NOISE_DPS)
        heading_deg = (-self._turned + self._compass_error_deg) % 360.0
        return AttitudeState(
            valid=True,
            epoch="trial",
            measured_s=now,
            roll_rad=0.0,
            pitch_rad=0.0,
            yaw_rad=remainder(radians(90.0 - heading_deg), tau),
            heading_deg=heading_deg if heading_deg < 360.0 else 0.0,
            turned_deg=-self._turned,
            turn_rate_dps=rate_dps,
            still=abs(rate_dps) < 1.0,
            magnetic=True,
            calibrated=True,
        )

    def _dock(self, now: float) -> DockSignal:
        deaf = self._faults.deaf if now - self._began_s >= self._faults.deaf_s else frozenset()
        for beam in self._engine.sensed().beams:
            if beam not in deaf:
                self._seen[beam] = now
        ages = {beam: now - seen_s for beam, seen_s in self._seen.items()}
        return DockSignal(
            left=ages.get("left", inf) < BEAM_S,
            right=ages.get("right", inf) < BEAM_S,
            power=ages.get("power", inf) < BEAM_S,
            left_age_s=ages.get("left"),
            right_age_s=ages.get("right"),
            power_age_s=ages.get("power"),
        )

    def _sighting(self, _now: float) -> SightingState:
        found = self._ball()
        if found is None:
            return SightingState(watching=True, pictures_hz=1.0 / SIGHTING_S, reason="it is not in the picture")
        bearing_deg, distance_m = found
        return SightingState(
            watching=True,
            seen=True,
            bearing_deg=bearing_deg + self._random.gauss(0.0, BEARING_NOISE_DEG),
            distance_m=distance_m * (1.0 + self._random.gauss(0.0, DISTANCE_NOISE)),
            age_s=0.0,
            pictures_hz=1.0 / SIGHTING_S,
        )

    def _ball(self) -> tuple[float, float] | None:
        """Return the bearing and the distance of the nearest ball that is in the picture."""
        mount, seen = self._engine.settings.cameras.get(EYE), []
        for name in self._engine.settings.balls if mount is not None else ():
            at = self._engine.balls.middle(name, self._engine.time_s)
            if at is None or mount is None:
                continue
            x, y, up = at[0] - self.pose.x_m, at[1] - self.pose.y_m, at[2] - mount.z_m
            bearing = -degrees(remainder(atan2(y, x) - self.pose.yaw_rad - radians(mount.yaw_deg), tau))
            above = degrees(atan2(up, hypot(x, y))) + mount.pitch_deg
            if abs(bearing) < FIELD_DEG[0] / 2 and abs(above) < FIELD_DEG[1] / 2:
                seen.append((hypot(x, y, up), bearing))
        return min(seen)[::-1] if seen else None
