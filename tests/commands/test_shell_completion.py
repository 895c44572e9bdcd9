"""Tab in a real bash, with a robot that runs and without one; what was mistyped; the page of the manual."""

import shutil
import sys
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.robot import LBR, environment, prepare, running
from tests.support.waiting import HANG_S

ROOT = Path(__file__).resolve().parents[2]
TAB = """
compopt() { :; }  # is only there while a key is pressed
eval "$(lbr completion bash)"
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_lbr_completion lbr
printf '%s\\n' "${COMPREPLY[@]}"
"""


def tab(home: Path, *words: str) -> list[str]:
    """Return what bash offers after these words; the last is the one that is begun."""
    path = f"{Path(sys.executable).parent}:/usr/bin:/bin"
    command = ["bash", "-c", TAB, "bash", "lbr", *words]
    done = programs.run(command, env=environment(home) | {"PATH": path}, capture_output=True, text=True, timeout=HANG_S)
    assert done.stderr == ""
    return done.stdout.split()


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    home = prepare(tmp_path_factory.mktemp("home") / "h")
    with running(home):
        yield home


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (("sta",), {"status"}),
        (("run", "uxa90-"), {"uxa90-sim"}),
        (("topic", "echo", "drive/st"), {"drive/state", "drive/stop"}),
        (("plot", "motors/state.le"), {"motors/state.left"}),
        (("send", "/repor"), {"/report/"}),
        (("send", "/report/ev"), {"/report/events"}),
        (("status", "--robot", ""), {"lbr"}),
        (("motion", "export", "walk_b"), {"walk_back"}),
        (("why", "mot"), {"motors"}),
        (("set", "drive.max_p"), {"drive.max_power"}),
        (("get", "mo"), {"motors."}),
        (("get", "driv"), {"drive.max_power", "drive.ttl_s"}),
        (("logs", "lbr/ran"), {"lbr/ranges"}),
        (("logs", "lbr/dri"), {"lbr/drive"}),
    ],
)  # fmt: skip
def test_the_tab_key_offers_what_there_is(home, words, offered):
    assert offered <= set(tab(home, *words))


@pytest.mark.parametrize(
    "words", [("topic", "echo", "d"), ("plot", "d"), ("send", "/r"), ("box", "show", ""), ("token", "revoke", "x")]
)
def test_where_nothing_runs_nothing_is_offered_and_nothing_is_said(tmp_path, words):
    assert tab(tmp_path, *words) == []


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_read_what_is_printed_for_them(home, shell):
    where = shutil.which(shell)
    done = programs.run([*LBR, "completion", shell], capture_output=True, text=True, check=True)
    assert "lbr" in done.stdout
    if where is None:
        pytest.skip(f"{shell} is not here")
    read = programs.run([where, "-n"], input=done.stdout, capture_output=True, text=True)
    assert (read.returncode, read.stderr) == (0, "")


@pytest.mark.parametrize(
    ("typed", "meant"), [(("sttaus",), "status"), (("topic", "lsit"), "list"), (("db", "histroy"), "history")]
)
def test_a_mistyped_command_is_answered_with_the_one_that_was_meant(tmp_path, typed, meant):
    done = programs.run([*LBR, *typed], env=environment(tmp_path), capture_output=True, text=True)
    assert (done.returncode, done.stderr.count(f"Did you mean '{meant}'?")) == (2, 1)


def test_run_names_the_profiles_in_its_help(tmp_path):
    done = programs.run([*LBR, "run", "--help"], env=environment(tmp_path), capture_output=True, text=True, check=True)
    assert "uxa90, uxa90-sim" in done.stdout


@pytest.mark.skipif(shutil.which("groff") is None, reason="groff is not here")
def test_the_page_of_the_manual_is_one():
    page = ROOT / "docs" / "reference" / "lbr.1"
    done = programs.run(["groff", "-man", "-Tutf8", "-ww", str(page)], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert "lbr topic echo" in done.stdout.lower()
