"""One look at the next new picture, saved with the target marked, for the user who sets the colour."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from lbr.apps.vision.eye import NO_PICTURES, camera_off
from lbr.apps.vision.settings import VisionSettings
from lbr.apps.vision.sketch import Sketch, sketch
from lbr.capability import picture_files
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.camera import SnapshotReply
from lbr.messages.tracking import LookCommand, Target

NEW_PICTURE_S = 0.6

Draw = Callable[[VisionSettings, Target, bytes], Sketch]


class Glance:
    """Looks on a thread, as that may take a while; one look at a time."""

    def __init__(self, ctx: Context[VisionSettings], draw: Draw = sketch) -> None:
        self._ctx = ctx
        self._draw = draw
        self._pool = ThreadPoolExecutor(1)
        self._to_look: tuple[Call, LookCommand, float] | None = None
        self._looking: tuple[Call, Future[Sketch]] | None = None

    def ask(self, call: Call, command: LookCommand) -> None:
        """Look at the next new picture; a camera that rested has one soon."""
        if self._looking is not None or self._to_look is not None:
            call.refuse("a picture is being looked at; wait for the answer", "busy")
        else:
            self._to_look = call, command, self._ctx.clock() + NEW_PICTURE_S
            self._look_at_new(*self._to_look)

    def step(self) -> None:
        """Continue the look, and answer when it is done."""
        if self._to_look is not None:
            self._look_at_new(*self._to_look)
        if self._looking is not None and self._looking[1].done():
            self._show(*self._looking)

    def _look_at_new(self, call: Call, command: LookCommand, until: float) -> None:
        newest, now = self._ctx.latest("frame"), self._ctx.clock()
        if newest is not None and newest.age_s(now) <= self._ctx.settings.max_age_s:
            looked = self._pool.submit(self._draw, self._ctx.settings, command.target, newest.message.data)
            looked.add_done_callback(lambda _: self._ctx.wake())
            self._looking, self._to_look = (call, looked), None
        elif (why := camera_off(self._ctx.latest("camera"))) or now >= until:
            self._to_look = None
            call.refuse(why or NO_PICTURES, "unreachable")

    def _show(self, call: Call, looked: "Future[Sketch]") -> None:
        self._looking = None
        try:
            drawing = looked.result()
            path = picture_files.save_now(self._ctx.home, self._ctx.name, drawing.picture)
        except InputError as err:
            call.reply(SnapshotReply(accepted=False, reason=str(err), code=err.code))
        else:
            call.reply(SnapshotReply(accepted=True, reason=f"{drawing.text}; saved as {path}", path=str(path)))
