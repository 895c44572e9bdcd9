"""A check of your own: during quiet hours nobody may drive fast. Copy it to `$LBR_HOME/capabilities/`.

The drive shows it every new or changed motion before it accepts it; a check that refuses or does not answer means no.
"""

from datetime import datetime
from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability import Call, Capability, Kind
from lbr.messages.drive import CheckRequest, CheckVerdict

Hour = Annotated[int, Meta(ge=0, le=23)]


class QuietSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """From which hour to which, by the robot's clock, and how fast is still allowed."""

    begin: Hour = 22
    end: Hour = 7
    max_power: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.2


class QuietHours(Capability[QuietSettings]):
    """Answers the drive's question about one motion."""

    def command(self, call: Call) -> None:
        """Say whether this motion may be."""
        asked: CheckRequest = call.message
        quiet, limit = self._quiet_now(), self.ctx.settings.max_power
        if quiet and asked.command.power > limit:
            reason = f"quiet hours until {self.ctx.settings.end}:00, power is at most {limit:g}"
            call.reply(CheckVerdict(accepted=False, reason=reason))
        else:
            call.reply(CheckVerdict(accepted=True))

    def _quiet_now(self) -> bool:
        begin, end = self.ctx.settings.begin, self.ctx.settings.end
        hour = datetime.now().astimezone().hour
        return begin <= hour < end if begin <= end else hour >= begin or hour < end


KIND = Kind(
    name="quiet_hours",
    summary="refuses fast driving during quiet hours",
    family="app",
    entry=QuietHours,
    settings=QuietSettings,
    commands={"check": CheckRequest},
    replies={"check": CheckVerdict},
)
