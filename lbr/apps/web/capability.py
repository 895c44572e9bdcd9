"""The server as a process: it listens, passes requests between HTTP and the bus, and keeps the newest states."""

import socket
import sys
from contextlib import suppress

from starlette.types import ASGIApp

from lbr import home, plugins
from lbr.apps.http import names
from lbr.apps.http.pages import ANY, Pages
from lbr.apps.http.turns import Turns
from lbr.apps.web.access import Access
from lbr.apps.web.announce import Announcer
from lbr.apps.web.api.handover import Handover
from lbr.apps.web.api.live import Live
from lbr.apps.web.api.managing import Managing
from lbr.apps.web.api.requests import Requests
from lbr.apps.web.api.robot_bus import RobotBus, opened
from lbr.apps.web.api.service import Api
from lbr.apps.web.application import Gate
from lbr.apps.web.builtin import STOPS, BuiltinRoutes
from lbr.apps.web.face import declared
from lbr.apps.web.faces import Faces
from lbr.apps.web.front import Front
from lbr.apps.web.kind import PORTS, WebSettings
from lbr.apps.web.login import Login
from lbr.apps.web.page.files import build
from lbr.apps.web.pairing import PairingRoutes
from lbr.apps.web.robot import Robot, Snapshot
from lbr.apps.web.sessions import Sessions
from lbr.apps.web.states import States
from lbr.apps.web.streams import Streams
from lbr.apps.web.viewing import MOST_OF_ONE, MOST_VIEWERS
from lbr.bus.door import LanUser
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import LbrError
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.web import AddressReply, WebState

SWITCH_S = 0.0005
"""The interpreter's switch interval. Two threads share the interpreter, and a client waits for both."""
TELL_S = 0.95
"""Less than two rounds of the idle loop, so that its state comes with each second one, and no round is just missed."""
BUSY_HZ, IDLE_HZ, IDLE_AFTER_S = 50.0, 2.0, 2.0
"""The pace of the loop with a client, now or in the last `IDLE_AFTER_S`, and without one."""
LOOK_S = 5.0
KNOWS_S = 5.0
"""The longest wait for the first reports of all faces; without their device they never come."""
ENDS = "the server ends; it comes back at once if its rows were changed"


