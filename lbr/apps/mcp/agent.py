"""An agent at a robot: its tools, run in its own name, and their record."""

import asyncio
import re
import secrets
import time
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from io import BytesIO
from typing import Any, NamedTuple

import msgspec
from msgspec import Struct

from lbr.apps.mcp import bounds
from lbr.apps.mcp.messages import McpState, Rules
from lbr.apps.mcp.motion import BehaviourMotion, Motion
from lbr.apps.mcp.tools import SECONDS, Known, Tool, allowed_line, named
from lbr.bus import keys, wire
from lbr.client import BusError, InputError, LbrError, LineResult
from lbr.client.aio import AsyncRobot
from lbr.client.robot import GONE
from lbr.messages.plain import one_line
from lbr.messages.system import Event

Arguments = Mapping[str, Any]
SAY_S = 5.0
MOTIONS, MOTIONS_S = 20, 10.0
"""The most motions that may begin within a time; stops are not counted."""
KNOWN_S = 5.0
PLAN_S, MOST_PLANS = 60.0, 8
LONGEST_TEXT, LONGEST_EVENT = 600, 500
LARGEST_SIDE = 640
"""The largest side of a picture in pixels; larger pictures are scaled down."""
STOPPED = "the agent stopped it"
STREAMS = (
    "drive/state",
    "ranges/readings",
    "odometry/state",
    "attitude/state",
    "battery/state",
    "dock/signal",
    "joints/state",
    "motions/state",
    "behaviour/state",
    "power/state",
)
DO = {
    "bad_value": "keep to the bounds that the tool states",
    "busy": "wait for its end, or call `stop`",
    "confirm": "ask the person with the robot: they let you by `/agent/` and your name, at a console or the page",
    "denied": "ask the person before you try it again; `words` lists the allowed words",
    "estop": "ask a person to reset it; no tool does",
    "held": "ask its holder to let go; `status` names the holder",
    "obstacle": "`status` has what the sensors measure; go another way",
    "role": "ask for a token with a higher role",
    "stopped": "ask the person who stopped it before you go on; `why` names that person",
    "taken_over": "a person drives now; wait until you are asked",
    "unknown_command": "`words` lists the allowed words",
    "unreachable": "`why` names the missing part",
}
"""The cure of a code, for an agent."""


class Outcome(Struct, frozen=True, kw_only=True):
    """The answer of a tool: `code` is one of docs/reference/codes.md, `do` the cure."""

    code: str
    text: str
    do: str = ""
    data: object = None
    picture: bytes = b""

    @property
    def good(self) -> bool:
        """Return whether the tool succeeded."""
        return self.code in {"done", "time_over"}

    def as_json(self) -> dict[str, object]:
        """Return the answer as JSON."""
        answer: dict[str, object] = {"code": self.code, "text": one_line(self.text)[:LONGEST_TEXT]}
        return answer | ({"do": self.do} if self.do else {}) | ({"data": self.data} if self.data is not None else {})


def refused(err: LbrError) -> Outcome:
    """Return the outcome of a refusal, by its code."""
    code = getattr(err, "code", "") or ("unreachable" if isinstance(err, BusError) else "refused")
    return Outcome(code=code, text=str(err), do=DO.get(code, ""))


def clean_name(name: str) -> str:
    """Return an agent's name in the form that robots show."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", name).strip("-.")[:30] or "agent"


class MustAskError(Exception):
    """A person must be asked first, and the call cannot wait for the answer."""


class Way(Struct, frozen=True, kw_only=True):
    """The server's part: `begin` runs a motion to its end, `confirm` asks the agent's user (None: it cannot ask)."""

    begin: Callable[[Motion], Awaitable[LineResult]]
    confirm: Callable[[str], Awaitable[bool | None]]


class Plan(NamedTuple):
    """A planned motion, and the time at which it expires."""

    tool: Tool
    arguments: Arguments
    until: float


async def rules_of(robot: AsyncRobot) -> McpState:
    """Return a robot's rules for agents, from its row if that is on; raise InputError if its process is silent."""
    for part in (await robot.latest("@status"))["capabilities"]:
        if part["kind"] == "mcp":
            try:
                return msgspec.convert(await robot.latest(f"{part['name']}/state"), McpState)
            except (BusError, msgspec.ValidationError) as err:
                raise InputError(
                    f"the rules for agents are not known: '{part['name']}' does not answer", "not_ready"
                ) from err
    return McpState(listening=False, rules=Rules())


