"""The streams and commands of the robot, by its own description; immutable, so that every thread may read it."""

from collections.abc import Iterable, Mapping
from typing import Any

from lbr.capability.kind import STOP
from lbr.messages.description import CommandDescription, RobotDescription, Schema
from lbr.messages.joints import Joint, Motion
from lbr.messages.system import CapabilityStatus, Role

STATUS, EVENT = "@status", "@event"
WATCHED = frozenset({STATUS, EVENT})
CAMERA = "camera"
CAMERA_PREFIX = "camera_"


class Catalog:
    """A robot's streams and commands, by their keys below its name, such as `drive/state`."""

    def __init__(self, told: RobotDescription) -> None:
        self.told = told
        capabilities = told.capabilities
        streams = {f"{one.name}/{name}": schema for one in capabilities for name, schema in one.outputs.items()}
        self.streams: dict[str, Schema] = {key: schema for key, schema in streams.items() if not _is_picture(schema)}
        self.commands: dict[str, CommandDescription] = {
            f"{one.name}/{name}": command for one in capabilities for name, command in one.commands.items()
        }

    def heard(self, keys: Iterable[str]) -> tuple[str, ...]:
        """Return those of the keys that may be heard, each once: what is said, and never what another is told.

        Commands hold the leases of their senders, and pictures are for known clients.
        """
        return tuple(dict.fromkeys(key for key in keys if key in self.streams or key in WATCHED))

    @property
    def lenders(self) -> frozenset[str]:
        """Return the capabilities whose motion can be held, and which take a stop."""
        lend = {name.partition("/")[0] for name, command in self.commands.items() if command.leased}
        return frozenset(one for one in lend if f"{one}/{STOP}" in self.commands)

    def document(
        self,
        *,
        role: Role | None,
        version: str,
        phases: Iterable[CapabilityStatus],
        joints: Iterable[Joint],
        motions: Iterable[Motion],
        buttons: Iterable[object],
    ) -> dict[str, Any]:
        """Return what `GET /api` answers to one who has a role."""
        told, known = self.told, {one.name: one for one in phases}
        return {
            "robot": told.robot,
            "simulated": told.simulated,
            "version": version,
            "revision": told.revision,
            "role": role,
            "capabilities": [
                {
                    "name": one.name,
                    "kind": one.kind,
                    "family": one.family,
                    "summary": one.summary,
                    "phase": known[one.name].phase if one.name in known else "waiting",
                    "reason": known[one.name].reason if one.name in known else "",
                    "outputs": one.outputs,
                    "commands": one.commands,
                }
                for one in told.capabilities
            ],
            "words": [_word(one) for one in told.words],
            "joints": list(joints),
            "motions": [_motion(one) for one in motions],
            "cameras": [
                {"name": one.name.removeprefix(CAMERA_PREFIX), "capability": one.name}
                for one in told.capabilities
                if one.kind == CAMERA
            ],
            "wheels": told.wheels,
            "ranges": told.ranges,
            "buttons": list(buttons),
            "phrases": told.phrases,
            "base": told.base,
        }


def _is_picture(schema: Schema) -> bool:
    return "contentMediaType" in schema


def _word(said: Mapping[str, object]) -> dict[str, Any]:
    """Return a word as pages know it; `fields` say what may be filled in."""
    return {
        "word": said["word"],
        "help": said.get("help", ""),
        "role": said.get("role", "operate"),
        "usage": said.get("pattern", said["word"]),
        "fields": said.get("fields", []),
    }


def _motion(motion: Motion) -> dict[str, Any]:
    """Return a motion without its key frames, which may be thousands."""
    lasts_s = motion.slot_s if motion.slot_s is not None else sum(frame.duration_s for frame in motion.frames)
    return {
        "name": motion.name,
        "help": motion.help,
        "lead_in": motion.lead_in,
        "lead_out": motion.lead_out,
        "slot": motion.slot,
        "builtin": motion.builtin,
        "frames": len(motion.frames),
        "duration_s": round(lasts_s, 3),
    }
