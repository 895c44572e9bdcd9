"""The same robot for programs with an event loop: its motion goes on only while that loop runs.

    from lbr.client import aio                # in the distribution lbr-client: from lbr_client import aio

    async with aio.connect() as robot:
        async with robot.drive(0.2):
            await asyncio.sleep(2)
        await robot.turn(90)
        async for readings in robot.stream("ranges/readings"):
            ...

Tasks of the loop renew the leases: if the loop is blocked, frozen or killed, the robot stops.
"""

import asyncio
import threading
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing, suppress
from pathlib import Path
from typing import Any, ParamSpec, Self, TypeVar

import msgspec

from lbr.bus import wire
from lbr.client.motion import AT_MOST_S, KEEP_S, LONGEST_S, Message, Motion, bounded
from lbr.client.robot import HELD_S, LineResult, Picture, Robot
from lbr.client.robot import connect as connect_blocking
from lbr.client.words import Words
from lbr.console.lines import POLL_S
from lbr.errors import BusError, InputError
from lbr.messages.system import Role

P = ParamSpec("P")
R = TypeVar("R")


class AsyncRobot:
    """A robot, connected from the beginning of its `async with`. Its methods are those of `Robot`, to be awaited."""

    def __init__(self, open_robot: Callable[[], Robot]) -> None:
        self._open = open_robot
        self._robot: Robot | None = None
        self._words: Words[Any] | None = None

    async def __aenter__(self) -> Self:
        self._robot = await _apart(self._open)
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await asyncio.shield(_apart(self.blocking.close))

    @property
    def blocking(self) -> Robot:
        """Return the underlying robot; the loop's thread must not keep motion on it."""
        if self._robot is None:
            raise InputError("not connected: use it in an `async with`")
        return self._robot

    @property
    def name(self) -> str:
        """Return the robot's name."""
        return self.blocking.name

    @property
    def do(self) -> Words[Any]:
        """Return the robot's words as methods that are awaited: `await robot.do.play("wave")`."""
        if self._words is None:
            self._words = Words(self.blocking.operator.words, self.say)
        return self._words

    async def latest(self, name: str) -> Message:
        """Return the newest message of a stream, or another answer on a key; raise BusError without an answer."""
        return await _apart(self.blocking.latest, name)

    async def ask(self, name: str, **message: Any) -> Message:
        """Send a command that borrows nothing, and return its reply; raise RefusalError, or BusError without an
        answer."""
        return await _apart(self.blocking.ask, name, **message)

    async def stream(self, name: str, *, within_s: float = 2.0) -> AsyncGenerator[Message, None]:
        """Yield the messages of a stream as they come, always the newest; raise BusError after a silence."""
        async with aclosing(self._payloads(name, within_s)) as payloads:
            async for payload in payloads:
                yield msgspec.json.decode(payload)

    async def pictures(self, camera: str, *, within_s: float = 2.0) -> AsyncGenerator[Picture, None]:
        """Yield the pictures of a camera such as `camera_front` as they come, always the newest; BusError after a
        silence."""
        async with aclosing(self._payloads(f"{camera}/frame", within_s)) as payloads:
            async for payload in payloads:
                yield Picture(payload)

    async def picture(self, camera: str) -> Picture:
        """Return the next picture of a camera; BusError if none comes."""
        async with aclosing(self.pictures(camera)) as found:
            return await anext(found)

    async def say(self, line: str, *, hold_s: float = HELD_S) -> LineResult:
        """Send a console line and return when it is done; unbounded motion is held for `hold_s`, then stopped.

        Raise RefusalError if it is refused, or does not end as planned. If it is cancelled, its motion stops.
        """
        robot = self.blocking
        result = _apart(robot.say_kept, line, hold_s=hold_s, beat=lambda: None)  # the loop beats
        try:
            while not result.done():
                robot.operator.ear.beat()
                await asyncio.wait([result], timeout=POLL_S)
        except asyncio.CancelledError:
            result.add_done_callback(lambda late: late.cancelled() or late.exception())
            await asyncio.shield(_apart(robot.operator.release, "the program cancelled it"))
            raise
        return result.result()

    def hold(self, name: str, *, at_most_s: float = AT_MOST_S, **message: Any) -> "AsyncMotion":
        """Return a motion for an `async with`: a task keeps it, for `at_most_s`, and it is released at the end."""
        return AsyncMotion(lambda: self.blocking.borrow(name, **message), at_most_s)

    def drive(self, power: float, angle_deg: float = 0.0, *, at_most_s: float = AT_MOST_S) -> "AsyncMotion":
        """Drive within an `async with`, at a share of full power (-1 to 1); 0 degrees is ahead, 90 to the right."""
        return self.hold("drive/command", at_most_s=at_most_s, power=power, angle_deg=angle_deg)

    def twist(
        self, vx_mps: float = 0.0, wz_rps: float = 0.0, *, vy_mps: float = 0.0, at_most_s: float = AT_MOST_S
    ) -> "AsyncMotion":
        """Drive within an `async with`, with this twist (REP 103: ahead, anticlockwise, to the left)."""
        return self.hold("drive/twist", at_most_s=at_most_s, vx_mps=vx_mps, vy_mps=vy_mps, wz_rps=wz_rps)

    async def turn(self, angle_deg: float) -> None:
        """Turn on the spot, clockwise positive; return when it is done."""
        async with self.hold("drive/turn", at_most_s=LONGEST_S, angle_deg=angle_deg) as motion:
            await motion.wait()

    async def stop(self) -> None:
        """Stop whatever moves."""
        await _apart(self.blocking.stop)

    async def estop(self, reason: str = "") -> None:
        """Engage the emergency stop, which stays until `reset`."""
        await _apart(self.blocking.estop, reason)

    async def reset(self) -> None:
        """Release the emergency stop, without any motion."""
        await _apart(self.blocking.reset)

    async def _payloads(self, name: str, within_s: float) -> AsyncGenerator[bytes, None]:
        robot, loop, came = self.blocking, asyncio.get_running_loop(), asyncio.Event()

        def wake() -> None:
            with suppress(RuntimeError):  # the loop is closed: nobody reads on
                loop.call_soon_threadsafe(came.set)

        subscription = wire.Subscription(robot.session, robot.key(name), wake=wake)
        try:
            while True:
                async with asyncio.timeout(within_s):
                    await came.wait()
                came.clear()
                for raw in subscription.take():
                    yield raw.payload
        except TimeoutError:
            raise BusError(f"nothing came on '{name}' for {within_s:g} s") from None
        finally:
            subscription.close()


