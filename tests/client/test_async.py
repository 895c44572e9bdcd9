"""A robot in an event loop: what it keeps moving goes on only while that loop runs."""

import asyncio
from contextlib import asynccontextmanager

import pytest

from lbr import client
from lbr.client import aio
from tests.client.wheels import turning, wheels
from tests.support.mover import HELD_UP, NOT_BEGUN
from tests.support.waiting import HANG_S, until


@asynccontextmanager
async def connected():
    async with aio.connect(name="a test") as robot:
        await robot.reset()
        await robot.stop()
        yield robot


async def begun(robot, motion):
    """Begin a motion, once the base is armed again after what was before."""
    for _ in range(round(HANG_S / 0.05)):
        try:
            return await motion().__aenter__()
        except client.RefusalError as error:
            if error.code not in NOT_BEGUN:
                raise
            await asyncio.sleep(0.05)
    raise AssertionError("it never began")


async def soon(look):
    """Wait until it is so; it looks in a thread, since a query of the bus would hold up what the loop renews."""
    for _ in range(round(HANG_S / 0.01)):
        if await asyncio.to_thread(look):
            return
        await asyncio.sleep(0.01)
    raise AssertionError(look)


def test_it_looks_and_streams_and_says_lines(robot):
    async def main():
        async with connected() as ours:
            assert ours.name == "lbr"
            assert "forward_m" in await ours.latest("ranges/readings")
            heard = [message async for _, message in _first(3, ours.stream("ranges/readings", within_s=9.0))]
            assert len(heard) == 3
            assert "drive" in (await ours.do.status()).text
            with pytest.raises(client.RefusalError) as refused:
                await ours.say("/r/3/0")
            assert refused.value.code == "bad_value"
            with pytest.raises(client.BusError, match="nothing came on 'nothing/here'"):
                await anext(ours.stream("nothing/here", within_s=0.1))

    asyncio.run(main())


async def _first(count, messages):
    for number in range(count):
        yield number, await anext(messages)
    await messages.aclose()


def test_motion_goes_on_in_its_async_with_changes_and_ends_with_it(robot, running):
    async def main():
        async with connected() as ours:
            motion = await begun(ours, lambda: ours.drive(0.1, 180))
            await soon(lambda: turning(running))
            motion.change(power=0.2)
            await soon(lambda: abs(wheels(running)[0]) > 0.15)
            assert motion.moving
            await motion.__aexit__(None, None, None)
            await soon(lambda: wheels(running) == (0.0, 0.0))

    asyncio.run(main())


def test_motion_that_nothing_ends_ends_after_its_time(robot, running):
    async def main():
        async with connected() as ours:
            while True:
                motion = await begun(ours, lambda: ours.drive(0.1, 180, at_most_s=0.6))
                try:
                    await motion.wait()
                except client.RefusalError as error:
                    if error.code not in HELD_UP:
                        raise
                else:
                    break
            assert not motion.moving
            await soon(lambda: wheels(running) == (0.0, 0.0))

    asyncio.run(main())


@pytest.mark.parametrize("moving", ["borrowed", "said"])
def test_a_blocked_loop_keeps_nothing_moving(moving, robot, running):
    async def main():
        async with connected() as ours:
            motion = await begun(ours, lambda: ours.drive(0.1, 180, at_most_s=30)) if moving == "borrowed" else None
            said = asyncio.ensure_future(_said(ours, "/r/0.1/180")) if moving == "said" else None
            await soon(lambda: turning(running))
            until(lambda: wheels(running) == (0.0, 0.0))  # the loop stands still meanwhile
            with pytest.raises(client.RefusalError) as lost:
                await (said or motion.wait())
            assert lost.value.code in {"lapsed", "dead_lease", "holder_gone"}

    asyncio.run(main())


async def _said(robot, line):
    while True:
        try:
            return await robot.say(line, hold_s=30)
        except client.RefusalError as error:
            if error.code not in NOT_BEGUN:
                raise
            await asyncio.sleep(0.05)


def test_a_line_that_is_cancelled_stops_what_it_moves(robot, running):
    async def main():
        async with connected() as ours:
            said = asyncio.ensure_future(_said(ours, "/r/0.1/180"))
            await soon(lambda: turning(running))
            said.cancel()
            with pytest.raises(asyncio.CancelledError):
                await said
            await soon(lambda: wheels(running) == (0.0, 0.0))

    asyncio.run(main())


def test_motion_that_is_taken_away_is_told_at_the_end_of_its_with(robot, running):
    async def main():
        async with connected() as ours:
            motion = await begun(ours, lambda: ours.drive(0.1, 180, at_most_s=30))
            await soon(lambda: turning(running))
            await ours.stop()
            with pytest.raises(client.RefusalError) as lost:
                await motion.wait()
            assert lost.value.code in {"stopped", "dead_lease"}
            with pytest.raises(client.RefusalError):
                await motion.__aexit__(None, None, None)

    asyncio.run(main())


def test_a_motion_of_the_blocking_robot_is_kept_while_its_program_waits_and_no_longer_than_it_may(robot, running):
    def begun():
        try:
            return robot.drive(0.1, 180, at_most_s=1.5).__enter__()
        except client.RefusalError as error:
            if error.code not in NOT_BEGUN:
                raise
            return None

    motion = until(begun)
    until(lambda: turning(running))
    until(lambda: wheels(running) == (0.0, 0.0))  # nothing of ours ends it
    assert motion.wait(5.0)
    assert not motion.moving
    motion.__exit__(None, None, None)
    motion = until(begun)
    until(lambda: turning(running))
    running.say("s")
    with pytest.raises(client.RefusalError) as lost:
        motion.wait()
    assert lost.value.code in {"stopped", "dead_lease"}
    with pytest.raises(client.RefusalError):
        motion.__exit__(None, None, None)


@pytest.mark.parametrize("at_most_s", [0, -1, float("nan"), float("inf")])
def test_a_motion_without_a_bound_is_refused(robot, at_most_s):
    with pytest.raises(client.InputError, match="at_most_s"):
        robot.drive(0.1, at_most_s=at_most_s)
