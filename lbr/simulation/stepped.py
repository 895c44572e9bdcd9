"""The part that the physics of all worlds share: steps of one length, and time without them while nothing moves."""

from abc import ABC, abstractmethod

from lbr.simulation.balls import Balls
from lbr.simulation.battery import BatteryState
from lbr.simulation.bindings import MjModel
from lbr.simulation.cameras.view import view_of
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.inertial import InertialUnit
from lbr.simulation.measured import ImuReading
from lbr.simulation.physics import mujoco, packed
from lbr.simulation.settings import WorldSettings


class SteppedEngine(ABC):
    """A model with a battery, balls and an inertial unit; subclasses move it."""

    def __init__(self, model: MjModel, settings: WorldSettings | HumanoidWorldSettings) -> None:
        self.timestep_s = float(model.opt.timestep)
        self.battery = BatteryState(settings.battery)
        self.balls = Balls(model, settings.balls)
        self._model, self._data = model, mujoco.MjData(model)
        self._imu = InertialUnit(settings.imu, settings.seed)
        self._owed_s = 0.0
        self._steps = 0

    @property
    def time_s(self) -> float:
        """Return the seconds that the world has run."""
        return float(self._data.time)

    @property
    @abstractmethod
    def resting(self) -> bool:
        """Return whether nothing moves: then time passes without the physics, until the next order or change."""

    def rest(self, dt_s: float) -> None:
        """Let time pass in which the world stood, before an order that has just come."""
        self._owed_s += dt_s
        self._pass_time()

    def imu(self) -> ImuReading:
        """Return an inertial unit's measurement at the newest step; cheap, for a twin that is read."""
        return self._imu.read(self._steps)

    def view(self) -> bytes:
        """Return the data of a picture of this instant."""
        return view_of(self._model, self._data)

    def packed(self) -> bytes:
        """Return the model, for the drawing process."""
        return packed(self._model)

    def _run(self, dt_s: float, *, rests: bool) -> None:
        """Run for `dt_s` in whole steps, or let it pass if the world `rests`; the remainder stays owed."""
        self._owed_s += dt_s
        if rests:
            self._pass_time()
        while self._owed_s >= self.timestep_s - 1e-9:
            self._owed_s -= self.timestep_s
            self._step_once()

    def _pass_time(self) -> None:
        """Pass the whole steps that are owed without the physics."""
        count = int(self._owed_s / self.timestep_s + 1e-6)
        self._owed_s -= count * self.timestep_s
        self._data.time += count * self.timestep_s
        self._steps += count
        self._passed(count)

    @abstractmethod
    def _passed(self, count: int) -> None:
        """Do what goes on while nothing moves, for so many steps that have just passed."""

    @abstractmethod
    def _step_once(self) -> None:
        """Do one step of the physics."""
