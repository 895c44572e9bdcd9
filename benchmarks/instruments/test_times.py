"""A plugin of pytest: writes the duration and result of each test, as JSON to the file in LBR_TEST_TIMES."""

import json
import os
from pathlib import Path

import pytest

_took_s: dict[str, float] = {}
_failed: set[str] = set()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up setup, call and teardown."""
    _took_s[report.nodeid] = _took_s.get(report.nodeid, 0.0) + report.duration
    if not report.passed:
        _failed.add(report.nodeid)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the times of those that passed."""
    if not hasattr(session.config, "workerinput"):
        passed = {test: took_s for test, took_s in _took_s.items() if test not in _failed}
        Path(os.environ["LBR_TEST_TIMES"]).write_text(json.dumps(passed))
