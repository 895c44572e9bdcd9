"""An agent: the official client of MCP, which calls one tool of `lbr mcp` and says on its output how far it is.

    agent.py MODE TOOL ARGUMENTS [COMMAND ...]

It prints `calls` before the call, and what the tool answered after it.
"""

import asyncio
import json
import os
import sys

from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp_types import Implementation


async def main(mode: str, tool: str, arguments: str, *command: str) -> None:
    server = StdioServerParameters(command=command[0], args=list(command[1:]), env=dict(os.environ))
    async with Client(
        stdio_client(server), mode=mode, client_info=Implementation(name="test agent", version="1")
    ) as client:
        print("calls", flush=True)
        result = await client.call_tool(tool, json.loads(arguments))
        print(json.dumps(result.structured_content), flush=True)


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
