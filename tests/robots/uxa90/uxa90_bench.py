"""The loop's side of the UXA-90's API without a robot: requests are answered by a script, and time is what a test says."""

from math import inf
from types import SimpleNamespace
from typing import Any

from lbr.apps.web.bridge import Bridge
from lbr.apps.web.kind import KIND, WebSettings
from lbr.apps.web.robot import Robot, Snapshot
from lbr.capability.context import Received
from lbr.messages.drive import GoalResult
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import Joint, JointsState, JointState, MotionRow, MotionsState, MotionStep, motions_of
from lbr.messages.leases import CommandReply
from lbr.robots.uxa90.rest.service import Service
from lbr.testing import FakeContext
from tests.support import databases

ROWS = databases.of_robot("uxa90")
SHIPPED = SimpleNamespace(
    joints=ROWS.of(Joint),
    motors=ROWS.of(Motor),
    buttons=ROWS.of(Button),
    motions=motions_of(ROWS.of(MotionRow), ROWS.of(MotionStep)),
)
"""What a UXA-90 is shipped with."""


class PendingReply:
    """A question; `answer` it."""

    def __init__(self, request: str, message: Any) -> None:
        self.request = request
        self.message = message
        self.found: dict[str, Any] | None = None

    def answer(self, **answer: Any) -> None:
        self.found = {"other": CommandReply(**answer)}

    def reply(self, answer: Any) -> None:
        self.found = {"other": answer}

    def answers(self) -> dict[str, Any] | None:
        return self.found


class WebContext(FakeContext):
    """A context whose questions wait for the test, and whose clock never stands still."""

    def __init__(self) -> None:
        motions = (row for motion in SHIPPED.motions for row in motion.rows)
        rows = (*SHIPPED.joints, *SHIPPED.motors, *SHIPPED.buttons, *motions)
        super().__init__(KIND, WebSettings(faces=("uxa90",)), robot="uxa90", name="web", given=rows)

    def clock(self) -> float:
        self.now += 1e-6
        return self.now

    def ask(self, request: str, message: Any, timeout_s: float, **_: Any) -> PendingReply:
        del timeout_s
        self.asked.append(PendingReply(request, message))
        return self.asked[-1]


class Bench:
    """Work with its fakes. `joints` says yes by itself, unless a test takes it away."""

    def __init__(self) -> None:
        self.ctx = WebContext()
        self.failed: list[Exception] = []
        self.bridge = Bridge(lambda: None, self.failed.append)
        self.robot = Robot(self.ctx, self.bridge, None, None)
        self.work = Service(self.robot)
        self.leases = 0
        self.refusal = ""
        self.answered = 0
        self.automatic = True

    def query(self, text: str) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for part in filter(None, text.split("&")):
            name, _, value = part.partition("=")
            found.setdefault(name, []).append(value)
        return found

    def begin(self, work: Any) -> Any:
        """Have a request's work begin; what becomes of it is the result of what is returned."""
        return self.robot.start(work)

    def asked_motor(self, text: str, **options: Any) -> Any:
        work = self.work.motor(
            self.query(text),
            lambda role: None,
            measured=options.get("measured", False),
            came_s=options.get("came_s", inf),
        )
        return self.begin(work)

    def motor(self, text: str, **options: Any) -> Any:
        """Return what /motor?TEXT is answered with; raises Refused."""
        return self._result(self.asked_motor(text, **options))

    def several(self, *items: Any, unit: str = "", came_s: float = inf) -> Any:
        query = {"unit": [unit]} if unit else {}
        return self._result(self.begin(self.work.several({"motors": list(items)}, query, came_s)))

    def play(self, key: str, came_s: float = inf) -> Any:
        return self._result(self.begin(self.work.play(key, came_s)))

    def _result(self, promise: Any) -> Any:
        self.run()
        return promise.result(0)

    def run(self, seconds: float = 0.0) -> None:
        """Let rounds of the loop go by, 20 ms each, at least two."""
        for _ in range(max(3, round(seconds / 0.02))):
            self.ctx.now += 0.02 if seconds else 0.0
            self._answer()
            self.bridge.serve()
            self.work.step(self.ctx.clock())
            self.robot.moved = self.robot.played = ()

    def say(self, joints: JointsState | None = None, motions: MotionsState | None = None) -> None:
        """Have the robot be heard."""
        self.robot.snapshot = Snapshot(
            at=self.ctx.now,
            inputs={
                name: Received(message, None, self.ctx.now, name)
                for name, message in (("joints", joints), ("motions", motions))
                if message
            },
        )

    def sent(self, request: str = "move") -> list[Any]:
        """Return what was asked for, without mere renewals."""
        every = [asked.message for asked in self.ctx.asked if asked.request == request]
        return [message for message in every if request != "move" or message.positions]

    def ended(self, goal: str, how: str = "reached", reason: str = "there") -> GoalResult:
        return GoalResult(goal=goal, result=how, reason=reason, elapsed_s=0.1)  # type: ignore[arg-type]

    def _answer(self) -> None:
        for asked in self.ctx.asked[self.answered :] if self.automatic else ():
            self.answered += 1
            if asked.found is not None:
                continue
            lease = getattr(asked.message, "lease", "")
            if self.refusal:
                asked.answer(accepted=False, reason=self.refusal)
            elif asked.request in {"move", "play"}:
                self.leases += not lease
                asked.answer(accepted=True, lease=lease or f"lease-{self.leases}", goal=f"goal-{self.leases}")
            else:
                asked.answer(accepted=True)


def joints_state(**options: Any) -> JointsState:
    """Return joints that stand somewhere."""
    neck = JointState(id=23, position_rad=0.499, load=0.1, raw=100, trusted=True, age_s=0.01)
    head = JointState(id=24, raw=77, trusted=False, age_s=0.02)
    return JointsState(
        **{
            "sequence": 1, "measured_s": 1.0, "moving": False, "phase": "holding",
            "joints": {"neck_yaw": neck, "head_pitch": head}, **options,
        }
    )  # fmt: skip
