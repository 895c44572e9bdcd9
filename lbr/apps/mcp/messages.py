"""Messages on `mcp/*`: a row's rules for agents, the agents with consent, and the server's addresses."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

NEVER = frozenset(
    (
        "Shutdown",
        "agent",
        "close",
        "disable",
        "enable",
        "open",
        "p",
        "pair",
        "phone",
        "record",
        "reset",
        "restart",
        "torque",
    )
)
"""Words for people alone, which no row can allow to agents."""
WORDS = ("a", "camera", "help", "look", "mark", "report", "s", "snapshot", "watch")
Asked = Literal["first", "play", "fast"]
AgentName = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_.-]{1,30}$(?!\n)")]


class Rules(Struct, frozen=True, kw_only=True):
    """The rules for agents. `ask`: what needs a person's consent: an agent's first motion (`first`), a humanoid's
    (`play`), more than `fast_power` (`fast`).
    """

    words: tuple[str, ...] = WORDS
    most_power: float = 0.5
    ask: tuple[Asked, ...] = ()
    fast_power: float = 0.3


class AllowAgent(Struct, frozen=True, kw_only=True):
    """Let an agent do what needs a person's consent, while this row runs."""

    agent: AgentName


class McpState(Struct, frozen=True, kw_only=True):
    """The server's addresses (`urls`), the rules for all agents, and the agents with a person's consent (`allowed`)."""

    listening: bool
    rules: Rules
    urls: tuple[str, ...] = ()
    allowed: tuple[str, ...] = ()
    refused: int = 0
    reason: str = ""
