"""A robot as pages see it: the real server on a real port, over a bus on which a base in a room, and all else, answers."""

import io
import math
import os
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import msgspec
from PIL import Image, ImageDraw

from lbr import home
from lbr.apps.web.api import holds, live, patience
from lbr.apps.web.api.link_age import LinkAge
from lbr.apps.web.kind import WebSettings
from lbr.bus.stamp import Origin
from lbr.capability.context import Received
from lbr.messages.camera import CameraState, JpegFrame
from lbr.messages.description import BaseDescription, CapabilityDescription, CommandDescription, RobotDescription
from lbr.messages.faces import EditReply
from lbr.messages.leases import CommandReply
from lbr.messages.manage import ManageReply
from lbr.messages.pairing import PairReply
from lbr.messages.system import CapabilityStatus, ConsoleResult, EstopState, Event, Status
from tests.apps.web.api_stage import Lender, StageBus
from tests.apps.web.test_web_access import FINGERPRINT, HASH, SECRET, user
from tests.apps.web.web_stage import PendingReply, Served, Stage, serving
from tests.support.browsers import ELSEWHERE
from tests.support.waiting import until

PATIENT_S = 10.0
"""How long the server waits for a page's word: nothing here is about that, and a busy machine starves browsers."""
STATUS_S, STREAMS_S, ROUND_S = 0.5, 0.2, 0.02
ROOM = (-1.6, 3.4, -1.7, 2.1)
TOP_MPS, TOP_RPS = 0.9, 2.4
SENSORS = {"forward": (0.2, 0.0, 0.0), "back": (-0.2, 0.0, math.pi), "left": (0.0, 0.15, math.pi / 2), "right": (0.0, -0.15, -math.pi / 2)}  # fmt: skip
OPERATE, VIEW = "operate", "view"


def outputs(**types: str) -> dict[str, Any]:
    return {name: {"$ref": f"#/$defs/{kind}", "$defs": {kind: {"title": kind, "type": "object"}}} for name, kind in types.items()}  # fmt: skip


def commands(*, leased: Mapping[str, str] = {}, **roles: str) -> dict[str, CommandDescription]:
    """Return commands: by their role, and, if `leased`, by their message."""
    held = {
        name: CommandDescription(schema={"title": kind}, role=OPERATE, leased=True) for name, kind in leased.items()
    }
    return held | {name: CommandDescription(schema={}, role=role, leased=False) for name, role in roles.items()}  # type: ignore[arg-type]


def capability(name: str, kind: str, summary: str, out: dict[str, Any], can: dict[str, Any]) -> CapabilityDescription:
    return CapabilityDescription(name=name, kind=kind, family="operation", summary=summary, outputs=out, commands=can)


