"""The folders of recordings: bounded by size and age, oldest out first; what is kept stays."""

import os
import time

from lbr.apps.recorder.recording.segments import Segment
from lbr.apps.recorder.recording.shelf import Incident, Shelf, robots, size_of

WHY = Incident(kind="estop", subject="executive", text="pressed", wall_ns=time.time_ns())


def filled(place, count, size=1000):
    place.make()
    paths = []
    for _ in range(count):
        path = place.next_file()
        path.write_bytes(b"x" * size)
        paths.append(path)
    return paths


def test_the_oldest_go_first_whatever_their_times_say_and_the_newest_stays(tmp_path):
    place = Shelf(tmp_path, "lbr")
    paths = filled(place, 5)
    os.utime(paths[0], (4e9, 4e9))  # a clock that stood in the future
    assert place.prune(2500, 1e9, 0.0) == 3
    assert place.files() == paths[3:]
    assert place.prune(0, 1e9, 0.0) == 1
    assert place.files() == paths[4:]


def test_what_is_too_old_goes_only_while_the_clock_can_be_trusted(tmp_path):
    place = Shelf(tmp_path, "lbr")
    paths = filled(place, 3)
    for path in paths[:2]:
        os.utime(path, (1000.0, 1000.0))
    assert place.prune(10**9, 3600.0, 0.0) == 0
    assert place.prune(10**9, 3600.0, time.time()) == 2
    assert place.files() == paths[2:]


def test_what_is_kept_outlives_the_box_and_takes_no_more_room(tmp_path):
    place = Shelf(tmp_path, "lbr")
    paths = filled(place, 3)
    place.keep("one", WHY, paths[:2])
    place.keep("two", WHY, paths[1:])
    assert size_of({*paths, *(path for one in place.incidents() for path in one.files)}) == 3000
    place.prune(0, 0.0, 1e12)
    first, second = place.incidents()
    assert [path.name for path in first.files] == [path.name for path in paths[:2]]
    assert first.why == WHY
    assert place.prune_kept(2000, 1e12, 0.0) == ["one"]
    assert [one.path.name for one in place.incidents()] == ["two"]
    assert len(second.files) == 2


def test_a_file_that_is_being_written_is_not_deleted(tmp_path):
    place = Shelf(tmp_path, "lbr")
    place.make()
    segment = Segment(place.next_file(), "a test", {})
    assert not place.delete(segment.path)
    segment.finish()
    assert place.delete(segment.path)
    assert robots(tmp_path) == ["lbr"]


def test_why_something_was_kept_may_be_unreadable(tmp_path):
    place = Shelf(tmp_path, "lbr")
    place.keep("one", WHY, filled(place, 1))
    (place.kept_folder / "one" / "incident.json").write_bytes(b'{"text": "\xff"}')
    assert place.incidents()[0].why is None
    assert place.prune_kept(0, 0.0, 0.0) == []
