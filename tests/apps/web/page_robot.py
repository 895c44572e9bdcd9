"""A robot as a page sees it: the page's files, the API and its live socket on a real port, with a base in a room.

What moves is held as the robot's server holds it: 0.25 s without a word, a socket that closes, a stop, and it stands.
"""

import asyncio
import gzip
import io
import math
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

import uvicorn
from PIL import Image, ImageDraw
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from lbr.apps.web.page.files import INDEX, POLICY, File, built

SILENT_S = 0.25
ROOM = (-1.6, 3.4, -1.7, 2.1)
TOP_MPS, TOP_RPS = 0.9, 2.4
SENSORS = {"forward": (0.2, 0.0, 0.0), "back": (-0.2, 0.0, math.pi), "left": (0.0, 0.15, math.pi / 2), "right": (0.0, -0.15, -math.pi / 2)}  # fmt: skip
OPERATE, VIEW = "operate", "view"


def outputs(**types: str) -> dict[str, Any]:
    return {name: {"$ref": f"#/$defs/{kind}", "$defs": {kind: {"title": kind, "type": "object"}}} for name, kind in types.items()}  # fmt: skip


def commands(*leased: str, **roles: str) -> dict[str, Any]:
    return {name: {"schema": {}, "role": OPERATE, "leased": True} for name in leased} | {
        name: {"schema": {}, "role": role, "leased": False} for name, role in roles.items()
    }


def capability(name: str, kind: str, summary: str, out: dict[str, Any], can: dict[str, Any]) -> dict[str, Any]:
    told = {"name": name, "kind": kind, "family": "operation", "summary": summary, "phase": "ready", "reason": ""}
    return told | {"outputs": out, "commands": can}


CAPABILITIES = [
    capability("drive", "drive", "moves the base", outputs(state="DriveState", result="GoalResult"), commands("command", "turn", "heading", "twist", stop=VIEW)),
    capability("ranges", "ultrasonic_ring", "measures distances", outputs(readings="Ranges"), {}),
    capability("odometry", "odometry", "tells how far the base went", outputs(state="OdometryState"), {}),
    capability("attitude", "attitude", "tells where the body points", outputs(state="AttitudeState"), {}),
    capability("battery", "battery", "watches the battery", outputs(state="BatteryState"), {}),
    capability("speech", "speech", "speaks", outputs(state="SpeechState"), commands(say=OPERATE, hush=OPERATE, play=OPERATE)),
    capability("dance", "dance", "dances to songs", outputs(state="DanceState"), commands(play=OPERATE, stop=VIEW)),
    capability("camera_front", "camera", "shows what is ahead", outputs(state="CameraState"), commands(switch=OPERATE)),
    capability("camera_rear", "camera", "shows what is behind", outputs(state="CameraState"), commands(switch=OPERATE)),
    capability("cameras", "cameras", "chooses one camera", outputs(state="CamerasState"), commands(select=OPERATE)),
    capability("web", "web", "serves the robot over HTTP", outputs(state="WebState"), commands(address=VIEW)),
]  # fmt: skip
WORDS = [
    {"word": word, "help": "", "role": OPERATE, "usage": word}
    for word in ("autodock", "restart", "stop", "estop", "reset")
] + [
    {
        "word": "d",
        "help": "",
        "role": OPERATE,
        "usage": "/d/{song}",
        "fields": [{"name": "song", "choices": ["metronome", "blue_moon"]}],
    }
]
MECANUM = {"capability": "drive", "kind": "mecanum", "sideways": True, "max_speed_mps": 0.8, "max_turn_rps": 2.0}
PHRASES = [
    {"name": "hello", "language": "en", "text": "Hello, I am your robot."},
    {"name": "hello", "language": "de", "text": "Hallo, ich bin dein Roboter."},
    {"name": "follow_me", "language": "en", "text": "Please follow me."},
    {"name": "battery_low", "language": "en", "text": "My battery is low."},
]

OVERDUE = "emergency stop: motors has not acknowledged: use the hardware switch"


