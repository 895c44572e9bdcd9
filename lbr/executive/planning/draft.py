"""A robot's rows on their way to a plan: what its checks look at. Pure."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.capability.program import ProgramSettings
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow, RobotRows
from lbr.executive.planning.profile import Profile

ANY = Struct
"""The type of a program's port, which only the program knows."""


class Draft(Struct, frozen=True, kw_only=True):
    """The rows of a robot and its profile, with the kinds and settings of its capabilities, as far as they are good.

    `chosen` are the capabilities that would run.
    """

    rows: RobotRows
    profile: Profile
    kinds: dict[str, Kind]
    settings: dict[str, Struct]
    chosen: tuple[CapabilityRow, ...]

    @property
    def robot(self) -> str:
        """Return the name of the robot."""
        return self.rows.robot.name

    def problem(self, capability: str, column: str, text: str) -> Problem:
        """Return a problem of a capability's row."""
        return Problem("capability", f"{self.robot}/{capability}", column, text)

    def ports(self, name: str, *which: str) -> dict[str, type[Struct]]:
        """Return the ports of some groups of a capability, such as `inputs`; those of a program are in its settings."""
        own = self.settings.get(name)
        if isinstance(own, ProgramSettings):
            return {port: ANY for group in which for port in getattr(own, group, ())}
        groups = ("messages" if group == "commands" else group for group in which)
        return {port: message for group in groups for port, message in getattr(self.kinds[name], group).items()}
