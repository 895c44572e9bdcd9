"""Motion in an agent's name, while the agent's client lives."""

import asyncio
import time
from collections.abc import Callable
from typing import Protocol

from lbr.client import LineResult, Message, RefusalError
from lbr.client.aio import AsyncRobot

PATIENCE_S = 0.25
"""The longest pause between signs of life; then motion is stopped, and at zero within 0.4 s."""
TICK_S = 0.02
LOOK_S, BEGINS_S = 0.2, 1.0
SILENT = "the agent's client has shown no sign of life"
CALLED_OFF = "the agent called it off"
TIME_OVER = "its time is over"


class Pulse(Protocol):
    """Signs of life of a client; it counts as gone after `patience_s` without one."""

    patience_s: float

    def why_not(self) -> str:
        """Return why the life of the client cannot be observed; empty if it can."""

    async def follow(self, beat: Callable[[], None]) -> None:
        """Call `beat` at each sign of life, until cancelled."""


class Motion:
    """A console line and its motion, which goes on only while `beat` is called; `end` stops it for a reason."""

    def __init__(
        self, robot: AsyncRobot, line: str, hold_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.line = line
        self.ended = ""
        self.patience_s = PATIENCE_S
        self._robot = robot
        self._hold_s = hold_s
        self._clock = clock
        self._seen = clock()

    def beat(self) -> None:
        """Note a sign of life of the agent's client."""
        self._seen = self._clock()

    def silent(self) -> str:
        """Return why the motion must end; empty while the client shows that it lives."""
        return "" if self._clock() - self._seen <= self.patience_s else SILENT

    async def run(self) -> LineResult:
        """Send the line, and wait for the end of its motion; raise RefusalError or BusError. When cancelled, stop the
        motion."""
        operator = self._robot.blocking.operator
        operator.ear.also = self.silent
        saying = asyncio.ensure_future(self._robot.say(self.line, hold_s=self._hold_s))
        try:
            while not saying.done():
                if not self.ended and (why := self.silent()):
                    await self.end(why)
                await asyncio.wait([saying], timeout=TICK_S)
        except asyncio.CancelledError:
            saying.add_done_callback(lambda late: late.cancelled() or late.exception())
            await asyncio.shield(self.end(CALLED_OFF))
            raise
        return saying.result()

    async def end(self, why: str) -> None:
        """Stop the motion."""
        self.ended = self.ended or why
        await asyncio.to_thread(self._robot.blocking.operator.release, why)


class BehaviourMotion(Motion):
    """A behaviour, which the robot runs by itself: awaited to its end, and ended with its agent."""

    async def run(self) -> LineResult:
        """Run the behaviour, and wait for its end."""
        answer = await super().run()
        try:
            state = await self._end_of_run()
        except BaseException:
            await asyncio.shield(self.end(CALLED_OFF))
            raise
        text = state["reason"] or state["result"]
        if self.ended or not state["good"]:
            raise RefusalError(state["code"] or "cancelled", f"{self.ended}: {text}" if self.ended else text)
        return LineResult(answer.text, state, text)

    async def _end_of_run(self) -> Message:
        until, look_at = self._clock() + self._hold_s, 0.0
        begun_by = self._clock() + BEGINS_S
        while True:
            now = self._clock()
            if not self.ended and (why := self.silent() or ("" if now < until else TIME_OVER)):
                await self.end(why)
            if now >= look_at:
                look_at = now + LOOK_S
                state = await self._robot.latest("behaviour/state")
                runs = state["phase"] in {"running", "paused"}
                if not runs and now >= begun_by:
                    return state
                begun_by = now if runs else begun_by
            await asyncio.sleep(TICK_S)

    async def end(self, why: str) -> None:
        """End the behaviour."""
        self.ended = self.ended or why
        await self._robot.say("/behaviour/stop")