class Base:
    """Two wheels in a rectangular room."""

    def __init__(self) -> None:
        self.x = self.y = 0.0
        self.yaw = 0.35
        self.left = self.right = self.aside = 0.0
        self.way = 0.0

    def step(self, span_s: float) -> None:
        ahead, turn = (self.left + self.right) / 2 * TOP_MPS, (self.right - self.left) / 2 * TOP_RPS
        aside = self.aside * TOP_MPS
        x = self.x + (ahead * math.cos(self.yaw) - aside * math.sin(self.yaw)) * span_s
        y = self.y + (ahead * math.sin(self.yaw) + aside * math.cos(self.yaw)) * span_s
        self.yaw += turn * span_s
        if ROOM[0] + 0.25 < x < ROOM[1] - 0.25 and ROOM[2] + 0.25 < y < ROOM[3] - 0.25:
            self.x, self.y = x, y
            self.way += ahead * span_s

    def distance(self, sensor: str) -> float:
        ahead, aside, look = SENSORS[sensor]
        angle = self.yaw + look
        x = self.x + ahead * math.cos(self.yaw) - aside * math.sin(self.yaw)
        y = self.y + ahead * math.sin(self.yaw) + aside * math.cos(self.yaw)
        reach = []
        for wall, place, step in ((ROOM[1], x, math.cos(angle)), (ROOM[0], x, math.cos(angle)), (ROOM[3], y, math.sin(angle)), (ROOM[2], y, math.sin(angle))):  # fmt: skip
            if abs(step) > 1e-6 and (wall - place) / step > 0:
                reach.append((wall - place) / step)
        return min(reach)


@cache
def page_files() -> dict[str, File]:
    """Return the page's files by name, packed once for all robots."""
    return {one.name: one for one in built()}


