"""A process and the capabilities in it, as the executive has them: what is reported by which number, and who ends with whom."""

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import msgspec
import pytest

from lbr.capability.config import Order, ProcessConfig, Report
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes.launching import Reports
from lbr.executive.processes.process_host import SLOW_S, TERM_S, Child, Process, ProcessHost
from lbr.executive.processes.reaper import Reaper
from tests.support import programs
from tests.support.waiting import until


def unit(name: str, settings: str = "{}") -> ProcessSpec:
    config = ProcessConfig(
        robot="r", name=name, kind="k", settings=msgspec.Raw(settings.encode()), endpoints=(), home="", process="crew"
    )
    return ProcessSpec(name=name, kind="k", family="app", moves=False, restart="never", needs=(), config=config)


class Crew:
    """A process that writes down its orders and reports what the test says, and the capabilities in it."""

    def __init__(self, reaper: Reaper, path: Path) -> None:
        self.path = path
        mark = reaper.mark()
        with path.open("wb") as orders:
            self.popen = programs.start(["cat"], stdin=subprocess.PIPE, stdout=orders, start_new_session=True)
        mark.began(self.popen.pid)
        reading, self.writing = os.pipe()
        os.set_blocking(reading, False)
        self.process = Process("crew", unit("ann").config, self.popen, Reports(reading), mark)
        self.children: dict[int, Child] = {}

    def start(self, name: str, number: int) -> Child:
        spec = unit(name)
        order = msgspec.json.encode(Order(number=number, start=spec.config)) + b"\n"
        child = self.children[number] = self.process.start(spec, spec.config, number, order)
        return child

    def says(self, number: int, phase: str, reason: str = "") -> None:
        """Report, and have it looked at."""
        self.writes(number, phase, reason)
        self.process.quiet = False

    def writes(self, number: int, phase: str, reason: str = "") -> None:
        os.write(self.writing, msgspec.json.encode(Report(number=number, phase=phase, reason=reason)) + b"\n")

    def orders(self) -> list[tuple[int, bool]]:
        lines = self.path.read_bytes().splitlines()
        return [(order.number, order.start is not None) for order in map(msgspec.json.Decoder(Order).decode, lines)]

    def close(self) -> None:
        os.close(self.writing)
        self.popen.kill()
        for child in self.children.values():
            ended(child)
            child.close()


@pytest.fixture
def reaper() -> Iterator[Reaper]:
    with closing(Reaper()) as made:
        yield made


@pytest.fixture
def crew(reaper: Reaper, tmp_path: Path) -> Iterator[Crew]:
    with closing(Crew(reaper, tmp_path / "orders")) as made:
        yield made


def phases(child: Child) -> list[str]:
    return [report.phase for report in child.reports()]


def ended(child: Child) -> int:
    """Wait for its end, as the supervisor does."""
    until(lambda: [child.reports(), child.returncode()][-1] is not None)
    code = child.returncode()
    assert code is not None
    return code


def test_what_is_still_reported_of_an_earlier_start_is_nobodys(crew: Crew) -> None:
    first, mate = crew.start("ann", 1), crew.start("bob", 2)
    first.terminate()
    crew.says(1, "ended")
    assert (phases(first), first.returncode()) == (["ended"], 0)
    crew.children.pop(1).close()
    second = crew.start("ann", 3)
    for phase in ("ready", "ended", "left", "hung", "failed"):
        crew.says(1, phase)
    assert (phases(second), second.returncode()) == ([], None)
    assert (phases(mate), mate.returncode()) == ([], None)
    assert not crew.process.over
    crew.says(3, "ready")
    assert phases(second) == ["ready"]


def test_processes_without_news_are_not_asked_and_every_news_is_seen_in_one_look(
    reaper: Reaper, tmp_path: Path
) -> None:
    host = ProcessHost(tmp_path, reaper)
    with closing(Crew(reaper, tmp_path / "one")) as one, closing(Crew(reaper, tmp_path / "two")) as two:
        host.watch(one.process)
        host.watch(two.process)
        ann, bob = one.start("ann", 1), two.start("bob", 2)
        host.poll()
        assert (one.process.quiet, two.process.quiet) == (True, True)
        one.writes(1, "ready")
        assert phases(ann) == []
        host.poll()
        assert (phases(ann), phases(bob)) == (["ready"], [])
        two.popen.kill()
        until(lambda: [host.poll(), bob.reports(), bob.returncode()][-1] == -signal.SIGKILL)
        assert ann.returncode() is None
        one.popen.kill()
        until(lambda: [host.poll(), ann.reports(), ann.returncode()][-1] == -signal.SIGKILL)


def test_who_is_asked_to_end_leaves_the_others_and_the_last_ends_with_the_process(crew: Crew) -> None:
    ann, bob = crew.start("ann", 1), crew.start("bob", 2)
    ann.terminate()
    assert (ann.patience_s, crew.process.over) == (SLOW_S, False)
    until(lambda: crew.orders() == [(1, True), (2, True), (1, False)])
    crew.says(1, "ended")
    assert ended(ann) == 0
    crew.children.pop(1).close()
    bob.terminate()
    assert (bob.patience_s, crew.process.over) == (TERM_S, True)
    crew.says(2, "ended")
    assert ended(bob) == 0
    assert crew.popen.wait() == -signal.SIGTERM


def test_the_last_has_not_ended_before_its_process(crew: Crew) -> None:
    os.kill(crew.popen.pid, signal.SIGSTOP)
    ann = crew.start("ann", 1)
    crew.says(1, "left", "no cheese")
    (report,) = ann.reports()
    assert (report.phase, report.reason) == ("failed", "no cheese")
    assert (ann.returncode(), crew.process.over) == (None, True)
    os.kill(crew.popen.pid, signal.SIGCONT)
    assert ended(ann) == 70


def test_one_that_leaves_before_it_began_leaves_the_others_alone(crew: Crew) -> None:
    ann, bob = crew.start("ann", 1), crew.start("bob", 2)
    crew.says(1, "left", "no cheese")
    assert phases(bob) == []
    assert ended(ann) == 70
    assert (bob.returncode(), crew.process.over) == (None, False)


def test_who_fails_takes_along_the_others_who_say_whose_end_it_was(crew: Crew) -> None:
    ann, bob = crew.start("ann", 1), crew.start("bob", 2)
    crew.says(2, "failed", "out of cheese")
    crew.popen.kill()
    crew.popen.wait()
    (report,) = ann.reports()
    assert (report.phase, "'bob'" in report.reason) == ("taken_along", True)
    assert phases(bob) == ["failed"]
    assert (ann.returncode(), bob.returncode()) == (-signal.SIGKILL, -signal.SIGKILL)


def test_nothing_begins_where_all_end(reaper: Reaper, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    host = ProcessHost(tmp_path, reaper)
    children = []
    for name in ("ann", "bob"):
        spec = unit(name)
        children.append(host.start(spec, spec.config))
        os.kill(children[-1].pid, signal.SIGSTOP)
        children[-1].kill()
    assert children[0].pid != children[1].pid
    for child in children:
        assert ended(child) == -signal.SIGKILL
        child.close()
