"""The simulated room as an environment of Gymnasium, `lbr/Room-v0`: the learner drives by twists, through the real
drive.

    import gymnasium
    import lbr.gym

    room = gymnasium.make("lbr/Room-v0")

The drive's rules, limits and ramps are those of the robot: it slows down and refuses a twist before an obstacle. No
real robot moves.
"""

from math import cos, isfinite, radians, sin
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import msgspec
import numpy as np
from gymnasium import spaces
from msgspec.structs import replace
from numpy.typing import NDArray

from lbr import home
from lbr.bus import keys
from lbr.capability import registry
from lbr.capability.calls import Answers
from lbr.capability.stage import ROUND_S, Stage
from lbr.commands.rows import planned
from lbr.database import store
from lbr.database.rows import RobotRows
from lbr.errors import InputError
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.dock import DockSignal
from lbr.messages.drive import TwistCommand
from lbr.messages.sensing import Ranges
from lbr.simulation.engine import Engine, body_of
from lbr.simulation.settings import StartPose, Ultrasonic, WorldSettings
from lbr.simulation.trials.faults import NONE
from lbr.simulation.trials.instruments import Instruments
from lbr.simulation.trials.places import free, starts
from lbr.simulation.trials.trial import COMPASS_DEG, NOISY, rows_of

ID = "lbr/Room-v0"
USUAL = "lbr"
BY = "gym"
WITHIN = ("drive", "battery", "odometry")
"""Kinds that run here unchanged."""
HEARD: dict[type[Any], str] = {Ranges: "ranges", AttitudeState: "attitude", DockSignal: "dock", BatteryState: "battery"}
SENSORS = ("forward", "back", "left", "right")
BEAMS = ("left", "right", "power")
REACH_M = 6.0
"""The value of a missing measurement: there is nothing within reach."""
MOST_MPS, MOST_RPS = 0.5, 1.5
STEP_S, WARM_S, LONGEST_S = 0.1, 1.0, 120.0
DOCKED, CONTACT, TIME = 100.0, -1.0, -0.01
"""The reward of a step: for the dock's current, each new contact with anything else, and the elapsed time."""

Seen = dict[str, NDArray[np.float32]]


