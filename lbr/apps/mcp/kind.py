"""The kind `mcp`: the rules for agents, and the address of their server."""

from typing import Annotated

from msgspec import Meta

from lbr.apps.mcp.messages import NEVER, WORDS, AllowAgent, Asked, McpState, Rules
from lbr.apps.web.server_settings import ServerSettings
from lbr.bus.door import LanUser
from lbr.capability.kind import Command, Kind, Needs, Rights, Rows
from lbr.capability.word import Word


class McpSettings(ServerSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `mcp`.

    `words` to `fast_power` are for every agent, also of `lbr mcp`. `ask`: a person is asked before an agent's first
    motion, a motion of a humanoid, or more than `fast_power`. Where other machines reach it, agents need a token, and
    TLS unless `clear_text`.
    """

    words: Annotated[tuple[str, ...], Meta(description="console words that agents may say, besides stops")] = WORDS
    most_power: Annotated[float, Meta(gt=0.0, le=1.0, description="the most power that an agent may drive with")] = 0.5
    ask: Annotated[tuple[Asked, ...], Meta(description="what a person is asked before")] = ("first", "play", "fast")
    fast_power: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.3
    port: Annotated[int, Meta(ge=0, le=65535, description="0: any free one")] = 50010

    def __post_init__(self) -> None:
        """Refuse words for people alone, and settings that contradict each other."""
        if never := sorted(NEVER.intersection(self.words)):
            raise ValueError(f"words: '{never[0]}' is for people alone")
        super().__post_init__()

    @property
    def rules(self) -> Rules:
        """Return the rules for every agent."""
        return Rules(words=self.words, most_power=self.most_power, ask=self.ask, fast_power=self.fast_power)


KIND = Kind(
    name="mcp",
    summary="serves the robot to language agents by HTTP, and has the rules for all of them",
    family="app",
    rights=Rights(serves=True, lets_in=("enabled", "host", "tls", "clear_text", "names")),
    entry="lbr.apps.mcp.capability:Mcp",
    settings=McpSettings,
    outputs={"state": McpState},
    commands={"allow": Command(AllowAgent)},
    rows=(Rows(LanUser, followed=True),),
    needs=Needs("mcp", extra="mcp"),
    words=(Word("/agent/{agent}", "allow", "Let an agent do what it must ask a person for, by its name"),),
)
