"""The common part of programs beside the robot: their connection, their name, and their end."""

import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

from lbr import home
from lbr.bus import session
from lbr.bus.session import Session
from lbr.bus.stamp import Origin
from lbr.errors import BusError, InputError, LbrError

FAILED, BAD_INPUT = 1, 2


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot of this home, and a session on its bus with the roles of its local door: view and operate.

    `started_s`, monotonic, is when the program was requested: what was stopped since then must not begin. `origin` has
    the sender and time of that request; None if no robot started the program.
    """

    bus: Session
    name: str
    source: str
    started_s: float
    origin: Origin | None = None


@contextmanager
def connected(program: str) -> Iterator[Robot]:
    """Connect to the robot that started this program, else to the only one that runs here."""
    wanted = os.environ.get("LBR_ROBOT")
    runs = [run for run in home.running() if wanted in {None, "", run.robot}]
    if not runs:
        raise BusError(f"robot '{wanted}' does not run here" if wanted else "no robot runs here; 'lbr run' starts one")
    if len(runs) > 1:
        names = ", ".join(run.robot for run in runs)
        raise InputError(f"several robots run here ({names}); say which with LBR_ROBOT=NAME")
    bus = session.open_client(runs[0].endpoints)
    try:
        yield Robot(bus, runs[0].robot, f"{program}:{os.getpid()}", _told_s("LBR_STARTED_S"), _origin())
    finally:
        bus.close()


def _told_s(name: str) -> float:
    """Return a time that the robot set for this program; now, if it is missing or not a number."""
    now = time.monotonic()
    with contextlib.suppress(KeyError, ValueError):
        said_s = float(os.environ[name])
        return min(now, said_s)  # this way round, NaN means now
    return now


def _origin() -> Origin | None:
    asker = os.environ.get("LBR_ASKED_BY")
    return Origin(asker, _told_s("LBR_WRITTEN_S")) if asker else None


def run(main: Callable[[], int]) -> int:
    """Run a program: SIGTERM ends it as Ctrl-C does, and an error becomes a sentence and an exit code."""
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        return main()
    except KeyboardInterrupt:
        return 0
    except InputError as err:
        sys.stderr.write(f"{err}\n")
        return BAD_INPUT
    except LbrError as err:
        sys.stderr.write(f"{err}\n")
        return FAILED


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
