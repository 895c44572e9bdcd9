"""A test that failed while the machine gave it too little is run once more, on new fixtures, and that is told.

Robots are held to deadlines of a tenth of a second, and a machine that runs several whole ones at once can take more than
that from any of them. A test that has its time and fails has failed. So has one after `MOST` others of its process needed
a second try: that is no accident any more.
"""

from typing import Any

import pytest
from _pytest import runner

from tests.support import machine

MOST = 6
LONGEST = 300


class SecondTry:
    """A plugin: takes the place of the protocol that runs a test."""

    def __init__(self) -> None:
        self._taken = 0

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool:
        """Run a test, and again where the machine is to blame; report the last try alone."""
        watch = machine.Stopwatch()
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        reports = _tried(item)
        failed = [report for report in reports if report.failed]
        again = bool(failed) and self._taken < MOST and watch.share < machine.BUSY_SHARE
        reports.append(_torn_down(item, None if again else nextitem))
        if again:
            self._taken += 1
            said = str(getattr(failed[0].longrepr, "reprcrash", None) or failed[0].longrepr)[:LONGEST]
            busy = f"the machine gave {watch.share:.0%} of {watch.elapsed_s:.1f} s"
            machine.notes.append(f"FAILED, and was run again ({busy}): {' '.join(said.split())}")
            _with_new_time(item)
            reports = _tried(item)
            reports.append(_torn_down(item, nextitem))
        for report in reports:
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True


def _tried(item: Any) -> list[pytest.TestReport]:
    item._initrequest()
    reports = [runner.call_and_report(item, "setup", log=False)]
    if reports[0].passed:
        reports.append(runner.call_and_report(item, "call", log=False))
    return reports


def _torn_down(item: Any, nextitem: pytest.Item | None) -> pytest.TestReport:
    report = runner.call_and_report(item, "teardown", log=False, nextitem=nextitem)
    item._request, item.funcargs = False, None
    return report


def _with_new_time(item: Any) -> None:
    """Give the second try the same time as the first."""
    import pytest_timeout

    settings = pytest_timeout._get_item_settings(item)
    if settings.timeout:
        item.ihook.pytest_timeout_cancel_timer(item=item)
        item.ihook.pytest_timeout_set_timer(item=item, settings=settings)
