"""The bridge as a process: it admits clients, offers the robot's streams, and passes words to the robot."""

import sys
from collections.abc import Collection, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import msgspec
from msgspec import Struct
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Scope

from lbr import home
from lbr.apps.bodies.model import body_file, model
from lbr.apps.foxglove import channels, protocol
from lbr.apps.foxglove import services as words
from lbr.apps.foxglove.channels import Source
from lbr.apps.foxglove.kind import FoxgloveSettings
from lbr.apps.foxglove.layout import layout
from lbr.apps.foxglove.messages import FoxgloveState
from lbr.apps.foxglove.pictures import Pictures
from lbr.apps.foxglove.services import ESTOP, STOP, Service
from lbr.apps.foxglove.socket import Viewer
from lbr.apps.http import peers
from lbr.apps.http.pages import Pages
from lbr.apps.http.turns import Turns
from lbr.apps.motion_requests import adopt
from lbr.apps.web.access import Access
from lbr.apps.web.api.feeds import Feeds
from lbr.apps.web.api.requests import LINE_S, source_of
from lbr.apps.web.api.robot_bus import RobotBus, opened
from lbr.apps.web.api.service import NO_BUS, NOT_YET, Api
from lbr.apps.web.application import Gate
from lbr.apps.web.bridge import until
from lbr.apps.web.face import Client, Message, Refused, Request, declared, get, json, post
from lbr.apps.web.front import Front
from lbr.apps.web.login import Login
from lbr.apps.web.robot import Robot
from lbr.apps.web.sessions import Sessions
from lbr.apps.web.viewing import Viewing, shown_token
from lbr.bus.codec import Decoder
from lbr.bus.door import LanUser
from lbr.bus.wire import PendingQuery
from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.errors import BusError, LbrError, MalformedError
from lbr.leases.client import LeaseTarget
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason
from lbr.messages.description import RobotDescription
from lbr.messages.joints import Joint
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor
from lbr.messages.system import ConsoleResult, Hold

SWITCH_S = 0.0005
REPORT_S = 1.0
REQUESTS_HZ = 50.0
ENDS = "the bridge ends; it comes back at once if its rows were changed"
LOST = Reason("holder_gone", "the connection to Foxglove is gone")
LATE = Reason("timeout", "it took too long")
_results = Decoder(ConsoleResult)


class Goal(Struct):
    """Motion with an end, begun by a word: renewed until the end, while its client is connected."""

    viewer: Viewer
    holder: Holder
    until_s: float


class Door(Viewing):
    """Admits clients of Foxglove at any path; other requests come by HTTP."""

    protocols = protocol.PROTOCOLS
    does = "connected"

    def __init__(self, bridge: "Foxglove", gate: Gate, viewers: Turns, sessions: Sessions) -> None:
        super().__init__(gate, viewers, sessions)
        self._bridge = bridge

    def chosen(self, offered: Collection[str]) -> str:
        """Return the best subprotocol of an offer; raise Refused if all are unknown."""
        chosen = super().chosen(offered)
        if chosen is None:
            raise Refused(400, f"this speaks {' and '.join(self.protocols)}", code="not_possible")
        return chosen

    async def client(self, scope: Scope, headers: Mapping[str, str]) -> Client:
        """Return the client; raise Refused. A page of another origin has the rights of its token alone: in the
        owner's browser it may look, and no more."""
        shown = shown_token(scope) or HTTPConnection(scope).query_params.get("token", "")
        return await self._gate.client(scope, headers, shown, owner="origin" not in headers, signs_in=True)

    def viewer(self, scope: Scope, client: Client) -> Viewer:
        """Return the viewer, which may watch cameras if its client is known."""
        del scope
        ctx = self._bridge.ctx
        pictures = client.known or peers.is_own(client.whose)
        return Viewer(self._bridge, client, ctx.robot, ctx.settings.rate_hz, pictures=pictures)