DRIVES = {"command": "DriveCommand", "turn": "TurnCommand", "heading": "HeadingCommand", "twist": "TwistCommand"}
CAPABILITIES = [
    capability("drive", "drive", "moves the base", outputs(state="DriveState", result="GoalResult"), commands(leased=DRIVES, stop=VIEW)),
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


class Mover(Lender):
    """Lends the robot's motion, and has the robot move by it."""

    TTL_S = PATIENT_S

    def __init__(self, robot: "PageRobot") -> None:
        super().__init__()
        self._robot = robot
        self._last: Any = None

    def ask(self, source: str, request: str, message: Any, origin: Origin | None = None) -> CommandReply | None:
        to = request.partition("/")[2]
        latched = CommandReply(accepted=False, code="estop", reason="the emergency stop is latched")
        self.refusal = self._robot.refused or (latched if self._robot.estop else None)
        if not message.get("lease"):
            self.ended = None
        reply = super().ask(source, request, message, origin)
        if to.endswith("/stop"):
            self._robot.halt()
            return reply
        plain = {name: value for name, value in message.items() if name not in {"lease", "ttl_s"}}
        if self._last != (to, plain) or not message.get("lease"):
            self._robot.held.append({"to": to, "message": plain})
            self._last = to, plain
            if reply is not None and reply.accepted:
                self._robot.move(to, plain)
        return reply

    def end(self, cause: str, reason: str) -> None:
        """End what is lent; who holds it reads why with its next word."""
        if self.holder:
            self.ended = CommandReply(accepted=False, code="dead_lease", cause=cause, reason=reason)  # type: ignore[arg-type]
            self.holder = ""


class PageBus(StageBus):
    """The robot's bus as its server has it."""

    def __init__(self, robot: "PageRobot") -> None:
        super().__init__(robot.name)
        self._robot = robot
        self.lent = Mover(robot)

    def reply(self, key: str, said: Any) -> Any:
        return self._robot.reply(key.partition("/")[2], said)


class PageStage(Stage):
    """The server's process."""

    def __init__(self, robot: "PageRobot", settings: WebSettings, users: tuple[Any, ...]) -> None:
        super().__init__(settings, (*users, *robot.rows))
        self._robot, self.robot, self.home = robot, robot.name, os.environ["LBR_HOME"]
        self.wired |= {"pair", "call_ring", "call_keep"}
        self.answer = robot.answer

    def event(self, kind: str, text: str, *, level: str = "info", data: Any = None, code: str = "", about: str = "") -> None:  # fmt: skip
        super().event(kind, text, level=level, data=data, code=code, about=about)
        told = Event(kind=kind, subject=self.name, text=text, level=level, data=data or {}, code=code, about=about)  # type: ignore[arg-type]
        self._robot.bus.say("@event", told)

    def targets(self, request: str) -> tuple[str, ...]:
        """Return who answers: `call` its own requests, and else the joints."""
        return ("call",) if request.startswith("call_") else super().targets(request)

    def ask(self, request: str, message: Any, timeout_s: float) -> PendingReply:
        return PendingReply(*self.targets(request), super().ask(request, message, timeout_s).answers()["joints"])

    def engage_estop(self, reason: str) -> None:
        super().engage_estop(reason)
        self._robot.asked.append(("estop", None))
        self._robot.estop = reason
        self._robot.stop("the emergency stop")

    def show(self, camera: str, state: CameraState, picture: bytes) -> None:
        """Have a camera report, and show its newest picture."""
        self.bring("cameras", camera, state)
        if state.on:
            self.came["frames"] = [Received(JpegFrame(picture), None, time.monotonic(), camera)]


class PageRobot:
    """What the pages are told, and what they asked for; `refusal` refuses all motion."""

    name, capabilities, faces = "lbr", CAPABILITIES, ("page", "cameras")
    rows: tuple[Any, ...] = ()

    def __init__(self) -> None:
        self.bus = PageBus(self)
        self.base = Base()
        self.asked: list[tuple[str, Any]] = []
        self.held: list[dict[str, Any]] = []
        self.refusal: dict[str, str] | None = None
        self.estop = ""
        self.muted: set[str] = set()
        self.blind: dict[str, str] = {}
        """Statuses of sensors that say nothing of use."""
        self.lasts_s = 0.6
        """How long a move takes that ends by itself."""
        self.link_age_s = 0.03
        """The age of what a hand drives by."""
        self.moved_at = 0.0
        self.goal = ""
        self.served: Served | None = None
        self.drives_by: dict[str, Any] | None = None
        """What it says of its base; see `rebuild`."""
        self._revision = 7
        self._pictures: dict[int, bytes] = {}
        self._until = math.inf

    @property
    def moves(self) -> bool:
        return bool(self.base.left or self.base.right or self.base.aside)

    @property
    def holder(self) -> str | None:
        return self.bus.lent.holder or None

    @property
    def refused(self) -> CommandReply | None:
        return CommandReply(accepted=False, **self.refusal) if self.refusal else None  # type: ignore[arg-type]

    @property
    def sockets(self) -> int:
        """How many pages look at it."""
        assert self.served is not None
        return len(self.served.web._api.feeds._wanted)  # type: ignore[union-attr]

    def move(self, to: str, message: dict[str, Any]) -> None:
        """Begin or change motion."""
        power, angle = message.get("power", 0.5), math.radians(message.get("angle_deg", 0.0))
        self._until, self.goal, self.moved_at = math.inf, to.partition("/")[2], time.monotonic()
        if self.goal == "twist":
            turn = message["wz_rps"] / MECANUM["max_turn_rps"]
            ahead, self.base.aside = (message[name] / MECANUM["max_speed_mps"] for name in ("vx_mps", "vy_mps"))
            self.base.left, self.base.right = ahead - turn, ahead + turn
            return
        if self.goal in {"turn", "heading"}:
            angle = math.copysign(math.pi / 2, message.get("angle_deg", 1.0))
        if self.goal in {"turn", "heading"} or message.get("distance_cm"):
            self._until = time.monotonic() + self.lasts_s
        throttle, steering = math.cos(angle), math.sin(angle)
        scale = power / max(1.0, abs(throttle) + abs(steering))
        self.base.left, self.base.right = (throttle + steering) * scale, (throttle - steering) * scale

    def halt(self) -> None:
        """Have the wheels stand."""
        self.base.left = self.base.right = self.base.aside = 0.0
        self._until = math.inf

    def stop(self, reason: str, cause: str = "stopped") -> None:
        """Stop, whoever moves it; for another cause as well."""
        self.bus.lent.end(cause, reason)
        self.halt()

    def close(self) -> None:
        """End what it runs."""

    def rebuild(self, base: dict[str, Any] | None) -> None:
        """Say another base from now on."""
        self.drives_by, self._revision = base, self._revision + 1
        self.bus.robot = self.describe()
        api = self.served.web._api if self.served is not None else None
        until(lambda: api is None or (api.known is not None and api.known.robot.revision == self._revision))

    def step(self) -> None:
        """Let a moment pass."""
        self.base.step(ROUND_S)
        if time.monotonic() >= self._until:
            self.stop("turned 90 degrees", "done")

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
            "odometry/state": {"valid": True, "epoch": "a", "x_m": base.x, "y_m": base.y, "yaw_rad": base.yaw, "distance_m": base.way, "speed_mps": speed, "aside_mps": base.aside * TOP_MPS, "turn_rps": 0.0},
            "attitude/state": {"valid": True, "heading_deg": (90 - math.degrees(base.yaw)) % 360, "roll_rad": 0.0, "pitch_rad": 0.0, "yaw_rad": base.yaw},
            "battery/state": {"valid": True, "voltage_v": 12.6, "charge": 0.82, "charging": False, "level": "ok"},
            "speech/state": {"speaking": False, "text": "", "queued": 0, "spoken": 0, "failed": 0, "sink": "speaker"},
            "dance/state": {"phase": "resting", "song": "", "dance": "", "beat": 0, "beats": 0, "moves": 0, "reason": ""},
            "camera_front/state": {"on": True, "phase": "streaming", "device": "/dev/video0", "width_px": 640, "height_px": 480, "fps": 15.0},
            "camera_rear/state": {"on": False, "phase": "off", "device": "/dev/video2", "reason": "it is switched off"},
        }  # fmt: skip

    def status(self) -> Status:
        parts = tuple(
            CapabilityStatus(
                name=one.name, kind=one.kind, phase="degraded" if one.name == "speech" else "ready", pid=100, restarts=0, uptime_s=300.0, cpu_percent=1.7, memory_mb=31.0,
                reason="no loudspeaker: /dev/snd is not there" if one.name == "speech" else "", rates_hz=dict.fromkeys(one.outputs, 20.0),
            )
            for one in self.capabilities
        )  # fmt: skip
        late = (
            {"waiting": ("motors",), "overdue": ("motors",), "text": OVERDUE, "source": "web:page"}
            if self.estop
            else {}
        )
        estop = EstopState(engaged=bool(self.estop), reason=self.estop, **late)  # type: ignore[arg-type]
        return Status(robot=self.name, profile="lbr-sim", ready=True, pid=1, uptime_s=300.0, estop=estop, capabilities=parts, revision=self._revision)  # fmt: skip

    def describe(self) -> RobotDescription:
        base = BaseDescription(**self.drives_by) if self.drives_by else None
        ranges = [{"name": name, "kind": "ultrasonic", "x_m": x, "y_m": y, "yaw_rad": yaw, "fov_rad": 0.45, "max_m": 4.0} for name, (x, y, yaw) in SENSORS.items()]  # fmt: skip
        return RobotDescription(robot=self.name, simulated=True, revision=self._revision, capabilities=tuple(self.capabilities), words=tuple(WORDS), ranges=tuple(ranges), phrases=tuple(PHRASES), base=base)  # fmt: skip

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

    def reply(self, name: str, said: Any) -> Any:
        """Answer what the server asks on the bus; nothing to what is not there."""
        if name.startswith("@console"):
            return self.line(said)
        if name == "@manage":
            return self.manage(said)
        if said is None:
            return self.streams().get(name) if name.partition("/")[0] not in self.muted else None
        self.asked.append((name, said))
        return self.command(name, said)

    def command(self, name: str, given: dict[str, Any]) -> Any:
        """Answer a command that holds nothing."""
        del name, given
        return CommandReply(accepted=True)

    def line(self, line: str) -> ConsoleResult:
        """Answer a console line."""
        if line == "stop":
            self.asked.append(("stop", None))
            self.stop("stopped by a page")
        elif line.startswith("/why/"):
            text = f"the emergency stop is latched by console@kitchen:812: {self.estop}"
            why = {"state": "held", "text": text, "code": "estop", "do": "reset, once nothing is in danger"}
            well = {"state": "ok", "text": "Nothing is wrong: it waits for a command", "code": "", "do": ""}
            return ConsoleResult(
                code=0, text="", data={"part": line.rpartition("/")[2], **(why if self.estop else well)}
            )
        else:
            self.asked.append(("console", {"line": line}))
        return ConsoleResult(code=0, text="accepted")

    def manage(self, said: dict[str, Any]) -> ManageReply:
        """Answer about rows and events."""
        if "table" in said:
            found = {"table": said["table"], "key": ["name"], "fixed": "", "schema": {}, "settings": {}}
            return ManageReply(accepted=True, data={**found, "rows": []})
        now = time.time_ns()
        events = [
            {"kind": "ready", "subject": "drive", "text": "is ready", "level": "info", "wall_ns": now},
            {"kind": "degraded", "subject": "speech", "text": "no loudspeaker: /dev/snd is not there", "level": "warning", "wall_ns": now, "code": "unreachable"},
            {"kind": "crashed", "subject": "motors", "text": "crashed an hour ago", "level": "error", "wall_ns": 1},
        ]  # fmt: skip
        return ManageReply(accepted=True, data={"events": [one for one in events if said.get("subject", "") in {"", one["subject"]}]})  # fmt: skip

    def answer(self, request: str, message: Any) -> Any:
        """Answer what the server asks by a port."""
        if request == "pair":
            self.asked.append((request, msgspec.to_builtins(message)))
            if message.digits != "123456":
                return PairReply(accepted=False, code="token", reason="these are not the digits that are shown")
            return PairReply(accepted=True, token=token("phone"), name="phone", role=OPERATE, hash=HASH)  # type: ignore[arg-type]
        if request == "estop_reset":
            self.asked.append(("reset", None))
            self.estop = ""
        return EditReply(accepted=True) if request == "edit" else CommandReply(accepted=True)

    def live(self, over: threading.Event, stage: PageStage) -> None:
        """Let time pass, and report, until that is over."""
        streams = status = 0.0
        while not over.wait(ROUND_S):
            now = time.monotonic()
            self.step()
            if now >= streams:
                streams = now + STREAMS_S
                for name, message in self.streams().items():
                    if name.partition("/")[0] not in self.muted:
                        self.bus.say(name, message)
            if now >= status:
                status = now + STATUS_S
                self.bus.say("@status", self.status())
                self.look(stage)

    def look(self, stage: PageStage) -> None:
        """Have the cameras see."""
        stage.show("camera_front", CameraState(on=True, phase="streaming", device="/dev/video0"), self.picture())


