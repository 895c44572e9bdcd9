"""The call as a process: media in a thread beside the loop. It moves nothing and switches no camera."""

from math import inf
from typing import TYPE_CHECKING

from lbr.apps.call.desk import Connect, Desk
from lbr.apps.call.kind import CallSettings
from lbr.apps.call.messages import CallState, Hears, KeepCommand, RingCommand, RingReply
from lbr.capability.base import Capability
from lbr.capability.context import Call as Asked
from lbr.capability.context import Context, Received
from lbr.messages.camera import CameraState
from lbr.messages.codes import Code, Reason
from lbr.messages.leases import CommandReply, refused

if TYPE_CHECKING:
    from lbr.apps.call.media import Media, PeerNews

STATE_EVERY_S = 1.0
CURRENT_S = 1.0
"""The time without a picture of one camera after which another camera's are shown."""
PREFIX = "camera_"
INSTALL = "pip install 'lbr[telepresence]'"


class Call(Capability[CallSettings]):
    """Admits pages, and shows them the camera that is on. A camera that is off stays off."""

    rate_hz = 10.0

    def __init__(self, ctx: Context[CallSettings]) -> None:
        super().__init__(ctx)
        self._desk = Desk(ctx.settings)
        self._media: Media | None = None
        self._cameras: dict[str, CameraState] = {}
        self._camera, self._seen_s = "", -inf
        self._published: CallState | None = None
        self._publish_at = -inf

    def open(self) -> None:
        """Start the media, if their packages are installed."""
        try:
            from lbr.apps.call.media import Media  # noqa: PLC0415 - without it the page is told why there are no calls
        except ImportError as err:
            self._desk.lacks = f"calls need the extra 'telepresence' ({err.name} is missing): {INSTALL}"
            self.ctx.warn(self._desk.lacks, "not_possible")
        else:
            self._media = Media(self.ctx.wake, self.ctx.settings.microphone, simulated=self.ctx.simulated)

    def step(self) -> None:
        """Pass pictures on, and read the results of connections."""
        now, media = self.ctx.clock(), self._media
        for received in self.ctx.take("cameras"):
            self._cameras[received.source] = received.message
        if self._desk.any:
            for received in self.ctx.take("frames"):
                self._look(received, now)
        else:
            self._look_at_states(now)
        while media is not None and media.news:
            self._note(media.news.popleft())
        self._desk.tick(now)
        self._carry_out()
        self._publish_state(now)

    def command(self, call: Asked) -> None:
        """Answer a page that rings or stays, or a word of the robot's owner."""
        message, now = call.message, self.ctx.clock()
        if isinstance(message, RingCommand):
            reply = self._desk.ring(message, now)
            call.reply(self._whole(reply))
        elif isinstance(message, KeepCommand):
            reply = self._desk.keep(message.id, now, leave=message.leave)
            call.reply(self._whole(reply), quiet=True)
        elif call.name == "answer":
            call.reply(_replied(self._desk.answer(call.source, now)))
        elif call.name in {"decline", "end"}:
            call.reply(_replied(self._desk.finish(call.source, declined=call.name == "decline")))
        else:
            super().command(call)
        self._carry_out()
        self._publish_state(now)

    def close(self) -> None:
        """End every connection."""
        self._desk.close(Reason("shutting_down", "the call's process ends"))
        self._desk.orders.clear()
        if self._media is not None:
            self._media.stop()
            self._media = None

    def _look_at_states(self, now: float) -> None:
        """Choose the camera that a call would show, from the states alone: pictures are read during calls only."""
        streaming = [
            name for name, state in self._cameras.items() if state.phase == "streaming" and self.ctx.alive(name)
        ]
        if streaming:
            self._camera = self._camera if self._camera in streaming else streaming[0]
            self._seen_s = now

    def _look(self, received: Received, now: float) -> None:
        camera = received.source
        if camera != self._camera and now - self._seen_s < CURRENT_S:
            return  # two cameras are on: keep showing the first
        self._camera, self._seen_s = camera, now
        if self._media is not None:
            self._media.show(received.message.data, received.arrived)

    def _note(self, change: "PeerNews") -> None:
        if change.outcome == "answer":
            self._desk.answered(change.id, change.text)
        elif change.outcome == "connected":
            self._desk.connected(change.id)
        else:
            code: Code = "malformed" if change.outcome == "refused" else "unreachable"
            self._desk.lost(change.id, Reason(code, change.text))

    def _carry_out(self) -> None:
        orders, self._desk.orders = self._desk.orders, []
        if self._media is not None:
            for order in orders:
                if isinstance(order, Connect):
                    self._media.connect(order.id, order.purpose, order.offer)
                else:
                    self._media.close(order.id)
        news, self._desk.news = self._desk.news, []
        for one in news:
            self.ctx.event(one.kind, one.text, level=one.level, code=one.code)

    def _whole(self, reply: RingReply) -> RingReply:
        """Add the state of picture and sound to a reply."""
        if not reply.accepted or reply.phase == "idle":
            return reply
        hears, sound = self._sound
        fields = {name: getattr(reply, name) for name in ("id", "phase", "answer")}
        return RingReply(
            accepted=True, picture=self._no_picture(), hears=hears, sound=sound, seen=self._desk.displays > 0, **fields
        )

    @property
    def _sound(self) -> tuple[Hears, str]:
        return (self._media.hears, self._media.sound) if self._media is not None else ("silence", "")

    def _no_picture(self) -> str:
        """Return why there is no picture; empty if there is one."""
        if self.ctx.clock() - self._seen_s <= CURRENT_S:
            return self._media.broken if self._media is not None else ""
        cameras = {name: state for name, state in self._cameras.items() if self.ctx.alive(name)}
        if not cameras:
            return "no camera is there"
        if on := [name for name, state in cameras.items() if state.on]:
            name = on[0]
            return f"{name.removeprefix(PREFIX)}: {cameras[name].reason or 'no picture comes'}"
        return "the camera is off: the call does not switch it on"

    def _publish_state(self, now: float) -> None:
        desk, caller, (hears, sound) = self._desk, self._desk.caller, self._sound
        state = CallState(
            phase=desk.phase,
            caller=caller.name if caller is not None else "",
            at_once=self.ctx.settings.answer == "at_once",
            by_webrtc=desk.pictured,
            most=self.ctx.settings.most,
            displays=desk.displays,
            camera=self._camera.removeprefix(PREFIX) if not self._no_picture() else "",
            picture=self._no_picture(),
            hears=hears,
            sound=sound,
            reason=desk.last.text,
            code=desk.last.code,
            calls=desk.calls,
            lacks=desk.lacks,
        )
        if now >= self._publish_at or state != self._published:
            self._published, self._publish_at = state, now + STATE_EVERY_S
            self.ctx.publish("state", state)


def _replied(why: Reason | None) -> CommandReply:
    return CommandReply(accepted=True) if why is None else refused(why)
