"""The API in the capability's loop: motors move by one lease, motions play one at a time, jobs begin when due."""

from collections.abc import Callable, Mapping
from math import inf
from typing import Any

from msgspec import UNSET
from msgspec.structs import replace

from lbr.apps.web.bridge import until
from lbr.apps.web.face import Refused
from lbr.apps.web.robot import Robot
from lbr.messages.faces import Motor
from lbr.messages.joints import Joint
from lbr.messages.system import Role
from lbr.robots.uxa90.driver.messages import TakeControlCommand
from lbr.robots.uxa90.rest import parsing
from lbr.robots.uxa90.rest.answers import Measured, MotorAnswer, MotorData, MultiAnswer, MultiPositions, PlayedAnswer
from lbr.robots.uxa90.rest.buttons import ButtonTable, played
from lbr.robots.uxa90.rest.counts import count_of
from lbr.robots.uxa90.rest.jobs import Jobs
from lbr.robots.uxa90.rest.motor_client import MotorClient
from lbr.robots.uxa90.rest.number import nearest
from lbr.robots.uxa90.rest.parsing import Move, Turn
from lbr.robots.uxa90.rest.playing import Player
from lbr.robots.uxa90.rest.table import MotorTable

TAKE_CONTROL_S = 3.0
STOOD_STILL_S = 1.0
"""The longest pause of the loop after which due jobs still begin: later ones would surprise everybody."""