class Web(Capability[WebSettings]):
    """The server. Raises DeviceError if it cannot listen."""

    rate_hz = BUSY_HZ
    woken_by_streams = False
    _access: Access

    def __init__(self, ctx: Context[WebSettings]) -> None:
        super().__init__(ctx)
        sys.setswitchinterval(SWITCH_S)
        self._front = Front(ctx, "HTTP")
        kept = home.home() / "credentials" / f"web.{ctx.robot}.{ctx.name}.sessions"
        self._sessions = Sessions(kept, {user.name: user.secret for user in ctx.rows(LanUser)})
        self._robot = Robot(ctx, self._front.bridge, self._sessions, self._front.counts.tell)
        self._faces = Faces(ctx.settings.faces, self._robot, f"{ctx.robot}/{ctx.name}")
        self._told = ""
        self._api: Api | None = None
        self._announcer: Announcer | None = None
        self._tell_at = self._look_at = self._busy_until = self._opened = 0.0
        self._requests = 0

    def open(self) -> None:
        """Listen and serve."""
        self._told, self._opened = "", self.ctx.clock()
        self._front.open(self._application, plain_here=not self.ctx.settings.tls, beside=self._announce)
        self._warn_of_openness()

    def step(self) -> None:
        """Run what clients requested, and read new states."""
        now = self.ctx.clock()
        self._access.use(self.ctx.rows(LanUser))
        self._robot.moved = tuple(one.message for one in self.ctx.take("moved"))
        self._robot.played = tuple(one.message for one in self.ctx.take("played"))
        if self.ctx.on_tick:
            self._look(now)
            self._take_pace(now)
        if self._api is not None:
            self._api.step()
        self._front.bridge.serve()
        self._faces.step(now)
        if (trouble := self._faces.trouble) != self._told:
            self._told = trouble
            self.ctx.event("face_refused", trouble, level="error")
            self.ctx.warn(trouble, "not_possible")
        self._front.publish_news()
        if now >= self._tell_at:
            self._tell_at = now + TELL_S
            self._tell()

    def answers(self) -> bool:
        """Return whether the faces have their first reports, or the wait for these is over."""
        return self._faces.know() or self.ctx.clock() - self._opened >= KNOWS_S

    def command(self, call: Call) -> None:
        """Return the address, or stop the motion requested here."""
        if call.name == "address":
            listens, place = self._front.listens, self._front.place
            local = place.local if self._announcer is not None and not self._announcer.trouble else ""
            call.reply(
                AddressReply(
                    accepted=listens, reason=place.text(), url=place.url, local=local, open=place.open, tls=place.tls
                )
            )
        elif isinstance(call.message, StopCommand):
            self._stop(call.message.reason or f"stopped by {call.source}")
            call.reply(CommandReply(accepted=True))
        else:
            super().command(call)

    def degraded(self, reason: str) -> None:
        """Report that no client is served."""
        self.ctx.publish("state", WebState(listening=False, faces=self._faces.names, reason=reason))

    def close(self) -> None:
        """Stop serving; refuse the requests under way."""
        self._front.bridge.close(ENDS)
        if self._api is not None:
            self._api.release(ENDS)
        self._faces.stopped(ENDS)
        self._faces.close()
        self._front.close(ENDS)
        if self._api is not None:
            self._api.close()
            self._api = None

    def _open_bus(self) -> RobotBus | None:
        """Return the API's bus; None on a machine without one."""
        return opened(self.ctx)

    def _application(self) -> ASGIApp:
        self._api = api = Api(self._robot, self._open_bus(), plugins.version())
        settings, place = self.ctx.settings, self._front.place
        pages, states = Pages(settings.cors), States(self.ctx.robot)
        login = Login(self._sessions, f"lbr_web_{place.port}", tls=place.tls)
        self._access = access = Access(settings.trusted, self.ctx.rows(LanUser), legacy=self._legacy, login=login)
        gate = Gate(access, pages)
        viewers = Turns(MOST_OF_ONE, MOST_VIEWERS)
        streams = Streams(self._robot, states, gate, viewers)
        live = Live(api, gate, viewers, self._sessions, build() if "page" in settings.faces else "")
        builtin = BuiltinRoutes(self._robot, states, place, self._faces, api)
        parts = builtin, login, PairingRoutes(self._robot, access, login), Handover(api), Managing(api), Requests(api)
        routes = [route for part in parts for route in declared(part)]
        routes += self._faces.open(routes)
        builtin.describe(routes, plugins.version())
        if settings.announce and not self._front.is_loopback:
            name = f"{self.ctx.robot} on {socket.gethostname()}"[:56]
            self._announcer = Announcer(name, place.port, place.look, self._announced)
        return self._front.application(
            routes, streams, live, gate=gate, pages=pages, requests_per_s=settings.requests_per_s
        )

    @property
    def _legacy(self) -> bool:
        """Return whether the old API is open to programs without a token."""
        setting = self.ctx.settings.legacy
        return setting == "on" or (setting == "simulated" and self.ctx.simulated)

    async def _announce(self) -> None:
        if self._announcer is not None:
            await self._announcer.run()

    def _announced(self) -> dict[str, str]:
        """Return the announced properties; `door` is the port of the door for programs."""
        properties = {"path": "/", "robot": self.ctx.robot, "tls": str(int(self._front.place.tls))}
        with suppress(LbrError, OSError):
            lan = [at for one in home.running() if one.robot == self.ctx.robot for at in one.lan]
            doors = [at.rpartition(":")[2] for at in lan if at.startswith("tls/")]
            if doors:
                properties["door"] = doors[0]
        return properties

    def _take_pace(self, now: float) -> None:
        """Set the pace of the loop to the need of clients."""
        if self._front.connections or self._front.counts.requests != self._requests:
            self._requests, self._busy_until = self._front.counts.requests, now + IDLE_AFTER_S
        self.rate_hz = BUSY_HZ if now < self._busy_until or not self.answers() else IDLE_HZ

    def _look(self, now: float) -> None:
        """Store the newest states for requests on the other thread."""
        self._robot.snapshot = Snapshot(
            at=now,
            inputs={name: last for name in PORTS.states if (last := self.ctx.latest(name)) is not None},
            faces=self._faces.states(),
        )
        if self._front.place.open and now >= self._look_at:
            self._look_at = now + LOOK_S
            self._front.place.look()

    def _tell(self) -> None:
        self.ctx.publish(
            "state",
            WebState(
                listening=True,
                urls=self._front.place.urls,
                faces=self._faces.names,
                announced=self._announcer.said if self._announcer is not None else "",
                clients=self._front.connections,
                requests=self._front.counts.requests,
                refused=self._front.counts.refused,
                jobs=self._faces.jobs,
                reason=self._faces.trouble or (self._announcer.trouble if self._announcer is not None else ""),
            ),
        )

    def _stop(self, why: str) -> None:
        self._faces.stopped(why)
        for request in STOPS:
            self.ctx.ask(request, StopCommand(reason=why[:200], whole=True), 1.0)

    def _warn_of_openness(self) -> None:
        settings = self.ctx.settings
        if ANY in settings.cors:
            self.ctx.event(
                "exposed", "every page that a browser shows may ask this robot: cors is '*'", level="warning"
            )
        if settings.legacy == "on":
            text = "every program of this machine may move the robot without a token: legacy is 'on'"
            self.ctx.event("exposed", text, level="warning")
        if not self._front.place.open:
            return
        trusted = [one for one in settings.trusted if not names.is_local(one.partition("/")[0])]
        if trusted:
            text = f"clients in {', '.join(trusted)} may move the robot without a token"
            self.ctx.event("exposed", text, level="warning")
