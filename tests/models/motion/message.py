"""What senders and sensors of a simulated world say, and the same as the kernel hears it."""

from math import cos, inf, isfinite, isnan, nan, radians, sin

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.drive import CheckVerdict, DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.sensing import Ranges, RangeStatus
from lbr.operations.drive.state import Command
from tests.models.motion.senses import FULL_MPS

What = tuple[float | None, ...]
TRACK_M = 0.27
"""As far apart as the drive takes the wheels to be."""


class Message(Struct, frozen=True):
    """A motion command on its way, a turn if it has `turn_deg` or `heading_deg`: `sent` is the truth; `ahead_s` is how much its sender's clock is ahead (NaN: none).

    A `twist` says its power and angle in SI units.
    """

    source: str
    power: float
    angle_deg: float = 0.0
    lease: str = ""
    range_cm: float = 0.0
    interval_s: float = 0.0
    ttl_s: float | None = None
    take_over: bool = False
    remote: bool = False
    answerable: bool = True
    sent: float = 0.0
    ahead_s: float = nan
    check: bool | None = None
    turn_deg: float | None = None
    heading_deg: float | None = None
    distance_cm: float = 0.0
    twist: bool = False

    @property
    def what(self) -> What:
        """What it asks for."""
        if self.turns:
            return (self.turn_deg, self.heading_deg)
        kind = float(self.twist and self.moves)
        return (kind, self.power, self.angle_deg, self.range_cm, self.interval_s, self.distance_cm)

    @property
    def turns(self) -> bool:
        """Whether it asks for a turn."""
        return self.turn_deg is not None or self.heading_deg is not None

    @property
    def moves(self) -> bool:
        """Whether it asks for anything but standing still."""
        return self.power > 0.0 or self.turns

    @property
    def towards_deg(self) -> float:
        """The angle of the motion; a turn spins."""
        return 90.0 if self.turns else self.angle_deg

    def by(self, source: str) -> "Message":
        """Return the same motion, said by another."""
        return self if self.source == source else replace(self, source=source)


def command_event(message: Message, name: str, now: float) -> Command:
    """Return what the kernel gets when a message arrives; `name` is for what it may begin."""
    dated = not (message.remote or isnan(message.ahead_s))
    verdict = {} if message.check is None else {"mine": CheckVerdict(accepted=message.check)}
    return Command(
        command=_command(message),
        source=message.source,
        new_lease=name,
        new_goal=f"G{name}",
        received=min(now, message.sent) if dated else now,
        remote=message.remote,
        sender_s=message.sent + message.ahead_s,
        answerable=message.answerable,
        checks=verdict,
    )


def _command(message: Message) -> DriveCommand | TurnCommand | HeadingCommand | TwistCommand:
    lease, ttl_s, take_over = message.lease, message.ttl_s, message.take_over
    if message.turn_deg is not None:
        return TurnCommand(angle_deg=message.turn_deg, lease=lease, ttl_s=ttl_s, take_over=take_over)
    if message.heading_deg is not None:
        return HeadingCommand(heading_deg=message.heading_deg, lease=lease, ttl_s=ttl_s, take_over=take_over)
    if message.twist:
        vx_mps, wz_rps = _twist(message.power, radians(message.angle_deg))
        return TwistCommand(vx_mps=vx_mps, wz_rps=wz_rps, lease=lease, ttl_s=ttl_s, take_over=take_over)
    return DriveCommand(
        power=message.power,
        angle_deg=message.angle_deg,
        lease=lease,
        range_cm=message.range_cm,
        interval_s=message.interval_s,
        distance_cm=message.distance_cm,
        ttl_s=ttl_s,
        take_over=take_over,
    )


def _twist(power: float, angle: float) -> tuple[float, float]:
    """Return metres a second ahead and radians a second anticlockwise of an arc whose faster wheel has this power."""
    speed_mps = power * FULL_MPS / max(1.0, abs(cos(angle)) + abs(sin(angle)))
    return cos(angle) * speed_mps, -2.0 * sin(angle) * speed_mps / TRACK_M


def to_ranges(distances: dict[str, float]) -> Ranges:
    """Return distances as a range sensor tells them: infinite is nothing near, NaN is no reading."""
    status: dict[str, RangeStatus] = {side: _status(value) for side, value in distances.items()}
    known = {f"{side}_m": value if isfinite(value) else None for side, value in distances.items()}
    return Ranges(**known, bottom_m=None, status={**status, "bottom": "over_range"})


def _status(value: float) -> RangeStatus:
    return "ok" if isfinite(value) else "over_range" if value == inf else "missing"
