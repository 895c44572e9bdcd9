"""An agent at a whole robot: what its tools do, in its own name, and what becomes of its motion when it is gone."""

import asyncio
import sqlite3
from contextlib import closing

import pytest

from tests.apps.mcp.conftest import SPIN, agent, turning
from tests.support import needs
from tests.support import robot as robots
from tests.support.mover import HELD_UP
from tests.support.waiting import HANG_S, until

needs.modules("mcp")
from mcp import Client  # noqa: E402 - an extra
from mcp_types import ElicitResult, Implementation  # noqa: E402

from lbr import client  # noqa: E402
from lbr.apps.mcp.agent import Agent  # noqa: E402
from lbr.apps.mcp.messages import McpState, Rules  # noqa: E402
from lbr.apps.mcp.motion import SILENT  # noqa: E402
from lbr.apps.mcp.server import McpServer  # noqa: E402
from lbr.client import aio  # noqa: E402

NAMED = Implementation(name="a test", version="1")
AGAIN = HELD_UP | {"busy", "stopped_since"}
"""After these a motion is to be asked for again: the base is not armed yet, or a busy machine held somebody up."""
pytestmark = pytest.mark.slow_start


class Present:
    """The pulse of a client in this process."""

    patience_s = HANG_S

    def why_not(self):
        return ""

    async def follow(self, beat):
        while True:
            beat()
            await asyncio.sleep(0.01)


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    with robots.running(robots.prepare(tmp_path_factory.mktemp("mcp"), edits=robots.PATIENT)) as robot:
        yield robot


@pytest.fixture
def home(running, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(running.home))
    running.line("reset")
    running.line("stop")
    until(lambda: wheels(running) == (0.0, 0.0))
    return running.home


def wheels(robot):
    state = robot.ask("motors/state") or {"left": None, "right": None}
    return state["left"], state["right"]


def audit(home):
    """Return who did what, by the audit trail."""
    with closing(sqlite3.connect(home / "robot.db")) as database:
        return database.execute("SELECT source, text FROM audit WHERE kind = 'command'").fetchall()


def with_tools(work, rules=None, pulse=Present, **options):
    """Run `work(client, call)` with the official client in this process; `call` returns what a tool answers."""

    async def main():
        async def rules_of_row(_robot):
            return McpState(listening=False, rules=rules or Rules())

        ours = Agent("a test", lambda name: aio.connect(name=name), rules_of_row)
        server = McpServer(lambda _ctx: ours, lambda _ctx: pulse())
        try:
            async with Client(server.sdk, client_info=NAMED, **options) as program_of_agent:

                async def call(tool, /, **arguments):
                    return (await program_of_agent.call_tool(tool, arguments)).structured_content

                return await work(program_of_agent, call)
        finally:
            await ours.close()

    return asyncio.run(main())


async def driven(call, **how):
    """Drive, once the base is armed again after what was before; on a busy machine a command may come too late, and a
    lease may lapse."""
    for _ in range(100):
        answer = await call("drive", **how)
        if answer["code"] not in AGAIN or SILENT in answer["text"]:
            return answer
        await asyncio.sleep(0.05)
    raise AssertionError(answer)


