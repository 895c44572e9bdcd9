"""Words that a kind adds to the console of each robot with a capability of it."""

from dataclasses import dataclass, field

from lbr.messages.system import Role


@dataclass(frozen=True, slots=True)
class Word:
    """A line, `/r/{power}/{angle_deg}` or a bare word, and the command that it sends to its capability, or to the
    executive.

    `fixed` are fields of the message that the pattern does not bind. `role` is the least role of its sender, unless the
    command needs a higher one. A robot's own row with the same pattern replaces it.
    """

    pattern: str
    command: str
    help: str
    fixed: dict[str, object] = field(default_factory=dict)
    role: Role = "view"
    executive: bool = False
