"""The physics of a humanoid, moved by the twins of its servo buses."""

from collections.abc import Sequence

from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.humanoid.body import TIMESTEP_S
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.servos import Servo, servo
from lbr.simulation.measured import ImuReading, Sensed, ServoDrive, ServoFelt
from lbr.simulation.messages import HumanoidPose
from lbr.simulation.twins import PowerSwitch, ServoBus, Twin


class HumanoidPhysics:
    """The physics with its twins. `pose` and `view` are the newest; any thread may set `pick_up`, for the next step."""

    timestep_s = TIMESTEP_S

    def __init__(self, engine: HumanoidEngine, twins: Sequence[Twin], cameras: CameraHost) -> None:
        self.pose: HumanoidPose = engine.pose()
        self.view = engine.view()
        self.pick_up = False
        self._engine = engine
        self._cameras = cameras
        self._switches = [twin for twin in twins if isinstance(twin, PowerSwitch)]
        found = {twin.name: twin for twin in twins if isinstance(twin, ServoBus)}
        self._buses = [(name if name in engine.buses else "", bus) for name, bus in found.items()]

    def advance(self, now: float, dt_s: float) -> None:
        """Run for `dt_s` with the servos driven by their registers, and give them the resulting angles."""
        if self.pick_up:
            self.pick_up = False
            self._engine.pick_up()
        self._engine.step(self._drives(now), dt_s)
        felt: dict[str, dict[int, ServoFelt]] = {name: {} for name, _ in self._buses}
        for one, measured in self._engine.felt().items():
            name, number = one if isinstance(one, tuple) else ("", one)
            felt.setdefault(name, {})[number] = measured
        supply_v = self._engine.battery.voltage_v if all(switch.motors_on for switch in self._switches) else 0.0
        for name, bus in self._buses:
            bus.feel_servos(felt[name], supply_v, now)

    def resting(self, now: float) -> bool:
        """Return whether nothing moves, and the servos' registers ask for no motion."""
        return not self.pick_up and self._engine.resting and self._engine.driven(self._drives(now))

    def rest(self, dt_s: float) -> None:
        """Let time pass in which nothing has moved."""
        self._engine.rest(dt_s)

    def imu(self) -> ImuReading:
        """Return the inertial unit's measurement at the newest step."""
        return self._engine.imu()

    def look(self, now: float) -> Sensed:
        """Look around, also through the cameras."""
        self.pose, self.view = self._engine.pose(), self._engine.view()
        if self._cameras.running:
            self._cameras.show(self.view, now)
        return self._engine.sensed()

    def moved_by(self, twin: Twin) -> bool:
        """Return whether a twin moves joints, or gives their servos power."""
        return isinstance(twin, PowerSwitch | ServoBus)

    def at_rest(self, now: float) -> bool:  # noqa: ARG002
        """Return True: a servo's motion ends with its bus."""
        return True

    def _drives(self, now: float) -> dict[Servo, ServoDrive]:
        """Return the motor state of each servo."""
        return {servo(name, number): drive for name, bus in self._buses for number, drive in bus.drives(now).items()}
