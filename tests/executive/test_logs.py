"""Logs stay small while somebody writes to them."""

import os

import pytest

from lbr.errors import InputError
from lbr.executive.processes import logs


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


def test_what_is_not_a_file_is_no_log_and_nothing_waits_for_its_reader(tmp_path):
    path = tmp_path / "a.log"
    os.mkfifo(path)
    with pytest.raises(InputError, match="is not a file"):
        logs.open_log(path)