class Room(gymnasium.Env[Seen, NDArray[np.float32]]):
    """A robot on wheels somewhere in its room, which has to reach its dock.

    An action is a twist, two shares from -1 to 1: of MOST_MPS ahead, and of MOST_RPS anticlockwise; it holds for
    STEP_S. An episode ends when the dock charges the robot, and is truncated after `max_s` seconds of the robot's time.
    `database` and `robot` choose the rows; by default, the shipped rows of `lbr`. InputError: the rows are not of a
    robot on wheels, there is no such file, or `max_s` is invalid.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(
        self,
        *,
        database: str | Path | None = None,
        robot: str = USUAL,
        max_s: float = LONGEST_S,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            raise InputError(f"'{ID}' draws nothing: leave render_mode out", "bad_value")
        if not isinstance(max_s, int | float) or not max_s > 0.0:  # this way round, NaN is refused
            raise InputError(f"max_s {max_s!r} is no number of seconds above 0", "bad_value")
        self.render_mode = None
        self._max_s = max_s
        self._robot = robot
        self._units, self._kinds = _processes(_rows(database, robot))
        self._world: WorldSettings = self._kinds["world"].parse(self._units["world"].settings)
        if self._world.ultrasonic == Ultrasonic():
            self._world = replace(self._world, ultrasonic=NOISY)
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space: Any = spaces.Dict(
            {
                "ranges_m": spaces.Box(0.0, REACH_M, (len(SENSORS),), np.float32),
                "heading": spaces.Box(-1.0, 1.0, (2,), np.float32),
                "beacon": spaces.Box(0.0, 1.0, (len(BEAMS),), np.float32),
                "battery": spaces.Box(0.0, 1.0, (2,), np.float32),
            }
        )
        self._board: Stage | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Seen, dict[str, Any]]:
        """Put the robot at a random place where it can turn, or at `options["start"]`: x and y in metres, yaw in
        radians.

        Return its observation, and the truth about it. InputError: there is no room for it there.
        """
        super().reset(seed=seed)
        random = Random(int(self.np_random.integers(1 << 62)))
        world = replace(self._world, start=self._start(options or {}, random), seed=random.randrange(1 << 30))
        board = self._board = Stage(self._robot)
        sensors, wheels, rollers = body_of(world, rows_of(self._units["world"]))
        self._seen: dict[str, Any] = {}
        for name, unit in self._units.items():
            if self._kinds[name].name in WITHIN:
                board.add(unit, self._kinds[name], random.uniform(0.0, 0.02))
            for output, message in self._kinds[name].outputs.items():
                if message in HEARD:
                    board.listen(keys.port(self._robot, name, output), message, self._hears(HEARD[message]))
        others = {name: (unit, self._kinds[name]) for name, unit in self._units.items() if name not in board.members}
        compass_deg = random.uniform(-COMPASS_DEG, COMPASS_DEG)
        engine = Engine(world, sensors, wheels, rollers=rollers)
        self._instruments = Instruments(board, others, engine, random, NONE, compass_deg)
        self._asked: Answers | None = None
        self._lease = self._refusal = ""
        self._against = False
        self._rounds(WARM_S)
        self._began_s = board.now
        return self._observed(), self._info()

    def step(self, action: NDArray[np.float32]) -> tuple[Seen, float, bool, bool, dict[str, object]]:
        """Drive by a twist for STEP_S. A NaN is a stop."""
        board = self._board
        if board is None:
            raise InputError("reset comes before the first step", "rest_first")
        try:
            ahead, turn = map(float, action)
        except (TypeError, ValueError) as err:
            raise InputError(f"an action is two numbers, ahead and turning; {action!r} is not", "bad_value") from err
        if not (isfinite(ahead) and isfinite(turn)):
            ahead = turn = 0.0
        ahead, turn = (min(max(share, -1.0), 1.0) for share in (ahead, turn))
        twist = TwistCommand(vx_mps=ahead * MOST_MPS, wz_rps=turn * MOST_RPS, lease=self._lease)
        self._asked = board.command(self._drive, "twist", twist, BY)
        contacts = self._rounds(STEP_S)
        docked = self._instruments.pose.charging
        reward = TIME + CONTACT * contacts + (DOCKED if docked else 0.0)
        return self._observed(), reward, docked, board.now - self._began_s >= self._max_s, self._info()

    def close(self) -> None:
        """Release the world."""
        self._board = None

    @property
    def _drive(self) -> str:
        return next(name for name, kind in self._kinds.items() if kind.name == "drive")

    def _start(self, options: dict[str, Any], random: Random) -> StartPose:
        if unknown := ", ".join(map(repr, options.keys() - {"start"})):
            raise InputError(f"there is no option {unknown}: 'start' is the only one", "bad_value")
        if "start" not in options:
            if len(places := starts(self._world, 2, random.randrange(1 << 30))) < 2:
                raise InputError(
                    "there is no room for the robot to turn anywhere: see the walls of its world", "bad_value"
                )
            return places[1]
        try:
            x_m, y_m, yaw_rad = (float(one) for one in options["start"])
        except (TypeError, ValueError) as err:
            raise InputError("options['start'] is x and y in metres and yaw in radians", "bad_value") from err
        if not all(isfinite(one) for one in (x_m, y_m, yaw_rad)):
            raise InputError(
                f"options['start'] is of finite numbers; {x_m:g}, {y_m:g}, {yaw_rad:g} is not", "bad_value"
            )
        try:
            start = msgspec.convert({"x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad}, StartPose)
        except msgspec.ValidationError as err:
            raise InputError(f"options['start']: {err}", "bad_value") from err
        if not free(self._world, start):
            raise InputError(f"there is no room for the robot to turn at {x_m:g}, {y_m:g}", "bad_value")
        return start

    def _hears(self, what: str) -> Any:
        def hear(message: object) -> None:
            self._seen[what] = message

        return hear

    def _rounds(self, seconds: float) -> int:
        """Let time pass; return how often the robot newly touched anything but its dock."""
        assert self._board is not None
        contacts = 0
        for _ in range(round(seconds / ROUND_S)):
            self._board.round()
            self._instruments.round()
            self._answered()
            touching = self._instruments.pose.touching
            contacts += touching and not self._against
            self._against = touching
        return contacts

    def _answered(self) -> None:
        """Renew the drive's lease, or request one again after a refusal."""
        if self._asked is None or (answers := self._asked.answers()) is None:
            return
        self._asked, reply = None, answers[self._drive]
        self._lease = reply.lease if reply is not None and reply.accepted else ""
        self._refusal = "" if reply is None or reply.accepted else reply.why.code

    def _observed(self) -> Seen:
        """Return the newest readings; before the first, nothing is near and nothing is known."""
        ranges, attitude = self._seen.get("ranges"), self._seen.get("attitude")
        dock, battery = self._seen.get("dock"), self._seen.get("battery")
        metres = [ranges.metres(name) if ranges is not None else None for name in SENSORS]
        heading = radians(attitude.heading_deg) if attitude is not None and attitude.heading_deg is not None else 0.0
        charge = battery.charge if battery is not None and battery.charge is not None else 1.0
        return {
            "ranges_m": np.array([REACH_M if one is None else min(one, REACH_M) for one in metres], np.float32),
            "heading": np.array([cos(heading), sin(heading)], np.float32),
            "beacon": np.array([float(dock is not None and getattr(dock, beam)) for beam in BEAMS], np.float32),
            "battery": np.array([charge, float(battery is not None and battery.charging is True)], np.float32),
        }

    def _info(self) -> dict[str, object]:
        """Return the truth, for rewards and evaluation: no robot knows it."""
        pose = self._instruments.pose
        return {
            "pose": (pose.x_m, pose.y_m, pose.yaw_rad),
            "speed_mps": pose.speed_mps,
            "touching": pose.touching,
            "charging": pose.charging,
            "refused": self._refusal,
        }


