"""What other threads hand over to the executive's own: done once, or never."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import pytest

from lbr.errors import LbrError
from lbr.executive.processes import mainthread
from lbr.executive.processes.mainthread import MainThread
from tests.support.waiting import HANG_S, until


class Asker(threading.Thread):
    """Another thread that asks for something once, and keeps what came of it."""

    def __init__(self, main: MainThread, do: Callable[[], Any]) -> None:
        super().__init__(daemon=True)
        self.came: list[Any] = []
        self._main, self._do = main, do
        self.start()

    def run(self) -> None:
        try:
            self.came.append(self._main.call(self._do))
        except (LbrError, TimeoutError) as err:
            self.came.append(err)


def test_what_its_asker_was_told_is_not_done_is_not_done_later_either(monkeypatch: pytest.MonkeyPatch, wording) -> None:
    monkeypatch.setattr(mainthread, "ANSWER_LIMIT_S", 0.05)
    main, done = MainThread(), []
    asker = Asker(main, lambda: done.append("started"))
    until(lambda: asker.came, what="it is told")
    wording(asker.came[0])
    main.run_calls()
    assert done == []


def test_what_has_begun_is_waited_for_however_long_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    class Patient(Future[Any]):
        """Its time begins with what is asked, however late that is."""

        def result(self, timeout: float | None = None) -> Any:
            until(lambda: self.running() or self.done())
            return super().result(timeout)

    monkeypatch.setattr(mainthread, "ANSWER_LIMIT_S", 0.05)
    monkeypatch.setattr(mainthread, "Future", Patient)
    main, waited = MainThread(), threading.Event()
    asker = Asker(main, lambda: waited.wait(0.3) or "started")
    until(lambda: main.wait(0.02, ()) or asker.came, what="it is done")
    asker.join(HANG_S)
    assert asker.came == ["started"]


def test_what_it_raises_is_its_askers_also_a_timeout_of_its_own() -> None:
    main = MainThread()

    def slow() -> None:
        raise TimeoutError("the disk")

    asker = Asker(main, slow)
    until(lambda: main.wait(0.02, ()) or asker.came, what="it is told")
    assert str(asker.came[0]) == "the disk"
