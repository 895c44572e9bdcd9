"""What a row allows to agents. Pure."""

from typing import Annotated

from msgspec import Meta, Struct

NEVER = frozenset(
    {"Shutdown", "close", "disable", "enable", "open", "p", "pair", "phone", "reset", "restart", "torque", "record"}
)
"""Words for people alone: no row allows them to agents."""
WORDS = ("a", "camera", "help", "look", "mark", "report", "s", "snapshot", "watch")


class Rules(Struct, frozen=True, kw_only=True):
    """What agents may do: the words that they may say, and the most power that they may drive with."""

    words: Annotated[
        tuple[str, ...], Meta(description="console words that agents may say, besides stops and their own tools")
    ] = WORDS
    most_power: Annotated[float, Meta(gt=0.0, le=1.0, description="the most power that an agent may drive with")] = 0.5
