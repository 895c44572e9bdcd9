"""The power operation in process: its context is lists, its time goes on by the test, its motions and joints obey."""

import time
from types import SimpleNamespace

from msgspec.structs import replace

from lbr.capability.context import Received
from lbr.messages.drive import GoalResult
from lbr.messages.joints import PlayCommand
from lbr.messages.leases import CommandReply
from lbr.messages.power import ArmCommand, CancelCommand, UpsState
from lbr.operations.power import KIND
from tests.support.machine import Stopwatch
from tests.support.replies import dead

TICK_S = 0.05
GOOD = UpsState(valid=True, source="external", external_v=11.5, battery_v=4.1)
LOW = replace(GOOD, external_v=9.5)


class Asked:
    def __init__(self, replies):
        self._replies = replies

    def answers(self):
        return self._replies


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
        ctx.results.append(GoalResult(goal="goal-1", result="reached", reason="", elapsed_s=self.takes_s))
        return dead("it is over", "done")

    def asked(self, *requests):
        return [message for _, request, message in self.log if request in requests]


class Context:
    robot, name, home, on_tick = "tester", "power", "/nowhere", True

    def __init__(self, bus="", calibration=None, **settings):
        self.settings = KIND.settings(device="ups", bus=bus, **settings)
        self.calibration = dict(calibration or {})
        self.now = 1000.0
        self.body = Body()
        self.inbox, self.results, self.published, self.events, self.phases = [], [], [], [], []
        self.wired = {"park": ("motions",), "halt": ("motions",), "let_go": ("joints",), "say": ("speech",)}

    def clock(self):
        return self.now

    def take(self, port):
        box = self.inbox if port == "ups" else self.results
        taken = [Received(message, None, self.now, port) for message in box]
        box.clear()
        return taken

    def targets(self, request):
        return self.wired.get(request, ())

    def ask(self, request, message, timeout_s):
        reply = self.body.ask(self, request, message)
        if request == "park" and isinstance(message, PlayCommand) and not message.lease and reply.accepted:
            reply = self.body.play(self, message)
        return Asked({self.wired[request][0]: reply})

    def publish(self, output, message):
        self.published.append(message)

    def event(self, kind, text, *, level="info", data=None, code="", about=""):
        self.events.append((kind, text, level))

    def keep_calibration(self, values):
        self.calibration |= values

    def ready(self, reason=""):
        self.phases.append("ready")

    def warn(self, reason):
        self.phases.append(reason)

    def wake(self):
        pass


class Running:
    """The capability on that context; `go` lets time pass, with a reading each second."""

    def __init__(self, **options):
        self.ctx = Context(**options)
        self.power = KIND.load()(self.ctx)
        self.power.open()
        self._read_at = self.ctx.now

    @property
    def state(self):
        return self.ctx.published[-1]

    def go(self, for_s, ups=LOW):
        for _ in range(round(for_s / TICK_S)):
            if ups is not None and self.ctx.now >= self._read_at:
                self._read_at = self.ctx.now + 1.0
                self.ctx.inbox.append(ups)
            self.step()
        return self.state

    def step(self):
        self.power.step()
        if self.ctx.published and self.state.phase == "powering_off" and self.ctx.settings.bus:
            self.wait_for(lambda: self.state.phase != "powering_off")
        self.ctx.now += TICK_S

    def wait_for(self, wanted, within_s=5.0):
        """Let logind's thread have its time; the test's stands still meanwhile."""
        watch = Stopwatch()
        while not wanted():
            assert not watch.over(within_s), (self.state, self.ctx.events)
            time.sleep(0.002)
            self.power.step()

    def say(self, message):
        said = []
        call = SimpleNamespace(
            name="arm", message=message, source="console",
            reply=lambda answer: said.append(answer.reason), refuse=lambda why, _code: said.append(f"refused: {why}"),
        )  # fmt: skip
        self.power.command(call)
        return said

    def arm(self, **thresholds):
        return self.say(ArmCommand(armed=True, **thresholds))

    def disarm(self):
        return self.say(ArmCommand(armed=False))

    def cancel(self, reason=""):
        return self.say(CancelCommand(reason=reason))

    def kinds(self):
        return [kind for kind, _, _ in self.ctx.events]

    def told(self, kind):
        return next(text for one, text, _ in self.ctx.events if one == kind)