class Agent:
    """The tools of one agent. It connects at its first call, and again after the robot was away."""

    def __init__(
        self,
        name: str,
        connect: Callable[[str], AsyncRobot],
        rules: Callable[[AsyncRobot], Awaitable[McpState]] = rules_of,
    ) -> None:
        self.name = clean_name(name)
        self.motion: Motion | None = None
        self._connect = connect
        self._rules = rules
        self._robot: AsyncRobot | None = None
        self._connecting = asyncio.Lock()
        self._known = Known()
        self._known_until = 0.0
        self._begun: deque[float] = deque(maxlen=MOTIONS)
        self._confirmed: set[str] = set()
        self._plans: dict[str, Plan] = {}

    async def close(self) -> None:
        """Stop its motion, and disconnect."""
        robot, self._robot = self._robot, None
        if robot is not None:
            await robot.__aexit__()

    async def known(self) -> Known:
        """Return the robot's words and rules, read again after some seconds."""
        robot = await self._connected()
        now = time.monotonic()
        if now >= self._known_until:
            words = await asyncio.to_thread(robot.blocking.operator.words)
            described = {}
            for target in {one["target"] for one in words if one["target"].count(".") == 1}:
                described[target] = await self._described(robot, target)
            rules = (await self._rules(robot)).rules
            self._known, self._known_until = Known(words=tuple(words), described=described, rules=rules), now + KNOWN_S
        return self._known

    async def call(self, name: str, arguments: Mapping[str, object], way: Way) -> Outcome:
        """Run a tool."""
        tool: Tool | None = None
        try:
            tool = named(name)
            outcome = await self._done(tool, arguments, way)
        except LbrError as err:
            outcome = refused(err)
        except asyncio.CancelledError:
            await asyncio.shield(self._note(name, arguments, Outcome(code="cancelled", text=self._ended())))
            raise
        if tool is None or not tool.reads or not outcome.good:
            await self._note(name, arguments, outcome)
        return outcome

    def _ended(self) -> str:
        return self.motion.ended if self.motion is not None else "the agent called it off"

    async def _done(self, tool: Tool, arguments: Mapping[str, object], way: Way) -> Outcome:
        if tool.name == "stop":
            if self.motion is not None:
                self.motion.ended = STOPPED
            return await self._say("stop")
        known = await self.known()
        if not tool.fits(known):
            raise InputError(f"this robot has nothing that can {tool.name}", "not_possible")
        given: Arguments = bounds.checked(tool.schema(known), arguments)
        if tool.name == "do":
            plan = self._planned(given["plan"])
            return await self._moved(plan.tool, plan.arguments, known, way, given["plan"])
        if tool.moves:
            return await self._moved(tool, given, known, way)
        doing = getattr(self, f"_{tool.name}")
        outcome: Outcome = await doing(given, known)
        return outcome

    async def _moved(self, tool: Tool, given: Arguments, known: Known, way: Way, plan_id: str = "") -> Outcome:
        line = allowed_line(given["line"], known) if tool.name == "say" else tool.line(given)
        self._refuse_more()
        robot = await self._connected()
        await self._ask(tool, given, known, line, way)
        self._refuse_more()  # again: the person may have taken long
        if plan_id:
            self._planned(plan_id)
            del self._plans[plan_id]
        self._begun.append(time.monotonic())
        sort = BehaviourMotion if tool.name == "behaviour_run" else Motion
        self.motion = motion = sort(robot, line, given.get(SECONDS, SAY_S))
        try:
            answer = await way.begin(motion)
        finally:
            self.motion = None
        if motion.ended:
            return Outcome(code="stopped", text=motion.ended)
        return Outcome(code="done", text=answer.ending or answer.text)

    def _refuse_more(self) -> None:
        if self.motion is not None:
            raise InputError(f"'{self.motion.line}' is under way", "busy")
        if len(self._begun) == MOTIONS and time.monotonic() - self._begun[0] < MOTIONS_S:
            raise InputError(f"{MOTIONS} motions in {MOTIONS_S:g} s are the most; wait a little", "busy")

    async def _ask(self, tool: Tool, given: Mapping[str, object], known: Known, line: str, way: Way) -> None:
        """Ask a person if the row requires it; raise InputError without consent."""
        wanted = set(known.rules.ask) & _asked_before(tool, given, known, line) - self._confirmed
        if not wanted or self.name in (await self._rules(await self._connected())).allowed:
            return
        text = f"The agent '{self.name}' wants to move the robot: {line}. Let it?"
        if (agreed := await way.confirm(text)) is None:
            raise InputError(f"a person must let '{self.name}' do that first ({', '.join(sorted(wanted))})", "confirm")
        if not agreed:
            raise InputError("the person did not allow it", "denied")
        self._confirmed |= wanted

    def _planned(self, plan_id: str) -> Plan:
        plan = self._plans.get(plan_id)
        if plan is None or not time.monotonic() <= plan.until:
            raise InputError("there is no such plan, or it was done, or is older than a minute", "late")
        return plan

    async def _preview(self, given: Arguments, known: Known) -> Outcome:
        tool = named(given["tool"])
        if not tool.fits(known):
            raise InputError(f"this robot has nothing that can {tool.name}", "not_possible")
        arguments = bounds.checked(tool.schema(known), given["arguments"])
        robot = await self._connected()
        part = str((known.entry(tool.patterns[0]) or {})["target"]).partition(".")[0]
        chain = (await robot.say(f"why {part}")).data or {}
        data: dict[str, Any] = {
            "line": tool.line(arguments),
            "holds_it": chain.get("text", ""),
            "do": chain.get("do", ""),
        }
        data["would_be_refused"] = chain.get("state") == "held"
        data["a_person_is_asked"] = bool(
            set(known.rules.ask) & _asked_before(tool, arguments, known, "") - self._confirmed
        )
        with suppress(BusError):
            data["measured"] = _brief(await robot.latest("ranges/readings"))
        if (side := _side(tool, arguments)) and data.get("measured", {}).get(side) is not None:
            data["free_cm"] = round(data["measured"][side] * 100.0)
            data["reaches"] = data["free_cm"] > abs(arguments.get("distance_cm", 0.0))
        plan_id = secrets.token_hex(8)
        self._plans = dict(list(self._plans.items())[-MOST_PLANS:])
        self._plans[plan_id] = Plan(tool, arguments, time.monotonic() + PLAN_S)
        return Outcome(
            code="done",
            text=f"nothing moved; `do` with plan {plan_id} sends {data['line']}",
            data=data | {"plan": plan_id},
        )

    async def _say(self, line: str) -> Outcome:
        said = await (await self._connected()).say(line)
        return Outcome(code="done", text=said.text, data=said.data)

    async def _estop(self, given: Arguments, _known: Known) -> Outcome:
        reason = one_line(given.get("reason", "")).replace("/", " ").strip()
        return await self._say(f"/estop/{self.name}: {reason}" if reason else f"/estop/{self.name}")

    async def _why(self, given: Arguments, _known: Known) -> Outcome:
        part = one_line(given.get("part", "")).strip()
        answer = await (await self._connected()).say(f"why {part}".strip())
        chain = answer.data or {}
        wrong = [link for link in chain.get("links", ()) if link["state"] != "ok"]
        facts = {name: chain.get(name) for name in ("part", "state", "code", "since_s", "evidence")}
        text, do = chain.get("text") or answer.text, chain.get("do", "")
        return Outcome(code="done", text=text, do=do, data=facts | {"links": wrong})

    async def _words(self, _given: Mapping[str, object], known: Known) -> Outcome:
        words = [
            {
                "pattern": entry["pattern"],
                "help": entry.get("help", ""),
                "choices": {
                    field["name"]: field["choices"] for field in entry.get("fields") or [] if field.get("choices")
                },
            }
            for entry in known.allowed
        ]
        return Outcome(code="done", text=f"{len(words)} words are allowed", data=words)

    async def _look(self, given: Arguments, _known: Known) -> Outcome:
        picture = await (await self._connected()).picture(given["camera"])
        small = await asyncio.to_thread(scaled, bytes(picture))
        return Outcome(code="done", text=f"what {given['camera']} sees now", picture=small)

    async def _status(self, _given: Mapping[str, object], _known: Known) -> Outcome:
        robot = await self._connected()
        status = await robot.latest("@status")
        parts = {part["name"]: part for part in status["capabilities"]}
        streams = {}
        for key in STREAMS:
            if key.partition("/")[0] in parts:
                with suppress(BusError):  # no message yet
                    streams[key] = _brief(await robot.latest(key))
        wrong = {part["name"]: part["reason"] or part["phase"] for part in parts.values() if part["phase"] != "ready"}
        data = {
            "robot": status["robot"],
            "ready": status["ready"],
            "estop": status["estop"],
            "not_ready": wrong,
            "you": robot.blocking.source,
            "measured": streams,
        }
        drive = streams.get("drive/state", {})
        moves = f"moved by {drive['holder']}" if drive.get("holder") else "nothing moves it"
        return Outcome(
            code="done", text=f"{status['robot']}: {'ready' if status['ready'] else 'not ready'}, {moves}", data=data
        )

    async def _connected(self) -> AsyncRobot:
        async with self._connecting:
            if self._robot is not None and self._robot.blocking.why_unanswered == GONE:
                await self.close()
            if self._robot is None:
                robot = self._connect(f"agent {self.name}")
                self._robot, self._known_until = await robot.__aenter__(), 0.0
            return self._robot

    async def _described(self, robot: AsyncRobot, target: str) -> Arguments:
        capability, _, command = target.partition(".")
        try:
            schema = await robot.latest(f"@schema/{capability}/{command}")
        except BusError:
            return {}
        named_schema = schema.get("$defs", {}).get(schema.get("$ref", "").rpartition("/")[2], schema)
        properties: Arguments = named_schema.get("properties", {})
        return properties

    async def _note(self, tool: str, arguments: Mapping[str, object], outcome: Outcome) -> None:
        """Publish the call and its outcome as an event, which the robot adds to its audit trail."""
        asked = ", ".join(f"{name}={bounds.brief(value)}" for name, value in list(arguments.items())[:8])
        text = f"{self.name} asked for {bounds.brief(tool)}({asked}): {outcome.code}: {one_line(outcome.text)}"
        robot = self._robot
        if robot is None:
            return
        event = Event(
            kind="command",
            subject="mcp",
            text=text[:LONGEST_EVENT],
            level="info" if outcome.good else "warning",
            code=outcome.code,
            about=robot.blocking.source,
            data={"agent": self.name},
            wall_ns=time.time_ns(),
        )
        try:
            wire.put(robot.blocking.session, keys.event(robot.name), event, source=robot.blocking.source)
        except BusError:
            return


