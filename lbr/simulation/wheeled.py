"""The physics of a robot on wheels, moved by the twins of its motor controllers."""

from collections.abc import Sequence

from lbr.messages.kinematics import TWO
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.engine import Engine
from lbr.simulation.measured import ImuReading, Sensed
from lbr.simulation.model import TIMESTEP_S
from lbr.simulation.twins import MotorDrive, Twin, WheelDrive


class WheeledPhysics:
    """The physics with its twins. `pose` and `ranges_m` are the newest."""

    timestep_s = TIMESTEP_S

    def __init__(self, engine: Engine, twins: Sequence[Twin], cameras: CameraHost) -> None:
        self.pose, self.ranges_m = engine.pose(), engine.ranges_m
        self._engine = engine
        self._pairs = [twin for twin in twins if isinstance(twin, WheelDrive)]
        self._motors = [twin for twin in twins if isinstance(twin, MotorDrive) and not isinstance(twin, WheelDrive)]
        self._cameras = cameras

    def advance(self, now: float, dt_s: float) -> None:
        """Run for `dt_s` with the power of the motor controllers."""
        self._engine.drive(self._powers(now), dt_s)

    def resting(self, now: float) -> bool:
        """Return whether nothing moves or is about to."""
        return self._engine.resting and self.at_rest(now)

    def rest(self, dt_s: float) -> None:
        """Let time pass in which nothing has moved."""
        self._engine.rest(dt_s)

    def imu(self) -> ImuReading:
        """Return an inertial unit's measurement at the newest step."""
        return self._engine.imu()

    def look(self, now: float) -> Sensed:
        """Look around, also through the cameras."""
        sensed = self._engine.sensed()
        self.pose, self.ranges_m = self._engine.pose(), sensed.ranges_m
        if self._cameras.running:
            self._cameras.show(self._engine.view(), now)
        return sensed

    def moved_by(self, twin: Twin) -> bool:
        """Return whether a twin turns wheels."""
        return isinstance(twin, WheelDrive | MotorDrive)

    def at_rest(self, now: float) -> bool:
        """Return whether no wheel has power."""
        return not any(self._powers(now).values())

    def _powers(self, now: float) -> dict[str, float]:
        """Return the power of each motor."""
        powers: dict[str, float] = {}
        for pair in self._pairs:
            powers |= dict(zip(TWO, pair.wheels(now), strict=True))
        for twin in self._motors:
            powers |= twin.motors(now)
        return powers
