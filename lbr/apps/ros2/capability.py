"""ROS 2 as a capability: publishes the robot's streams there, and leases motion for its nodes.

`graph` receives the tokens of `link`; its subscribers decide which topics `showing` publishes. `driving` receives the
samples; a holder follows its twist under a lease of the drive. `words` receives the requests.
"""

from math import inf
from pathlib import Path

from lbr.apps.bodies.model import body_file, model
from lbr.apps.ros2 import codec, topics, wire
from lbr.apps.ros2.driving import Driving, Limits, MotionMessage
from lbr.apps.ros2.graph import Graph, refusal_of
from lbr.apps.ros2.kind import SHOWN, STOP, Ros2Settings
from lbr.apps.ros2.link import Link, Request, Router, Sample
from lbr.apps.ros2.messages import Ros2State
from lbr.apps.ros2.showing import Showing
from lbr.apps.ros2.trajectory import TRAJECTORY, trajectory
from lbr.apps.ros2.wire import Endpoint
from lbr.apps.ros2.words import Reply, Words
from lbr.bus.door import TokenRight
from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.errors import InputError
from lbr.leases.client import LeaseTarget
from lbr.leases.holder import FINAL, GONE, RESULT_S, Holder
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult, TwistCommand
from lbr.messages.joints import Joint, JointsCommand
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor
from lbr.messages.system import RANKS

LENDERS = {
    TwistCommand: LeaseTarget("twist", "halt", "drive", f"the drive: {GONE}"),
    JointsCommand: LeaseTarget("joints_move", "joints_halt", "joints", f"the joints: {GONE}", result_s=RESULT_S),
}
ACTIVE_HZ, RESTING_HZ = 50.0, 4.0
PUBLISH_S, PUBLISH_NEWS_S = 2.0, 0.25
ROUTER_GONE = Reason("unreachable", "the router of ROS is gone, and with it who could stop this")
MOST_REPORTED = 200