def _asked_before(tool: Tool, given: Arguments, known: Known, line: str) -> set[str]:
    """Return the reasons for which a row may require consent before a motion."""
    if tool.name == "say":
        word = line.strip("/").split("/")[0]
        targets = {str(entry["target"]) for entry in known.words if entry["word"] == word}
        if not any("lease" in known.described.get(target, {}) for target in targets):
            return set()
    asked = {"first"} | ({"play"} if tool.name == "play" else set())
    return asked | ({"fast"} if given.get("power", 0.0) > known.rules.fast_power else set())


def _side(tool: Tool, arguments: Arguments) -> str:
    """Return the range sensor in the direction of a motion; empty if it turns."""
    if tool.name == "go":
        return "forward_m" if arguments["distance_cm"] > 0 else "back_m"
    if tool.name != "drive":
        return ""
    return ("forward_m", "right_m", "back_m", "left_m")[round(arguments["angle_deg"] / 90.0) % 4]


def _brief(message: dict[str, Any]) -> dict[str, Any]:
    """Shorten a message for agents; of joints only the angles and faults stay."""
    brief = {name: value for name, value in message.items() if name not in {"loop", "rows", "variables"}}
    if isinstance(joints := brief.get("joints"), dict):
        brief["joints"] = {name: joint["position_rad"] for name, joint in joints.items()}
        brief["wrong"] = {
            name: text for name, joint in joints.items() if (text := joint["reason"] or ", ".join(joint["faults"]))
        }
    return brief


def scaled(picture: bytes) -> bytes:
    """Scale a JPEG picture to LARGEST_SIDE at most; other data is unchanged."""
    from PIL import Image

    with suppress(OSError), Image.open(BytesIO(picture)) as image:
        if max(image.size) > LARGEST_SIDE:
            image.thumbnail((LARGEST_SIDE, LARGEST_SIDE))
            image.save(small := BytesIO(), "JPEG")
            return small.getvalue()
    return picture


def encoded(value: object) -> str:
    """Encode a value as JSON text."""
    return msgspec.json.encode(value).decode()
