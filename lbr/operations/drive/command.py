"""The content of a command: drive, move by a twist, turn by an angle or turn to a heading."""

from math import atan2, degrees, fmod

from lbr.messages.drive import CheckRequest, DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.kinematics import Base
from lbr.operations.drive.mixing import mix
from lbr.operations.drive.settings import DriveSettings

Motion = DriveCommand | TurnCommand | HeadingCommand | TwistCommand
Sides = tuple[float, float, float]
"""Power of the left and of the right side, and to the left, as fractions of full speed."""
RIGHT_DEG = 90.0


def moves(command: Motion) -> bool:
    """Return whether a command is more than a stop; a turn always is, and so are numbers that are not finite."""
    if isinstance(command, TwistCommand):
        return not command.vx_mps == command.vy_mps == command.wz_rps == 0.0
    return not (isinstance(command, DriveCommand) and command.power == 0.0)


def content_of(command: Motion) -> tuple[float | str, ...]:
    """Return the content of a command, without its sender, its lease and its duration."""
    if isinstance(command, TurnCommand):
        return ("turn", command.angle_deg)
    if isinstance(command, HeadingCommand):
        return ("heading", command.heading_deg)
    if isinstance(command, TwistCommand):
        return ("twist", command.vx_mps, command.vy_mps, command.wz_rps)
    return (
        command.power,
        command.angle_deg,
        command.range_cm,
        command.sensor,
        command.interval_s,
        command.distance_cm,
    )


def power_of(command: Motion, settings: DriveSettings) -> float:
    """Return the greatest power that a command may use."""
    if isinstance(command, TwistCommand):
        return min(max(map(abs, asked_sides(command, settings))), settings.max_power)
    asked = command.power if isinstance(command, DriveCommand) else settings.turn_power
    return min(asked, settings.max_power)


def asked_sides(command: TwistCommand, settings: DriveSettings) -> Sides:
    """Return a twist as powers of the two sides and sideways, without any limit."""
    ahead, turn = command.vx_mps, command.wz_rps * settings.track_m / 2
    full_mps = settings.max_speed_mps
    return (ahead - turn) / full_mps, (ahead + turn) / full_mps, command.vy_mps / full_mps


def fitting_sides(command: TwistCommand, settings: DriveSettings, base: Base) -> Sides:
    """Return a twist as powers, reduced together until each motor is within its limit; NaN gives zero."""
    sides = asked_sides(command, settings)
    return times(sides, base.fitting(*sides, settings.max_power))


def sides_of(command: Motion, settings: DriveSettings, base: Base) -> Sides:
    """Return a command as powers at its full speed."""
    if isinstance(command, TwistCommand):
        return fitting_sides(command, settings, base)
    return (*mix(power_of(command, settings), towards_deg(command), settings), 0.0)


def times(sides: Sides, factor: float) -> Sides:
    """Return all powers times a factor, so that the path keeps its form; a factor of 0 or NaN gives zero."""
    if not factor > 0.0:
        return 0.0, 0.0, 0.0
    left, right, aside = sides
    return left * factor, right * factor, aside * factor


def towards_deg(command: Motion) -> float:
    """Return the angle of the motion; for a turn that of a spin, to the left if that is requested."""
    if isinstance(command, DriveCommand):
        return command.angle_deg
    if isinstance(command, TwistCommand):
        if command.vx_mps == command.vy_mps == 0.0:
            return -RIGHT_DEG if command.wz_rps > 0.0 else RIGHT_DEG
        return degrees(atan2(-command.vy_mps, command.vx_mps))
    return -RIGHT_DEG if isinstance(command, TurnCommand) and command.angle_deg < 0.0 else RIGHT_DEG


def straight(command: DriveCommand) -> bool:
    """Return whether a command drives straight ahead or straight back."""
    return fmod(command.angle_deg, 180.0) == 0.0


def check_request(source: str, command: Motion, settings: DriveSettings) -> CheckRequest:
    """Return the request to the user's checks: a turn appears as its spin, and as the original command."""
    if isinstance(command, DriveCommand):
        return CheckRequest(source=source, command=command)
    spin = DriveCommand(
        power=power_of(command, settings),
        angle_deg=towards_deg(command),
        lease=command.lease,
        ttl_s=command.ttl_s,
        take_over=command.take_over,
    )
    if isinstance(command, TwistCommand):
        return CheckRequest(source=source, command=spin, twist=command)
    if isinstance(command, TurnCommand):
        return CheckRequest(source=source, command=spin, turn=command)
    return CheckRequest(source=source, command=spin, heading=command)
