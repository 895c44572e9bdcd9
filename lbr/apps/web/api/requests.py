"""The API's routes with one answer: the robot's description, a stream's newest message, a command, a console line."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any

from msgspec import Meta, Struct
from starlette.responses import Response

from lbr.apps.web.api.catalog import WATCHED, Described
from lbr.apps.web.api.feeds import sample_of
from lbr.apps.web.api.service import Api
from lbr.apps.web.api.stops import AT_ONCE, is_stop
from lbr.apps.web.bridge import until
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Client, Refused, Request, encoded, get, json, post
from lbr.bus import codec
from lbr.bus.wire import PendingQuery, RawMessage, encode
from lbr.capability.kind import STOP
from lbr.errors import MalformedError
from lbr.messages.codes import MEANINGS
from lbr.messages.system import RANKS, ConsoleResult, Role
from lbr.messages.why import Chain

COMMAND_S = 5.0
STREAM_S = 1.0
LINE_S = 30.0
WHY_S = 2.0
LONGEST_PART = 64
LONGEST_LINE = 4096
OVERTAKEN = "a stop came after this command"
TOLD = 400
OF_PEOPLE = "web:"
"""The prefix of a client's name on the bus; the name of its token, or its address, follows."""


class ConsoleBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A line, as it would be typed at the console."""

    line: Annotated[str, Meta(max_length=LONGEST_LINE)]


class Requests:
    """The routes; they run in the capability's loop, which resumes them once a round."""

    def __init__(self, api: Api) -> None:
        self._api = api

    @get("/api")
    async def _describe(self, client: Client) -> Described:
        """The description of the robot, and your rights."""
        return self._api.described(client.role)

    @get("/api/{capability}/{name}")
    async def _newest(self, client: Client, capability: str, name: str) -> Response:
        name = f"{capability}/{name}".lower()
        catalog = self._api.catalog()
        if name in WATCHED or name not in catalog.streams:
            raise Refused(404, f"there is no stream '{name[:81]}' on this robot; GET /api names them")
        question = self._api.query(name, b"", source=source_of(client), timeout_s=STREAM_S)
        await until(lambda: question.done or bool(question.replies))
        sample = sample_of(question.replies[0]) if question.replies else None
        if sample is None:
            raise Refused(
                404, f"'{name}' has sent nothing yet, or its process is gone", {"Retry-After": "1"}, "unreachable"
            )
        age = max(0.0, self._api.now() - sample.sent_s)
        return encoded(b'{"age_s":%.3f,"message":%s}' % (age, sample.text))

    @post("/api/{capability}/{name}", stops=lambda given: given["name"].lower() == STOP, within_s=COMMAND_S + 1.0)
    async def _command(
        self, request: Request, capability: str, name: str, body: dict[str, Any] | None = None
    ) -> Response:
        name = f"{capability}/{name}".lower()
        command = self._api.catalog().commands.get(name)
        if command is None:
            raise Refused(404, f"there is no command '{name[:81]}' on this robot; GET /api names them")
        request.require(command.role)
        source, payload = source_of(request.client), payload_of(body or {})
        capability, _, asks = name.partition("/")
        if asks == STOP:
            self._api.stopped(request.came_s, capability)
        if RANKS[command.role] > RANKS["view"] and not command.leased:
            self._api.tell("command", f"{source} asks {name}: {payload[:TOLD].decode(errors='replace')}")
        waiting = self._api.waiting(request.came_s, capability if command.leased or asks == STOP else "")
        if waiting.sent_s is not None and RANKS[command.role] > RANKS["view"] and not command.leased:
            raise Refused(409, OVERTAKEN, code="stopped")
        question = self._api.query(name, payload, source=source, timeout_s=COMMAND_S, waiting=waiting)
        await until(lambda: question.done or bool(question.replies))
        if not question.replies:
            raise Refused(503, f"'{name}' does not answer", {"Retry-After": "1"})
        return replied(_decoded(question.replies[0]))

    @post("/api/console", stops=lambda given: is_stop(given["body"].line), within_s=LINE_S + 1.0)
    async def _console(self, request: Request, body: ConsoleBody) -> Annotated[Response, {200: ConsoleResult}]:
        """Run a console line.

        It runs with the rights of the client. The status is 200 even for a refused line; `code` has the result.
        """
        role: Role = request.client.role or "view"
        line = body.line
        if stops := is_stop(line):
            self._api.stopped(request.came_s)
        said = AT_ONCE if stops else self._api.waiting(request.came_s)
        question = self._api.line(line, role=role, source=source_of(request.client), timeout_s=LINE_S, waiting=said)
        answer = await answered(question, LINE_S)
        return json(answer, 200, Reason_Code=_code(answer.get("reason_code", "")))

    @get("/api/why", within_s=WHY_S + 1.0)
    async def _why(self, client: Client) -> Annotated[Response, {200: Chain}]:
        """The hindrances of the robot."""
        return await self._reason("why", client)

    @get("/api/why/{part}", within_s=WHY_S + 1.0)
    async def _why_part(
        self, client: Client, part: str
    ) -> Annotated[Response, {200: Chain}, Refuses({404: "There is nothing of this name on this robot."})]:
        """The hindrances of a part, and what to type.

        `first` is the index in `links` of the main cause; `state` is `ok` without a hindrance.
        """
        return await self._reason(f"/why/{part[:LONGEST_PART]}", client)

    async def _reason(self, line: str, client: Client) -> Response:
        role = client.role or "view"
        question = self._api.line(line, role=role, source=source_of(client), timeout_s=WHY_S)
        answer = await answered(question, WHY_S)
        if answer.get("code") != 0:
            raise Refused(404, str(answer.get("text", "")), code="unknown_name")
        return json(answer.get("data"))


async def answered(question: PendingQuery, within_s: float) -> dict[str, object]:
    """Return the robot's answer; raise Refused (503) if it is late or malformed."""
    await until(lambda: question.done or bool(question.replies))
    if not question.replies:
        raise Refused(503, f"the robot did not answer within {within_s:g} s", {"Retry-After": "1"}, "timeout")
    return _decoded(question.replies[0])


def source_of(client: Client) -> str:
    """Return the client's name on the bus: by its token, or by its address."""
    name = client.name or client.session.partition(":")[0]
    return f"{OF_PEOPLE}{name or client.address}"[:80]


def payload_of(message: object) -> bytes:
    """Encode a message for the robot; raise Refused (400) for values that JSON does not have."""
    try:
        return encode(message)
    except (OverflowError, RecursionError) as err:
        raise Refused(400, f"the message cannot be passed on: {err}") from None


def replied(answer: dict[str, object], statuses: Mapping[str, int] = MappingProxyType({})) -> Response:
    """Return a reply as a response; a refusal gets the status of its code, and the fields of all refusals."""
    if answer.get("accepted") is not False:
        return json(answer)
    code = str(answer.get("code") or "refused")
    status = {"malformed": 400, "bad_value": 400, **statuses}.get(code, 409)
    return json({**answer, "message": str(answer.get("reason", "")), "code": code}, status, Reason_Code=_code(code))


def _decoded(raw: RawMessage) -> dict[str, object]:
    try:
        answer = codec.decode(raw.payload)
    except MalformedError as err:
        raise Refused(503, f"the answer cannot be read: {err}", code="malformed") from None
    return answer if isinstance(answer, dict) else {"answer": answer}


def _code(code: object) -> str:
    """Return a code for a header; a capability's unknown code becomes `refused`."""
    return code if isinstance(code, str) and code in MEANINGS else "refused" if code else ""
