"""The parts of the black box: its clock, what it keeps, the logs it follows, and a disk that takes nothing."""

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.recorder.box.clock import MOST_NS, Clock
from lbr.apps.recorder.box.disk import BoxDisk, Chunk, Disk
from lbr.apps.recorder.box.keeping import MARK, MOST_OF_ONE, Keeping
from lbr.apps.recorder.box.logs import Logs
from lbr.apps.recorder.recording import chunks, selection
from lbr.apps.recorder.recording.chunks import Channel, Channels
from lbr.apps.recorder.recording.shelf import Shelf
from lbr.messages.system import Event
from tests.support import programs
from tests.support.waiting import until

S = 10**9


class Hands:
    """Two clocks of a machine."""

    def __init__(self) -> None:
        self.mono, self.wall = 1000 * S, 1_700_000_000 * S

    def go(self, seconds: float) -> None:
        self.mono += round(seconds * S)
        self.wall += round(seconds * S)


def clock(hands):
    return Clock("here", lambda: hands.mono, lambda: hands.wall)


def test_a_clock_that_jumps_moves_nothing_within_a_file():
    hands = Hands()
    ours = clock(hands)
    before = ours.dated(ours.sent_ns("here", hands.mono - S))
    hands.go(1)
    assert ours.look() == 0
    hands.wall -= 3600 * S
    hands.go(1)
    assert ours.dated(hands.mono) - before == 3 * S
    assert ours.look() == -3600 * S
    assert ours.look() == 0
    assert abs(ours.dated(hands.mono) - hands.wall) < 1000
    assert not ours.is_steady
    hands.go(601)
    ours.look()
    assert ours.is_steady


@given(st.lists(st.tuples(st.sampled_from(["here", "there", ""]), st.integers(-(2**70), 2**70)), max_size=20))
def test_no_stamp_dates_a_message_into_the_future_or_beyond_what_a_file_holds(stamps):
    hands = Hands()
    ours = clock(hands)
    for boot, mono in stamps:
        sent = ours.sent_ns(boot, mono)
        assert sent <= hands.mono
        assert 0 <= ours.dated(sent) <= MOST_NS


