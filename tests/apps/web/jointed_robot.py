"""A humanoid as a page sees it: its rows, its body, joints that go where they are sent as fast as their rows allow."""

import time
from typing import Any

import msgspec
from msgspec.structs import replace

from lbr.messages.description import RobotDescription
from lbr.messages.faces import Button
from lbr.messages.joints import Joint, MotionRow, MotionStep, motions_of
from lbr.messages.leases import CommandReply
from tests.apps.web.page_robot import ROUND_S, PageRobot, capability, commands, outputs
from tests.support import databases

OWN_TORQUE = 0.9
HUMANOID = [
    capability("servos", "dynamixel", "moves the servos", outputs(state="ServosState"), {}),
    capability("joints", "joints", "decides what the joints do", outputs(state="JointsState", result="GoalResult"), commands(leased={"command": "JointsCommand", "move": "MoveCommand"}, torque="operate", recover="operate", stop="view")),
    capability("motions", "motions", "plays motions", outputs(state="MotionsState", result="GoalResult"), commands(leased={"play": "PlayCommand"}, capture="admin", stop="view")),
    capability("attitude", "attitude", "tells how the trunk lies", outputs(state="AttitudeState"), {}),
    capability("ups", "pico", "supplies the power", outputs(state="UpsState"), {}),
    capability("power", "power", "shuts down in time", outputs(state="PowerState"), commands(arm="admin", cancel="operate")),
    capability("web", "web", "serves the robot over HTTP", outputs(state="WebState"), commands(address="view")),
]  # fmt: skip
BODILESS = ("attitude", "ups", "power")


class JointedRobot(PageRobot):
    """Its joints stand at `angles`; what is not in `torque` is limp. `broken` are joints that report an overload."""

    faces = ("page", "model")

    def __init__(self, robot: str = "bioloid") -> None:
        known = databases.of_robot(robot)
        self.name, self.joints = robot, known.of(Joint)
        self.rows = tuple(row for kind in (Joint, MotionRow, MotionStep, Button) for row in known.of(kind))
        super().__init__()
        self.fallen = ""
        self.capabilities = [one for one in HUMANOID if robot == "bioloid" or one.name not in BODILESS]
        self.angles = {one.name: max(one.lower_rad, min(one.upper_rad, 0.0)) for one in self.joints}
        self.goals = dict(self.angles)
        self.torque = dict.fromkeys(self.angles, OWN_TORQUE)
        self.broken: dict[str, str] = {}
        self.armed = False
        self.speed_rps = 1.0
        self.frames: list[tuple[float, dict[str, float]]] = []
        self.playing = ""
        self.kept: list[tuple[MotionStep, ...]] = []

    @property
    def moves(self) -> bool:
        return any(abs(self.goals[name] - angle) > 1e-3 for name, angle in self.angles.items())

    def move(self, to: str, message: dict[str, Any]) -> None:
        now = self._until = time.monotonic()
        self.speed_rps = 3.0
        if to == "motions/play":
            known = databases.of_robot(self.name)
            motion = next(
                one for one in motions_of(known.of(MotionRow), known.of(MotionStep)) if one.name == message["motion"]
            )
            self.playing, self.frames = motion.name, []
            for frame in motion.frames * message.get("times", 1):
                self._until += frame.duration_s / message.get("speed", 1.0)
                self.frames.append((self._until, dict(frame.positions)))
            self._until += 0.2
        elif message.get("frames"):
            self._until = now + 0.5
        else:
            self._until = float("inf")
            self.goals |= message.get("positions", {})
            self.speed_rps = message.get("speed_rps") or 3.0

    def halt(self) -> None:
        super().halt()
        self.goals, self.frames, self.playing = dict(self.angles), [], ""

    def step(self) -> None:
        super().step()
        if self.frames:
            now = time.monotonic()
            self.goals |= next((pose for at, pose in self.frames if at >= now), self.frames[-1][1])
        for one in self.joints:
            if self.torque[one.name]:
                way, most = self.goals[one.name] - self.angles[one.name], min(self.speed_rps, one.speed_rps) * ROUND_S
                self.angles[one.name] += max(-most, min(most, way))

    def streams(self) -> dict[str, Any]:
        joints = {
            one.name: {
                "id": one.device_id, "position_rad": self.angles[one.name], "speed_rps": 0.0, "load": 0.08,
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

    def describe(self) -> RobotDescription:
        return replace(super().describe(), ranges=())

    def look(self, stage: Any) -> None:
        """It has no camera."""

    def answer(self, request: str, message: Any) -> Any:
        if request == "edit":
            self.kept.append(msgspec.json.decode(message.rows[MotionStep.TABLE], type=tuple[MotionStep, ...]))
        return super().answer(request, message)

    def command(self, name: str, given: dict[str, Any]) -> Any:
        named = given.get("joints") or list(self.angles)
        if name == "joints/torque":
            if not given["on"] and not given.get("joints") and not given.get("confirmed"):
                return CommandReply(accepted=False, reason="all joints: say that you mean it", code="confirm")
            self.torque |= dict.fromkeys(named, OWN_TORQUE if given["on"] else 0.0)
            self.goals |= {name: self.angles[name] for name in named}
        elif name == "joints/recover":
            self.broken = {name: why for name, why in self.broken.items() if name not in named}
        elif name == "power/arm":
            self.armed = given["armed"]
        elif name == "motions/stop":
            self.stop("stopped by a page")
        return super().command(name, given)