def test_tools_look_drive_and_are_written_down_by_name(running, home):
    async def work(program_of_agent, call):
        tools = {tool.name: tool for tool in (await program_of_agent.list_tools()).tools}
        assert tools["drive"].input_schema["properties"]["power"]["maximum"] == 0.5
        assert tools["stop"].annotations.idempotent_hint
        assert not tools["stop"].annotations.destructive_hint
        assert tools["status"].annotations.read_only_hint
        prompts = (await program_of_agent.list_prompts()).prompts
        text = (await program_of_agent.get_prompt(prompts[0].name)).messages[0].content.text
        assert "`preview`" in text
        status = await call("status")
        assert status["data"]["ready"]
        assert "ranges/readings" in status["data"]["measured"]
        assert (await driven(call, power=0.15, angle_deg=90, seconds=0.3))["code"] == "done"
        for tool, arguments, code in (
            ("drive", {"power": 0.9, "angle_deg": 0}, "bad_value"),
            ("drive", {"power": 0.1, "angle_deg": 0, "lease": "x"}, "unknown_name"),
            ("publish", {"key": "motors/setpoint"}, "unknown_command"),
            ("say", {"line": "reset"}, "denied"),
        ):
            answer = await call(tool, **arguments)
            assert answer["code"] == code, answer
            assert answer["text"]
        assert (await call("why", part="drive"))["text"]
        assert (await call("stop"))["code"] == "done"
        pressed = await call("estop", reason="a test")
        assert pressed["code"] == "done" or running.status()["estop"]["engaged"], (
            pressed
        )  # it may be acknowledged later
        assert (await call("drive", power=0.1, angle_deg=0))["code"] == "estop"

    with_tools(work)
    source, text = until(lambda: [row for row in audit(home) if "drive(power=0.15" in row[1] and ": done: " in row[1]])[
        0
    ]
    assert source.startswith("lbr/agent a-test@")
    assert text.startswith("a-test asked for drive")


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_a_person_is_asked_before_the_first_motion_and_only_then(mode, running, home):
    answers, questions = ["decline", "accept"], []

    async def elicited(_context, params):
        questions.append(params.message)
        return ElicitResult(action=answers.pop(0), content={})

    async def work(_client, call):
        refused = await call("drive", power=0.15, angle_deg=90, seconds=0.1)
        assert refused["code"] == "denied"
        assert (await driven(call, power=0.15, angle_deg=90, seconds=0.1))["code"] == "done"
        assert (await driven(call, power=0.15, angle_deg=90, seconds=0.1))["code"] == "done"

    with_tools(work, Rules(ask=("first",)), mode=mode, elicitation_callback=elicited)
    assert len(questions) == 2
    assert "a-test" in questions[0]


def test_a_client_that_cannot_ask_a_person_is_refused(running, home):
    async def work(_client, call):
        answer = await call("drive", power=0.15, angle_deg=90)
        assert answer["code"] == "confirm"
        assert "/agent/" in answer["do"]

    with_tools(work, Rules(ask=("first",)))


def test_a_plan_moves_nothing_and_is_good_once_a_person_lets_it(running, home):
    async def elicited(_context, _params):
        return ElicitResult(action="accept", content={})

    async def work(_client, call):
        plan = await call("preview", tool="drive", arguments={"power": 0.15, "angle_deg": 90, "seconds": 0.1})
        assert plan["data"]["line"] == "/r/0.15/90"
        assert "free_cm" in plan["data"]
        assert not turning(running)
        done = await call("do", plan=plan["data"]["plan"])
        assert done["code"] in {"done", *AGAIN}
        assert (await call("do", plan=plan["data"]["plan"]))["code"] == "late"
        over = await call("preview", tool="drive", arguments={"power": 0.9, "angle_deg": 0})
        assert over["code"] == "bad_value"

    with_tools(work, Rules(ask=("first",)), elicitation_callback=elicited)


def test_a_person_stops_an_agent_and_it_is_told_by_whom(running, home):
    async def work(_client, call):
        driving = asyncio.ensure_future(driven(call, **SPIN))
        while not await asyncio.to_thread(turning, running):
            assert not driving.done(), driving.result()
        while not driving.done():  # where it lapsed before, it has been asked for again
            await asyncio.to_thread(person.stop)
        answer = driving.result()
        assert answer["code"] == "stopped"
        assert answer["do"]
        assert "anna@" in answer["text"]

    with client.connect(name="anna") as person:
        with_tools(work)
    until(lambda: wheels(running) == (0.0, 0.0))


def test_an_agent_whose_client_shows_no_sign_of_life_moves_nothing(running, home):
    class Silent(Present):
        patience_s = 1.5

        async def follow(self, beat):
            await asyncio.Event().wait()

    async def work(_client, call):
        driving = asyncio.ensure_future(driven(call, **SPIN))
        while not await asyncio.to_thread(turning, running):
            assert not driving.done(), driving.result()
        answer = await driving
        assert answer["code"] != "done"
        assert SILENT in answer["text"], answer

    with_tools(work, pulse=Silent)
    until(lambda: wheels(running) == (0.0, 0.0))


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_an_agent_that_is_killed_moves_nothing(mode, running, home):
    with agent(running, mode, [*robots.LBR, "mcp"]) as popen:
        until(lambda: turning(running))
        popen.kill()
        until(lambda: wheels(running) == (0.0, 0.0))
    reason = until(lambda: (running.ask("drive/state") or {}).get("reason"))
    assert "called it off" in reason or "no sign of life" in reason or "not renewed" in reason, reason
