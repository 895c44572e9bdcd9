"""Agents over HTTP: a server with the web server's access rules, and the rules for every agent."""

import asyncio
from typing import cast

from mcp.server.streamable_http_manager import StreamableHTTPSessionManager
from starlette.requests import HTTPConnection
from starlette.routing import BaseRoute, Match
from starlette.types import Receive, Scope, Send

from lbr.apps.http.connection import connection_of
from lbr.apps.http.pages import Pages
from lbr.apps.mcp.agent import Agent, rules_of
from lbr.apps.mcp.kind import McpSettings
from lbr.apps.mcp.messages import AllowAgent, McpState
from lbr.apps.mcp.pulses import pulse_of_http
from lbr.apps.mcp.roster import Roster
from lbr.apps.mcp.server import Context as AgentContext
from lbr.apps.mcp.server import McpServer
from lbr.apps.web.access import Access
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client, refuse_without
from lbr.apps.web.front import Front
from lbr.apps.web.guards import headers_of
from lbr.apps.web.viewing import asker
from lbr.bus.door import LanUser
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.client import aio
from lbr.messages.leases import CommandReply

PATH = "/mcp"
CLIENT = "lbr.client"
LARGEST_BODY = 64 * 1024
SESSIONS, IDLE_S = 200, 600.0
"""The sessions of older clients. A killed client's session, of 44 KB, stays as long as a person may think."""
AGENTS = 16
REQUESTS_HZ = 200.0
PUBLISH_S = 1.0
ENDS = "the server for agents ends"


class Door(BaseRoute):
    """Admits agents at one path, with the tokens and users of the web server."""

    def __init__(self, gate: Gate, manager: StreamableHTTPSessionManager) -> None:
        self._gate = gate
        self._manager = manager

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Return whether a request is an agent's."""
        return (Match.FULL if scope["type"] == "http" and scope["path"] == PATH else Match.NONE), {}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request; raise Refused."""
        headers = headers_of(scope)
        self._gate.refuse_strangers(scope, headers)
        client = await self._gate.client(scope, headers, owner=True)
        refuse_without(client, "view")
        scope[CLIENT] = client
        if (connection := connection_of(scope)) is not None:
            connection.mark("watching")
        await self._manager.handle_request(scope, receive, send)


class Mcp(Capability[McpSettings]):
    """The server. Raises DeviceError if it cannot listen."""

    rate_hz = 10.0
    woken_by_streams = False

    def __init__(self, ctx: Context[McpSettings]) -> None:
        super().__init__(ctx)
        self._front = Front(ctx, "agents", lambda url: f"{url.rstrip('/')}{PATH}")
        self._roster = Roster(AGENTS)
        self._access = Access((), ctx.rows(LanUser))
        self._allowed: tuple[str, ...] = ()
        self._publish_at = 0.0

    def open(self) -> None:
        """Listen and serve."""
        server = McpServer(self._agent, pulse_of_http)
        manager = StreamableHTTPSessionManager(
            server.sdk, max_request_body_size=LARGEST_BODY, max_sessions=SESSIONS, session_idle_timeout=IDLE_S
        )
        pages = Pages(())
        gate = Gate(self._access, pages)
        door = Door(gate, manager)
        self._front.open(
            lambda: self._front.application((), door, gate=gate, pages=pages, requests_per_s=REQUESTS_HZ),
            beside=lambda: self._beside(server, manager),
        )

    def step(self) -> None:
        """Publish the rules, and the agents with a person's consent."""
        now = self.ctx.clock()
        self._access.use(self.ctx.rows(LanUser))
        self._front.bridge.serve()
        self._front.publish_news()
        if now >= self._publish_at:
            self._publish_at = now + PUBLISH_S
            self._publish_state(listening_=True)

    def command(self, call: Call) -> None:
        """Give consent to an agent."""
        message = call.message
        if not isinstance(message, AllowAgent):
            call.refuse(f"{call.name} is not understood here", "unknown_command")
            return
        self._allowed = (*self._allowed, message.agent)[-AGENTS:]
        self._publish_state(listening_=self._front.listens)
        call.reply(CommandReply(accepted=True, reason=f"'{message.agent}' may move the robot"))

    def degraded(self, reason: str) -> None:
        """Report that no agent is served."""
        self._publish_state(listening_=False, reason=reason)

    def close(self) -> None:
        """Stop serving, and stop the motion of agents."""
        self._front.bridge.close(ENDS)
        self._front.close(ENDS)

    async def _beside(self, server: McpServer, manager: StreamableHTTPSessionManager) -> None:
        try:
            async with manager.run():
                await asyncio.Event().wait()
        finally:
            await server.close()
            await self._roster.close()

    def _agent(self, ctx: AgentContext) -> Agent:
        """Return the agent of a request, by its client, program and role."""
        client: Client = cast("HTTPConnection", ctx.request).scope[CLIENT]
        params = ctx.session.client_params
        name = params.client_info.name if params is not None else ""
        role, robot = client.role or "view", self.ctx.robot

        def made() -> Agent:
            return Agent(name, lambda source: aio.connect(robot, name=source, role=role), rules_of)

        return self._roster.agent((asker(client), name, role), made)

    def _publish_state(self, *, listening_: bool, reason: str = "") -> None:
        state = McpState(
            listening=listening_,
            rules=self.ctx.settings.rules,
            urls=self._front.urls if listening_ else (),
            allowed=self._allowed,
            refused=self._front.counts.refused,
            reason=reason,
        )
        self.ctx.publish("state", state)