def _rows(database: str | Path | None, robot: str) -> RobotRows:
    """Return a robot's rows, from a database or as shipped."""
    if database is not None:
        if not Path(database).exists():
            raise InputError(f"there is no database {database}; 'lbr db init' makes one", "unknown_name")
        return _loaded(Path(database), robot)
    with TemporaryDirectory(prefix="lbr-gym-") as place:
        shipped = Path(place) / "rows" / "robot.db"
        store.create(shipped)
        return _loaded(shipped, robot)


def _loaded(path: Path, robot: str) -> RobotRows:
    with store.Database.open(path, program="gym") as opened:
        return opened.load(*opened.robots(robot))


def _processes(rows: RobotRows) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a robot's processes as its rows plan them in a simulation, and their kinds; the world's name is
    `world`."""
    plan, problems = planned(rows)
    if plan is None:
        raise InputError(f"the rows of {rows.robot.name} make no robot: {problems[0]}", "bad_value")
    units = {name: one.config for name, one in plan.units.items() if one.program is None}
    kinds = {name: registry.find(one.kind, home.home()) for name, one in units.items()}
    worlds = [name for name, kind in kinds.items() if kind.name == "world"]
    if not worlds or all(kind.name != "drive" for kind in kinds.values()):
        raise InputError(f"{rows.robot.name} has no wheels in a room: rows of kind 'world' and 'drive'", "not_possible")
    units["world"], kinds["world"] = units.pop(worlds[0]), kinds.pop(worlds[0])
    return units, kinds


gymnasium.register(id=ID, entry_point="lbr.gym:Room")
