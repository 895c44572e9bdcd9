"""A camera as a capability: it publishes every picture at once, and closes the device when switched off.

Without a subscriber it rests. A program that sometimes asks for the newest picture gets one of the last half second.
"""

from dataclasses import dataclass

from lbr.bus import pictures
from lbr.capability import picture_files
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.drivers.camera import CameraSettings, switch_memory
from lbr.drivers.camera.capture import Capture
from lbr.drivers.camera.picture import Picture
from lbr.drivers.camera.source import open_source
from lbr.errors import InputError
from lbr.messages.camera import CameraState, JpegFrame, SnapshotCommand, SnapshotReply, SwitchCommand
from lbr.messages.leases import CommandReply

STATE_PERIOD_S = 0.95
"""A little less than a second, so that the second round at 2 Hz publishes."""
OFF_S, ON_S = 0.6, 1.1
"""The time limits of the reply to `switch`, off and on, whatever the outcome; their sum is less than a caller's
patience."""
CLOSE_S = 0.3
NEWEST_S = 1.0
SWITCHING_HZ, RESTING_HZ = 10.0, 2.0
"""Its rounds: pictures, commands and the first viewer wake it anyway."""
REST_AFTER_S = 2.0
OPENING_S = 1.5
"""The time that a device may take to open before that is reported."""


@dataclass(frozen=True, slots=True)
class _Switching:
    """A pending switch; `was_on` is the previous position."""

    call: Call
    on: bool
    was_on: bool
    until: float


