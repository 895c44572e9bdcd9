"""The robot for language agents, by the Model Context Protocol: few tools with bounds, a lease in the agent's own name.

`tools` and `bounds` are what agents may ask for, `messages` what a row allows; these are pure. `motion` keeps what moves
only while the agent's client lives, `agent` does what tools do, `server` speaks the protocol by the official SDK, and
`stdio` and `capability` are the ways there; `pulses` shows that a client over HTTP lives.
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
