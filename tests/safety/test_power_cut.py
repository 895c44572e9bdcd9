"""A power cut loses no acknowledged row, no latch, and little of what the black box had heard."""

import os
import random

import pytest

from tests.scenarios.cuts import cut
from tests.support import cut_disk
from tests.support.figures import Results

pytestmark = [
    pytest.mark.timeout(90),
    pytest.mark.skipif(not cut_disk.possible(), reason=f"a disk whose power can be cut needs {cut_disk.NEEDS}"),
]


def test_a_power_cut_loses_no_acknowledged_row_and_little_of_the_black_box():
    found = cut(Results({}), 3.0, random.Random())
    assert not found.wrong
    assert found.edits > 5
    assert found.older > 100
    assert found.gone <= 0.02 * found.older, found


def test_the_disk_of_these_tests_loses_what_was_not_synced(tmp_path):
    with cut_disk.cut_disk(tmp_path) as disk:
        for name in ("synced", "not"):
            with (disk.at / name).open("wb") as file:
                file.write(b"whole")
                file.flush()
                if name == "synced":
                    os.fsync(file.fileno())
        disk.cut()
        with pytest.raises(OSError, match="error"):
            (disk.at / "later").write_bytes(b"x")
        disk.back()
        assert (disk.at / "synced").read_bytes() == b"whole"
        assert not (disk.at / "not").exists() or (disk.at / "not").read_bytes() != b"whole"