def test_a_message_of_another_machine_is_dated_by_the_quickest_that_came_from_there():
    hands = Hands()
    ours = clock(hands)
    away = 77 * S
    assert ours.sent_ns("there", hands.mono - away - S) == hands.mono
    hands.go(1)
    ours.look()
    assert ours.sent_ns("there", hands.mono - away) == hands.mono
    assert ours.sent_ns("there", hands.mono - away - S // 2) == hands.mono - S // 2


def happened(kind, subject="drive"):
    return Event(kind=kind, subject=subject, text="because")


def test_what_led_to_an_incident_is_kept_once_and_other_events_are_not():
    keeping = Keeping(60.0, 20.0)
    assert keeping.event(happened("ready"), 0.0, S) is None
    first = keeping.event(happened("crashed"), 0.0, S)
    assert first is not None
    assert keeping.event(happened("crashed"), 10.0, 11 * S) is first
    assert (first.why.again, first.until) == (1, 30.0)
    assert keeping.event(happened("crashed", "motors"), 10.0, 11 * S) is not first
    later = keeping.event(happened("crashed"), 200.0, 201 * S)
    assert later is not None
    assert later.name != first.name


def test_what_happens_again_and_again_does_not_push_out_what_happened_once_but_marks_are_people():
    keeping = Keeping(60.0, 20.0)
    kept = [keeping.event(happened("fault"), n * 100.0, n * 100 * S) for n in range(MOST_OF_ONE + 3)]
    assert [one is not None for one in kept] == [True] * MOST_OF_ONE + [False] * 3
    assert all(keeping.incident(MARK, "", "x", n * 100.0, n * 100 * S) for n in range(20))


def test_lines_of_logs_come_once_each_also_when_a_log_is_cut(tmp_path):
    log = tmp_path / "lbr-drive.log"
    log.write_text("before\n")
    (tmp_path / "other-drive.log").write_text("")
    logs = Logs(tmp_path, "lbr")
    with log.open("a") as file:
        file.write("one\ntwo and ")
    (tmp_path / "other-drive.log").write_text("not ours\n")
    (tmp_path / "siren.log").write_text("a program\n")
    assert sorted(logs.take(["siren"])) == [("drive", "one"), ("siren", "a program")]
    with log.open("a") as file:
        file.write("a half\n")
    assert list(logs.take(["siren"])) == [("drive", "two and a half")]
    log.write_text("new\n")
    assert list(logs.take(["siren"])) == [("drive", "new")]


LIMITED = """
import resource, sys, time
from pathlib import Path
from lbr.apps.recorder.box.disk import Bounds, BoxDisk, Chunk, Disk
from lbr.apps.recorder.recording import chunks
from lbr.apps.recorder.recording.chunks import Channel, Channels
from lbr.apps.recorder.recording.shelf import Shelf

shelf = Shelf(Path(sys.argv[1]), "lbr")
bounds = Bounds(bytes=10**9, seconds=1e9, kept_bytes=0, kept_seconds=1e9, free_bytes=0)
one = Path(sys.argv[1], "one.mcap")
disk = BoxDisk(shelf, bounds, "a test") if sys.argv[2] == "box" else Disk(lambda: one, "a test")
channels = Channels()
number = channels.number(Channel("drive/state"))
limit = (20_000, resource.getrlimit(resource.RLIMIT_FSIZE)[1])

def put(n, begin):
    import os
    parts = [channels.of([number]), chunks.message(number, n, n, n, os.urandom(3000))]
    done = disk.messages + disk.lost
    disk.put(Chunk(parts, 1, 3000, n, n, {"robot": "lbr"} if begin else None))
    while disk.messages + disk.lost == done:
        time.sleep(0.001)

resource.setrlimit(resource.RLIMIT_FSIZE, limit if sys.argv[3] == "later" else (0, limit[1]))
for n in range(1, 13):
    put(n, n == 1)
print("lost", disk.lost, disk.trouble)
resource.setrlimit(resource.RLIMIT_FSIZE, (limit[1], limit[1]))
for n in range(13, 17):
    put(n, disk.broken)
print("now", disk.lost, disk.trouble)
disk.close(5.0)
"""


@pytest.mark.parametrize("whose", ["box", "on purpose"])
@pytest.mark.parametrize("full", ["later", "from the beginning"])
def test_a_disk_that_takes_nothing_is_told_of_costs_nothing_written_and_is_used_again_once_it_does(
    tmp_path, whose, full
):
    done = programs.run(
        [sys.executable, "-c", LIMITED, str(tmp_path), whose, full],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=30,
    )
    first, second = done.stdout.splitlines()
    lost = int(first.split()[1])
    assert 3 <= lost <= 8 if full == "later" else lost == 12
    assert "nothing is recorded" in first
    assert second.split() == ["now", str(lost)]
    damage = selection.Damage()
    files = Shelf(tmp_path, "lbr").files() if whose == "box" else [tmp_path / "one.mcap"]
    read = [one.sequence for one in selection.messages(files, damage=damage)]
    assert read == [*range(1, 13 - lost), *range(13, 17)]
    assert damage.places == 0


def test_a_disk_that_is_too_slow_costs_messages_and_no_time(tmp_path, monkeypatch):
    import threading

    let_go = threading.Event()
    monkeypatch.setattr("os.fdatasync", lambda _fd: let_go.wait(5.0))
    disk = Disk(lambda: tmp_path / "one.mcap", "a test")
    channels = Channels()
    number = channels.number(Channel("drive/state"))
    part = chunks.message(number, 1, 1, 1, b"x")
    taken = [disk.put(Chunk([part], 1, 6_000_000, 1, 1, {"robot": "lbr"} if n == 0 else None)) for n in range(6)]
    assert taken[:2] == [True, True]
    assert taken[-1] is False
    assert "too slow" in disk.trouble
    assert disk.lost == taken.count(False)
    let_go.set()
    until(lambda: disk.messages == taken.count(True), what="what waited is written")
    disk.close(5.0)


LACKING = """
import sys
sys.modules["zstandard"] = None
from lbr.apps.recorder.box.kind import KIND
from lbr.apps.recorder.box.start import Box
from lbr.errors import DeviceError
from lbr.testing.context import FakeContext

try:
    Box(FakeContext(KIND)).open()
except DeviceError as err:
    print(err)
"""


def test_where_its_packages_are_missing_it_is_degraded_and_says_what_to_install():
    done = programs.run([sys.executable, "-c", LACKING], stdout=subprocess.PIPE, text=True, check=True, timeout=30)
    assert "'zstandard' is not installed, so nothing is recorded" in done.stdout


def test_a_box_that_leaves_no_room_to_others_gives_up_its_oldest_files_and_then_says_so(tmp_path, monkeypatch):
    import os
    from types import SimpleNamespace

    from lbr.apps.recorder.box.disk import Bounds

    place = Shelf(tmp_path, "lbr")
    place.make()
    for _ in range(3):
        place.next_file().write_bytes(b"x")
    monkeypatch.setattr(os, "statvfs", lambda _path: SimpleNamespace(f_bavail=10, f_frsize=1_000_000, f_blocks=100_000))
    bounds = Bounds(bytes=10**9, seconds=1e9, kept_bytes=0, kept_seconds=1e9, free_bytes=200_000_000)
    disk = BoxDisk(place, bounds, "a test")
    number = Channels().number(Channel("drive/state"))
    disk.put(Chunk([chunks.message(number, 1, 1, 1, b"{}")], 1, 2, 1, 1, {"robot": "lbr"}))
    until(lambda: disk.lost == 1, what="the message is given up")
    assert "10 MB are free, and 200 are left to others" in disk.trouble
    assert len(place.files()) == 1
    disk.close(5.0)
