"""Some test processes have whole robots at a time and the others wait their turn: a robot needs the processor.

So there can be more test processes than robots, and what only waits for lines and clocks is tried meanwhile. A process
has its turn from the start of its first robot until all of its robots have ended, so that none waits for itself.
"""

import fcntl
import os
import subprocess
import time
from pathlib import Path

PLACE = "LBR_TESTS_SLOTS"
"""Where the turns are, by the environment of a run; without it nothing waits."""
QUEUE = "queue"
AGAIN_S = 0.02

waited_s = 0.0
"""How long this process has waited for its turns so far."""
_held: int | None = None
_waits_since: float | None = None
_robots: "list[subprocess.Popen[str]]" = []


def make(place: Path, count: int) -> None:
    """Have this many turns in a folder, for this process and all that it starts."""
    for number in range(count):
        (place / f"slot{number}").touch()
    os.environ[PLACE] = str(place)


def take() -> None:
    """Wait for a turn, unless this process has one."""
    global _held, _waits_since, waited_s  # noqa: PLW0603 - one for each process
    place = os.environ.get(PLACE)
    if place is None or _held is not None:
        return
    began = _waits_since = time.monotonic()
    with (Path(place) / QUEUE).open("w") as queue:
        fcntl.flock(queue, fcntl.LOCK_EX)  # who comes first is first, also before one that has just given its turn back
        while (_held := _free(Path(place))) is None:
            time.sleep(AGAIN_S)
    waited_s += time.monotonic() - began
    _waits_since = None


def waited() -> float:
    """Return for how long this process has waited for turns, with the one that it waits for now."""
    return waited_s + (time.monotonic() - _waits_since if _waits_since is not None else 0.0)


def has(robot: "subprocess.Popen[str]") -> None:
    """Keep the turn for as long as this robot runs."""
    _robots.append(robot)


def give_back() -> None:
    """Let another have the turn, if no robot of this process runs any more."""
    global _held  # noqa: PLW0603 - see above
    _robots[:] = [robot for robot in _robots if robot.poll() is None]
    if _held is not None and not _robots:
        os.close(_held)
        _held = None


def _free(place: Path) -> int | None:
    for path in sorted(place.glob("slot*")):
        slot = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        try:
            fcntl.flock(slot, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(slot)
        else:
            return slot
    return None
