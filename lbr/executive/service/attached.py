"""The plugged-in devices, for pages. The process of `lbr devices` looks for them, so that no device blocks this one."""

import subprocess
import sys
from pathlib import Path

import msgspec

from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

WITHIN_S = 9.0
LONGEST_TEXT = 300


def look(robot: str, database: Path) -> object:
    """Return the output of `lbr devices --json`, which writes nothing; raise InputError if it fails."""
    words = [sys.executable, "-m", "lbr.start", "devices", "--json", "--robot", robot, "--db", str(database)]
    try:
        done = subprocess.run(words, capture_output=True, timeout=WITHIN_S, stdin=subprocess.DEVNULL, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"'lbr devices' did not end within {WITHIN_S:g} s; say it at the robot", "timeout") from None
    except OSError as err:
        raise InputError(f"'lbr devices' cannot be started: {err.strerror}", "failed") from err
    try:
        return msgspec.json.decode(done.stdout)
    except UNREADABLE:
        why = " ".join(done.stderr.decode(errors="replace").split())[-LONGEST_TEXT:]
        raise InputError(f"'lbr devices' failed: {why or f'exit code {done.returncode}'}", "failed") from None
