"""The beacon as a capability: the kernel decides about leases, a manoeuvre about motion, every message passes here."""

from math import inf
from typing import Any

from lbr.capability.context import Call, Context
from lbr.leases.lease import LeaseRequest
from lbr.messages.beacon import BeaconState, SeekCommand
from lbr.messages.codes import Reason
from lbr.operations.lender import LeasingCapability, new_goal, origin_of
from lbr.operations.statistics import Beat
from lbr.robots.lbr.beacon import BeaconSettings
from lbr.robots.lbr.beacon.kernel import Begin, Event, Halt, Outputs, Over, Seek, State, Tick, decide, first_state
from lbr.robots.lbr.beacon.manoeuvres import Memory, script
from lbr.robots.lbr.beacon.pilot import Pilot
from lbr.robots.lbr.beacon.senses import BlindError
from lbr.robots.lbr.beacon.view import Ending, Script

LOOKS_HZ = 10.0
SEEKING_HZ, IDLE_HZ = 20.0, 5.0
PATIENCE_S = 5.0
"""The pause of a robot without attitude or ranges before it gives up: a replugged device, or a restarted process, is
back by then."""
STATE_EVERY_S = 0.5


class Beacon(LeasingCapability[BeaconSettings, State]):
    """Does one manoeuvre at a time, for the holder of its lease, by a lease of the drive."""

    ends, tick = "the search for the dock is shutting down", Tick()
    feeds = ("drive",)
    rate_hz = IDLE_HZ
    woken_by_streams = False
    received_while_read = frozenset({"attitude", "ranges", "dock"})

    def __init__(self, ctx: Context[BeaconSettings]) -> None:
        super().__init__(ctx)
        self._pilot = Pilot(ctx)
        self._memory = Memory(ctx.settings.side)
        self._script: Script[Ending] | None = None
        self._looks = Beat(LOOKS_HZ)
        self._seen_s = -inf
        self._before_v: float | None = None
        self._reported: BeaconState | None = None
        self._reported_at = -inf
        self.begin()

    def first(self) -> State:
        """Return the state before any manoeuvre."""
        return first_state(self.ctx.settings.ttl_s, self.ctx.clock())

    def decide(self, event: Event, now: float) -> tuple[State, Outputs]:
        """Return the kernel's decision on an event."""
        return decide(self._state, event, now)

    def step(self) -> None:
        """Process arrived messages, and continue the manoeuvre."""
        self.listen()
        self.happen(Tick())
        self._go_on()
        self.rate_hz = IDLE_HZ if self._state.lease is None else SEEKING_HZ
        self.report()

    def lend(self, call: Call) -> None:
        """Handle `seek`."""
        command = call.message
        if not isinstance(command, SeekCommand):
            super().lend(call)
            return
        ask = LeaseRequest(
            content=command.manoeuvre,
            moves=True,
            lease=command.lease,
            take_over=command.take_over,
            ttl_s=command.ttl_s,
            **origin_of(call),
        )
        self.happen(Seek(ask=ask, manoeuvre=command.manoeuvre, new_goal=new_goal(), trouble=self.trouble()), call)

    def hear(self) -> None:
        """Process the robot's messages; a stop by another sender ends the manoeuvre."""
        self._pilot.listen()
        lease, stopped = self._state.lease, self._pilot.stopped
        if lease is not None and stopped is not None:
            self.happen(Over(goal=lease.motion.goal, how="stopped", why=stopped))

    def not_at_rest(self) -> str:
        """Return an empty string: the drive moves, and acknowledges the stop itself."""
        return ""

    def trouble(self) -> Reason | None:
        """Return why the drive would not follow, or None."""
        names = self.ctx.targets("move")
        if names and any(self.ctx.alive(name) for name in names):
            return None
        return Reason("unreachable", f"the drive ({', '.join(names) or 'none is wired'}) is not running")

    def pass_on(self, output: Any, call: Call | None) -> None:
        """Publish an output, reply, or stop or move the robot."""
        match output:
            case Begin(seeking=seeking):
                lease = self._state.lease
                self._pilot.halt("another manoeuvre begins")
                self._pilot.begin(lease.source if lease is not None else "")
                self._script = script(seeking.manoeuvre, self.ctx.settings, self._memory)
                self._pilot.do(next(self._script))
                self._seen_s = self.ctx.clock()
                if seeking.manoeuvre == "follow":
                    self._before_v = self._pilot.rest_voltage_v
            case Halt(why=why):
                self._script = None
                self._pilot.halt(why)
            case _:
                super().pass_on(output, call)

    def report(self) -> None:
        """Publish the state twice a second, and at once when it changed."""
        state, now = self._described(), self.ctx.clock()
        if state != self._reported or not now - self._reported_at < STATE_EVERY_S:
            self._reported, self._reported_at = state, now
            self.ctx.publish("state", state)

    def _go_on(self) -> None:
        lease, now = self._state.lease, self.ctx.clock()
        if lease is None or self._script is None or not self._looks.due(now):
            return
        goal = lease.motion.goal
        try:
            view = self._pilot.look()
        except BlindError as err:
            self._pilot.break_off(str(err))
            if now - self._seen_s > PATIENCE_S:
                self.happen(Over(goal=goal, how="fault", why=Reason("stale_sensor", str(err))))
            return
        self._seen_s = now
        try:
            self._pilot.do(self._script.send(view))
        except StopIteration as end:
            ended: Ending = end.value
            self._script = None
            why = Reason(ended.code, ended.text)
            self.happen(Over(goal=goal, how="reached" if ended.good else "fault", why=why))

    def _described(self) -> BeaconState:
        lease = self._state.lease
        volts, before = self._pilot.rest_voltage_v, self._before_v
        aside, why = self._memory.aside, self._state.why
        return BeaconState(
            manoeuvre=lease.motion.manoeuvre if lease is not None else "",
            holder=lease.source if lease is not None else None,
            goal=lease.motion.goal if lease is not None else None,
            dock_side="" if not aside else "right" if aside > 0.0 else "left",
            risen_v=None if volts is None or before is None else round(volts - before, 2),
            reason=why.text if lease is None and why is not None else "",
            code=why.code if lease is None and why is not None else "",
        )
