"""Whether a client lives is told by the pipe that it reads."""

import asyncio
import os
import socket
import tempfile
from contextlib import closing

import pytest

from tests.support import needs

needs.modules("mcp")


@pytest.fixture(params=["pipe", "socket"])
def ends(request):
    if request.param == "pipe":
        read, write = os.pipe()
        yield read, write
        os.close(read)
        os.close(write)
        return
    ours, theirs = socket.socketpair()
    with closing(ours), closing(theirs):
        yield theirs.fileno(), ours.fileno()


def pipe_to(descriptor):
    from lbr.apps.mcp.stdio import Pipe  # mcp takes seconds to load, and only one of the test processes needs it

    return Pipe(descriptor)


async def beats_of(pipe, count, client):
    """Follow a pipe until it has beaten so often, with a client that does `client` again and again."""
    enough, beats = asyncio.Event(), []

    def beat():
        beats.append(1)
        if len(beats) >= count:
            enough.set()

    following = asyncio.create_task(pipe.follow(beat))
    acting = asyncio.create_task(client())
    await enough.wait()
    following.cancel()
    acting.cancel()


def test_a_client_that_reads_lives(ends):
    read, write = ends

    async def reads():
        while True:
            await asyncio.to_thread(os.read, read, 100)

    async def main():
        pipe = pipe_to(write)
        assert not pipe.why_not()
        await beats_of(pipe, 5, reads)
        os.write(write, b"\n")  # the thread that reads ends

    asyncio.run(main())


def test_a_client_that_reads_nothing_shows_nothing(ends):
    _read, write = ends

    async def main():
        beaten = asyncio.Event()
        following = asyncio.create_task(pipe_to(write).follow(beaten.set))
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(beaten.wait(), 0.2)
        following.cancel()

    asyncio.run(main())


def test_a_message_follows_blanks_and_is_whole(ends):
    read, write = ends

    async def main():
        pipe = pipe_to(write)
        following = asyncio.create_task(pipe.follow(lambda: None))
        assert await asyncio.to_thread(os.read, read, 1) == b" "
        await pipe.write('{"id": 1}\n')
        following.cancel()
        text = b""
        while not text.endswith(b"\n"):
            text += os.read(read, 100)
        assert text.strip() == b'{"id": 1}'

    asyncio.run(main())


def test_a_file_tells_nothing_of_a_client():
    with tempfile.TemporaryFile() as file:
        assert pipe_to(file.fileno()).why_not()
