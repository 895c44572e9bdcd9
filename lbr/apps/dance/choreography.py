"""Moves by beat. Pure."""

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from itertools import chain, repeat

from msgspec import Struct

from lbr.apps.dance.messages import DanceStep
from lbr.errors import InputError
from lbr.names import did_you_mean


class Move(Struct, frozen=True):
    """The drive from one beat to the next."""

    power: float = 0.0
    angle_deg: float = 0.0


REST = Move()


class Choreography(Struct, frozen=True):
    """A dance: a move for each beat; after the last move comes the first."""

    name: str
    moves: tuple[Move, ...]

    def at(self, beat: int) -> Move:
        """Return the move of a beat, counted from 0."""
        return self.moves[beat % len(self.moves)]


def choose(steps: Iterable[DanceStep], name: str) -> Choreography:
    """Return the choreography of this name; raise InputError with similar names."""
    rows = sorted(steps, key=lambda step: step.step)
    own = [repeat(Move(step.power, step.angle_deg), step.beats) for step in rows if step.dance == name]
    if not own:
        known = {step.dance for step in rows}
        raise InputError(
            f"there are no rows of a dance '{name[:40]}' in choreography; {did_you_mean(name, known)}", "unknown_name"
        )
    return Choreography(name, tuple(chain.from_iterable(own)))


def beat_at(beats: Sequence[float], seconds: float) -> int:
    """Return the last beat before a time, counted from 0; -1 before the first."""
    return bisect_right(beats, seconds) - 1
