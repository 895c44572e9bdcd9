"""The fall of a robot, and the side on which it lies, by the lean of its trunk. Pure."""

from math import acos, cos, radians, sin
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.attitude import AttitudeState
from lbr.messages.codes import Reason
from lbr.messages.motors import RESTS_S

Lies = Literal["", "face", "back", "side"]
FALLEN_RAD, UPRIGHT_RAD = radians(60.0), radians(35.0)
"""The lean of a fall and of an upright robot: none came back from 50 degrees in simulation; good motions lean 30 at
most."""
FALLEN_S, UPRIGHT_S = 0.2, 0.5
"""The least duration of each: a knock is no fall."""
OLDEST_S = 0.3
ALONG = sin(radians(45.0))
ON: dict[Lies, str] = {"face": "on its face", "back": "on its back", "side": "on its side"}


GETS_UP = "get_up"
"""The prefix of motions that begin lying; all others need a standing robot."""


class Fall(Struct, frozen=True, kw_only=True):
    """The side on which it lies, empty: upright or unknown. `since` is the beginning of a different lean."""

    lies: Lies = ""
    since: float | None = None


def refusal(state: Fall, motion: str) -> Reason | None:
    """Return why a motion cannot begin while the robot lies, or None."""
    if not state.lies or motion.startswith(GETS_UP):
        return None
    lying = f"motions that begin lying are named {GETS_UP}…"
    text = f"the robot lies {ON[state.lies]}, and '{motion}' needs it to stand; {lying}"
    return Reason("fallen", text)


def seen(state: Fall, attitude: AttitudeState, now: float) -> Fall:
    """Return the state after an attitude; one that is old, invalid or not finite changes nothing."""
    roll, pitch, oldest_s = attitude.roll_rad, attitude.pitch_rad, RESTS_S if attitude.rests else OLDEST_S
    if not attitude.valid or roll is None or pitch is None or not now - attitude.measured_s <= oldest_s:
        return replace(state, since=None)
    upright = cos(roll) * cos(pitch)
    if not -1.0 <= upright <= 1.0:
        return replace(state, since=None)
    lean = acos(upright)
    changes = lean < UPRIGHT_RAD if state.lies else lean > FALLEN_RAD
    if not changes:
        return Fall(lies=_side(pitch) if state.lies and lean > FALLEN_RAD else state.lies)
    since = now if state.since is None else state.since
    if now - since < (UPRIGHT_S if state.lies else FALLEN_S):
        return replace(state, since=since)
    return Fall(lies="" if state.lies else _side(pitch))


def _side(pitch: float) -> Lies:
    """Return the side on which it lies: pitch is positive with its face down."""
    along = sin(pitch)
    return "face" if along > ALONG else "back" if along < -ALONG else "side"
