"""The last switch position of a camera, for as long as its robot runs: it outlives restarts of the camera's process."""

import os
from contextlib import suppress
from pathlib import Path


def keep(home: str, robot: str, camera: str, *, on: bool) -> None:
    """Store the switch position; a failure to write is ignored."""
    path = _path(home, robot, camera)
    with suppress(OSError):
        path.parent.mkdir(mode=0o700, exist_ok=True)
        path.write_text(f"{_run()} {'on' if on else 'off'}\n")


def remembered(home: str, robot: str, camera: str, *, otherwise: bool) -> bool:
    """Return the stored switch position of this run of the robot, or `otherwise`."""
    try:
        run, _, wish = _path(home, robot, camera).read_text().strip().rpartition(" ")
    except (OSError, UnicodeDecodeError):
        return otherwise
    return wish == "on" if run == _run() else otherwise


def _path(home: str, robot: str, camera: str) -> Path:
    return Path(home) / "run" / f"{robot}-{camera}.switch"


def _run() -> str:
    """Return the identity of this run of the robot: its executive's pid and start time."""
    executive = os.getppid()
    started = Path(f"/proc/{executive}/stat").read_text().rpartition(")")[2].split()[19]
    return f"{executive} {started}"
