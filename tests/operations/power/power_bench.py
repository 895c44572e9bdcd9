"""The power operation in process: its context is lists, its time goes on by the test, its motions and joints obey."""

from msgspec.structs import replace

from lbr.messages.calibration import measured, values
from lbr.messages.drive import GoalResult
from lbr.messages.joints import PlayCommand
from lbr.messages.leases import CommandReply
from lbr.messages.power import ArmCommand, CancelCommand, UpsState
from lbr.operations.power import KIND
from lbr.testing import FakeCall, FakeContext
from tests.support.waiting import until

TICK_S = 0.05
GOOD = UpsState(valid=True, source="external", external_v=11.5, battery_v=4.1)
LOW = replace(GOOD, external_v=9.5)


class Body:
    """Motions and joints as they answer: a motion of a second, then torque off."""

    def __init__(self):
        self.refuses = ""
        self.takes_s = 1.0
        self.holds_joints = 0
        self.lease = ""
        self.log = []

    def ask(self, ctx, request, message):
        self.log.append((round(ctx.now, 2), request, message))
        if request == "park":
            return (
                CommandReply(accepted=not self.refuses, reason=self.refuses)
                if not message.lease
                else self._renew(ctx, message)
            )
        if request == "let_go" and self.holds_joints:
            self.holds_joints -= 1
            return CommandReply(accepted=False, reason="held by motions")
        return CommandReply(accepted=True)

    def play(self, ctx, message):
        self.lease, self.until = "lease-1", ctx.now + self.takes_s
        return CommandReply(accepted=True, lease="lease-1", ttl_s=0.3, goal="goal-1")

    def _renew(self, ctx, message):
        if ctx.now < self.until:
            return CommandReply(accepted=True, lease="lease-1", ttl_s=0.3, goal="goal-1")
        ctx.arrive("parked", GoalResult(goal="goal-1", result="reached", reason="", elapsed_s=self.takes_s))
        return CommandReply(accepted=False, reason="lease is dead: it is over")

    def asked(self, *requests):
        return [message for _, request, message in self.log if request in requests]


class PowerContext(FakeContext):
    """The context of power: a body that obeys, and a supply whose readings `arrive`."""

    def __init__(self, bus="", calibration=None, **settings):
        chosen = KIND.settings(device="ups", bus=bus, **settings)
        super().__init__(KIND, chosen, robot="tester", name="power", given=tuple(measured("ups", calibration or {})))
        self.body = Body()
        self.wired = {"park": ("motions",), "halt": ("motions",), "let_go": ("joints",), "say": ("speech",)}

    @property
    def calibration(self):
        """What was written down beside the device."""
        return values(self.given)

    def targets(self, request):
        return self.wired.get(request, ())

    def answer(self, request, message):
        reply = self.body.ask(self, request, message)
        if request == "park" and isinstance(message, PlayCommand) and not message.lease and reply.accepted:
            reply = self.body.play(self, message)
        return {self.wired[request][0]: reply}


class Running:
    """The capability on that context; `go` lets time pass, with a reading each second."""

    def __init__(self, **options):
        self.ctx = PowerContext(**options)
        self.power = KIND.load()(self.ctx)
        self.power.open()
        self._read_at = self.ctx.now

    @property
    def state(self):
        return self.ctx.published[-1][1]

    def go(self, for_s, ups=LOW):
        for _ in range(round(for_s / TICK_S)):
            if ups is not None and self.ctx.now >= self._read_at:
                self._read_at = self.ctx.now + 1.0
                self.ctx.arrive("ups", ups)
            self.step()
        return self.state

    def step(self):
        self.power.step()
        if self.ctx.published and self.state.phase == "powering_off" and self.ctx.settings.bus:
            self.wait_for(lambda: self.state.phase != "powering_off")
        self.ctx.now += TICK_S

    def wait_for(self, wanted):
        """Let logind's thread have its time; the test's stands still meanwhile."""
        until(lambda: wanted() or self.power.step(), f"{self.state}, {self.ctx.events}")

    def say(self, message):
        said = []
        call = FakeCall("arm", message)
        call.reply = lambda answer, **_: said.append("refused: " * (not answer.accepted) + answer.reason)
        self.power.command(call)
        return said

    def arm(self, **thresholds):
        return self.say(ArmCommand(armed=True, **thresholds))

    def disarm(self):
        return self.say(ArmCommand(armed=False))

    def cancel(self, reason=""):
        return self.say(CancelCommand(reason=reason))

    @property
    def events(self):
        """Each event's kind, text and level."""
        return [(*event, level) for event, level in zip(self.ctx.events, self.ctx.levels, strict=True)]

    def kinds(self):
        return [kind for kind, _ in self.ctx.events]

    def told(self, kind):
        return next(text for one, text in self.ctx.events if one == kind)
