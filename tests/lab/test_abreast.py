import json
import queue
import socket
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from tests.lab.abreast import MOST_AHEAD_S, Abreast, waits

SOON_S = 20.0


class Played:
    """What QEMU is to it: a line on which the time is told, and another that takes commands."""

    def __init__(self, folder: Path, at: float) -> None:
        folder.mkdir()
        self._at = at
        self.clock = (folder / "clock", folder / "control")
        self.asked: queue.Queue[str] = queue.Queue()
        self._told, self._control = (_listening(path) for path in self.clock)
        self._line = socket.socket()
        self._thread = threading.Thread(target=self._answer)
        self._thread.start()

    def tell(self, at: float) -> None:
        self._line.sendall(f"{at:.4f}\r\n".encode())

    def does(self) -> str:
        return self.asked.get(timeout=SOON_S)

    def off(self) -> None:
        self._line.close()

    def close(self) -> None:
        self._thread.join(SOON_S)
        self.off()
        self._told.close()
        self._control.close()

    def _answer(self) -> None:
        self._line.close()
        self._line, _ = self._told.accept()
        self.tell(self._at)
        link, _ = self._control.accept()
        with closing(link):
            link.sendall(b'{"QMP": {}}\n')
            while data := link.recv(4096):
                what = json.loads(data)["execute"]
                self.asked.put(what)
                link.sendall(f'{{"event": "{what.upper()}"}}\n{{"return": {{}}}}\n'.encode())


@contextmanager
def played(folder: Path) -> Iterator[tuple[Abreast, Played, Played]]:
    first, second = Played(folder / "first", 100.0), Played(folder / "second", 7.0)
    kept = Abreast(first.clock, second.clock)
    kept.start()
    try:
        assert first.does() == second.does() == "qmp_capabilities"
        yield kept, first, second
    finally:
        kept.stop()
        first.close()
        second.close()


def test_who_is_ahead_waits_until_the_other_has_come_up_to_it(tmp_path: Path) -> None:
    with played(tmp_path) as (kept, first, second):
        first.tell(100.03)
        assert first.does() == "stop"
        second.tell(7.031)
        assert first.does() == "cont"
        second.tell(7.06)
        assert second.does() == "stop"
        first.tell(100.07)
        assert second.does() == "cont"
        assert kept.seen() == pytest.approx(0.03, abs=2e-3)


def test_who_waits_goes_on_when_they_are_no_longer_kept_abreast(tmp_path: Path) -> None:
    with played(tmp_path) as (kept, first, _second):
        first.tell(101.0)
        assert first.does() == "stop"
        kept.stop()
        assert first.does() == "cont"


def test_a_machine_that_goes_off_is_told_and_the_other_goes_on(tmp_path: Path) -> None:
    with played(tmp_path) as (kept, first, second):
        first.tell(101.0)
        assert first.does() == "stop"
        second.off()
        assert first.does() == "cont"
        kept.stop()
        with pytest.raises(RuntimeError, match="not kept abreast"):
            kept.seen()


@pytest.mark.parametrize(
    ("ahead_s", "held", "waiting"),
    [(-1.0, False, False), (MOST_AHEAD_S, False, False), (MOST_AHEAD_S + 1e-3, False, True), (1e-3, True, True), (0.0, True, False)],
)  # fmt: skip
def test_a_machine_waits_by_how_far_it_is_ahead(ahead_s: float, held: bool, waiting: bool) -> None:
    assert waits(ahead_s, held) is waiting


def _listening(path: Path) -> socket.socket:
    door = socket.socket(socket.AF_UNIX)
    door.bind(str(path))
    door.listen(1)
    return door
