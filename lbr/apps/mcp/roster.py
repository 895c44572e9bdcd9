"""The agents of a server over HTTP, by client and program."""

import asyncio
from collections.abc import Callable, Hashable

from lbr.apps.mcp.agent import Agent
from lbr.errors import InputError


class Roster:
    """At most `most` agents: the one idle for longest leaves first, unless it moves the robot."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._agents: dict[Hashable, Agent] = {}
        self._leaving: set[asyncio.Task[None]] = set()

    def agent(self, key: Hashable, make: Callable[[], Agent]) -> Agent:
        """Return the agent of a key, made at its first call; raise InputError if all others move the robot."""
        if key not in self._agents and len(self._agents) >= self._most:
            self._dismiss_one()
        agent = self._agents.pop(key, None) or make()
        self._agents[key] = agent
        return agent

    async def close(self) -> None:
        """Disconnect all of them."""
        for agent in self._agents.values():
            await agent.close()
        await asyncio.gather(*self._leaving)

    def _dismiss_one(self) -> None:
        idle = next((key for key, agent in self._agents.items() if agent.motion is None), None)
        if idle is None:
            raise InputError(f"{self._most} agents move the robot already", "busy")
        leaving = asyncio.ensure_future(self._agents.pop(idle).close())
        self._leaving.add(leaving)
        leaving.add_done_callback(self._leaving.discard)
