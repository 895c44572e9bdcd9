"""A process tells its executive what changed in whole lines, and never waits for it."""

import os
from collections.abc import Iterator
from itertools import count, pairwise

import msgspec
import pytest

from lbr.capability import reporter as reporting
from lbr.capability.config import Report
from lbr.capability.reporter import BEAT_S, COUNTS_S, EARLY_S, HEARTBEAT_VARIABLE, Reporter, final_report


class Pipe:
    """The executive's end."""

    def __init__(self) -> None:
        self.reading, self.writing = os.pipe()
        os.set_blocking(self.reading, False)

    def lines(self) -> list[bytes]:
        try:
            return os.read(self.reading, 1 << 20).splitlines()
        except BlockingIOError:
            return []

    def reports(self) -> list[Report]:
        """Return what is more than a heartbeat."""
        reports = [msgspec.json.decode(line, type=Report) for line in self.lines()]
        return [report for report in reports if report != Report(number=report.number, at=report.at)]


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    made = Pipe()
    yield made
    for fd in (made.reading, made.writing):
        os.close(fd)


@pytest.fixture
def now(monkeypatch):
    """The clock, as a list of one."""
    time = [100.0]
    monkeypatch.setattr(reporting.time, "monotonic", lambda: time[0])
    return time


def test_a_phase_is_told_when_it_or_its_reason_or_its_code_changes(pipe):
    said = Reporter(pipe.writing)
    for phase in (
        ("ready",),
        ("ready",),
        ("ready", "slow"),
        ("ready", "slow", "late"),
        ("ready", "slow", "late"),
        ("ready",),
    ):
        said.phase(*phase)
    assert [(one.phase, one.reason, one.code) for one in pipe.reports()] == [
        ("ready", "", ""), ("ready", "slow", ""), ("ready", "slow", "late"), ("ready", "", ""),
    ]  # fmt: skip


@pytest.mark.parametrize("reason", ["a\nb", "\x00", "\u2028", '"', "ü" * 9000, "\U0001f600" * 9000])
def test_whatever_a_reason_has_it_is_one_line_that_a_pipe_takes_whole(pipe, reason):
    Reporter(pipe.writing).phase("failed", reason)
    (line,) = os.read(pipe.reading, 1 << 20).removesuffix(b"\n").split(b"\n")
    assert len(line) < reporting.PIPE_BUF
    assert msgspec.json.decode(line, type=Report).reason == reason[:500]


def test_beats_are_as_seldom_as_is_enough_and_counts_as_seldom_as_a_second(pipe, now):
    said, heard = Reporter(pipe.writing), []
    for turn in range(1000):
        now[0] = 100.0 + turn / 100.0
        said.beat({"state": turn})
        heard += [(now[0], line) for line in pipe.lines()]
    times = [at for at, _ in heard]
    assert min(b - a for a, b in pairwise(times)) >= BEAT_S - EARLY_S - 1e-9
    assert max(b - a for a, b in pairwise(times)) <= BEAT_S + 0.02
    counts = [at for at, line in heard if msgspec.json.decode(line, type=Report).counts]
    assert len(heard) > 4 * len(counts)
    assert min(b - a for a, b in pairwise(counts)) >= COUNTS_S - 1e-9


def test_an_executive_that_does_not_read_or_is_gone_holds_nothing_up(pipe, now):
    said = Reporter(pipe.writing)
    for turn in count():
        now[0] += BEAT_S
        said.beat({"state": turn})
        said.phase("ready", f"{turn} {'x' * 400}")
        if turn > 300:  # more than a pipe holds
            break
    assert all(one.phase == "ready" or one.counts for one in pipe.reports())
    reading, writing = os.pipe()
    os.close(reading)
    Reporter(writing).phase("ready")
    os.close(writing)


def test_the_last_word_goes_to_the_pipe_that_the_executive_gave(monkeypatch):
    monkeypatch.delenv(HEARTBEAT_VARIABLE, raising=False)
    assert final_report("failed", "gone", "failed")[0] == -1
    monkeypatch.setenv(HEARTBEAT_VARIABLE, "7")
    fd, line = final_report("failed", "gone", "failed")
    assert (fd, line.count(b"\n"), line[-1:]) == (7, 1, b"\n")
    assert msgspec.json.decode(line, type=Report) == Report(phase="failed", reason="gone", code="failed")


def test_a_loop_that_goes_round_as_often_as_beats_are_due_beats_each_time_though_it_is_a_little_early(pipe, now):
    said = Reporter(pipe.writing)
    for turn in range(20):
        now[0] = 100.0 + turn * BEAT_S - (turn % 2) * EARLY_S / 2
        said.beat({})
    assert len(pipe.lines()) == 20
