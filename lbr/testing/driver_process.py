"""A driver in a process of its own, which a test kills."""

import json
import select
import subprocess
import sys
import time
from typing import Any

from lbr.capability.die_with_parent import dying_with_parent

PROGRAM = "lbr.testing.driver_program"
WORKS = "works"
"""The line that it prints once it works."""


def started(bench: dict[str, Any], program: str = PROGRAM) -> "subprocess.Popen[str]":
    """Start the driver of a bench, given as JSON, as a module; it dies with this process."""
    argv = dying_with_parent((sys.executable, "-m", program, json.dumps(bench)))
    return subprocess.Popen(argv, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)


def wait_until_it_works(process: "subprocess.Popen[str]", within_s: float) -> None:
    """Wait until it reports that it works."""
    assert process.stdout is not None
    end = time.monotonic() + within_s
    while not select.select([process.stdout], [], [], 0.05)[0]:
        assert time.monotonic() < end, f"a driver in a process of its own does not work within {within_s:g} s"
    said = process.stdout.readline().strip()
    assert said == WORKS, "a driver in a process of its own has ended: see what it wrote; is its package installed?"


def kill(process: "subprocess.Popen[str]") -> None:
    """Kill it, if it still runs."""
    process.kill()
    process.wait()
    if process.stdout is not None:
        process.stdout.close()
