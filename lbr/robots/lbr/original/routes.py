"""The old API as a face: its paths, with the original's replies."""

import time
from typing import Annotated

import msgspec
from starlette.responses import Response

from lbr.apps.http import names
from lbr.apps.web import face as web
from lbr.apps.web.bridge import until
from lbr.apps.web.cameras.ports import Ports
from lbr.apps.web.cameras.routes import CamerasFace
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Refused, Request, Route, declared, get, post, route
from lbr.apps.web.robot import Robot
from lbr.capability.context import Received
from lbr.errors import InputError
from lbr.messages.camera import SelectCommand
from lbr.messages.dock import DockHeard
from lbr.messages.schema import JsonObject
from lbr.messages.speech import SayCommand
from lbr.messages.system import Role
from lbr.robots.lbr.original import wishes
from lbr.robots.lbr.original.driving import Client, Driver
from lbr.robots.lbr.original.package import cameras, lasting, package, with_beams
from lbr.robots.lbr.original.wishes import Asked, NotFiniteError

LINE_END = "\r\n"
NOT_FOUND = f"Service not available.{LINE_END}"
VALID, INVALID = f"Validation succeeded.{LINE_END}", f"Validation failed.{LINE_END}"
ALLOWED = {
    "Access-Control-Allow-Credentials": "true",
    "Access-Control-Allow-Methods": "GET, POST, OPTIONS",
    "Access-Control-Allow-Headers": "X-Requested-With, Content-type, User, Authorization",
}
ASK_FOR_TOKEN = {"WWW-Authenticate": 'TOK realm="lbr"'}
NO_TOKEN = "show a token: 'User: NAME' and 'Authorization: TOK:TOKEN'; 'lbr token add NAME --for web' makes one"  # noqa: S105
ACT_S = 4.0
"""The time limit of an action: a motion may need a second request, and speech follows it."""
ASK_S, CATCH_UP_S = 1.0, 1.0
REFUSED = Refuses({400: "It makes no sense.", 401: "A token is needed.", 409: "The robot refuses it now."})
NOT_VALID = Refuses({401: "The token is not valid."})
Text = Annotated[Response, web.TEXT]


class Acting(Route):
    """A route for an action. Its refusals are a sentence alone, and without a body for a missing or wrong token."""

    def refused(self, err: Refused) -> Response:
        """Return the refusal, with the code in a header."""
        if err.status == 401:
            return Response(status_code=401, headers={"Reason-Code": "token", **ASK_FOR_TOKEN})
        return web.json({"message": err.message}, err.status, **{"Reason-Code": err.code, **err.headers})


