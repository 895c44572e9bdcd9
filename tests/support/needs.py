"""What some tests need of the machine: without it they are skipped and say why; in CI, which has it, they fail."""

import importlib.util
import os
import shutil

import pytest

IN_CI = os.environ.get("CI", "").lower() in {"1", "true"}
"""`.ci/run` says so once it has installed everything, and so do services that run checks."""


def program(name: str, package: str) -> pytest.MarkDecorator:
    """Skip a test where a program is not installed."""
    there = shutil.which(name) is not None or IN_CI
    return pytest.mark.skipif(not there, reason=f"{name} is not installed here: sudo apt install {package}")


def root(what: str) -> pytest.MarkDecorator:
    """Skip a test where an ordinary user runs it: only root can do `what`."""
    return pytest.mark.skipif(os.geteuid() != 0, reason=f"only root {what}")


LOOKING_INSIDE = root("looks into a process that has given up being looked at")
"""For what a capability was started with, and what it has open."""


def modules(*names: str) -> None:
    """Skip a module of tests where a package of the extras is not installed."""
    absent = [name for name in names if importlib.util.find_spec(name) is None]
    if absent and not IN_CI:
        pytest.skip(f"{', '.join(absent)} not installed: pip install -e '.[sim,dev]'", allow_module_level=True)
