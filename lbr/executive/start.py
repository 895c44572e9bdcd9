"""The beginning of a run: locks the robot, creates and upgrades its database, and passes both to an executive."""

import os
import sys
from functools import partial
from pathlib import Path

from lbr import home, plugins
from lbr.capability.confine import OWNER_ONLY
from lbr.database import copies, store
from lbr.database.claims import Claim
from lbr.errors import LbrError
from lbr.executive import executive
from lbr.executive.planning import joining, machine, trials
from lbr.executive.planning import profile as profiles
from lbr.executive.processes import scheduling
from lbr.executive.service import terminal

NO_THREAD = "can't start new thread"
"""In Python's wording."""


def run(
    profile_name: str,
    database: Path | None = None,
    listen: tuple[str, ...] = (),
    *,
    console: bool = True,
    verbose: bool = False,
) -> int:
    """Run a robot until it is asked to shut down; return the exit code. Errors that people can fix are LbrErrors.

    A `verbose` console shows how all parts start.
    """
    profile = profiles.load(profile_name)
    lock, claim = home.RunLock(profile.robot), Claim(profile.robot)
    scheduling.rank(os.getpid(), scheduling.MOTION)  # this process carries the router, and has no other thread yet
    os.umask(OWNER_ONLY)
    machine.raise_limits()
    try:
        path = database or home.default_database()
        left_out: tuple[str, ...] = ()
        if database is None and not path.exists():
            copies.refuse_if_lost(path)
            left_out = joining.create(path)
        with store.Database.open(path, program="executive") as opened:
            claim.take(path)
            _tell(
                *plugins.broken(), *left_out, joining.join(opened, profile.robot), trials.go_back(opened, profile.robot)
            )
            opened.bound()
            start = partial(terminal.start, verbose=verbose) if console else None
            return executive.run(profile, profile_name, opened, lock, listen, console=start)
    except RuntimeError as err:
        if NO_THREAD not in str(err):
            raise
        raise LbrError(f"{err}: free some memory, or have the limits raised ('ulimit -v', 'ulimit -u')") from err
    finally:
        claim.release()
        lock.release()


def _tell(*texts: str) -> None:
    """Report on standard error what was done or left out before the run: standard output is for programs."""
    for text in filter(None, texts):
        print(f"lbr: {text}", file=sys.stderr, flush=True)
