"""What one servo is to do, and was told."""

from dataclasses import dataclass
from math import inf


@dataclass(slots=True)
class Out:
    """One servo. `known`: whether this driver knows if it has torque (`on`). `count`: its goal, None where unknown.

    `want` is the packet that is to be said, `said` the one that was, `told_at` when. `carried`: it may have had torque
    before the line was opened; it is held where it is until a new motion begins. `adrift`: to be held where it is as
    soon as that is known. `overtaken`: a goal from before a stop, which is not gone to. `blocked` says why it gets no torque before a setpoint had it without.
    """

    id: int
    known: bool = False
    on: bool = False
    count: int | None = None
    level: int = 0
    want: bytes | None = None
    said: bytes | None = None
    told_at: float = -inf
    times: int = 0
    weak_until: float = -inf
    rest_at: float = inf
    carried: bool = False
    adrift: bool = False
    overtaken: float | None = None
    blocked: str = ""
    trouble: str = ""
    still: tuple[int, float] | None = None
