"""Whether two routers still pass on what is asked, found out by asking."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from lbr.bus import session
from lbr.bus.session import Router, Session
from lbr.executive.processes import crossing
from lbr.executive.processes.crossing import BROKEN_AFTER, Crossing
from tests.support.waiting import until

NEAR, FAR = "1aa", "1bb"


@pytest.fixture
def near(tmp_path: Path) -> Iterator[Session]:
    with session.open_router(Router(listen=(f"unixsock-stream/{tmp_path}/near",), id=NEAR)) as opened:
        yield opened


@pytest.fixture
def tried(near: Session) -> Iterator[Crossing]:
    with contextlib.closing(Crossing(near, FAR, "lbr", lambda: None)) as made:
        yield made


def far(tmp_path: Path) -> Session:
    connect = (f"unixsock-stream/{tmp_path}/near",)
    return session.open_router(Router(listen=(f"unixsock-stream/{tmp_path}/far",), id=FAR, connect=connect))


def test_a_link_is_tried_when_it_comes_and_when_it_goes_and_then_rests(tmp_path: Path, tried: Crossing) -> None:
    for _ in range(2):
        with far(tmp_path) as opened:
            kept = crossing.answer(opened, "lbr")
            until(tried.due, what="there is reason to ask")
            until(lambda: rests(tried), what="it has been answered")
            del kept
        until(tried.due, what="a link that has gone is reason to ask")


def rests(tried: Crossing) -> bool:
    """Do what the doors do with it."""
    due = tried.due()
    if due is not None and time.monotonic() >= due:
        assert not tried.broken()
    return due is None


def test_a_link_that_stands_and_passes_nothing_is_broken(tmp_path: Path, tried: Crossing) -> None:
    with far(tmp_path):  # which answers nothing
        until(tried.due)
        assert [tried.broken() for _ in range(BROKEN_AFTER)] == [False] * (BROKEN_AFTER - 1) + [True]
        assert tried.due() is not None
