"""The streams and commands of the robot, from its own description; immutable, so that every thread may read it."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from msgspec import Struct

from lbr.capability.kind import STOP
from lbr.messages.description import (
    BaseDescription,
    CapabilityDescription,
    CommandDescription,
    RobotDescription,
    Schema,
)
from lbr.messages.faces import Button
from lbr.messages.joints import Joint, Motion
from lbr.messages.system import CapabilityPhase, CapabilityStatus, Role

STATUS, EVENT = "@status", "@event"
WATCHED = frozenset({STATUS, EVENT})
CAMERA = "camera"
CAMERA_PREFIX = "camera_"


class Catalog:
    """A robot's streams and commands by their keys below its name, such as `drive/state`."""

    def __init__(self, robot: RobotDescription) -> None:
        self.robot = robot
        capabilities = robot.capabilities
        streams = {f"{one.name}/{name}": schema for one in capabilities for name, schema in one.outputs.items()}
        self.streams: dict[str, Schema] = {key: schema for key, schema in streams.items() if not _is_picture(schema)}
        self.commands: dict[str, CommandDescription] = {
            f"{one.name}/{name}": command for one in capabilities for name, command in one.commands.items()
        }

    def published(self, keys: Iterable[str]) -> tuple[str, ...]:
        """Return the keys that clients may receive, each once: streams, and never commands. Commands contain the leases
        of their senders, and pictures are for known clients."""
        return tuple(dict.fromkeys(key for key in keys if key in self.streams or key in WATCHED))

    @property
    def lenders(self) -> frozenset[str]:
        """Return the capabilities with a motion to hold and a stop."""
        lend = {name.partition("/")[0] for name, command in self.commands.items() if command.leased}
        return frozenset(one for one in lend if f"{one}/{STOP}" in self.commands)

    def described(
        self,
        *,
        role: Role | None,
        version: str,
        phases: Iterable[CapabilityStatus],
        joints: tuple[Joint, ...],
        motions: Iterable[Motion],
        buttons: tuple[Button, ...],
    ) -> "Described":
        """Return the description of the robot for a role."""
        robot, statuses = self.robot, {status.name: status for status in phases}
        return Described(
            robot=robot.robot,
            simulated=robot.simulated,
            version=version,
            revision=robot.revision,
            role=role,
            capabilities=tuple(_capability(part, statuses.get(part.name)) for part in robot.capabilities),
            words=tuple(_word(word) for word in robot.words),
            joints=joints,
            motions=tuple(_motion(motion) for motion in motions),
            cameras=tuple(
                DescribedCamera(name=part.name.removeprefix(CAMERA_PREFIX), capability=part.name)
                for part in robot.capabilities
                if part.kind == CAMERA
            ),
            wheels=robot.wheels,
            ranges=robot.ranges,
            buttons=buttons,
            phrases=robot.phrases,
            base=robot.base,
        )


class DescribedCapability(Struct, frozen=True, kw_only=True):
    """A running capability, and its phase."""

    name: str
    kind: str
    family: str
    summary: str
    phase: CapabilityPhase
    reason: str
    outputs: dict[str, Schema]
    commands: dict[str, CommandDescription]


class DescribedWord(Struct, frozen=True, kw_only=True):
    """A word of the console; `fields` are the blanks in its `usage`."""

    word: str
    help: str
    role: str
    usage: str
    fields: Sequence[Any]


class DescribedMotion(Struct, frozen=True, kw_only=True):
    """A motion without its key frames, which may be thousands; `frames` counts them."""

    name: str
    help: str
    lead_in: str
    lead_out: str
    slot: int | None
    builtin: bool
    frames: int
    duration_s: float


class DescribedCamera(Struct, frozen=True, kw_only=True):
    """A camera by its short name."""

    name: str
    capability: str


class Described(Struct, frozen=True, kw_only=True):
    """The description of the robot, and your rights."""

    robot: str
    simulated: bool
    version: str
    revision: int
    role: Role | None
    capabilities: tuple[DescribedCapability, ...]
    words: tuple[DescribedWord, ...]
    joints: tuple[Joint, ...]
    motions: tuple[DescribedMotion, ...]
    cameras: tuple[DescribedCamera, ...]
    wheels: tuple[dict[str, Any], ...]
    ranges: tuple[dict[str, Any], ...]
    buttons: tuple[Button, ...]
    phrases: tuple[dict[str, Any], ...]
    base: BaseDescription | None


def _is_picture(schema: Schema) -> bool:
    return "contentMediaType" in schema


def _capability(part: CapabilityDescription, status: CapabilityStatus | None) -> DescribedCapability:
    return DescribedCapability(
        name=part.name,
        kind=part.kind,
        family=part.family,
        summary=part.summary,
        phase=status.phase if status is not None else "waiting",
        reason=status.reason if status is not None else "",
        outputs=part.outputs,
        commands=part.commands,
    )


def _word(word: Mapping[str, Any]) -> DescribedWord:
    return DescribedWord(
        word=word["word"],
        help=word.get("help", ""),
        role=word.get("role", "operate"),
        usage=word.get("pattern", word["word"]),
        fields=word.get("fields", ()),
    )


def _motion(motion: Motion) -> DescribedMotion:
    lasts_s = motion.slot_s if motion.slot_s is not None else sum(frame.duration_s for frame in motion.frames)
    return DescribedMotion(
        name=motion.name,
        help=motion.help,
        lead_in=motion.lead_in,
        lead_out=motion.lead_out,
        slot=motion.slot,
        builtin=motion.builtin,
        frames=len(motion.frames),
        duration_s=round(lasts_s, 3),
    )
