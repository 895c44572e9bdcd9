"""A humanoid as a page sees it: its rows, its body, joints that go where they are sent as fast as their rows allow."""

import asyncio
import json
import math
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from lbr.apps.bodies.model import model
from lbr.apps.web import face
from lbr.apps.web.contract import contract
from lbr.apps.web.model.poses import key_pose
from lbr.apps.web.model.routes import ModelFace
from lbr.messages.faces import EditReply
from lbr.messages.joints import Joint, Motion, MotionRow, MotionStep, motions_of
from tests.apps.web import page_robot as served
from tests.apps.web.asking import called
from tests.apps.web.page_robot import PageRobot, capability, commands, outputs

ROOT = Path(__file__).resolve().parents[3]
BODY = {"so101": ROOT / "examples/so101/lbr_so101"}
OWN_TORQUE = 0.9
HUMANOID = [
    capability("servos", "dynamixel", "moves the servos", outputs(state="ServosState"), {}),
    capability("joints", "joints", "decides what the joints do", outputs(state="JointsState", result="GoalResult"), commands("command", "move", torque="operate", recover="operate", stop="view")),
    capability("motions", "motions", "plays motions", outputs(state="MotionsState", result="GoalResult"), commands("play", capture="admin", stop="view")),
    capability("attitude", "attitude", "tells how the trunk lies", outputs(state="AttitudeState"), {}),
    capability("ups", "pico", "supplies the power", outputs(state="UpsState"), {}),
    capability("power", "power", "shuts down in time", outputs(state="PowerState"), commands(arm="admin", cancel="operate")),
    capability("web", "web", "serves the robot over HTTP", outputs(state="WebState"), commands(address="view")),
]  # fmt: skip
PATIENT_S = 3.0
"""How long a page may be silent here: one that draws without a graphics card, on a busy machine, is at times."""
PAGE = face.Client("127.0.0.1", role="admin")
BODILESS = ("attitude", "ups", "power")


def rows_of(robot: str) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of a robot's joints, motions and buttons, as its package has them."""
    found = sqlite3.connect(":memory:")
    found.row_factory = sqlite3.Row
    folder = BODY.get(robot, ROOT / "lbr/robots" / robot)
    found.executescript((ROOT / "robot.db.sql").read_text() + (folder / "rows.sql").read_text())
    try:
        return {
            table: [dict(row) for row in found.execute(f"SELECT * FROM {table} WHERE robot = ?", (robot,))]
            for table in ("joint", "motion", "motion_step", "button")
        }
    finally:
        found.close()


def _typed(rows: list[dict[str, Any]], kind: type) -> list[Any]:
    ready = [{name: json.loads(value) if name == "positions" else value for name, value in row.items() if value is not None} for row in rows]  # fmt: skip
    return msgspec.convert(ready, list[kind], strict=False)  # type: ignore[valid-type]