class Ros2(Capability[Ros2Settings]):
    """A node of ROS with the robot's name."""

    rate_hz = RESTING_HZ
    woken_by_streams = False
    received_while_read = SHOWN

    def __init__(self, ctx: Context[Ros2Settings]) -> None:
        super().__init__(ctx)
        settings = ctx.settings
        denied = self._denied()
        sensors = ctx.rows(RangeSensor)
        self._ports = topics.ports(settings, ctx.sources, sensors)
        self._accepted = topics.accepted(settings, ctx.sources)
        self._joints = frozenset(one.name for one in ctx.rows(Joint))
        self._graph = Graph()
        limits = Limits(
            speed_mps=settings.speed_mps,
            turn_rps=settings.turn_rps,
            silent_s=settings.silent_s,
            late_s=settings.late_s,
        )
        self._driving = Driving(limits, denied)
        self._holder = Holder(ctx)
        self._words = Words(ctx, settings.services, denied)
        router = Router(
            connect=settings.connect,
            listen=settings.listen,
            domain=settings.domain,
            namespace=settings.namespace,
            name=ctx.robot,
        )
        self._link = Link(router, self._ports, ctx.wake, ctx.clock)
        body = model(ctx.robot, body_file(ctx.robot, Path(ctx.home)), ctx.rows(Joint), ctx.rows(Wheel), sensors)
        self._showing = Showing(ctx, self._ports, body, sensors, self._link.publish)
        self._reported: set[str] = set()
        self._count = self._refused = 0
        self._joined = False
        self._health = ""
        self._published: Ros2State | None = None
        self._published_s = -inf

    def open(self) -> None:
        """Start the connection to ROS."""
        self._link.start()

    def step(self) -> None:
        """Do one round: entities, messages, motion, publishing."""
        now = self.ctx.clock()
        self._look_after_link()
        self._look_who_is_there()
        for sample in self._link.samples():
            self._receive(sample)
        for request in self._link.requests():
            self._call(request)
        results = [one.message for one in self.ctx.take("results") if isinstance(one.message, GoalResult)]
        self._drive(now, results)
        self._words.step(results)
        self._report_losses()
        if self._link.connected:
            self._showing.step(now)
        active = self._holder.asks or self._words.moving or self._showing.wanted
        self.rate_hz = ACTIVE_HZ if active else RESTING_HZ
        self._publish_state(now)

    def woke(self, slept_s: float) -> None:  # noqa: ARG002 - however long
        """End all motion: its publisher may have left during the sleep."""
        self._driving.end_all(Reason("holder_gone", "the robot's computer slept"))

    def close(self) -> None:
        """Stop the motion of ROS, and disconnect."""
        self._holder.release("the bridge to ROS is shutting down")
        self._words.halt("the bridge to ROS is shutting down")
        self._link.close()

    def _denied(self) -> Reason | None:
        """Return why ROS may only look and stop; None if it may drive."""
        name = self.ctx.settings.token
        token = next((one for one in self.ctx.rows(TokenRight) if one.name == name), None)
        if not name or token is None or token.role == "host":
            return Reason("token", "ROS only looks, and stops: the setting 'token' of the row names none that counts")
        if RANKS[token.role] < RANKS["operate"]:
            return Reason("role", f"it needs the role operate, and the row's token has {token.role}")
        return None

    def _look_after_link(self) -> None:
        link = self._link
        self._health = "" if link.connected else f"ROS at {link.router.endpoint}: {link.trouble}"
        if self._health:
            self.ctx.warn(self._health, "unreachable")
        else:
            self.ctx.ready()
        if link.connected and link.count == self._count:
            return
        if self._joined:
            self._lose_router()
        if link.connected:
            self._count, self._joined, self._driving.joined_s = link.count, True, self.ctx.clock()
            self._showing.begin()

    def _lose_router(self) -> None:
        self._joined = False
        self._graph.clear()
        self._driving.end_all(ROUTER_GONE)
        self._words.halt(ROUTER_GONE.text, lost=True)
        self._showing.subscribed(self._graph.subscribed)

    def _look_who_is_there(self) -> None:
        tokens = self._link.tokens()
        for token in tokens:
            if token.present:
                entity = self._graph.come(token.text)
                if isinstance(entity, Endpoint):
                    self._complain_once(refusal_of(entity, self._accepted), "not_possible")
            elif isinstance(entity := self._graph.go(token.text), Endpoint) and entity.kind == "MP":
                self._lose(entity, wire.gid(token.text))
        if tokens:
            self._showing.subscribed(self._graph.subscribed)

    def _lose(self, publisher: Endpoint, gid: bytes) -> None:
        """Handle the loss of a publisher; one whose messages do not match its token may be the driver."""
        why = Reason("holder_gone", f"{publisher.node.path} is gone")
        driver = self._driving.driver
        unknown = driver and publisher.topic in self._accepted and not self._graph.knows(driver)
        self._driving.leave(driver if unknown and gid != driver else gid, why)

    def _complain_once(self, text: str, code: str) -> None:
        """Report each fault of a publisher once."""
        if text and text not in self._reported and len(self._reported) < MOST_REPORTED:
            self._reported.add(text)
            self._report_refusal(text, code)

    def _receive(self, sample: Sample) -> None:
        try:
            by = wire.attachment(sample.attachment)
        except InputError as err:
            self._complain_once(f"a message on {sample.key}: {err}", "malformed")
            return
        type_ = wire.type_in(sample.key)
        try:
            if wire.hash_in(sample.key) not in (codec.type_hash(type_), wire.HUMBLE_HASH):
                return  # another type of that name, already reported by its token
            motion = (
                trajectory(sample.payload, self._joints) if type_ == TRAJECTORY else codec.twist(type_, sample.payload)
            )
        except InputError as err:
            self._driving.malformed(by.gid, str(err))
            return
        self._driving.receive(MotionMessage(motion, by, sample.arrived_s, sample.wall_ns))

    def _call(self, request: Request) -> None:
        if request.service == STOP:
            self._driving.end_all(Reason("stopped", "stopped by the service stop"))
        self._words.call(request.service, self._reply(request))

    def _reply(self, request: Request) -> Reply:
        def reply(text: str, done: bool) -> None:
            self._refused += not done
            self._link.reply(request, codec.answer(text, success=done))

        return reply

    def _drive(self, now: float, results: list[GoalResult]) -> None:
        """Follow the requested motion under a lease; a publisher that loses it must rest first."""
        command = self._driving.command(now, self.ctx.settings.ttl_s)
        rests = self._driving.stands if command is None else None
        # A trajectory supersedes only earlier motion of ROS.
        ended = self._holder.step([one for one in results if one.result != "superseded"], lost=rests)
        if ended is not None and ended is not rests:
            if self._holder.good:
                self._driving.finish()
            else:
                end = self._driving.end_all if ended.code in FINAL else self._driving.end
                end(ended)
        elif command is not None and self._holder.asks and isinstance(self._holder.motion, type(command)):
            self._holder.change(command)
        elif command is not None:
            self._words.halt("a topic is used")
            self._holder.begin(LENDERS[type(command)], command)

    def _report_losses(self) -> None:
        """Report each refusal and each end once."""
        losses, self._driving.lost = self._driving.lost, []
        for gid, why in losses:
            self._report_refusal(f"{self._graph.name(gid)}{self._graph.place(gid)}: {why}", why.code)

    def _report_refusal(self, text: str, code: str) -> None:
        self._refused += 1
        self.ctx.event("ros2_refused", text, level="warning", code=code, about=self.ctx.name)

    def _publish_state(self, now: float) -> None:
        driver, stands = self._driving.driver, self._driving.stands
        state = Ros2State(
            connected=self._link.connected,
            endpoint=self._link.router.endpoint,
            nodes=self._graph.nodes,
            subscribed=tuple(sorted(self._showing.wanted)),
            driver=self._graph.name(driver) if driver else "",
            connections=self._count,
            refused=self._refused,
            reason=self._health or ("" if driver else stands.text),
            code="unreachable" if self._health else "" if driver else stands.code,
        )
        since_s = now - self._published_s
        if since_s >= PUBLISH_S or (state != self._published and since_s >= PUBLISH_NEWS_S):
            self._published, self._published_s = state, now
            self.ctx.publish("state", state)
