"""An agent: the official client of MCP, which calls tools of `lbr mcp` and says on its output how far it is.

    agent.py MODE TOOL ARGUMENTS COMMAND ...      by a pipe to a program
    agent.py MODE TOOL ARGUMENTS http://…/mcp     by HTTP; LBR_TOKEN has a token, LBR_CA the file of the certificate

It prints `calls` before a call, and what the tool answered after it. A line on its input cancels the call that goes on;
once that has ended, a line is the next call, such as `stop {}`.
"""

import asyncio
import json
import os
import ssl
import sys

import httpx2
from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp.client.streamable_http import streamable_http_client
from mcp_types import Implementation

AGAIN = frozenset({"not_armed", "no_setpoint", "stale_sensor", "held", "busy", "stopped", "lapsed", "dead_lease"})


async def main(mode: str, tool: str, arguments: str, *command: str) -> None:
    where, lines = reached(*command), lines_of_input()
    async with Client(where, mode=mode, client_info=Implementation(name="test agent", version="1")) as client:
        print("calls", flush=True)
        await told(asyncio.ensure_future(done(client, tool, json.loads(arguments))), lines)
        while True:
            tool, _, arguments = (await lines.get()).partition(" ")
            if not arguments:  # to cancel a call that has ended
                continue
            print("calls", flush=True)
            await told(asyncio.ensure_future(called(client, tool, json.loads(arguments))), lines)


def reached(*command: str) -> object:
    """Return the server as the official client takes it."""
    if not command[0].startswith("http"):
        return stdio_client(StdioServerParameters(command=command[0], args=list(command[1:]), env=dict(os.environ)))
    if "LBR_TOKEN" not in os.environ:
        return command[0]
    robots_own = ssl.create_default_context(cafile=os.environ["LBR_CA"])
    robots_own.check_hostname = False  # it is for robot.lbr, and no other certificate is trusted
    headers = {"Authorization": f"Bearer {os.environ['LBR_TOKEN']}"}
    return streamable_http_client(
        command[0], http_client=httpx2.AsyncClient(headers=headers, verify=robots_own, timeout=30.0)
    )


def lines_of_input() -> "asyncio.Queue[str]":
    """Return what comes on the input, line by line."""
    lines: asyncio.Queue[str] = asyncio.Queue()

    def hear() -> None:
        if line := sys.stdin.readline():
            lines.put_nowait(line.strip())
        else:
            asyncio.get_running_loop().remove_reader(sys.stdin)

    asyncio.get_running_loop().add_reader(sys.stdin, hear)
    return lines


async def told(call: "asyncio.Future[object]", lines: "asyncio.Queue[str]") -> None:
    """See a call to its end, cancel it once if a line comes, and say what became of it."""
    hearing = asyncio.ensure_future(lines.get())
    await asyncio.wait([call, hearing], return_when=asyncio.FIRST_COMPLETED)
    if not hearing.cancel() and not call.done():
        call.cancel()
        await asyncio.wait([call])
    print("cancelled" if call.cancelled() else json.dumps(call.result()), flush=True)


async def done(client: Client, tool: str, arguments: dict[str, object]) -> object:
    """Call a tool, again while the robot is not ready for it, or the machine held this program up."""
    while True:
        answer = await called(client, tool, arguments)
        if answer["code"] not in AGAIN:
            return answer


async def called(client: Client, tool: str, arguments: dict[str, object]) -> dict[str, object]:
    """Call a tool."""
    return (await client.call_tool(tool, arguments)).structured_content


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
