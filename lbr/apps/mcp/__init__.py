"""The robot for language agents, by the Model Context Protocol: few tools with bounds, a lease in the agent's own name.

`tools` and `bounds` define what agents may request, `messages` a row's rules; these are pure. `motion` moves only while
the agent's client lives, and `agent` runs the tools. `server` implements the protocol with the official SDK. `stdio`
and `capability` connect agents to it; `pulses` observes clients over HTTP.
"""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"mcp": "lbr.apps.mcp.kind:KIND"},
    commands={
        "mcp": CliCommand(
            "lbr.apps.mcp.commands.mcp:command",
            "Let a language agent look and drive, by the Model Context Protocol.",
            "drive",
        )
    },
    messages=("lbr.apps.mcp.messages",),
    needs=("web",),
)
