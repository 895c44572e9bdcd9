"""A picture becomes a file of its owner's alone, or a sentence that says why not; never half a file."""

import errno
import io
import os
import re
import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability import picture_files
from lbr.errors import InputError


def test_a_picture_is_a_new_file_that_its_owner_alone_reads(tmp_path, wording):
    path = picture_files.save(str(tmp_path), "front-1", b"JPEG")
    assert (path, path.read_bytes()) == (tmp_path / "pictures" / "front-1.jpg", b"JPEG")
    assert [stat.S_IMODE(one.stat().st_mode) for one in (path, path.parent)] == [0o600, 0o700]
    with wording.of(InputError):
        picture_files.save(str(tmp_path), "front-1", b"other")
    assert path.read_bytes() == b"JPEG"


@given(st.text(max_size=90))
def test_no_name_leads_out_of_the_folder_or_hides_in_it(name):
    if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}", name):
        return
    with pytest.raises(InputError) as caught:
        picture_files.save("/nowhere", name, b"")
    assert caught.value.code == "bad_value"


@pytest.mark.parametrize("name", ["a\n", "../up", ".hidden", "", "a/b", "ä", "a" * 81, "-x"])
def test_a_name_that_is_none_writes_nothing(tmp_path, name, wording):
    with wording.of(InputError):
        picture_files.save(str(tmp_path), name, b"")
    assert list(tmp_path.iterdir()) == []


def test_a_link_in_its_place_is_not_followed(tmp_path):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "a.jpg").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="is there already"):
        picture_files.save(str(tmp_path), "a", b"JPEG")
    assert not (tmp_path / "elsewhere").exists()


def test_a_disk_that_fills_up_leaves_no_half_picture_and_the_name_free(tmp_path, monkeypatch):
    class Full(io.FileIO):
        def write(self, data: bytes) -> int:  # type: ignore[override]
            super().write(data[: len(data) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as full:
        full.setattr(picture_files.os, "fdopen", lambda fd, _mode: Full(fd, "wb"))
        with pytest.raises(InputError, match=r"a\.jpg cannot be written \(No space left on device\); check the disk"):
            picture_files.save(str(tmp_path), "a", b"JPEG")
    assert list((tmp_path / "pictures").iterdir()) == []
    assert picture_files.save(str(tmp_path), "a", b"JPEG").read_bytes() == b"JPEG"


def test_an_almost_full_disk_takes_no_picture(tmp_path, monkeypatch, wording):
    monkeypatch.setattr(picture_files, "KEPT_FREE_BYTES", 1 << 80)
    with wording.of(InputError):
        picture_files.save(str(tmp_path), "a", b"JPEG")
    assert list((tmp_path / "pictures").iterdir()) == []


def test_a_file_where_the_folder_belongs_is_told(tmp_path):
    (tmp_path / "pictures").touch()
    with pytest.raises(InputError, match="pictures"):
        picture_files.save(str(tmp_path), "a", b"JPEG")


@given(st.floats(0.0, 4e9))
def test_a_name_made_of_the_time_is_a_name(at):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(picture_files.time, "time", lambda: at)
        name = picture_files.name_now("front_camera")
    assert re.fullmatch(r"front_camera-\d{8}-\d{6}-\d{3}", name)
    assert Path(f"{name}.jpg").name == f"{name}.jpg"


def test_pictures_without_a_name_in_the_same_millisecond_are_all_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(picture_files.time, "time", lambda: 1e9)
    paths = [picture_files.save_now(str(tmp_path), "front", picture) for picture in (b"1", b"2", b"3")]
    assert [path.read_bytes() for path in paths] == [b"1", b"2", b"3"]
    assert [path.stem.removeprefix(paths[0].stem) for path in paths] == ["", "-2", "-3"]