class JointedRobot(PageRobot):
    """Its joints stand at `angles`; what is not in `torque` is limp. `broken` are joints that report an overload."""

    def __init__(self, robot: str) -> None:
        super().__init__()
        self.name = robot
        self.fallen = ""
        rows = rows_of(robot)
        self.joints: list[Joint] = _typed(rows["joint"], Joint)
        self.motions: tuple[Motion, ...] = motions_of(_typed(rows["motion"], MotionRow), _typed(rows["motion_step"], MotionStep))  # fmt: skip
        self.buttons = rows["button"]
        self.capabilities = [one for one in HUMANOID if robot == "bioloid" or one["name"] not in BODILESS]
        self.silent_s = PATIENT_S
        folder = BODY.get(robot, ROOT / "lbr/robots" / robot)
        self.body = model(robot, folder / "body.xml", self.joints, (), ())
        self.angles = {one.name: max(one.lower_rad, min(one.upper_rad, 0.0)) for one in self.joints}
        self.goals = dict(self.angles)
        self.torque = dict.fromkeys(self.angles, OWN_TORQUE)
        self.load: dict[str, float] = {}
        self.broken: dict[str, str] = {}
        self.armed = False
        self.speed_rps = 1.0
        self.frames: list[tuple[float, dict[str, float]]] = []
        self.playing = ""
        self.kept: list[Any] = []
        self.motors: tuple[Any, ...] = ()
        self.ctx = SimpleNamespace(home="/nowhere", rows=lambda _row: ())
        self.now = time.monotonic
        self.model_face = ModelFace(self)  # type: ignore[arg-type]
        self._ticked = time.monotonic()

    @property
    def moves(self) -> bool:
        return any(abs(self.goals[name] - angle) > 1e-3 for name, angle in self.angles.items())

    def move(self, viewer: Any, hold: dict[str, Any]) -> dict[str, Any]:
        n, message = hold["n"], hold["message"]
        self.held.append(hold)
        if self.refusal:
            return {"n": n, "holds": False, "code": "", "reason": "", "holder": "", **self.refusal}
        self._hold, self.holder = (viewer, n), "web:page"
        self._until = math.inf
        if hold["to"] == "motions/play":
            motion = next(one for one in self.motions if one.name == message["motion"])
            at = time.monotonic()
            self.playing, self.frames = motion.name, []
            for frame in motion.frames * message.get("times", 1):
                at += frame.duration_s / message.get("speed", 1.0)
                self.frames.append((at, dict(frame.positions)))
            self.speed_rps, self._until = 3.0, at + 0.2
        elif message.get("frames"):
            self.speed_rps, self._until = 3.0, time.monotonic() + 0.5
        else:
            self.goals |= message.get("positions", {})
            self.speed_rps = message.get("speed_rps") or 3.0
        return {"n": n, "holds": True, "code": "", "reason": "", "holder": "web:page"}

    def motion(self, name: str) -> Motion | None:
        return next((one for one in self.motions if one.name == name), None)

    def halt(self, viewer: Any = None) -> int | None:
        mine = self._hold is not None and (viewer is None or self._hold[0] is viewer)
        found = super().halt(viewer)
        if mine:
            self.goals, self.frames, self.playing = dict(self.angles), [], ""
        return found

    def follow(self) -> None:
        """Let the joints go on for as long as it has been."""
        now = time.monotonic()
        span, self._ticked = min(0.2, now - self._ticked), now
        if self.frames:
            self.goals |= next((pose for at, pose in self.frames if at >= now), self.frames[-1][1])
        for one in self.joints:
            if self.torque[one.name]:
                way, most = self.goals[one.name] - self.angles[one.name], min(self.speed_rps, one.speed_rps) * span
                self.angles[one.name] += max(-most, min(most, way))

    def streams(self) -> dict[str, Any]:
        self.follow()
        joints = {
            one.name: {
                "id": one.device_id, "position_rad": self.angles[one.name], "speed_rps": 0.0, "load": self.load.get(one.name, 0.08),
                "goal_rad": self.goals[one.name], "target_rad": self.goals[one.name] if self.moves else None, "torque": self.torque[one.name],
                "voltage_v": 11.7, "temperature_c": 36.0 + one.device_id % 7, "faults": [], "reason": "",
                "latched": [self.broken[one.name]] if one.name in self.broken else [],
            }
            for one in self.joints
        }  # fmt: skip
        left = self.frames[-1][0] - time.monotonic() if self.frames else None
        ups = {"valid": True, "source": "external", "external_v": 11.62, "battery_v": 3.98, "output_v": 5.08, "charging": True, "temperature_c": 34.0, "relay": True}  # fmt: skip
        return {
            "joints/state": {"sequence": 1, "measured_s": 0.0, "moving": self.moves, "phase": "ready", "joints": joints, "holder": self.holder, "reason": "", "code": "idle", "estop": bool(self.estop)},
            "motions/state": {"playing": bool(self.playing), "motion": self.playing, "frame": 1, "frames": len(self.frames), "round": 1, "times": 1, "left_s": left, "holder": self.holder, "fallen": self.fallen},
            "attitude/state": {"valid": True, "roll_rad": 0.03, "pitch_rad": {"face": 1.5, "back": -1.5}.get(self.fallen, -0.02), "yaw_rad": 0.6, "heading_deg": 55.0},
            "ups/state": ups,
            "power/state": {"phase": "watching" if self.armed else "disarmed", "armed": self.armed, "warn_v": 10.5, "shutdown_v": 9.9, "reason": ""},
        }  # fmt: skip

    def status(self) -> dict[str, Any]:
        return super().status() | {"robot": self.name}

    def describe(self) -> dict[str, Any]:
        motions = [
            {"name": one.name, "help": one.help, "slot": one.slot, "builtin": one.builtin, "frames": len(one.frames), "duration_s": one.slot_s or sum(frame.duration_s for frame in one.frames)}
            for one in self.motions
        ]  # fmt: skip
        told = super().describe() | {"robot": self.name, "motions": motions}
        return told | {"joints": msgspec.to_builtins(self.joints), "buttons": self.buttons, "cameras": [], "ranges": []}

    def application(self) -> Starlette:
        usual = super().application()
        own = [Route("/api/model", self._model), Route("/api/poses", self._poses)]
        asked = [one for one in self.model_face.routes() if one.path.startswith("/api/motion")]
        own += [Route(one.path, partial(self._answer, one), methods=[one.method]) for one in asked]
        usual.router.routes[:0] = own
        return usual

    async def _answer(self, route: Any, received: Request) -> Response:
        """Answer by the server's own handlers, whose rounds are made here."""
        told = contract(route)
        body = msgspec.json.decode(await received.body(), type=told.body) if told.body else None
        params = msgspec.convert(dict(received.query_params), told.params, strict=False) if told.params else None
        self.model_face.step(time.monotonic())
        try:
            answer = called(route, PAGE, params=params, body=body)
            while not isinstance(answer, Response):
                try:
                    answer.send(None)
                except StopIteration as done:
                    return done.value  # type: ignore[no-any-return]
                self.model_face.step(time.monotonic())
                await asyncio.sleep(0.01)
        except face.Refused as err:
            return JSONResponse({"message": err.message, "code": err.code}, err.status)
        return answer

    async def edit(self, rows: Any, *, create: bool, by: str) -> EditReply:
        """Keep a motion, as the executive does."""
        self.kept.append(rows)
        (motion,) = motions_of(*([row for row in rows if isinstance(row, kind)] for kind in (MotionRow, MotionStep)))
        self.motions = (*(one for one in self.motions if one.name != motion.name), motion)
        return EditReply(accepted=True)

    async def _model(self, _request: Request) -> Response:
        return Response(msgspec.json.encode(self.body), media_type="application/json")

    async def _poses(self, _request: Request) -> Response:
        return JSONResponse({"poses": {one.name: key_pose(one) for one in self.motions if one.frames}})

    async def _command(self, request: Request) -> Response:
        given, what = await request.json(), request.path_params["path"]
        self.asked.append((what, given))
        named = given.get("joints") or list(self.angles)
        if what == "joints/torque":
            if not given["on"] and not given.get("joints") and not given.get("confirmed"):
                return JSONResponse({"accepted": False, "reason": "all joints: say that you mean it", "code": "confirm"}, 409)  # fmt: skip
            self.torque |= dict.fromkeys(named, OWN_TORQUE if given["on"] else 0.0)
            self.goals |= {name: self.angles[name] for name in named}
        elif what == "joints/recover":
            self.broken = {name: why for name, why in self.broken.items() if name not in named}
        elif what == "power/arm":
            self.armed = given["armed"]
        elif what == "motions/stop":
            self._tell_stopped("stopped by a page")
        return JSONResponse({"accepted": True})


@contextmanager
def jointed_robot(robot: str = "bioloid") -> Iterator[tuple[JointedRobot, str]]:
    """Serve such a robot until the end of a `with`; yields it and its address."""
    found = JointedRobot(robot)
    with patch.object(served, "SILENT_S", PATIENT_S), served.page_robot(found) as (_, url):
        try:
            yield found, url
        finally:
            found.model_face.close()
