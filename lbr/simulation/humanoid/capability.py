"""The capability `humanoid_world`: a body on a floor, and an emulated twin for each device row of a known type."""

from collections.abc import Sequence
from functools import partial
from math import degrees

from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.joints import Joint
from lbr.messages.leases import CommandReply
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.portrait import portrait
from lbr.simulation.humanoid.servos import Servo, servo
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.loop import Physics
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.messages import HumanoidPose
from lbr.simulation.requests import BallRequest, HandRequest, PickUpReply, PickUpRequest, PictureRequest
from lbr.simulation.twins import PowerSwitch, ServoBus, Twin
from lbr.simulation.world import SimulatedWorld


class HumanoidPhysics(Physics[HumanoidEngine]):
    """The physics with its twins. `pose` and `view` are the newest; any thread may set `pick_up`, for the next step."""

    def __init__(self, engine: HumanoidEngine, twins: Sequence[Twin], cameras: CameraHost) -> None:
        super().__init__(engine, cameras)
        self.pose: HumanoidPose = engine.pose()
        self.view = engine.view()
        self.pick_up = False
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


class HumanoidWorld(SimulatedWorld[HumanoidWorldSettings]):
    """A body on a floor; publishes its pose."""

    def __init__(self, ctx: Context[HumanoidWorldSettings]) -> None:
        super().__init__(ctx)
        self._engine: HumanoidEngine | None = None
        self._physics: HumanoidPhysics | None = None
        self._was: HumanoidPose | None = None

    def open(self) -> None:
        """Put the body at its start, plug the twins in and start time."""
        self._was = None
        engine = self._engine = HumanoidEngine(self.ctx.settings, self.ctx.rows(Joint), self.ctx.home)
        self._physics = self.begin(engine, partial(HumanoidPhysics, engine), mounts=engine.body.cameras)

    def tell_pose(self, now: float) -> None:
        """Publish the pose, less often while nothing moves, and report what a bystander would see."""
        pose = self._running()[0].pose
        self.publish_pose(pose, now, supply_v=0.0, time_s=0.0)
        self._tell(pose)

    def command(self, call: Call) -> None:
        """Answer `ball`, `fault`, `hand`, `pick_up`, `picture` and `plug`."""
        physics, engine = self._running()
        if isinstance(call.message, PictureRequest):
            self._picture(call, call.message)
        elif isinstance(call.message, PickUpRequest):
            physics.pick_up = True
            call.reply(PickUpReply(accepted=True, reason=f"{self.ctx.robot} is {self._as_it_began()}"))
        elif isinstance(call.message, BallRequest):
            engine.balls.answer(self.ctx, call, call.message)
        elif isinstance(call.message, HandRequest):
            try:
                call.reply(CommandReply(accepted=True, reason=engine.grip.take(call.message)))
            except InputError as err:
                call.refuse(str(err), err.code)
        else:
            super().command(call)

    def _running(self) -> tuple[HumanoidPhysics, HumanoidEngine]:
        if self._physics is None or self._engine is None:
            raise RuntimeError("the world is not open")
        return self._physics, self._engine

    def _tell(self, pose: HumanoidPose) -> None:
        """Report what a bystander would see."""
        was, self._was = self._was, pose
        if was is None:
            return
        robot, rests = self.ctx.robot, bool(self.ctx.settings.rests)
        if was.held and not pose.held:
            self.ctx.event("let_go", f"the helper's hand has released it: {robot} {_stance(pose)} by itself")
        if was.upright and not pose.upright:
            lean = f"rolled {degrees(pose.roll_rad):.0f} and pitched {degrees(pose.pitch_rad):.0f} degrees"
            again = "as it began" if rests else "back on its feet"
            self.ctx.event("fallen", f"{robot} has fallen, {lean}; pick_up puts it {again}", level="warning")
        elif rests and pose.upright and was.stands != pose.stands:
            self.ctx.event(_stance(pose), f"{robot} {_stance(pose)}")

    def _as_it_began(self) -> str:
        """Return the result of picking it up, in words; only the world's thread knows whether a servo has torque."""
        if not self.ctx.settings.rests:
            return "in a helper's hand, on its feet"
        return "back as it began, or in a helper's hand if it has torque"

    def _picture(self, call: Call, request: PictureRequest) -> None:
        physics, engine = self._running()
        pose, view, body = physics.pose, physics.view, engine.body
        size = (request.width_px, request.height_px)
        self._painter.ask(call, request.path, lambda: portrait(body, view, pose, size))


def _stance(pose: HumanoidPose) -> str:
    return "stands" if pose.stands else "sits"
