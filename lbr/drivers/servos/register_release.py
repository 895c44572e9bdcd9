"""The guard's last orders to servos whose torque, goal and limit can be read back; see `guard_release`."""

from collections import deque
from collections.abc import Collection
from math import inf

from lbr.drivers.servos.contract import ServoBus, ServoModel


class RegisterRelease:
    """Holds servos where they are, then fades the torque that they had."""

    blind = False
    least_hold_s = 0.0

    def __init__(self, bus: ServoBus, model: ServoModel, servos: Collection[int]) -> None:
        self._bus = bus
        self._model = model
        self._servos = servos
        self._limits: dict[int, int] = {}
        self._unanswered = deque(servos)

    def hold(self) -> bool:
        """Set the goal of every servo with torque to its position."""
        self._hold(len(self._unanswered))
        return bool(self._limits or self._unanswered)

    def keep(self) -> None:
        """Hold one more servo that had not answered; a lost line raises while reading."""
        self._hold(1)

    def prepare(self) -> float:
        """Return 0: nothing has to be prepared."""
        return 0.0

    def fade(self, strength: float) -> None:
        """Lower the torque limits."""
        self._bus.write_limits({one: max(1, round(limit * strength)) for one, limit in self._limits.items() if limit})

    def off(self) -> None:
        """Switch the torque of all off, also of those that never answered: they may still receive."""
        self._bus.torque_off(self._servos)

    def _hold(self, most: int) -> None:
        self._bus.drain()  # what the dead driver asked for would be taken for the place where a servo is now
        goals = {}
        for servo in [self._unanswered.popleft() for _ in range(min(most, len(self._unanswered)))]:
            state = self._bus.read_state(servo, inf)
            if state is None:
                self._unanswered.append(servo)
                continue
            motion, slow = state
            if slow.enabled:
                self._limits[servo] = slow.limit
                if motion is not None:
                    goals[servo] = self._model.holding_goal(motion.position, motion.speed, slow.goal)
        self._bus.write_positions(goals)
