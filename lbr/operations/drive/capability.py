"""The process around the drive kernel: it passes arrivals and the time to the kernel, and publishes the outputs."""

from collections.abc import Mapping
from functools import partial
from math import inf

from lbr.capability.context import Call, Context, Received
from lbr.messages.codes import Reason
from lbr.messages.drive import CheckVerdict, DriveState
from lbr.messages.kinematics import Kinematics, Wheel, base_of
from lbr.messages.motors import MotorSetpoint
from lbr.messages.sensing import RangeSensor
from lbr.operations.drive.command import check_request
from lbr.operations.drive.granting import to_be_checked
from lbr.operations.drive.kernel import decide, drive_state, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import (
    AttitudeSeen,
    Command,
    Event,
    MotorsLost,
    MotorsSeen,
    OdometrySeen,
    Outputs,
    RangesSeen,
    ScanSeen,
    State,
    Tick,
    motors_trouble,
)
from lbr.operations.lender import Answers, LeasingCapability, new_goal, origin_of

STATE_PERIOD_S = 0.1
RESTING_PERIOD_S = 0.5
"""Half of the age at which readers call the state too old."""
RESTING_HZ = 2.0
"""The rate at rest, where setpoints only show that the drive is alive."""
RESTS_AFTER_S = 0.5
"""The time after a motion for which zero continues at its rate, so that no lost message leaves the base moving."""
MOTIONS = frozenset({"command", "turn", "heading", "twist"})
NO_ANSWERS: Mapping[str, object] = {}
UNANSWERED: Mapping[str, object] = {"(none in time)": None}


class Drive(LeasingCapability[DriveSettings, State]):
    """Drive operations: every decision is the kernel's, every message passes here."""

    ends, driver, tick = "drive operations end", "motors", Tick()
    feeds = ("motors", "ranges", "scans", "attitude", "odometry")

    def __init__(self, ctx: Context[DriveSettings]) -> None:
        self._base = base_of(ctx.rows(Kinematics), ctx.rows(Wheel), ctx.settings.track_m)
        super().__init__(ctx)
        self.rate_hz = ctx.settings.rate_hz
        self.begin()

    def open(self) -> None:
        """Start without a holder of the base, and publish zero at once."""
        self.begin()
        self.listen()
        self.happen(Tick())

    def close(self) -> None:
        """Publish zero; end the current motion."""
        self.ctx.publish("setpoint", MotorSetpoint(left=0.0, right=0.0))
        super().close()

    def begin(self) -> None:
        """Start without a lease."""
        self._moved_at, self.rate_hz = self.ctx.clock(), self.ctx.settings.rate_hz
        super().begin()
        self._reported: DriveState | None = None
        self._reported_at = -inf

    def first(self) -> State:
        """Return the state of a base that was not moved yet."""
        return first_state(self.ctx.settings, self.ctx.clock(), self.ctx.rows(RangeSensor) or None, self._base)

    def decide(self, event: Event, now: float) -> tuple[State, Outputs]:
        """Return the kernel's decision on an event."""
        return decide(self._state, event, now)

    def driver_seen(self, received: Received) -> MotorsSeen:
        """Return the event for a state of the motor driver."""
        return MotorsSeen(motors=received.message, arrived=received.arrived)

    def driver_lost(self, names: str) -> MotorsLost:
        """Return the event for a lost motor driver."""
        return MotorsLost(reason=f"the motor driver ({names}) is gone")

    def hear(self) -> None:
        """Process ranges, scans, attitude and odometry."""
        for received in self.ctx.take("ranges"):
            self.happen(RangesSeen(ranges=received.message, arrived=received.arrived))
        for received in self.ctx.take("scans"):
            self.happen(ScanSeen(scan=received.message, arrived=received.arrived))
        for received in self.ctx.take("attitude"):
            self.happen(AttitudeSeen(attitude=received.message, arrived=received.arrived))
        for received in self.ctx.take("odometry"):
            self.happen(OdometrySeen(odometry=received.message, arrived=received.arrived))

    def lend(self, call: Call) -> None:
        """Decide a motion now, or after the replies of the user's checks, if there are any."""
        if call.name not in MOTIONS:
            super().lend(call)
            return
        event = _event(call)
        if not (self.ctx.targets("checks") and to_be_checked(self._state, event, self.ctx.clock())):
            self.happen(event, call)
            return
        question, timeout_s = (
            check_request(call.source, event.command, self.ctx.settings),
            self.ctx.settings.checks_timeout_s,
        )
        ask = partial(self.ctx.ask, "checks", question, timeout_s=timeout_s)
        self.wait_for(call, "checks", ask, timeout_s, lambda answers: self.happen(_event(call, answers), call))

    def step(self) -> None:
        """Process arrived messages, and do a round when it is due; at rest rounds are rare."""
        self._pace()
        super().step()
        self._pace()

    def rests(self) -> bool:
        """Return whether the base has stood for a while, and its motors know it."""
        now = self.ctx.clock()
        if not self._state.rests:
            self._moved_at = now
        return now - self._moved_at >= RESTS_AFTER_S

    def not_at_rest(self) -> str:
        """Return a sentence if a wheel still has to turn, or an empty string."""
        return "a wheel is still to turn" if any(self._state.sides) else ""

    def trouble(self) -> Reason | None:
        """Return why the motors would not follow, or None."""
        return motors_trouble(self._state, self.ctx.clock())

    def report(self) -> None:
        """Publish the state ten times a second, twice without a holder, and at once when it changed."""
        now = self.ctx.clock()
        state = drive_state(self._state, now, self._loop)
        rests = state.holder is None and not state.moving
        due = now - self._reported_at >= (RESTING_PERIOD_S if rests else STATE_PERIOD_S)
        if due or self._reported is None or _gist(state) != _gist(self._reported):
            self._reported, self._reported_at = state, now
            self.ctx.publish("state", state)

    def _pace(self) -> None:
        """Set the rate that the state needs: a command may change it before the step, the motors within it."""
        rate_hz = RESTING_HZ if self.rests() else self.ctx.settings.rate_hz
        if rate_hz != self.rate_hz:
            self.rate_hz = rate_hz
            self.keep_time(self.ctx.clock())


def _event(call: Call, answers: Answers = NO_ANSWERS) -> Command:
    found = UNANSWERED if answers is None else answers
    verdicts = {name: said if isinstance(said, CheckVerdict) else None for name, said in found.items()}
    return Command(command=call.message, new_goal=new_goal(), checks=verdicts, **origin_of(call))


def _gist(state: DriveState) -> tuple[object, ...]:
    """Return the values whose change is published at once."""
    stopped_by = "" if state.moving else state.reason
    asked = (state.power, state.angle_deg)
    news = bool(state.limited_by), stopped_by, state.stopped_s, state.estop
    return (state.moving, asked, state.holder, state.goal, *news)