class PageRobot:
    """What the pages are told, and what they said; `refusal` refuses all motion."""

    capabilities = CAPABILITIES

    def __init__(self) -> None:
        self.base = Base()
        self.role = "admin"
        self.asked: list[tuple[str, Any]] = []
        self.held: list[dict[str, Any]] = []
        self.refusal: dict[str, str] | None = None
        self.estop = ""
        self.needs_token = False
        self.muted: set[str] = set()
        self.drives_by: dict[str, Any] | None = None
        """What it says of its base."""
        self.blind: dict[str, str] = {}
        """Statuses of sensors that say nothing of use."""
        self.lasts_s = 0.6
        """How long a move takes that ends by itself."""
        self.stopped_at = self.moved_at = 0.0
        self.holder: str | None = None
        self.goal = ""
        self.sockets = self.generation = 0
        self.hears: list[list[str]] = []
        self.closed = False
        self.happened: list[dict[str, Any]] = []
        self.news: list[dict[str, Any]] = []
        self.stopped: set[Any] = set()
        self.build = ""
        """Which page the robot says that it has; empty: it does not say."""
        self.altered: set[str] = set()
        """Files that come as others than they were built."""
        self.link: dict[str, Any] = {}
        """What it says of the age of what a hand drives by."""
        self.silent_s = SILENT_S
        self.period_s = 0.04
        self._pictures: dict[int, bytes] = {}
        self._hold: tuple[Any, int] | None = None
        self._until = math.inf

    @property
    def moves(self) -> bool:
        return bool(self.base.left or self.base.right or self.base.aside)

    def move(self, viewer: Any, hold: dict[str, Any]) -> dict[str, Any]:
        """Begin or change motion; return what the page is told."""
        n, message = hold["n"], hold["message"]
        self.held.append(hold)
        rests = {"code": "rest_first", "reason": "it was stopped: release it first"} if viewer in self.stopped else None
        refused = (
            self.refusal
            or rests
            or ({"code": "estop", "reason": "the emergency stop is latched"} if self.estop else None)
        )
        if refused:
            return {"n": n, "holds": False, "code": "", "reason": "", "holder": "", **refused}
        self._hold, self.holder = (viewer, n), "web:page"
        power, angle = message.get("power", 0.5), math.radians(message.get("angle_deg", 0.0))
        if hold["to"] == "drive/twist":
            turn = message["wz_rps"] / MECANUM["max_turn_rps"]
            ahead, self.base.aside = (message[name] / MECANUM["max_speed_mps"] for name in ("vx_mps", "vy_mps"))
            self._until, self.goal, self.moved_at = math.inf, "twist", time.monotonic()
            self.base.left, self.base.right = ahead - turn, ahead + turn
            return {"n": n, "holds": True, "code": "", "reason": "", "holder": "web:page"}
        if hold["to"] in {"drive/turn", "drive/heading"}:
            angle = math.copysign(math.pi / 2, message.get("angle_deg", 1.0))
            self._until = time.monotonic() + self.lasts_s
        elif message.get("distance_cm"):
            self._until = time.monotonic() + self.lasts_s
        else:
            self._until = math.inf
        self.goal = hold["to"].partition("/")[2]
        throttle, steering = math.cos(angle), math.sin(angle)
        scale = power / max(1.0, abs(throttle) + abs(steering))
        self.base.left, self.base.right = (throttle + steering) * scale, (throttle - steering) * scale
        self.moved_at = time.monotonic()
        return {"n": n, "holds": True, "code": "", "reason": "", "holder": "web:page"}

    def halt(self, viewer: Any = None) -> int | None:
        """Have the wheels stand if this viewer, or any, moves them; return the number of what was held."""
        if self._hold is None or (viewer is not None and self._hold[0] is not viewer):
            return None
        n = self._hold[1]
        self._hold, self.holder = None, None
        if self.moves:
            self.stopped_at = time.monotonic()
        self.base.left = self.base.right = self.base.aside = 0.0
        return n

    def holds(self, viewer: Any) -> bool:
        return self._hold is not None and self._hold[0] is viewer

    def hang_up(self) -> None:
        """Have all sockets close, as those of a robot that ends."""
        self.generation += 1

    def over(self) -> bool:
        return time.monotonic() >= self._until

    def streams(self) -> dict[str, Any]:
        base = self.base
        near = {f"{name}_m": round(distance, 3) if distance < 4 else None for name in SENSORS for distance in [base.distance(name)]}  # fmt: skip
        status = {name: "ok" if near[f"{name}_m"] is not None else "over_range" for name in SENSORS}
        near |= dict.fromkeys(f"{name}_m" for name in self.blind)
        status |= self.blind
        loop = {"rate_hz": 50.0, "period_p99_ms": 20.4, "period_max_ms": 22.1, "overruns": 0}
        drive = {
            "moving": self.moves, "power": max(abs(base.left), abs(base.right)), "angle_deg": 0.0, "left": base.left, "right": base.right, "holder": self.holder,
            "goal": self.goal if self.moves else None, "limited_by": "", "reason": "", "estop": bool(self.estop), "loop": loop, "code": "idle",
        }  # fmt: skip
        speed = (base.left + base.right) / 2 * TOP_MPS
        return {
            "drive/state": drive,
            "ranges/readings": {**near, "bottom_m": 0.1, "status": status | {"bottom": "ok"}, "others_m": {}},
            "odometry/state": {"valid": True, "epoch": "a", "x_m": base.x, "y_m": base.y, "yaw_rad": base.yaw, "distance_m": base.way, "speed_mps": speed, "turn_rps": 0.0},
            "attitude/state": {"valid": True, "heading_deg": (90 - math.degrees(base.yaw)) % 360, "roll_rad": 0.0, "pitch_rad": 0.0, "yaw_rad": base.yaw},
            "battery/state": {"valid": True, "voltage_v": 12.6, "charge": 0.82, "charging": False, "level": "ok"},
            "speech/state": {"speaking": False, "text": "", "queued": 0, "spoken": 0, "failed": 0, "sink": "speaker"},
            "dance/state": {"phase": "resting", "song": "", "dance": "", "beat": 0, "beats": 0, "moves": 0, "reason": ""},
            "camera_front/state": {"on": True, "phase": "streaming", "device": "/dev/video0", "width_px": 640, "height_px": 480, "fps": 15.0},
            "camera_rear/state": {"on": False, "phase": "off", "device": "/dev/video2", "reason": "it is switched off"},
        }  # fmt: skip

    def status(self) -> dict[str, Any]:
        parts = [
            {"name": one["name"], "kind": one["kind"], "phase": "degraded" if one["name"] == "speech" else "ready", "pid": 100, "restarts": 0, "uptime_s": 300.0,
             "reason": "no loudspeaker: /dev/snd is not there" if one["name"] == "speech" else "", "rates_hz": dict.fromkeys(one["outputs"], 20.0), "cpu_percent": 1.7, "memory_mb": 31.0}
            for one in self.capabilities
        ]  # fmt: skip
        estop = {"engaged": bool(self.estop), "reason": self.estop, "source": "web:page" if self.estop else "", "acknowledged": [], "waiting": ["motors"], "overdue": ["motors"], "text": OVERDUE if self.estop else ""}  # fmt: skip
        return {"robot": "lbr", "profile": "lbr-sim", "ready": True, "pid": 1, "uptime_s": 300.0, "estop": estop, "capabilities": parts, "problems": [], "revision": 7}  # fmt: skip

    def describe(self) -> dict[str, Any]:
        ranges = [{"name": name, "kind": "ultrasonic", "x_m": x, "y_m": y, "yaw_rad": yaw, "fov_rad": 0.45, "max_m": 4.0} for name, (x, y, yaw) in SENSORS.items()]  # fmt: skip
        return {
            "robot": "lbr", "simulated": True, "version": "0.1.0", "revision": 7, "role": self.role, "capabilities": self.capabilities, "words": WORDS, "joints": [], "motions": [],
            "cameras": [{"name": "front", "capability": "camera_front"}, {"name": "rear", "capability": "camera_rear"}], "wheels": [], "ranges": ranges, "buttons": [], "phrases": PHRASES, "base": self.drives_by,
        }  # fmt: skip

    def picture(self) -> bytes:
        """Return a plain picture of a corridor, as a JPEG."""
        shift = round(math.sin(self.base.yaw) * 12) * 10
        if shift in self._pictures:
            return self._pictures[shift]
        image = Image.new("RGB", (640, 480), (58, 74, 80))
        draw = ImageDraw.Draw(image)
        draw.polygon([(0, 480), (640, 480), (390 + shift, 250), (250 + shift, 250)], fill=(120, 104, 88))
        draw.polygon([(0, 0), (640, 0), (390 + shift, 170), (250 + shift, 170)], fill=(196, 200, 196))
        draw.rectangle([250 + shift, 170, 390 + shift, 250], fill=(150, 168, 170))
        draw.rectangle([300 + shift, 190, 340 + shift, 250], fill=(94, 70, 52))
        kept = io.BytesIO()
        image.save(kept, "JPEG", quality=80)
        return self._pictures.setdefault(shift, kept.getvalue())

    # what is served

    def application(self) -> Starlette:
        post = ["POST"]
        return Starlette(
            routes=[
                *self.more_routes(),
                Route("/api", self._api),
                Route("/api/pair", self._pair, methods=post),
                Route("/api/{path:path}", self._command, methods=post),
                WebSocketRoute("/api/live", self._live),
                Route("/api/events", self._written),
                Route("/api/why/{part}", self._why),
                Route("/api/rows/{table}", self._rows),
                Route("/stop", self._stop, methods=post),
                Route("/estop", self._engage, methods=post),
                Route("/estop/reset", self._reset, methods=post),
                Route("/session", self._session, methods=["POST", "DELETE"]),
                Route("/stream.mjpg", self._stream),
                Route("/{path:path}", self._file),
            ]
        )

    def more_routes(self) -> list[Route]:
        """Return what it answers besides."""
        return []

    def _known(self, request: Request | WebSocket) -> bool:
        shown = request.headers.get("authorization", "") + request.headers.get("sec-websocket-protocol", "")
        return not self.needs_token or "phone.secret" in shown

    async def _written(self, request: Request) -> Response:
        old = {"kind": "crashed", "subject": "motors", "text": "crashed an hour ago", "level": "error", "wall_ns": 1}
        hidden = request.query_params.get("subject", "motors") != "motors"
        return JSONResponse({"accepted": True, "data": {"events": [] if hidden else [old]}})

    async def _why(self, request: Request) -> Response:
        part = request.path_params["part"]
        if not self.estop:
            return JSONResponse(
                {"part": part, "state": "ok", "text": "Nothing is wrong: it waits for a command", "code": "", "do": ""}
            )
        text = f"the emergency stop is latched by console@kitchen:812: {self.estop}"
        do = "reset, once nothing is in danger"
        return JSONResponse({"part": part, "state": "held", "text": text, "code": "estop", "do": do})

    async def _rows(self, request: Request) -> Response:
        found = {"table": request.path_params["table"], "key": ["name"], "fixed": "", "schema": {}, "settings": {}}
        return JSONResponse({"accepted": True, "data": {**found, "rows": []}})

    async def _api(self, request: Request) -> Response:
        if not self._known(request):
            return JSONResponse({"message": "show a token", "code": "token"}, 401)
        return JSONResponse(self.describe())

    async def _pair(self, request: Request) -> Response:
        given = await request.json()
        self.asked.append(("pair", given))
        if given["code"] != "123456":
            return JSONResponse({"message": "these are not the digits that are shown", "code": "denied"}, 403)
        return JSONResponse({"token": "phone.secret.print", "role": OPERATE})

    async def _session(self, request: Request) -> Response:
        known = "phone.secret" in request.headers.get("authorization", "") or request.method == "DELETE"
        return Response(status_code=204) if known else JSONResponse({"message": "unknown", "code": "token"}, 401)

    async def _command(self, request: Request) -> Response:
        given = await request.json()
        self.asked.append((request.path_params["path"], given))
        if (kind := {"ask": "asked_for", "hand_over": "handed_over"}.get(request.path_params["path"])) is not None:
            self.happened.append({"kind": kind, "subject": "web", "text": "", "data": {"by": "web:tablet", **given}})
        if request.path_params["path"] == "console":
            return JSONResponse({"code": 0, "text": "accepted"})
        return JSONResponse({"accepted": True})

    async def _stop(self, _request: Request) -> Response:
        self.asked.append(("stop", None))
        self._tell_stopped("stopped by a page")
        return JSONResponse({"message": "stopped"})

    async def _engage(self, request: Request) -> Response:
        self.asked.append(("estop", None))
        self.estop = (await request.json()).get("reason", "")
        self._tell_stopped("the emergency stop")
        return JSONResponse({"message": "engaged", "engaged": True, "noticed": True})

    async def _reset(self, _request: Request) -> Response:
        self.asked.append(("reset", None))
        self.estop = ""
        return JSONResponse({"message": "released"})

    def _tell_stopped(self, reason: str) -> None:
        self.stopped |= {self._hold[0]} if self._hold else set()
        if (n := self.halt()) is not None:
            self.news.append({"n": n, "holds": False, "code": "stopped", "reason": reason, "holder": ""})

    async def _stream(self, _request: Request) -> Response:
        async def parts() -> Any:
            while not self.closed:
                yield b"--FRAME\r\nContent-Type: image/jpeg\r\n\r\n" + self.picture() + b"\r\n--FRAME\r\nContent-Type: image/jpeg\r\n\r\n" + self.picture() + b"\r\n"  # fmt: skip
                await asyncio.sleep(0.2)

        return StreamingResponse(parts(), media_type="multipart/x-mixed-replace; boundary=FRAME")

    async def _file(self, request: Request) -> Response:
        found = page_files().get(request.path_params["path"] or INDEX)
        if found is None:
            return JSONResponse({"message": "there is no such file", "code": "unknown_name"}, 404)
        content = (found.plain or gzip.decompress(found.packed)) + b" " * (found.name in self.altered)
        return Response(content, media_type=found.media, headers={"Content-Security-Policy": POLICY})

    async def _live(self, socket: WebSocket) -> None:
        if not self._known(socket):
            await socket.close()
            return
        await socket.accept("lbr.live" if "lbr.live" in socket.headers.get("sec-websocket-protocol", "") else None)
        if self.build:
            await socket.send_json({"page": self.build})
        viewer, heard = object(), {"keys": [], "last": time.monotonic()}
        self.sockets += 1
        telling = asyncio.create_task(self._tell(socket, viewer, heard))
        try:
            while True:
                said = await socket.receive_json()
                heard["last"] = time.monotonic()
                if "hear" in said:
                    heard["keys"] = said["hear"]
                    self.hears.append(said["hear"])
                if "hold" in said:
                    await socket.send_json({"hold": self.move(viewer, said["hold"])} | self.link)
                if said.get("release"):
                    self.stopped.discard(viewer)
                    self.halt(viewer)
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            self.sockets -= 1
            self.halt(viewer)
            telling.cancel()
            with suppress(asyncio.CancelledError):
                await telling

    async def _tell(self, socket: WebSocket, viewer: object, heard: dict[str, Any]) -> None:
        beat, news, generation, happened = 0, len(self.news), self.generation, len(self.happened)
        while True:
            if generation != self.generation:
                await socket.close(1001)
                return
            if self.holds(viewer) and time.monotonic() - heard["last"] > self.silent_s:
                self.news.append({"n": self.halt(viewer), "holds": False, "code": "lapsed", "reason": "the page fell silent", "holder": ""})  # fmt: skip
            if self.holds(viewer) and self.over():
                await socket.send_json({"hold": {"n": self.halt(viewer), "holds": False, "code": "done", "reason": "turned 90 degrees", "holder": ""}})  # fmt: skip
            told = {key: {"age_ms": 4, "message": message} for key, message in self.streams().items() if key in heard["keys"] and key.partition("/")[0] not in self.muted}  # fmt: skip
            if beat % 5 == 0:
                told["@status"] = {"age_ms": 1, "message": self.status()}
            await socket.send_json({"streams": told})
            for one in self.news[news:]:
                await socket.send_json({"hold": one})
            if beat == 0:
                started = {"kind": "ready", "subject": "drive", "text": "is ready", "level": "info", "wall_ns": time.time_ns()}  # fmt: skip
                warned = {"kind": "degraded", "subject": "speech", "text": "no loudspeaker: /dev/snd is not there", "level": "warning", "wall_ns": time.time_ns(), "code": "unreachable"}  # fmt: skip
                await socket.send_json({"events": [started, warned]})
            if self.happened[happened:]:
                await socket.send_json({"events": self.happened[happened:]})
            news, beat, happened = len(self.news), beat + 1, len(self.happened)
            await asyncio.sleep(self.period_s)

    async def go_on(self) -> None:
        """Let time pass in the room."""
        while not self.closed:
            self.base.step(0.02)
            await asyncio.sleep(0.02)


@contextmanager
def page_robot(robot: Any = None, tls: tuple[str, str] | tuple[()] = ()) -> Iterator[tuple[Any, str]]:
    """Serve such a robot, or one that is given, until the end of a `with`; yields it and its address. `tls` is key and certificate."""
    robot = robot or PageRobot()
    sock = socket.create_server(("127.0.0.1", 0))
    config = uvicorn.Config(robot.application(), log_level="error", lifespan="off", ws="websockets-sansio", timeout_graceful_shutdown=1, **dict(zip(("ssl_keyfile", "ssl_certfile"), tls, strict=False)))  # fmt: skip
    server = uvicorn.Server(config)

    async def run() -> None:
        room = asyncio.create_task(robot.go_on())
        await server.serve(sockets=[sock])
        robot.closed = True
        await room

    thread = threading.Thread(target=lambda: asyncio.run(run()))
    thread.start()
    try:
        yield robot, f"http{'s' if tls else ''}://127.0.0.1:{sock.getsockname()[1]}"
    finally:
        robot.closed = True
        server.should_exit = True
        thread.join(5.0)
        sock.close()
        assert not thread.is_alive()