class AsyncMotion:
    """Motion within an `async with`, for `at_most_s` at most, while its event loop runs; then it is released."""

    def __init__(self, begin: Callable[[], Motion], at_most_s: float) -> None:
        self._begin = begin
        self._at_most_s = bounded(at_most_s)
        self._motion: Motion | None = None
        self._task: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        self._motion = await _apart(self._begin)
        self._task = asyncio.create_task(self._keep(self._motion))
        return self

    async def __aexit__(self, kind: type[BaseException] | None, *_exc: object) -> None:
        assert self._motion is not None
        assert self._task is not None
        lost = self._task.exception() if self._task.done() and not self._task.cancelled() else None
        self._task.cancel()
        await asyncio.shield(_apart(self._motion.release))
        if kind is None and lost is not None:
            raise lost

    @property
    def moving(self) -> bool:
        """Return whether the motion still goes on."""
        return self._task is not None and not self._task.done()

    def change(self, **change: Any) -> None:
        """Change these fields of the motion; raise RefusalError if it has ended."""
        if self._motion is None:
            raise InputError("this motion has not begun: it does within its `async with`")
        self._motion.keep(**change)

    async def wait(self) -> None:
        """Wait for its end; raise RefusalError if it does not end as planned."""
        if self._task is None:
            raise InputError("this motion has not begun: it does within its `async with`")
        await asyncio.wait([self._task])
        self._task.result()

    async def _keep(self, motion: Motion) -> None:
        loop = asyncio.get_running_loop()
        until = loop.time() + self._at_most_s
        while motion.keep() and loop.time() < until:  # noqa: ASYNC110 - it is renewed by time
            await asyncio.sleep(KEEP_S)
        await asyncio.shield(_apart(motion.release))


def connect(
    robot: str | None = None,
    *,
    at: str | None = None,
    token_file: Path | str | None = None,
    name: str = "",
    role: Role = "admin",
) -> AsyncRobot:
    """Return the robot of `lbr.client.connect`, for an `async with`, which connects."""
    return AsyncRobot(lambda: connect_blocking(robot, at=at, token_file=token_file, name=name, role=role))


def _apart(call: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> asyncio.Future[R]:
    """Run a blocking call in a thread of its own: a pool could be full when a stop has to be sent."""
    loop = asyncio.get_running_loop()
    future: asyncio.Future[R] = loop.create_future()

    def settle(result: R | None, error: BaseException | None) -> None:
        if future.done():
            return
        if error is not None:
            future.set_exception(error)
        else:
            future.set_result(result)  # type: ignore[arg-type]

    def run() -> None:
        result, error = None, None
        try:
            result = call(*args, **kwargs)
        except BaseException as err:  # noqa: BLE001 - it belongs to who awaits it
            error = err
        with suppress(RuntimeError):  # the loop is closed: nobody awaits it
            loop.call_soon_threadsafe(settle, result, error)

    threading.Thread(target=run, name="lbr-client", daemon=True).start()
    return future
