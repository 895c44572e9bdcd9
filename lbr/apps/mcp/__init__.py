"""The robot for language agents, by the Model Context Protocol: few tools with bounds, a lease in the agent's own name.

`tools` and `bounds` are what agents may ask for, `rules` what a row allows; these are pure. `motion` keeps what moves
only while the agent's client lives, `agent` does what tools do, `server` speaks the protocol by the official SDK, and
`stdio` is the way there.
"""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    commands={
        "mcp": CliCommand(
            entry="lbr.apps.mcp.commands.mcp:command",
            help="Let a language agent look and drive, by the Model Context Protocol.",
            group="drive",
        )
    },
)
