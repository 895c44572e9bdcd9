"""What a command asks for, whether it drives, turns by an angle or turns to a heading."""

from math import fmod

from lbr.messages.drive import CheckRequest, DriveCommand, HeadingCommand, TurnCommand
from lbr.operations.drive.settings import DriveSettings

Motion = DriveCommand | TurnCommand | HeadingCommand
RIGHT_DEG = 90.0


def moves(command: Motion) -> bool:
    """Say whether a command wants anything but standing still; a turn always does, and so does nonsense."""
    return not (isinstance(command, DriveCommand) and command.power == 0.0)


def what(command: Motion) -> tuple[float | str, ...]:
    """Return what a command asks for, whoever asks, under whichever lease and for how long."""
    if isinstance(command, TurnCommand):
        return ("turn", command.angle_deg)
    if isinstance(command, HeadingCommand):
        return ("heading", command.heading_deg)
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
    asked = command.power if isinstance(command, DriveCommand) else settings.turn_power
    return min(asked, settings.max_power)


def towards_deg(command: Motion) -> float:
    """Return the angle of the motion; for a turn that of a spin, to the left if that is what it asks for."""
    if isinstance(command, DriveCommand):
        return command.angle_deg
    return -RIGHT_DEG if isinstance(command, TurnCommand) and command.angle_deg < 0.0 else RIGHT_DEG


def straight(command: DriveCommand) -> bool:
    """Say whether a command drives straight ahead or straight back."""
    return fmod(command.angle_deg, 180.0) == 0.0


def shown(source: str, command: Motion, settings: DriveSettings) -> CheckRequest:
    """Return what the user's checks are shown: a turn as the spin that it is, and as what was asked."""
    if isinstance(command, DriveCommand):
        return CheckRequest(source=source, command=command)
    spin = DriveCommand(
        power=power_of(command, settings),
        angle_deg=towards_deg(command),
        lease=command.lease,
        ttl_s=command.ttl_s,
        take_over=command.take_over,
    )
    if isinstance(command, TurnCommand):
        return CheckRequest(source=source, command=spin, turn=command)
    return CheckRequest(source=source, command=spin, heading=command)
