"""The content of a request of the old API, from its JSON. Pure.

The rules are the original's. The first of `heading`, `turn` and `level` counts. An empty string counts as missing.
Numbers may be texts, except for the level. Bounds are whole centimetres and seconds.
"""

import json
from collections.abc import Mapping
from math import fmod, isfinite
from typing import Any, Literal

from msgspec import Struct

from lbr.errors import InputError
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.unreadable import keyed_once

Motion = DriveCommand | TurnCommand | HeadingCommand
Port = Literal["drive_command", "drive_turn", "drive_heading"]
PORTS: dict[type[Motion], Port] = {
    DriveCommand: "drive_command",
    TurnCommand: "drive_turn",
    HeadingCommand: "drive_heading",
}
"""The request for each type of motion."""
SENSORS = ("forward", "back", "left", "right", "bottom")
NEAREST_CM, FARTHEST_CM = 17, 768
"""The bounds for a range to stop at, as in the original."""
LONGEST_S = 3600
NOTHING = "say 'level' and 'angle', 'turn', 'heading' or 'speech'"


class NotFiniteError(InputError):
    """A NaN: its sender computes wrongly, so the robot must stand."""


class Asked(Struct, frozen=True, kw_only=True):
    """The content: a motion, or a stop, and a text to speak."""

    motion: Motion | None = None
    stop: bool = False
    speech: str = ""

    @property
    def bounded(self) -> bool:
        """Return whether the motion ends by itself, in time or at an angle."""
        motion = self.motion
        return isinstance(motion, TurnCommand | HeadingCommand) or (
            isinstance(motion, DriveCommand) and motion.interval_s > 0.0
        )


def decoded(body: bytes) -> Any:
    """Return the content of a body, with NaN and infinite numbers; raise InputError if it is not JSON."""
    try:
        content = json.loads(keyed_once(body))
        json.dumps(content, ensure_ascii=False).encode()  # a lone surrogate is JSON, but no text
    except UnicodeEncodeError:
        raise InputError("the body has text that is no Unicode") from None
    except (ValueError, RecursionError) as err:  # a ValidationError is a ValueError
        raise InputError(f"the body is not JSON: {str(err)[:120]}") from None
    return content


def asked(body: bytes) -> Asked:
    """Return the content of a request to `/`; raise InputError with its error."""
    fields = _mapping(decoded(body))
    speech = _speech(fields["speech"]) if _is_there(fields, "speech") else ""
    if _is_there(fields, "heading"):
        return Asked(motion=_heading(fields), speech=speech)
    if _is_there(fields, "turn"):
        return Asked(motion=_turn(fields), speech=speech)
    if _is_there(fields, "level"):
        motion = _drive(fields)
        return Asked(motion=motion, stop=motion is None, speech=speech)
    if not speech:
        raise InputError(NOTHING)
    return Asked(speech=speech)


def speech(body: bytes) -> str:
    """Return the text of a request to `/say`; raise InputError without one."""
    text = _speech(_mapping(decoded(body)).get("speech"))
    if not text:
        raise InputError('say it as {"speech": "text"} or {"speech": {"text": "text"}}')
    return text


def beams(body: bytes) -> dict[str, bool]:
    """Return for each beam in a request to `/docksignal` whether it is seen; raise InputError without any."""
    signal = _mapping(decoded(body)).get("dockSignal")
    example = 'say it as {"dockSignal": {"time": 1676000000.0, "left": 1}}'
    if not isinstance(signal, dict):
        raise InputError(example)
    beams_seen = {name: bool(_number(signal, name)) for name in ("left", "right", "power") if _is_there(signal, name)}
    if not beams_seen:
        raise InputError(f"{example}, with left, right or power")
    return beams_seen


def _heading(fields: Mapping[str, object]) -> HeadingCommand:
    heading_deg = round(_number(fields, "heading"), 1)
    if not 0.0 <= heading_deg <= 360.0:
        raise InputError(f"heading {heading_deg:g} is outside 0 to 360")
    return HeadingCommand(heading_deg=heading_deg)


def _turn(fields: Mapping[str, object]) -> TurnCommand:
    angle_deg = round(_number(fields, "turn"), 1)
    if not -360.0 <= angle_deg <= 360.0:
        raise InputError(f"turn {angle_deg:g} is outside -360 to 360")
    return TurnCommand(angle_deg=angle_deg)


def _drive(fields: Mapping[str, object]) -> DriveCommand | None:
    """Return the motion to drive; None for a stop, such as a level below 0."""
    if isinstance(fields["level"], str):
        raise InputError("level must be a number, not a text")
    level = round(min(1.0, _number(fields, "level")), 2)
    if not level > 0.0:
        return None
    if not _is_there(fields, "angle"):
        raise InputError("level needs an angle: 0 is ahead, 90 right, 180 back, 270 left")
    angle_deg = fmod(_whole(fields, "angle"), 360.0)
    range_cm, interval_s = _bound(fields, "range"), _bound(fields, "duration")
    if not (range_cm or interval_s):
        return DriveCommand(power=level, angle_deg=angle_deg)
    if interval_s > LONGEST_S:
        raise InputError(f"duration {interval_s} is longer than {LONGEST_S} s")
    return DriveCommand(
        power=level,
        angle_deg=angle_deg,
        range_cm=float(min(max(range_cm, NEAREST_CM), FARTHEST_CM)) if range_cm else 0.0,
        sensor=_sensor(fields),
        interval_s=float(interval_s),
    )


def _sensor(fields: Mapping[str, object]) -> str:
    if not _is_there(fields, "sensor"):
        return "forward"
    name = str(fields["sensor"]).strip().lower()
    name = "back" if name == "rear" else name
    if name not in SENSORS:
        there = ", ".join(one.capitalize() for one in SENSORS)
        raise InputError(f"sensor '{name[:40]}' is not one of {there}", "unknown_name")
    return name


def _speech(wording: object) -> str:
    """Return a text, bare or wrapped; of a mapping, only `text` counts."""
    if isinstance(wording, dict):
        wording = wording.get("text")
    if wording is None:
        return ""
    if not isinstance(wording, str):
        raise InputError("speech must be a text")
    return wording.strip()


def _bound(fields: Mapping[str, object], name: str) -> int:
    """Return a bound in whole units; 0 for none, and for a bound below 0."""
    return max(0, _whole(fields, name)) if _is_there(fields, name) else 0


def _whole(fields: Mapping[str, object], name: str) -> int:
    return int(_number(fields, name))


def _number(fields: Mapping[str, object], name: str) -> float:
    value = fields[name]
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise InputError(f"{name} must be a number")
    try:
        number = float(value)
    except ValueError:
        raise InputError(f"{name} must be a number, not '{str(value)[:40]}'") from None
    except OverflowError:
        raise NotFiniteError(f"{name} is too large") from None
    if not isfinite(number):
        raise NotFiniteError(f"{name} is {number}, which is no number to move by")
    return number


def _mapping(fields: object) -> Mapping[str, object]:
    if not isinstance(fields, dict):
        raise InputError(f"the body must be an object; {NOTHING}")
    return fields


def _is_there(fields: Mapping[str, object], name: str) -> bool:
    return fields.get(name) is not None and fields[name] != ""