def token(name: str) -> str:
    """Return a token that the robot knows: `phone`, `tablet` and `ann` operate, `eve` looks."""
    return f"{name}.{SECRET}.{FINGERPRINT}"


USERS = (user("tablet", OPERATE), user("ann", OPERATE), user("eve", VIEW))


@contextmanager
def page_robot(robot: Any = None, **settings: Any) -> Iterator[tuple[Any, str]]:
    """Serve such a robot, or one that is given, until the end of a `with`; yields it and its address."""
    robot = robot or PageRobot()
    over = threading.Event()
    note = LinkAge.note
    with ExitStack() as stack:
        place = stack.enter_context(tempfile.TemporaryDirectory(prefix="lbr-"))
        stack.enter_context(patch.dict(os.environ, {"LBR_HOME": place}))
        home.directory("credentials")  # later the process may have the home of another robot
        stack.enter_context(patch.multiple(holds, SILENT_S=PATIENT_S))
        stack.enter_context(patch.multiple(patience, SILENT_S=PATIENT_S, BOUNDED_S=PATIENT_S))
        stack.enter_context(patch.multiple(live, OLDEST_S=PATIENT_S))
        stack.enter_context(patch.object(LinkAge, "note", lambda age, _age_s, now: note(age, robot.link_age_s, now)))
        robot.bus.robot = robot.describe()
        make = lambda settings, users: PageStage(robot, settings, users)  # noqa: E731
        found = stack.enter_context(
            serving(faces=robot.faces, users=USERS, bus=robot.bus, make=make, names=(ELSEWHERE,), requests_per_s=10_000.0, **settings)
        )  # fmt: skip
        robot.served = found
        sys.setswitchinterval(0.005)  # the server's own, for two threads, costs the many of this process too much
        living = threading.Thread(target=robot.live, args=(over, found.stage))
        stack.callback(robot.close)
        stack.callback(living.join)
        stack.callback(over.set)
        living.start()
        until(lambda: found.web._api is not None and found.web._api.known is not None and found.web._api.phases)
        yield robot, f"http{'s' if settings.get('tls') else ''}://127.0.0.1:{found.port}"
