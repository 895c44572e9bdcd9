"""Pairing: a device sends the six digits that a person read at the robot's console, and receives a token of its own.

The executive draws the digits, compares them and makes the token. The server only passes digits and token on.
"""

import re
from collections.abc import Callable
from typing import Annotated

import msgspec
from msgspec import Meta, Struct
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from lbr.apps.web.access import Access
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import JSON, Client, Refused, post
from lbr.apps.web.login import Login
from lbr.apps.web.robot import Robot
from lbr.bus import tokens
from lbr.bus.door import LanUser
from lbr.messages.pairing import PairCommand, PairReply
from lbr.messages.system import Role

PAIR_S = 5.0
"""The wait for the executive, which delays the answer to wrong digits on purpose."""
REFUSES = Refuses({403: "The code is wrong, used or over.", 429: "Too many are tried at once."})
STATUSES = {"token": 403, "busy": 429, "malformed": 400}


class PairBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The digits, and a name for the device."""

    code: Annotated[
        str, Meta(pattern="^[0-9]{3} ?[0-9]{3}$(?!\\n)", description="six digits, as the console shows them")
    ]
    name: Annotated[str, Meta(max_length=80, description="what the token is named by, as far as it has letters")] = ""


class PairAnswer(Struct, frozen=True, kw_only=True):
    """A token, sent only this once, with the name to list and revoke it by, and its role."""

    token: str
    name: str
    role: Role


class PairingRoutes:
    """The route that pairs devices. `access` and `login` know a new token at once."""

    def __init__(self, robot: Robot, access: Access, login: Login) -> None:
        self._robot = robot
        self._access = access
        self._login = login

    @post("/api/pair", role=None, within_s=PAIR_S + 1.0)
    async def _pair(
        self, client: Client, body: PairBody, whose: str | None
    ) -> Annotated[Response, {200: PairAnswer}, REFUSES]:
        """Get a token for the code at the console.

        The console's word `pair` shows six digits, good for two minutes, one device and four mistakes. The answer also
        sets a cookie, as `/session` does. Wrong digits are answered after a second.
        """
        asked = PairCommand(digits=re.sub("[^0-9]", "", body.code), name=body.name, address=client.address[:64])
        reply: PairReply = await self._robot.ask("pair", asked, timeout_s=PAIR_S)
        if not reply.accepted:
            raise Refused(STATUSES.get(reply.code, 503), reply.reason, code=reply.code or "refused")  # type: ignore[arg-type]
        secret = tokens.parse(reply.token).secret
        self._robot.ctx.adopt([LanUser(name=reply.name, role=reply.role, secret=secret, hash=reply.hash)])
        self._access.use(self._robot.ctx.rows(LanUser))
        answer = PairAnswer(token=reply.token, name=reply.name, role=reply.role)
        return _WithCookie(answer, lambda response: self._login.give(response, reply.name, whose))


class _WithCookie(Response):
    """A response that gets its cookie when it is sent, on the server's thread, as the sessions live there."""

    def __init__(self, answer: PairAnswer, give: Callable[[Response], None]) -> None:
        super().__init__(msgspec.json.encode(answer), 200, None, f"{JSON}; charset=utf-8")
        self._give = give

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Add the cookie, and send the response."""
        self._give(self)
        await super().__call__(scope, receive, send)
