"""What a clumsy hand says: an empty name, a wrong profile, a file for a folder, a folder that is gone, Ctrl-C too early."""

import importlib
import runpy
import sys
from pathlib import Path
from typing import Any

import pytest

from lbr import home, surroundings
from lbr.cli import cli
from lbr.console import target
from lbr.errors import BusError, InputError
from lbr.executive.service import latch
from lbr.executive.service.latch import LONGEST_REASON
from tests.support import databases


def invoked(*arguments: str) -> Any:
    return cli.main(args=list(arguments), standalone_mode=False)


def test_an_empty_name_is_a_name(monkeypatch: pytest.MonkeyPatch) -> None:
    only = home.Running(
        robot="lbr", pid=1, profile="lbr-sim", database="", endpoints=("unixsock-stream//x",), core="", password=""
    )
    monkeypatch.setattr(home, "running", lambda: [only])
    with pytest.raises(BusError, match=r"robot '' does not run here \(lbr runs here\)"):
        target.find("", None)


@pytest.mark.parametrize("robot", ["nobody", ""])
def test_a_robot_that_is_not_there_has_no_graph(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, robot: str) -> None:
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    databases.fresh(tmp_path / "robot.db")
    with pytest.raises(InputError, match=f"there is no robot '{robot}' in .*: bioloid, lbr, uxa90"):
        invoked("graph", "--robot", robot)


def test_a_wrong_profile_is_told_before_the_console_that_it_would_lack(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("forget_runtime", "bound_heaps", "need_room_for_a_robot"):
        monkeypatch.setattr(surroundings, name, lambda: None)
    monkeypatch.setattr(home, "begin", lambda: None)
    monkeypatch.setattr(surroundings, "_at_end", lambda _fd: True)
    monkeypatch.setattr(surroundings, "can_write", lambda _fd: True)
    with pytest.raises(InputError, match="no launch profile 'nope'"):
        invoked("run", "nope")


@pytest.mark.parametrize(("option", "of", "said"), [("--csv", "file", "no folder"), ("--mcap", "folder", "a folder")])
@pytest.mark.parametrize("more", [(), ("--force",)])
def test_a_file_is_no_folder_and_a_folder_no_file(
    tmp_path: Path, option: str, of: str, said: str, more: tuple[str, ...]
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=f"is {said}"):
        invoked("box", "export", option, str(tmp_path / of), *more)


def test_a_relative_home_in_a_folder_that_is_gone_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, wording
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    monkeypatch.setenv("LBR_HOME", "relative")
    with wording.of(InputError):
        home.home()


def test_an_interrupt_while_mujoco_begins_is_an_interrupt(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_name: str) -> None:
        raise ImportError("initialization failed") from KeyboardInterrupt()

    monkeypatch.setattr(importlib, "import_module", interrupted)
    monkeypatch.delitem(sys.modules, "lbr.simulation.physics", raising=False)
    with pytest.raises(KeyboardInterrupt):
        runpy.run_module("lbr.simulation.physics")


@pytest.mark.parametrize("written", [b"\0\x1b[2J\xff" * 700_000, b"a\0b", "é€".encode() * 600])
def test_whatever_the_file_of_the_latch_holds_its_reason_is_one_short_line_that_a_row_takes(
    tmp_path: Path, written: bytes
) -> None:
    (tmp_path / "lbr.estop").write_bytes(written)
    reason = latch.read(tmp_path / "lbr.estop")
    assert reason
    assert reason.isprintable()
    assert len(reason) <= LONGEST_REASON


def test_the_longest_reason_is_read_as_it_was_written(tmp_path: Path) -> None:
    latch.write(tmp_path / "lbr.estop", "€" * LONGEST_REASON)
    assert latch.read(tmp_path / "lbr.estop") == "€" * LONGEST_REASON