class LbrOriginalFace(web.Face):
    """The requests of the robot lbr's clients; pictures are those of the face `cameras`."""

    name = "lbr_original"

    def __init__(self, robot: Robot) -> None:
        settings = robot.settings.old_api
        self._robot = robot
        self._settings = settings
        self._driver = Driver(robot, settings.heartbeat_s, settings.unattended_s)
        self._cameras = CamerasFace(Ports(robot))
        self._seen: dict[str, float] = {}
        self._telemetry_parts: JsonObject = {}
        self._telemetry_at: float | None = None

    def routes(self) -> list[Route]:
        """Return its routes; the one that fits any path comes last."""
        return [*declared(self), *(one for one in self._cameras.routes() if one.path != "/cameras")]

    def step(self, now: float) -> None:
        """Continue motion, and receive pictures."""
        self._cameras.step(now)
        self._driver.step(now)
        self._remember(self._robot.ctx.latest("telemetry"), now)

    def knows(self) -> bool:
        """Return whether there was a message with every part of the telemetry that the robot has."""
        latest = self._robot.ctx.latest("telemetry")
        return latest is not None and latest.message.complete

    def stopped(self, reason: str) -> None:
        """Give up every motion."""
        self._driver.give_up(reason)

    def close(self) -> None:
        """End the streams."""
        self._cameras.close()

    def state(self) -> JsonObject:
        """Return the client for which the base moves."""
        return {"holder": self._driver.holder}

    @post("/", Acting, role=None, within_s=ACT_S)
    async def _act(self, request: Request, body: bytes) -> Annotated[Response, {200: JsonObject}, REFUSED]:
        """Move, turn, stop, speak; the answer is the telemetry.

        One of heading, turn, or level with angle, and range, sensor, duration; speech besides. Where something is
        refused, the answer has `refused` besides the telemetry.
        """
        client = Client.of(request)
        is_here = names.is_loopback(request.client.address)
        if not is_here and request.client.role is None:  # everybody at this machine may stop, and each role elsewhere
            _require(request, "operate")
        try:
            asked = wishes.asked(body)
        except InputError as err:
            if isinstance(err, NotFiniteError):
                self._driver.stop_own(client, str(err))
            return self._answered(Refused(400, str(err), code=err.code))
        if not asked.stop:
            _require(request, "operate")
        try:
            await self._do(request, client, asked)
        except Refused as err:
            return self._answered(err)
        return self._answered()

    async def _do(self, request: Request, client: Client, asked: Asked) -> None:
        if asked.stop:
            await self._driver.stop(client, f"stopped by {client}", request.came_s)
        elif asked.motion is not None:
            await self._driver.move(client, asked, request.came_s)
        else:
            self._driver.beat(client)
        if asked.speech:
            _require(request, "operate")
            await self._speak(asked.speech)

    @post("/say", Acting, role=None)
    async def _say(self, request: Request, body: bytes) -> Annotated[Response, {200: None}, REFUSED]:
        """Speak a text."""
        _require(request, "operate")
        try:
            text = wishes.speech(body)
        except InputError as err:
            raise Refused(400, str(err)) from None
        await self._speak(text)
        return Response(status_code=200)

    @post("/docksignal", Acting, role=None)
    async def _dock(self, request: Request, body: bytes) -> Annotated[None, REFUSED]:
        """Report that a beam of the dock is seen."""
        _require(request, "operate")
        try:
            beams = wishes.beams(body)
        except InputError as err:
            raise Refused(400, str(err)) from None
        for name, seen in beams.items():
            self._seen.pop(name, None)
            if seen:
                self._seen[name] = self._robot.now()
        if any(beams.values()) and self._robot.ctx.targets("dock_heard"):
            await self._robot.ask_all("dock_heard", DockHeard(**beams), timeout_s=ASK_S)

    @post("/wakeup", Acting, role=None)
    async def _wake(self, request: Request) -> None:
        """Nothing: it is awake."""
        _require(request, "view")

    @post("/camera/{name}", Acting, role=None)
    async def _camera(
        self, request: Request, name: str
    ) -> Annotated[Text, REFUSED, Refuses({404: "There is no such camera."})]:
        """Switch a camera on and the others off, or all off."""
        _require(request, "operate")
        try:
            command = msgspec.convert({"name": name}, SelectCommand)
        except msgspec.ValidationError:
            raise Refused(404, f"there is no camera '{name[:40]}'") from None
        reply = await self._robot.ask("select_camera", command, timeout_s=ASK_S)
        if not reply.accepted:
            raise Refused(404 if reply.code == "unknown_name" else 409, reply.why)
        return web.text(f"{{}}{LINE_END}")

    async def _speak(self, text: str) -> None:
        reply = await self._robot.ask("say", SayCommand(text=text), timeout_s=ASK_S)
        if not reply.accepted:
            raise Refused(409, reply.why)

    @get("/telemetry")
    @get("/telemetry{more:path}")
    async def _telemetry(self, request: Request) -> Annotated[Text, NOT_VALID]:
        """The whole telemetry, in the original's names."""
        if request.method == "GET":
            self._driver.beat(Client.of(request))
            await self._catch_up()
        return web.text(msgspec.json.encode(self._package()).decode())

    async def _catch_up(self) -> None:
        """Wait for telemetry newer than the last motion: clients detect the end of a motion by its currents."""
        latest, late = self._robot.ctx.latest, self._robot.now() + CATCH_UP_S

        def is_new() -> bool:
            last = latest("telemetry")
            part = last.message.amperages if last is not None else None
            return last is None or last.arrived - (part.age_s if part is not None else 0.0) > self._driver.begun

        await until(lambda: is_new() or self._robot.now() >= late)

    @get("/cameras")
    @get("/cameras{more:path}")
    async def _states(self) -> Annotated[JsonObject, NOT_VALID]:
        """The cameras, and their switches."""
        return cameras(self._robot.ctx.latest("telemetry"))

    @get("/validate", role=None)
    @get("/validate{more:path}", role=None)
    def _validate(self, request: Request) -> Annotated[Text, NOT_VALID]:
        """Check whether the request's token is valid."""
        valid = bool(request.client.name)
        return web.text(VALID) if valid else Response(INVALID, 401, ASK_FOR_TOKEN, web.TEXT)

    @get("/{path:path}", role=None, page=True)
    @post("/{path:path}", role=None)
    def _nothing(self) -> Response:
        return web.text(NOT_FOUND, 404)

    @route("OPTIONS", "/{path:path}", role=None)
    def _options(self) -> Response:
        return Response(status_code=200, headers=ALLOWED)

    def _package(self) -> JsonObject:
        now, latest = self._robot.now(), self._robot.ctx.latest
        wall, telemetry = time.time(), latest("telemetry")
        self._remember(telemetry, now)
        newest = package(telemetry, latest("ranges"), now, wall, self._settings.over_range_cm)
        found = lasting(self._telemetry_parts, newest)
        self._seen = {name: at for name, at in self._seen.items() if now - at <= self._settings.dock_ttl_s}
        return with_beams(found, {name: now - at for name, at in self._seen.items() if name != "power"}, wall)

    def _remember(self, newest: Received | None, now: float) -> None:
        """Store the telemetry: state machines use its last values while they are unknown."""
        if newest is not None and newest.arrived != self._telemetry_at:
            self._telemetry_at = newest.arrived
            parts = package(newest, None, now, time.time(), self._settings.over_range_cm)
            self._telemetry_parts = lasting(self._telemetry_parts, parts)

    def _answered(self, err: Refused | None = None) -> Response:
        """Return the telemetry, with a refusal if there is one."""
        if err is None:
            return web.json(self._package())
        refused = {"message": err.message, "code": err.code}
        headers = {name.replace("-", "_"): value for name, value in err.headers.items()}
        return web.json({**self._package(), "refused": refused}, err.status, Reason_Code=err.code, **headers)


def _require(request: Request, role: Role) -> None:
    """Raise Refused unless a token, or the setting `legacy`, permits a role's request."""
    client = request.client
    if not (client.name or client.legacy):
        raise Refused(401, NO_TOKEN)
    request.require(role)
