"""An agent at standard input and output: one client, at the other end of a pipe."""

import array
import asyncio
import fcntl
import os
import signal
import stat
import termios
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, cast

from mcp.server.stdio import stdio_server

from lbr.apps.mcp.agent import Agent, rules_of
from lbr.apps.mcp.motion import PATIENCE_S, TICK_S
from lbr.apps.mcp.server import Context, McpServer
from lbr.client.aio import AsyncRobot

BLANK = b" "
"""A message may follow a blank: JSON may begin with blanks."""
UNSEEN = "the life of this agent's client cannot be observed: start it with a pipe or a socket as standard output"


class Pipe:
    """This end of the pipe that the client reads. A client that lives reads what is in it, even a blank."""

    patience_s = PATIENCE_S

    def __init__(self, number: int) -> None:
        self._number = number
        self._lock = threading.Lock()
        self._unread_before = 0
        mode = os.fstat(number).st_mode
        self._question = termios.FIONREAD if stat.S_ISFIFO(mode) else termios.TIOCOUTQ if stat.S_ISSOCK(mode) else 0

    async def write(self, text: str) -> None:
        """Write a whole message; no blank can come within it."""
        await asyncio.to_thread(self._write, text.encode())

    async def flush(self) -> None:
        """Do nothing: nothing is buffered."""

    def why_not(self) -> str:
        """Return why the life of the client cannot be observed; empty if the pipe shows it."""
        return "" if self._question else UNSEEN

    async def follow(self, beat: Callable[[], None]) -> None:
        """Put a blank into the empty pipe repeatedly, and beat each time it was read."""
        while True:
            if self._has_read():
                beat()
            await asyncio.sleep(TICK_S)

    def _has_read(self) -> bool:
        """Return whether the client has read since the last call; write a blank if the pipe is empty."""
        if not self._lock.acquire(blocking=False):  # a message is being written, which needs a reader
            return False
        try:
            unread = self._unread()
            has_read, self._unread_before = unread < self._unread_before, unread
            if unread == 0:
                os.write(self._number, BLANK)
                self._unread_before = len(BLANK)
        except OSError:  # the client has closed it
            return False
        else:
            return has_read
        finally:
            self._lock.release()

    def _unread(self) -> int:
        """Return the number of unread bytes."""
        count = array.array("i", [0])
        fcntl.ioctl(self._number, self._question, count)
        return count[0]

    def _write(self, data: bytes) -> None:
        with self._lock, suppress(OSError):  # a client that has closed it closes our input, too
            rest = memoryview(data)
            while rest:
                rest = rest[os.write(self._number, rest) :]


def serve(connect: Callable[[str], AsyncRobot]) -> None:
    """Serve the client at standard input and output until it closes them, or a signal ends this process."""
    pipe = Pipe(os.dup(1))
    os.dup2(2, 1)  # other prints must not mix with messages
    asyncio.run(_served(pipe, connect))


async def _served(pipe: Pipe, connect: Callable[[str], AsyncRobot]) -> None:
    agents: list[Agent] = []

    def agent(ctx: Context) -> Agent:
        if not agents:
            params = ctx.session.client_params
            agents.append(Agent(params.client_info.name if params is not None else "", connect, rules_of))
        return agents[0]

    server = McpServer(agent, lambda _ctx: pipe)
    serving = asyncio.ensure_future(_run(server, pipe))
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, serving.cancel)
    try:
        with suppress(asyncio.CancelledError):
            await serving
    finally:
        await server.close()
        for one in agents:
            await one.close()


async def _run(server: McpServer, pipe: Pipe) -> None:
    async with stdio_server(stdout=cast("Any", pipe)) as (read, write):
        await server.sdk.run(read, write, server.sdk.create_initialization_options())
