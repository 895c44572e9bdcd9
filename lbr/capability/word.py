"""Words that a kind brings to the console of each robot that has a capability of it."""

from dataclasses import dataclass, field
from typing import Any

from lbr.messages.system import Role


@dataclass(frozen=True, slots=True)
class Word:
    """A line, `/r/{power}/{angle_deg}` or a bare word, and the command of its capability that it asks for, or of the
    executive itself.

    `fixed` are fields of the message that the pattern does not bind, `role` the least that may say it, unless the
    command needs more. A robot's own row of the same pattern takes its place.
    """

    pattern: str
    command: str
    help: str
    fixed: dict[str, Any] = field(default_factory=dict)
    role: Role = "view"
    executive: bool = False
