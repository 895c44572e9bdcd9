"""Starts the process that draws, and looks after it without ever waiting for it."""

import os
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec

from lbr.capability.die_with_parent import dying_with_parent
from lbr.operations.attitude.picture import NOT_INSTALLED, Drawing

LONGEST_S = 60.0
NICENESS = 10
"""A picture may wait: what turns the robot by the attitude may not."""
MODULE = "lbr.operations.attitude.picture"


@dataclass(frozen=True, slots=True)
class Drawn:
    """What came of a picture: its file, or `trouble` that says why there is none."""

    path: str = ""
    trouble: str = ""


class Painter:
    """One picture at a time: `begin`, then `poll` until it says what came of it."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._path = Path()
        self._until = 0.0

    def begin(self, drawing: Drawing, path: Path, now: float) -> str:
        """Start to draw; return why not, or nothing."""
        self.close()
        self._path, self._until = path, now + LONGEST_S
        try:
            with tempfile.TemporaryFile() as paper:
                paper.write(msgspec.json.encode(drawing))
                paper.seek(0)
                self._process = subprocess.Popen(
                    dying_with_parent((sys.executable, "-P", "-m", MODULE, str(path))),
                    stdin=paper,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    env=os.environ | {"MPLCONFIGDIR": str(path.parent / ".matplotlib")},
                )
            os.setpriority(os.PRIO_PROCESS, self._process.pid, NICENESS)
        except OSError as err:
            return f"no picture was drawn: {err}"
        return ""

    def poll(self, now: float) -> Drawn | None:
        """Return what came of the picture, once; None while there is nothing to tell."""
        process = self._process
        if process is None:
            return None
        code = process.poll()
        if code is None:
            if now < self._until:
                return None
            self.close()
            return Drawn(trouble=f"no picture was drawn within {LONGEST_S:.0f} s")
        said = process.stderr.read().decode(errors="replace").strip() if process.stderr is not None else ""
        self.close()
        if code == 0:
            return Drawn(path=str(self._path))
        if code == NOT_INSTALLED:
            return Drawn(trouble="no picture was drawn: matplotlib is not installed; lbr's extra 'plots' brings it")
        last = said.splitlines()[-1] if said else f"exit code {code}"
        return Drawn(trouble=f"no picture was drawn: {last[:200]}")

    def close(self) -> None:
        """End the process, if it still runs."""
        process, self._process = self._process, None
        if process is None:
            return
        with suppress(OSError):
            process.kill()
        with suppress(subprocess.TimeoutExpired):
            process.wait(1.0)
        if process.stderr is not None:
            process.stderr.close()