class Foxglove(Capability[FoxgloveSettings]):
    """The bridge. Raises DeviceError if it cannot listen. `sources` and `services` are replaced as a whole."""

    rate_hz = 50.0
    woken_by_streams = False
    api: Api
    pictures: Pictures

    def __init__(self, ctx: Context[FoxgloveSettings]) -> None:
        super().__init__(ctx)
        sys.setswitchinterval(SWITCH_S)
        self.sources: Mapping[int, Source] = {}
        self.services: Mapping[int, Service] = {}
        self.session = f"{ctx.robot}-{int(ctx.clock() * 1000)}"
        self._front = Front(ctx, "Foxglove", lambda url: url.replace("http", "ws", 1))
        self._sessions = Sessions(home.home() / "credentials" / f"foxglove.{ctx.robot}.{ctx.name}.sessions", {})
        self._access = Access((), (), login=Login(self._sessions, "", tls=True))
        self._known: object = None
        self._goals: list[Goal] = []
        self._bus: RobotBus | None = None
        self._report_at = 0.0

    @property
    def feeds(self) -> Feeds:
        """The streams, received once for all clients."""
        assert self.api.feeds is not None
        return self.api.feeds

    def open(self) -> None:
        """Listen and serve."""
        self._front.open(self._application)

    def step(self) -> None:
        """Serve requests, and follow changes of the robot's description."""
        now = self.ctx.clock()
        self._access.use(self.ctx.rows(LanUser))
        self.api.step()
        self._front.bridge.serve()
        self._renew(now)
        if self.api.known is not None and self.api.known is not self._known:
            self._known = self.api.known
            self._number(self.api.known.robot)
        self._front.publish_news()
        if now >= self._report_at:
            self._report_at = now + REPORT_S
            self._report(listening_=True)

    def degraded(self, reason: str) -> None:
        """Report that clients are not served."""
        self._report(listening_=False, reason=reason)

    def close(self) -> None:
        """Stop serving, and stop the motion of all clients."""
        self._front.bridge.close(ENDS)
        self._release(self._goals, ENDS)
        if not self._front.listens:
            return
        self.api.release(ENDS)
        self._front.close(ENDS)
        self.api.close()

    def shows(self, source: Source, client: Client, *, pictures: bool) -> bool:
        """Return whether a client may subscribe to a channel; cameras need a known client."""
        return not source.picture or (pictures and client.may("view"))

    def report(self, kind: str, text: str) -> None:
        """Publish an event; called by the server's thread."""
        self._front.counts.tell(kind, text)

    async def run_service(self, service: Service, line: str, viewer: Viewer) -> dict[str, object]:
        """Run the line of a service in the name of a client; raise Refused."""
        came_s = self.api.now()
        return await self._front.bridge.call(self._run(service, line, viewer, came_s), timeout_s=LINE_S + 1.0)

    # In the loop.

    async def _run(self, service: Service, line: str, viewer: Viewer, came_s: float) -> dict[str, object]:
        client = viewer.client
        if service.word == ESTOP:
            self.api.stopped(came_s)
            self.ctx.engage_estop(f"by {client}, from Foxglove")
        if service.word == STOP:
            self.api.stopped(came_s)
        if service.word in {STOP, ESTOP}:
            self._release([goal for goal in self._goals if goal.viewer is viewer], "stopped")
            if service.word == ESTOP:
                return {"code": 0, "text": "the emergency stop is engaged"}
            question = self.api.line(STOP, role="view", source=source_of(client), timeout_s=LINE_S)
        else:
            moment = self.api.waiting(came_s)
            role = client.role or "view"
            question = self.api.line(line, role=role, source=source_of(client), timeout_s=LINE_S, waiting=moment)
        result = await _result(question)
        text = result.text
        if result.hold is not None:
            text = self._keep(result.hold, viewer, text)
        return {"code": 0, "text": text, "data": result.data}

    def _keep(self, hold: Hold, viewer: Viewer, text: str) -> str:
        """Renew a goal while its client is connected; other motion ends unless the client publishes it."""
        if not hold.goal:
            return f"{text}; it is over in {hold.ttl_s:g} s: to drive, publish it (docs/foxglove.md)"
        at = {"motion": hold.key, **({"halt": hold.stop_key} if hold.stop_key else {})}
        assert self._bus is not None
        transport = self._bus.transport(source_of(viewer.client), at, self.ctx.wake)
        target = LeaseTarget("motion", halt="halt" if "halt" in at else "")
        goal = Goal(viewer, Holder(transport), self.ctx.clock() + hold.max_run_s)
        adopt(goal.holder, target, hold)
        self._goals.append(goal)
        return text

    def _renew(self, now: float) -> None:
        active = []
        for goal in self._goals:
            with suppress(BusError):
                goal.holder.step(lost=LOST if goal.viewer.gone else LATE if now >= goal.until_s else None)
                if goal.holder.asks:
                    active.append(goal)
        self._goals = active

    def _release(self, goals: list[Goal], why: str) -> None:
        for goal in goals:
            with suppress(LbrError):
                goal.holder.release(why)
        self._goals = [goal for goal in self._goals if goal.holder.asks]

    def _number(self, description: RobotDescription) -> None:
        """Number the channels and services of a new description; known ones keep their numbers and clients."""
        file = body_file(self.ctx.robot, Path(self.ctx.home))
        sensors = self.ctx.rows(RangeSensor)
        body = model(self.ctx.robot, file, self.ctx.rows(Joint), self.ctx.rows(Wheel), sensors)
        before = {source.channel.topic: number for number, source in self.sources.items()}
        offered = {source.channel.topic: source for source in channels.sources(description, body, sensors)}
        numbers = numbered(offered, before)
        self.services = self._offered(description)
        self.sources = {
            number: msgspec.structs.replace(source, channel=msgspec.structs.replace(source.channel, id=number))
            for number, source in ((numbers[topic], source) for topic, source in offered.items())
        }

    def _offered(self, description: RobotDescription) -> Mapping[int, Service]:
        before = {service.word: number for number, service in self.services.items()}
        offered = {service.word: service for service in words.services(description.words)}
        numbers = numbered(offered, before)
        return {numbers[word]: service for word, service in offered.items()}

    def _application(self) -> ASGIApp:
        settings, pages = self.ctx.settings, Pages(self.ctx.settings.cors)
        self._bus = bus = opened(self.ctx)
        if bus is None:
            raise BusError(NO_BUS)
        robot = Robot(cast("Any", self.ctx), self._front.bridge, self._sessions, self._front.counts.tell)
        self.api = Api(robot, bus, "")
        self.pictures = Pictures(bus, lambda name: f"{self.ctx.robot}/{name}")
        gate = Gate(self._access, pages)
        door = Door(self, gate, Turns(settings.clients, settings.clients), self._sessions)
        return self._front.application(declared(self), door, gate=gate, pages=pages, requests_per_s=REQUESTS_HZ)

    @get("/layout.json", page=True)
    def _layout(self) -> Response:
        known = self.api.known
        if known is None or not self.sources:
            raise Refused(503, NOT_YET, {"Retry-After": "1"}, "not_ready")
        drives = known.robot.base is not None
        return json(layout(self.sources.values(), self.services.values(), drives=drives))

    @post("/stop", stops=True, within_s=LINE_S + 1.0)
    async def _stop(self, request: Request) -> Message:
        self.api.stopped(request.came_s)
        question = self.api.line(STOP, role="view", source=source_of(request.client), timeout_s=LINE_S)
        return Message(message=(await _result(question)).text)

    def _report(self, *, listening_: bool, reason: str = "") -> None:
        self.ctx.publish(
            "state",
            FoxgloveState(
                listening=listening_,
                urls=self._front.urls if listening_ else (),
                clients=self._front.connections,
                refused=self._front.counts.refused,
                reason=reason,
            ),
        )


async def _result(question: PendingQuery) -> ConsoleResult:
    """Return the result of a line; raise Refused if it failed."""
    await until(lambda: question.done or bool(question.replies))
    if not question.replies:
        raise Refused(503, f"the robot did not answer within {LINE_S:g} s", code="timeout")
    try:
        result = _results.decode(question.replies[0].payload)
    except MalformedError as err:
        raise Refused(503, f"the answer cannot be read: {err}", code="malformed") from None
    if result.code != 0:
        code = f" [{result.reason_code}]" if result.reason_code else ""
        raise Refused(409, f"{result.text}{code}", code="refused")
    return result


def numbered(names: Mapping[str, object], before: Mapping[str, int]) -> dict[str, int]:
    """Number each name: its old number, or a new one."""
    next_ = max(before.values(), default=0) + 1
    added = [name for name in sorted(names) if name not in before]
    return {name: before[name] for name in names if name in before} | {
        name: next_ + at for at, name in enumerate(added)
    }
