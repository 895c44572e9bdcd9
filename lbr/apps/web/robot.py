"""The robot for faces: its rows, its newest states, and requests to it."""

from typing import TYPE_CHECKING, Any, TypeVar, cast

from msgspec import Struct

from lbr.apps.web.bridge import Bridge, Promise, until
from lbr.apps.web.face import Refused
from lbr.apps.web.sessions import Sessions
from lbr.capability.context import Context, Received
from lbr.messages.drive import GoalResult
from lbr.messages.faces import Button, EditCommand, EditReply, Motor
from lbr.messages.joints import Joint, JointsState, Motion, MotionRow, MotionsState, MotionStep, motions_of
from lbr.messages.rows import Row, by_table

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Coroutine

    from lbr.apps.web.kind import WebSettings

T = TypeVar("T")
EDIT_S = 5.0


class Snapshot(Struct, frozen=True, kw_only=True):
    """The newest message of each input; `faces` is each face's part of the states."""

    at: float
    inputs: dict[str, Received] = {}
    faces: dict[str, Any] = {}

    @property
    def joints(self) -> Received | None:
        """The last state of the joints."""
        return self.inputs.get("joints")

    @property
    def motions(self) -> Received | None:
        """The last state of the motions."""
        return self.inputs.get("motions")

    @property
    def drive(self) -> Received | None:
        """The last state of the base."""
        return self.inputs.get("drive")

    @property
    def is_latched(self) -> bool:
        """Return whether every known state of joints and drive reports the emergency stop."""
        states = [last.message for last in (self.joints, self.drive) if last is not None]
        return bool(states) and all(state.estop for state in states)

    @property
    def joints_state(self) -> JointsState | None:
        """The last message of the joints, of any age."""
        return self.joints.message if self.joints is not None else None

    @property
    def motions_state(self) -> MotionsState | None:
        """The last message of the motions, of any age."""
        return self.motions.message if self.motions is not None else None


class Robot:
    """The robot. All but `name`, `settings`, `snapshot`, `sessions` and `tell` is for the capability's loop.

    - `sessions`: the cookies that stand for tokens, for the server's thread.
    - `tell`: publishes an event.
    - `moved`, `played`: the goals of joints and motions that ended in this round.
    """

    def __init__(
        self, ctx: "Context[WebSettings]", bridge: Bridge, sessions: Sessions, tell: "Callable[[str, str], None]"
    ) -> None:
        self.sessions = sessions
        self.tell = tell
        self.ctx = ctx
        self.name = ctx.robot
        self.settings = ctx.settings
        self.joints = ctx.rows(Joint)
        self.snapshot = Snapshot(at=ctx.clock())
        self.moved: tuple[GoalResult, ...] = ()
        self.played: tuple[GoalResult, ...] = ()
        self._bridge = bridge
        self._composed: tuple[tuple[MotionRow, ...], tuple[MotionStep, ...], tuple[Motion, ...]] = (), (), ()

    @property
    def motions(self) -> tuple[Motion, ...]:
        """The present motions."""
        rows, steps = self.ctx.rows(MotionRow), self.ctx.rows(MotionStep)
        if (rows, steps) != self._composed[:2]:
            self._composed = rows, steps, motions_of(rows, steps)
        return self._composed[2]

    def motion(self, name: str) -> Motion | None:
        """Return the present motion of a name."""
        return next((motion for motion in self.motions if motion.name == name), None)

    @property
    def motors(self) -> tuple[Motor, ...]:
        """The present rows of the table `motor`."""
        return self.ctx.rows(Motor)

    @property
    def buttons(self) -> tuple[Button, ...]:
        """The present rows of the table `button`."""
        return self.ctx.rows(Button)

    def now(self) -> float:
        """Monotonic seconds."""
        return self.ctx.clock()

    async def ask(self, request: str, message: Struct, *, timeout_s: float = 1.0) -> Any:
        """Send a request that is wired to one capability, and return its answer; raise Refused (503) without one."""
        return answer_of(request, await self.ask_all(request, message, timeout_s=timeout_s))

    async def ask_all(self, request: str, message: Struct, *, timeout_s: float = 1.0) -> dict[str, Any]:
        """Send a request to all capabilities that it is wired to; return their answers, None for a missing one."""
        asked = self.ctx.ask(request, message, timeout_s)
        await until(lambda: asked.answers() is not None)
        return dict(asked.answers() or {})

    def start(self, work: "Coroutine[Any, Any, T]") -> "Promise[T]":
        """Start a coroutine that no request waits for."""
        return self._bridge.start(work)

    async def edit(
        self, rows: "Collection[Row]", *, create: bool = False, revision: int | None = None, by: str = ""
    ) -> EditReply:
        """Write rows, see `EditCommand`; once they are written, this robot has them."""
        command = EditCommand(rows=by_table(rows), create=create, revision=revision, by=by)
        reply = cast("EditReply", await self.ask("edit", command, timeout_s=EDIT_S))
        if reply.accepted:
            self.ctx.adopt(rows)
        return reply


def answer_of(request: str, answers: dict[str, Any]) -> Any:
    """Return the answer of the only capability; raise Refused (503) without one."""
    if len(answers) != 1:
        raise Refused(
            503,
            f"'{request}' must be wired to one capability by a channel row, and is to {len(answers)}",
            code="wiring",
        )
    name, answer = next(iter(answers.items()))
    if answer is None:
        raise Refused(503, f"'{name}' does not answer", {"Retry-After": "1"})
    return answer
