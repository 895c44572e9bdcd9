"""An agent: the official client of MCP, which calls one tool of `lbr mcp` and says on its output how far it is.

    agent.py MODE TOOL ARGUMENTS COMMAND ...      by a pipe to a program
    agent.py MODE TOOL ARGUMENTS http://…/mcp     by HTTP

It prints `calls` before the call, and what the tool answered after it. A line on its input cancels the call.
"""

import asyncio
import json
import os
import sys

from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp_types import Implementation

AGAIN = frozenset({"not_armed", "stale_sensor", "held", "busy", "stopped", "lapsed", "dead_lease"})


async def main(mode: str, tool: str, arguments: str, *command: str) -> None:
    where = command[0]
    if not where.startswith("http"):
        where = stdio_client(StdioServerParameters(command=where, args=list(command[1:]), env=dict(os.environ)))
    async with Client(where, mode=mode, client_info=Implementation(name="test agent", version="1")) as client:
        print("calls", flush=True)
        call = asyncio.ensure_future(done(client, tool, json.loads(arguments)))
        asyncio.get_running_loop().add_reader(sys.stdin, cancel, call)
        await asyncio.wait([call])
        print("cancelled" if call.cancelled() else json.dumps(call.result()), flush=True)
        await asyncio.Event().wait()  # until it is killed


def cancel(call: "asyncio.Future[object]") -> None:
    """Cancel a call once: more would interrupt how it is called off."""
    asyncio.get_running_loop().remove_reader(sys.stdin)
    call.cancel()


async def done(client: Client, tool: str, arguments: dict[str, object]) -> object:
    """Call a tool, again while the robot is not ready for it, or the machine held this program up."""
    while True:
        answer = (await client.call_tool(tool, arguments)).structured_content
        if answer["code"] not in AGAIN:
            return answer


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
