"""What goes over from the server's thread to the capability's loop, and what becomes of it."""

import asyncio

import pytest

from lbr.apps.web import bridge as bridges
from lbr.apps.web.bridge import Bridge, until
from lbr.apps.web.face import Refused


class Loop:
    """A capability's loop, whose rounds are a test's."""

    def __init__(self) -> None:
        self.failed: list[Exception] = []
        self.woken = 0
        self.bridge = Bridge(self._wake, self.failed.append)

    def _wake(self) -> None:
        self.woken += 1


@pytest.fixture
def loop() -> Loop:
    return Loop()


async def refused(loop: Loop, work, **options: float) -> str:
    with pytest.raises(Refused) as caught:
        await loop.bridge.call(work, **options)
    assert caught.value.status == 503
    return caught.value.message


def test_a_coroutine_goes_over_and_what_it_returns_comes_back(loop):
    seen: list[int] = []

    async def work() -> str:
        await until(lambda: len(seen) == 2)
        return "done"

    async def asks() -> str:
        asked = asyncio.ensure_future(loop.bridge.call(work()))
        await asyncio.sleep(0)
        for number in range(3):
            loop.bridge.serve()
            seen.append(number)
        return await asked

    assert asyncio.run(asks()) == "done"
    assert loop.woken == 1


def test_what_has_begun_goes_on_though_whoever_asked_is_gone(loop):
    there: list[int] = []

    async def work() -> None:
        there.append(1)
        await until(lambda: len(there) > 1)
        there.append(3)

    async def asks() -> None:
        asked = asyncio.ensure_future(refused(loop, work(), timeout_s=0.01))
        await asyncio.sleep(0)
        loop.bridge.serve()
        assert "did not answer within 0.01 s" in await asked

    asyncio.run(asks())
    there.append(2)
    loop.bridge.serve()
    assert there == [1, 2, 3]
    assert not loop.failed


def test_what_has_not_begun_does_not_begin_once_whoever_asked_is_gone(loop):
    begun: list[int] = []

    async def work() -> None:
        begun.append(1)

    asyncio.run(refused(loop, work(), timeout_s=0.01))
    loop.bridge.serve()
    assert begun == []


def test_a_fault_is_told_and_silences_nobody_else(loop):
    async def broken() -> None:
        raise ZeroDivisionError

    async def whole() -> int:
        return 1

    first, second = loop.bridge.start(broken()), loop.bridge.start(whole())
    assert isinstance(first.exception(0), ZeroDivisionError)
    assert second.result(0) == 1
    assert [type(err) for err in loop.failed] == [ZeroDivisionError]


def test_a_refusal_is_an_answer_and_no_fault(loop):
    seen: list[int] = []

    async def refuses() -> None:
        await until(lambda: bool(seen))
        raise Refused(409, "no")

    waits = loop.bridge.start(refuses())
    assert not waits.done()
    seen.append(1)
    loop.bridge.serve()
    assert isinstance(waits.exception(0), Refused)
    assert not loop.failed


def test_a_loop_that_ends_refuses_what_waits_and_what_comes(loop, monkeypatch, wording):
    async def never() -> None:
        await until(lambda: False)

    async def asks() -> None:
        waits = [asyncio.ensure_future(refused(loop, never())) for _ in range(2)]
        await asyncio.sleep(0)
        loop.bridge.serve()
        late = asyncio.ensure_future(refused(loop, never()))
        await asyncio.sleep(0)
        loop.bridge.close("the server ends")
        assert {await one for one in (*waits, late)} == {"the server ends"}
        assert await refused(loop, never()) == "the server ends"
        loop.bridge.open()
        monkeypatch.setattr(bridges, "MOST_WAITING", 0)
        wording(await refused(loop, never()))

    asyncio.run(asks())