class Service:
    """The API; everything here runs in the capability's loop, except for reading the tables."""

    def __init__(self, robot: Robot) -> None:
        self.motors = MotorTable(robot.motors, robot.joints, robot.settings.layer)
        self.buttons = ButtonTable(robot.buttons)
        self.jobs = Jobs()
        self._robot = robot
        self._mover = MotorClient(robot, self._drop)
        self._player = Player(robot, self._drop)
        self._stopped_s: float | None = None
        self._looked = False
        self._stepped = inf
        self._given_up = (0, "")  # the number of times, and the last reason
        self._next = ""  # the motion that begins once motors have stopped

    def step(self, now: float) -> None:
        """Continue motion, jobs and leases."""
        self._mover.step()
        self._player.step(now)
        self._watch_stops()
        if now - self._stepped > STOOD_STILL_S:
            self._drop(f"the server stood still for {now - self._stepped:.1f} s")
        self._stepped = now
        for name, turns in self.jobs.due(now):
            self._robot.start(self._begin(name, turns))

    def stopped(self, reason: str) -> None:
        """Give everything up, including moves that wait for replies."""
        self._given_up = (self._given_up[0] + 1, reason)
        self.jobs.drop(reason)
        self._mover.release(reason)
        self._player.stop(reason)

    def state(self) -> Mapping[str, Any]:
        """Return this face's part of the stream of states."""
        return {
            "positions": {str(number): position for number, position in self.motors.commanded.items()},
            "busy": self._player.busy(self._robot.now()),
            "moving": self._mover.holds,
            "jobs": self.jobs.waiting,
        }

    async def motor(
        self, query: parsing.Query, require: Callable[[Role], None], *, measured: bool, came_s: float = inf
    ) -> MotorAnswer:
        """Handle /motor."""
        wanted = parsing.of_motor(self.motors, query)
        if isinstance(wanted, Move):
            require("operate")
            self._refuse_stopped_since(came_s)
            return await self._move(wanted, parsing.unit_of(query), measured=measured)
        unit = parsing.unit_of(query)

        def data(motor: Motor) -> MotorData:
            return self._with_measured(self.motors.data(motor, unit=unit), measured=measured)

        if wanted is not None:
            return MotorAnswer(data(wanted), "getMotorInfo")
        return MotorAnswer([data(motor) for motor in self.motors.motors.values()], "getAllMotors")

    async def several(self, body: object, query: parsing.Query, came_s: float = inf) -> MultiAnswer:
        """Handle /multimotor."""
        self._refuse_stopped_since(came_s)
        decided = parsing.of_motors(self.motors, body, query)
        job = await self._turn(tuple(turn for turn, _ in decided))
        echoed = MultiPositions([item for _, item in decided])
        return MultiAnswer("setMultiMotorsPos", echoed, UNSET if job is None else job)

    async def play(self, key: str, came_s: float = inf) -> PlayedAnswer:
        """Handle /motion/KEY; motors' moves end first."""
        self._refuse_stopped_since(came_s)
        button, by_id = self.buttons.find(key)
        if button.motion:
            self._refuse_busy()
            await self._play(button.motion)
        else:
            await self._take_control()
        return played(button, by_id=by_id)

    async def _move(self, move: Move, unit: str, *, measured: bool) -> MotorAnswer:
        motor, position = move.turn.motor, move.turn.position
        old = self.motors.commanded[motor.id]
        job = await self._turn((move.turn,))
        data = self._with_measured(self.motors.data(motor, position, unit), measured=measured)
        return MotorAnswer(data, "setMotorPos", old, position, move.torq, UNSET if job is None else job)

    async def _turn(self, turns: tuple[Turn, ...]) -> str | None:
        """Begin the moves without a delay; return the job of the others, if the first were accepted."""
        now = tuple(turn for turn in turns if not turn.delay_s > 0.0)
        later = len(now) < len(turns)
        if later:
            self._refuse_stopped()
            self.jobs.refuse_more()
        if now:
            self._refuse_busy()
        asked, before = self._robot.now(), self._given_up
        if now:
            await self._mover.turn(now, self._joint)
            self._refuse_given_up(before)
            self._tell(now)
        return self.jobs.add(turns, asked) if later else None

    async def _begin(self, name: str, turns: tuple[Turn, ...]) -> None:
        """Begin the due steps of a job; a refusal ends it."""
        try:
            self._refuse_busy()
            await self._mover.turn(turns, self._joint, timed=True)
        except Refused as err:
            self.jobs.fail(name, turns, err.message)
            self._robot.ctx.event("job_dropped", f"job {name} was dropped: {err.message}", level="warning")
        else:
            self._tell(turns)

    async def _play(self, motion: str) -> None:
        why, before = f"the motion '{motion}' was asked for", self._given_up
        self.jobs.drop(why)
        released = self._mover.release(why)
        if released is not None:
            self._next = motion
            try:
                await until(lambda: released.answers() is not None)
            finally:
                self._next = ""
            self._refuse_given_up(before)
        await self._player.play(motion)

    async def _take_control(self) -> None:
        """Take control of the main board; motors' moves continue."""
        reply = await self._robot.ask("take_control", TakeControlCommand(), timeout_s=TAKE_CONTROL_S)
        if not reply.accepted:
            raise Refused(409, reply.why)

    def _joint(self, turn: Turn) -> Joint:
        return self.motors.joint(turn.motor)

    def _tell(self, turns: tuple[Turn, ...]) -> None:
        for turn in turns:
            self.motors.commanded[turn.motor.id] = turn.position

    def _refuse_busy(self) -> None:
        if why := self._player.busy(self._robot.now()) or (f"busy: '{self._next}' begins" if self._next else ""):
            raise Refused(409, why, code="busy")

    def _refuse_given_up(self, before: tuple[int, str]) -> None:
        """Refuse to continue a request from before everything was given up."""
        if self._given_up != before:
            raise Refused(409, self._given_up[1], code="stopped")

    def _refuse_stopped(self) -> None:
        joints = self._robot.snapshot.joints_state
        if joints is not None and joints.estop:
            raise Refused(409, f"{joints.reason or 'emergency stop'}; 'reset' releases it", code="estop")

    def _refuse_stopped_since(self, came_s: float) -> None:
        """Refuse a request that began to arrive before the joints were stopped, and is complete only now."""
        joints = self._robot.snapshot.joints_state
        if joints is not None and joints.stopped_s is not None and came_s <= joints.stopped_s:
            by = f" by {joints.stopped_by}" if joints.stopped_by else ""
            raise Refused(409, f"the robot was stopped{by} after this was sent", code="stopped_since")

    def _watch_stops(self) -> None:
        """Drop waiting jobs, too, when the joints are stopped."""
        joints = self._robot.snapshot.joints_state
        if joints is None:
            return
        stopped = self._looked and joints.stopped_s != self._stopped_s
        self._stopped_s, self._looked = joints.stopped_s, True
        if joints.estop:
            self._drop("the emergency stop was pressed")
        elif stopped:
            self._drop("the joints were stopped")

    def _drop(self, why: str) -> None:
        if dropped := self.jobs.drop(why):
            self._robot.ctx.event("job_dropped", f"{dropped} jobs were dropped: {why}", level="warning")

    def _with_measured(self, data: MotorData, *, measured: bool) -> MotorData:
        if not measured:
            return data
        return replace(data, measured=self._measured(self.motors.motors[data.id]), commanded=data.position)

    def _measured(self, motor: Motor) -> Measured | None:
        received, joint = self._robot.snapshot.joints, self.motors.joints.get(motor.id)
        state = received.message.joints.get(joint.name) if received is not None and joint is not None else None
        if received is None or joint is None or state is None:
            return None
        at = None if state.position_rad is None else nearest(count_of(joint, state.position_rad))
        age_s = None if state.age_s is None else round(state.age_s + received.age_s(self._robot.now()), 3)
        return Measured(at, state.load, age_s, state.trusted is not False and at is not None)
