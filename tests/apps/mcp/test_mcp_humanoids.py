"""Humanoids by the official client at `lbr mcp`: motions by a person's leave, behaviours, words, pictures."""

import asyncio
from base64 import b64decode
from io import BytesIO

import pytest
from PIL import Image

from tests.apps.mcp.conftest import row
from tests.support import needs
from tests.support import robot as robots

needs.modules("mcp")
from mcp import Client, StdioServerParameters  # noqa: E402 - an extra
from mcp.client.stdio import stdio_client  # noqa: E402
from mcp_types import ElicitResult  # noqa: E402

from lbr.apps.mcp.agent import LARGEST_SIDE  # noqa: E402

pytestmark = pytest.mark.slow_start
MOTIONS = {"bioloid": "wave", "uxa90": "basic_motion"}


@pytest.fixture(params=MOTIONS)
def humanoid(request, tmp_path):
    home = robots.prepare(tmp_path / "h", edits=(row(request.param, "agents"),))
    with robots.running(home, profile=f"{request.param}-sim") as robot:
        assert robot.line("/torque/on")["code"] == 0
        yield robot


def test_an_agent_plays_what_a_person_lets_it_play(humanoid):
    answers, questions, motion = ["decline", "accept"], [], MOTIONS[humanoid.name]

    async def elicited(_context, params):
        questions.append(params.message)
        return ElicitResult(action=answers.pop(0), content={})

    async def main():
        lbr = StdioServerParameters(
            command=robots.LBR[0], args=[*robots.LBR[1:], "mcp"], env=robots.environment(humanoid.home)
        )
        async with Client(stdio_client(lbr), elicitation_callback=elicited) as agent:

            async def call(tool, /, **arguments):
                return (await agent.call_tool(tool, arguments)).structured_content

            tools = {tool.name: tool for tool in (await agent.list_tools()).tools}
            assert motion in tools["play"].input_schema["properties"]["motion"]["enum"]
            assert "drive" not in tools
            planned = (await call("preview", tool="play", arguments={"motion": motion}))["data"]
            assert planned["a_person_is_asked"]
            assert (await call("do", plan=planned["plan"]))["code"] == "denied"
            assert (await call("do", plan=planned["plan"]))["code"] == "done"
            assert (await call("do", plan=planned["plan"]))["code"] == "late"
            assert (await call("say", line=f"/play/{motion}"))["code"] == "denied"
            assert (await call("say", line="help"))["code"] == "done"
            ended = await call("behaviour_run", name="greet", seconds=0.5)
            assert "its time is over" in ended["text"]
            joints = (await call("status"))["data"]["measured"]["joints/state"]
            assert set(map(type, joints["joints"].values())) == {float}
            if "look" in tools:
                picture = (await agent.call_tool("look", {})).content[1]
                with Image.open(BytesIO(b64decode(picture.data))) as taken:
                    assert max(taken.size) <= LARGEST_SIDE

    asyncio.run(main())
    assert len(questions) == 2
    assert f"/play/{motion}" in questions[0]
