"""What a field of a line may be on this robot, for completion: what its rows and files name."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from lbr.executive import reports
from lbr.executive.plan import Plan
from lbr.messages.camera import SelectCommand
from lbr.messages.dance import DanceCommand
from lbr.messages.joints import CaptureCommand, JointMove, PlayCommand, RecoverCommand, TorqueCommand
from lbr.messages.speech import SayCommand

CLICKS = "metronome"
OFF = "off"
CAMERA = "camera_"


def choices(plan: Plan, home: Path) -> dict[str, Iterable[str]]:
    """Return the known values by `capability.command` for its first field, or with `.field` at its end for that one."""
    found: dict[str, Iterable[str]] = {"executive.report": reports.NAMES, "executive.restart": tuple(plan.units)}
    return found | dict(_of_commands(plan, home))


def _of_commands(plan: Plan, home: Path) -> Iterator[tuple[str, Iterable[str]]]:
    rows = plan.rows
    for name, kind in plan.kinds.items():
        for command, message in kind.commands.items():
            target = f"{name}.{command}"
            if message is SayCommand:
                yield f"{target}.phrase", {row.name for row in rows.phrases}
            elif message is DanceCommand:
                yield f"{target}.song", {CLICKS, *(path.stem for path in (home / "music").glob("*.json"))}
                yield f"{target}.dance", {row.dance for row in rows.choreographies}
            elif message is SelectCommand:
                wired = {channel.target_end[0] for channel in rows.channels if channel.source_end[0] == name}
                yield f"{target}.name", {OFF, *(one.removeprefix(CAMERA) for one in wired if one.startswith(CAMERA))}
            elif message is JointMove:
                yield f"{target}.joint", {row.name for row in rows.joints}
            elif message in {TorqueCommand, RecoverCommand}:
                yield f"{target}.joints", {row.name for row in rows.joints}
            elif message in {PlayCommand, CaptureCommand}:
                yield f"{target}.motion", {row.name for row in rows.motions}
            elif "device" in getattr(message, "__struct_fields__", ()):
                yield f"{target}.device", {device.name for device in rows.devices}