class Camera(Capability[CameraSettings]):
    """Publishes the newest picture. `switch` turns it on and off, even while its device is away.

    The capture's own thread opens the device, and reopens it whenever it was lost.
    """

    rate_hz = SWITCHING_HZ

    def __init__(self, ctx: Context[CameraSettings]) -> None:
        super().__init__(ctx)
        self._on = switch_memory.remembered(ctx.home, ctx.robot, ctx.name, otherwise=ctx.settings.on)
        self._capture: Capture | None = None
        self._switching: _Switching | None = None
        self._newest: Picture | None = None
        self._frames = self._dropped_before = 0
        self._fps: float | None = None
        self._state_at = self._counted_at = self._opened_at = self._watched_at = 0.0
        self._counted = 0
        self._published_key = ("", False)

    def step(self) -> None:
        """Publish the picture and state, and open or close the device as the switch requires."""
        self._follow_switch()
        self._follow_viewers()
        self._publish_picture()
        self._answer_switch()
        self._tell()
        rests = self._switching is None and (self._capture is None or self._capture.rests)
        self.rate_hz = RESTING_HZ if rests else SWITCHING_HZ

    def command(self, call: Call) -> None:
        """Switch it, or save a picture."""
        if isinstance(call.message, SwitchCommand):
            self._switch(call, on=call.message.on)
        elif isinstance(call.message, SnapshotCommand):
            call.reply(self._saved(call.message.name))

    def close(self) -> None:
        """Close the device."""
        if self._capture is not None:
            self._capture.stop()
            self._capture.join(CLOSE_S)
            self._capture = None

    def _switch(self, call: Call, *, on: bool) -> None:
        if self._switching is not None:
            self._switching.call.refuse(f"{self.ctx.name} was switched again by {call.source}", "superseded")
        self._switching = _Switching(call, on, self._on, self.ctx.clock() + (ON_S if on else OFF_S))
        self._want(on=on)

    def _want(self, *, on: bool) -> None:
        self._on = on
        switch_memory.keep(self.ctx.home, self.ctx.robot, self.ctx.name, on=on)
        self._follow_switch()

    def _follow_switch(self) -> None:
        capture = self._capture
        if capture is not None:
            if not self._on:
                capture.stop()
                self._forget()
            if not (capture.stopping and capture.ended):
                return
            capture.join(CLOSE_S)
            self._dropped_before += capture.dropped
            self._capture = None
        if self._on:
            device, settings = self.device_row, self.ctx.settings
            self._opened_at = self.ctx.clock()
            self._capture = Capture(lambda: open_source(device, settings), self.ctx.wake, fps=settings.fps)
            self._watched_at = self._opened_at

    def _follow_viewers(self) -> None:
        now = self.ctx.clock()
        if self.ctx.watched("frame"):
            self._watched_at = now
        if self._capture is not None:
            self._capture.rest(rests=now - self._watched_at > REST_AFTER_S)

    def _forget(self) -> None:
        """Withdraw the old picture of a camera that is off or away."""
        self._newest = None
        self.ctx.forget("frame")

    def _publish_picture(self) -> None:
        picture = self._capture.take() if self._capture is not None and self._on else None
        if self._newest is not None and self._capture is not None and self._capture.phase == "lost":
            self._forget()
        if picture is not None:
            self._newest = picture
            self._frames += 1
            self.ctx.publish("frame", JpegFrame(picture.data), taken_s=picture.taken_s)

    def _answer_switch(self) -> None:
        waiting, capture = self._switching, self._capture
        if waiting is None:
            return
        late = self.ctx.clock() > waiting.until
        if not waiting.on:
            if capture is None:
                self._answer(CommandReply(accepted=True))
            elif late:
                self._answer(CommandReply(accepted=False, reason="its device is not closed yet", code="timeout"))
        elif capture is None or capture.stopping or capture.phase == "opening":
            if late:
                self._answer(CommandReply(accepted=True, reason="it is opening"))
        elif capture.phase == "streaming":
            self._answer(CommandReply(accepted=True))
        else:
            self._want(on=waiting.was_on)
            self._answer(CommandReply(accepted=False, reason=capture.reason, code="unreachable"))

    def _answer(self, reply: CommandReply) -> None:
        waiting, self._switching = self._switching, None
        if waiting is not None:
            waiting.call.reply(reply)

    def _saved(self, name: str) -> SnapshotReply:
        newest = self._newest
        if newest is None or self.ctx.clock() - newest.taken_s > NEWEST_S:
            reason = self._state().reason or "no picture has come yet"
            return SnapshotReply(
                accepted=False, reason=reason if self._on else f"{self.ctx.name} is off", code="unreachable"
            )
        try:
            if name:
                path = picture_files.save(self.ctx.home, name, newest.data)
            else:
                path = picture_files.save_now(self.ctx.home, self.ctx.name, newest.data)
        except InputError as err:
            return SnapshotReply(accepted=False, reason=str(err), code=err.code)
        return SnapshotReply(accepted=True, reason=f"saved as {path}", path=str(path))

    def _tell(self) -> None:
        now = self.ctx.clock()
        due = now >= self._state_at
        if due:
            self._fps = round((self._frames - self._counted) / (now - self._counted_at), 1) or None
            self._counted, self._counted_at, self._state_at = self._frames, now, now + STATE_PERIOD_S
        state = self._state()
        changed = (state.phase + state.reason, state.on) != self._published_key
        if not (due or changed):
            return
        self._published_key = (state.phase + state.reason, state.on)
        self.ctx.publish("state", state)
        if state.phase == "streaming":
            self.ctx.ready()
        elif state.phase == "off":
            self.ctx.ready("off")
        elif state.phase == "lost" or now - self._opened_at > OPENING_S:
            self.ctx.warn(
                state.reason or "waiting for the first picture", "unreachable" if state.reason else "not_ready"
            )

    def _state(self) -> CameraState:
        capture, newest = self._capture, self._newest
        size = pictures.size_px(newest.data) if newest is not None else None
        return CameraState(
            on=self._on,
            phase=capture.phase if capture is not None else "off",
            device=self.device_row.address,
            width_px=size[0] if size else None,
            height_px=size[1] if size else None,
            fps=self._fps if capture is not None and capture.phase == "streaming" else None,
            frames=self._frames,
            dropped=self._dropped_before + (capture.dropped if capture is not None else 0),
            rests=capture is not None and capture.rests,
            reason=capture.reason if capture is not None else "",
            code="unreachable" if capture is not None and capture.reason else "",
        )
