"""The `lbr` command with no robot running, as a shell sees it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from lbr import cli
from tests.support import programs
from tests.support.waiting import HANG_S

LBR = Path(sys.executable).with_name("lbr")


@pytest.fixture
def lbr(tmp_path):
    def run(*arguments: str, **options) -> "subprocess.CompletedProcess[str]":
        environment = os.environ | {"LBR_HOME": str(tmp_path / "home")}
        return programs.run(
            [str(LBR), *arguments],
            env=environment,
            capture_output=True,
            text=True,
            timeout=HANG_S,
            check=False,
            **options,
        )

    return run


@pytest.fixture
def here(tmp_path, monkeypatch, capsys):
    """Run a command in this process, which has imported already what each needs; `lbr` is a program of its own."""
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))

    def run(*arguments: str) -> "subprocess.CompletedProcess[str]":
        code = cli.main([*arguments])
        return subprocess.CompletedProcess(arguments, code, *capsys.readouterr())

    return run


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["status"], 1, "no robot runs here"),
        (["send", "s"], 1, "no robot runs here"),
        (["stop"], 1, "no robot runs here"),
        (["topic", "list"], 1, "no robot runs here"),
        (["view"], 1, "no robot runs here"),
        (["console", "--robot", "nobody"], 1, "robot 'nobody' does not run here"),
        (["send", "!1 + 1"], 2, "own console only"),
        (["send", "a\x1bb"], 2, "control character U+001B"),
        (["send"], 2, "Missing argument"),
        (["send", "s", "--hold", "900"], 2, "--hold"),
        (["send", ""], 2, "there is nothing to send"),
        (["send", " ", ""], 2, "there is nothing to send"),
        (["nonsense"], 2, "nonsense"),
        (["db", "check"], 2, "'lbr db init' makes one"),
        (["graph"], 2, "'lbr db init' makes one"),
        (["status", "--connect", "nonsense"], 1, "cannot reach a robot at nonsense"),
        (["status", "--connect", "unixsock-stream//tmp/lbr-nobody-listens"], 1, "cannot reach a robot"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_an_exit_code(here, arguments, code, said):
    refused(here(*arguments), code, said)


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["status"], 1, "no robot runs here"),
        (["run", "nothing", "--no-console"], 2, "profile 'nothing'"),
    ],
)
def test_a_program_says_so_and_ends_with_that_code(lbr, arguments, code, said):
    refused(lbr(*arguments), code, said)


def refused(done, code, said):
    assert done.returncode == code
    assert said in done.stderr
    assert done.stderr.startswith("lbr: ")
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""


def test_logs_of_a_robot_that_is_not_there_are_refused_with_those_that_are(here, tmp_path, wording):
    for name in ("lbr-base", "bioloid-servos"):
        log = tmp_path / "home" / "logs" / f"{name}.log"
        log.parent.mkdir(parents=True, exist_ok=True)
        log.write_text("said\n")
    done = here("logs", "--robot", "bioliod")
    assert done.returncode == 2
    wording(done.stderr)
    assert here("logs", "--robot", "bioloid").stdout.startswith("bioloid/servos")


def test_help_and_version_work_without_a_home(lbr):
    assert "Exit codes: 0 done" in lbr("--help").stdout
    assert lbr("--version").stdout.startswith("lbr ")


@pytest.mark.parametrize(
    "command",
    ["run", "console", "send", "status", "stop", "doctor", "service", "topic", "graph", "view", "db", "robots"],
)
def test_every_command_has_help(here, command):
    done = here(command, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith(f"Usage: lbr {command}")


@pytest.mark.parametrize("command", [[], ["topic"], ["db"]])
def test_a_group_without_a_command_prints_its_help(here, command):
    done = here(*command)
    assert done.stdout == here(*command, "--help").stdout
    assert (done.returncode, done.stderr) == (0, "")


def test_rows_are_made_once_checked_compared_and_drawn(here):
    assert here("db", "init").returncode == 0
    assert here("db", "init").returncode == 2
    assert here("db", "check").stdout == "bioloid: good\nlbr: good\nuxa90: good\n"
    assert here("db", "diff").stdout == "the rows are as shipped\n"
    graph = json.loads(here("graph", "--robot", "lbr", "--json").stdout)
    assert {"source": "drive.setpoint", "target": "motors.setpoint", "enabled": True, "rate_hz": None} in graph["edges"]


def test_the_doctor_runs_without_a_robot(here):
    findings = json.loads(here("doctor", "--json").stdout)
    assert {"python", "home", "bus", "database"} <= {finding["about"] for finding in findings}


def test_a_reader_that_leaves_early_is_no_error(lbr):
    done = programs.run(
        ["sh", "-c", f"{LBR} --help | true"], capture_output=True, text=True, timeout=HANG_S, check=False
    )
    assert done.stderr == ""


def test_starting_is_light():
    heavy = ["sqlalchemy", "mujoco", "numpy", "prompt_toolkit", "rich", "zenoh", "lbr.executive"]
    code = f"import sys, lbr.cli; print([name for name in {heavy} if name in sys.modules])"
    done = programs.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANG_S, check=True)
    assert done.stdout.strip() == "[]"


def test_where_no_thread_may_be_started_one_line_says_so(monkeypatch, capsys):
    def refused(*_arguments, **_options):
        raise RuntimeError(cli.NO_THREAD)

    monkeypatch.setattr(cli.cli, "main", refused)
    assert cli.main(["status"]) == cli.FAILED
    assert "ulimit -u" in capsys.readouterr().err
