"""The stored motions of an emulated main board: the format of `firmware.json`, and their play.

The file is one object, from the number of a slot to its programme:

    {"4": {"name": "walk_forward_short", "level": 0, "limp": false,
           "frames": [{"duration_s": 0.4, "counts": {"0": 125, "1": 127}},
                      {"figure": "step", "times": 2}],
           "figures": {"step": [{"duration_s": 0.2, "counts": {"2": 98.5}, "smooth": true}, {"duration_s": 0.1}]}}}
"""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from math import cos, pi
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

FRAME_S = 0.02
"""The period at which the main board sends its servos a position on the way."""

Count = Annotated[float, Meta(ge=1, le=254, description="nominal counts; 127 is the middle of a servo's range")]
Digits = Annotated[str, Meta(pattern="^[0-9]{1,2}$(?!\\n)", description="a servo's id")]
Level = Annotated[int, Meta(ge=0, le=4, description="torque level, 0 the strongest")]


class Frame(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Takes its servos, by id, to nominal counts within its time; all others hold.

    Fractions of counts are allowed. `smooth`: a gentle start and end. `level`: in place of the programme's. `figure`:
    plays that figure of the programme `times` instead.
    """

    duration_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 0.0
    counts: dict[Digits, Count] = {}
    smooth: bool = False
    level: Level | None = None
    figure: str = ""
    times: Annotated[int, Meta(ge=1, le=1000)] = 1

    def servos(self) -> dict[int, float]:
        """Return the counts by the servos' ids."""
        return {int(number): count for number, count in self.counts.items()}


class Programme(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A motion of the main board: its frames in order, from any position of the servos.

    A servo that it never names stays, limp or held. `limp`: all are released at its end. `figures`: frames that may be
    played again.
    """

    frames: Annotated[tuple[Frame, ...], Meta(min_length=1)]
    name: str = ""
    level: Level = 0
    limp: bool = False
    figures: dict[str, tuple[Frame, ...]] = {}

    def __post_init__(self) -> None:
        for frame in self.frames:
            if frame.figure and frame.figure not in self.figures:
                raise ValueError(f"a frame plays figure '{frame.figure}', which is not one of its figures")
        if any(frame.figure for figure in self.figures.values() for frame in figure):
            raise ValueError("a figure consists of frames with counts, not of figures")

    def played(self) -> Iterator[Frame]:
        """Yield the frames one after the other, with figures expanded."""
        for frame in self.frames:
            if frame.figure:
                for _ in range(frame.times):
                    yield from self.figures[frame.figure]
            else:
                yield frame

    @property
    def duration_s(self) -> float:
        """Return its duration."""
        return sum(frame.duration_s for frame in self.played())

    def ends_at(self) -> dict[int, float]:
        """Return the counts of the servos at its end, by id."""
        counts: dict[int, float] = {}
        for frame in self.played():
            counts |= frame.servos()
        return counts


class Way(Struct, frozen=True):
    """The next order for servos: counts by id, the time of the way, and the level."""

    counts: dict[int, float]
    duration_s: float
    level: int


class Player:
    """A programme in progress; it begins with the servos at their present positions."""

    def __init__(self, programme: Programme, counts: Mapping[int, float], now: float) -> None:
        self.programme = programme
        self.next_at = now
        self._frames = programme.played()
        self._counts = dict(counts)
        self._frame: Frame | None = None
        self._from: dict[int, float] = {}
        self._begun = now
        self._advance()

    @property
    def over(self) -> bool:
        """Return whether nothing is left to play at `next_at` but its end."""
        return self._frame is None

    def step(self) -> Way:
        """Return the order due at `next_at`, and advance that by its time."""
        frame = self._frame
        assert frame is not None
        until = min(self.next_at + FRAME_S, self._begun + frame.duration_s)
        if until > self._begun + frame.duration_s - FRAME_S / 4:
            until = self._begun + frame.duration_s
        share = 1.0 if frame.duration_s == 0.0 else (until - self._begun) / frame.duration_s
        share = (1.0 - cos(pi * share)) / 2 if frame.smooth else share
        goal = {n: self._from.get(n, to) + (to - self._from.get(n, to)) * share for n, to in frame.servos().items()}
        level = self.programme.level if frame.level is None else frame.level
        way = Way(goal, until - self.next_at, level)
        self.next_at = until
        self._counts |= goal
        if until >= self._begun + frame.duration_s:
            self._begun = until
            self._advance()
        return way

    def _advance(self) -> None:
        self._frame = next(self._frames, None)
        self._from = dict(self._counts)


@cache
def shipped() -> Mapping[int, Programme]:
    """Return the programmes of `firmware.json` by slot."""
    data = files("lbr.robots.uxa90.twin").joinpath("firmware.json").read_bytes()
    return msgspec.json.decode(data, type=dict[int, Programme])
