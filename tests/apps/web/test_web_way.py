"""The way of a request: how many files it goes through before the bus is asked, and by how many promises it returns."""

import sys
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import lbr
from lbr.apps.web import bridge as bridges
from lbr.apps.web.bridge import Bridge
from lbr.messages.leases import CommandReply
from tests.apps.web.test_web_hostile import uxa90

PACKAGE = Path(lbr.__file__).parent
THREAD = "apps/web/serving.py"
"""What the server's thread runs from the first request to the last; no request passes it."""


def passed() -> set[str]:
    """Return the files of lbr that have a hand in what runs now."""
    found = set()
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        path = Path(frame.f_code.co_filename)
        if path.is_relative_to(PACKAGE):
            found.add(path.relative_to(PACKAGE).as_posix())
        frame = frame.f_back
    return found - {THREAD}


@pytest.mark.parametrize(
    ("path", "asks"), [("/motor?id=23&pos=100", "move"), ("/motion/4", "play"), ("/multimotor", "move")]
)
def test_a_request_goes_through_ten_files_and_comes_back_by_one_promise(path, asks, monkeypatch):
    files: set[str] = set()
    promises: list[Any] = []
    asked: list[str] = []
    crossing, promise = Bridge.call, bridges.Promise

    def call(self: Bridge, work: Any, **options: float) -> Any:
        files.update(passed())
        return crossing(self, work, **options)

    class Counted(promise):
        def __init__(self) -> None:
            promises.append(self)
            super().__init__()

    def answer(request: str, _message: Any) -> CommandReply:
        if request == asks and not asked:
            asked.append(request)
            files.update(passed())
        return CommandReply(accepted=True, lease="1", goal="1")

    monkeypatch.setattr(Bridge, "call", call)
    monkeypatch.setattr(bridges, "Promise", Counted)
    with uxa90() as served:
        served.stage.answer = answer
        body = {"motors": [{"id": 23, "pos": 100}]} if path == "/multimotor" else None
        assert served.ask("POST" if body else "GET", path, body).status == 200
    assert asked == [asks]
    assert len(files) <= 10, "\n".join(sorted(files))
    assert len(promises) == 1
