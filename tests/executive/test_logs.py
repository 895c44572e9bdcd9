"""Logs stay small while somebody writes to them."""

import os
import re

import pytest

from lbr.errors import InputError
from lbr.executive.processes import logs
from lbr.messages.system import Event


def test_a_log_that_grows_is_cut_under_its_writer_and_its_end_is_kept(tmp_path):
    path = tmp_path / "a.log"
    with logs.open_log(path) as log:
        for n in range(30_000):
            log.write(b"%07d %s\n" % (n, b"x" * 90))
        logs.trim_all(tmp_path)
        log.write(b"afterwards\n")
    assert path.read_bytes() == logs.CUT + b"afterwards\n"
    kept = path.with_suffix(".old.log").read_bytes()
    assert kept.endswith(b"0029999 " + b"x" * 90 + b"\n")
    assert len(kept) <= logs.KEPT_BYTES


def test_a_small_log_and_an_old_one_are_left_alone(tmp_path):
    (tmp_path / "a.log").write_bytes(b"small")
    old = tmp_path / "a.old.log"
    old.write_bytes(b"")
    os.truncate(old, logs.LIMIT_BYTES + 1)
    logs.trim_all(tmp_path)
    assert (tmp_path / "a.log").read_bytes() == b"small"
    assert old.stat().st_size == logs.LIMIT_BYTES + 1


def test_an_event_stands_in_the_log_of_its_part_after_what_was_written_before_it(tmp_path):
    def log_of(subject: str) -> str:
        return {"motors": "rob-base.log", "drive": "rob-base.log"}.get(subject, "")

    def event(kind: str, subject: str, text: str) -> Event:
        return Event(kind=kind, subject=subject, text=text, wall_ns=1_700_000_000_000_000_000)

    log = tmp_path / "rob-base.log"
    with logs.open_log(log) as writer:
        writer.write(b"Traceback\n")
        logs.add(tmp_path, [event("crashed", "motors", "it\nended"), event("run", "nobody", "x")], log_of)
        writer.write(b"again\n")
    logs.add(tmp_path, [event("ready", "drive", "it is up")], log_of)
    first, crashed, again, ready = log.read_text().splitlines()
    assert (first, again) == ("Traceback", "again")
    assert crashed.endswith(" motors crashed: it ended")
    assert ready.endswith(" drive ready: it is up")
    assert re.match(r"2023-11-1\d \d\d:\d\d:\d\d ", crashed)
    assert [one.name for one in tmp_path.iterdir()] == [log.name]


def test_a_log_that_cannot_be_written_keeps_no_event_from_the_others(tmp_path):
    os.mkfifo(tmp_path / "motors.log")
    happened = [Event(kind="ready", subject=name, text="up", wall_ns=1) for name in ("motors", "drive")]
    logs.add(tmp_path, happened, "{}.log".format)
    assert (tmp_path / "drive.log").read_text().endswith("drive ready: up\n")


def test_what_is_not_a_file_is_no_log_and_nothing_waits_for_its_reader(tmp_path):
    path = tmp_path / "a.log"
    os.mkfifo(path)
    with pytest.raises(InputError, match="is not a file"):
        logs.open_log(path)
