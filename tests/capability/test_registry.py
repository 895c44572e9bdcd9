"""Kinds are found by name, among the installed ones and the user's own files, and nothing else is ever imported."""

import os

import pytest

from lbr.capability import registry
from lbr.capability.kind import KindError

OWN = (
    'from lbr.capability import Capability, Kind\nKIND = Kind(name="own", summary="", family="app", entry=Capability)\n'
)


@pytest.fixture
def folder(tmp_path):
    made = registry.user_directory(tmp_path)
    made.mkdir(mode=0o700)
    return made


def test_the_built_in_kinds_are_installed_like_any_other(tmp_path):
    assert {"drive", "exec", "roboteq", "ultrasonic_ring", "world"} <= set(registry.names(tmp_path))
    assert registry.find("drive", tmp_path).moves


def test_a_file_of_ones_own_is_a_kind_and_an_edit_of_it_is_seen(folder, tmp_path):
    (folder / "own.py").write_text(OWN)
    assert registry.find("own", tmp_path).summary == ""
    before = registry.fingerprint("own", tmp_path)
    (folder / "own.py").write_text(OWN.replace('summary=""', 'summary="new"'))
    assert registry.fingerprint("own", tmp_path) != before
    assert registry.find("own", tmp_path).summary == "new"


def test_a_copy_on_another_machine_is_the_same_file_and_one_of_the_same_length_is_not(folder, tmp_path):
    (folder / "own.py").write_text(OWN + "# 0.3")
    here = registry.fingerprint("own", tmp_path)
    os.utime(folder / "own.py", (1, 1))
    assert registry.same_content(registry.fingerprint("own", tmp_path), here)
    (folder / "own.py").write_text(OWN + "# 0.5")
    assert not registry.same_content(registry.fingerprint("own", tmp_path), here)
    (folder / "own.py").unlink()
    assert not registry.same_content(registry.fingerprint("own", tmp_path), here)
    assert registry.same_content("", registry.fingerprint("drive", tmp_path))


@pytest.mark.parametrize(
    "name", ["os.system", "../own", "os:system", "own.KIND", "__import__", "Own", "", "x" * 41, "\u043ewn"]
)
def test_a_name_that_is_code_or_a_path_is_refused_and_imports_nothing(folder, tmp_path, name):
    (folder.parent / "own.py").write_text("raise AssertionError('imported')")
    with pytest.raises(KindError, match="is not a kind's name"):
        registry.find(name, tmp_path)


def test_an_unknown_kind_is_told_what_there_is(tmp_path):
    with pytest.raises(KindError, match=r"hovercraft.*attitude, .*camera"):
        registry.find("hovercraft", tmp_path)


@pytest.mark.parametrize("place", ["file", "folder"])
def test_a_file_that_others_may_change_is_never_loaded(folder, tmp_path, place, wording):
    (folder / "own.py").write_text("raise AssertionError('imported')")
    (folder / "own.py" if place == "file" else folder).chmod(0o777)
    with wording.of(KindError):
        registry.find("own", tmp_path)


def test_a_link_to_where_others_may_put_another_file_is_refused(folder, tmp_path, wording):
    loose = tmp_path / "loose"
    loose.mkdir()
    (loose / "own.py").write_text(OWN)
    (loose / "own.py").chmod(0o600)
    (folder / "own.py").symlink_to(loose / "own.py")
    loose.chmod(0o777)
    with wording.of(KindError):
        registry.find("own", tmp_path)
    loose.chmod(0o700)
    assert registry.find("own", tmp_path).name == "own"
