"""Programs by name: which one a row means, and where what it prints goes."""

import select
import sys
from contextlib import closing

import pytest

from lbr.bus.stamp import Origin
from lbr.database.rows import ExternalCommandRow
from lbr.executive.processes import external
from lbr.executive.processes.external import ExternalCommands
from lbr.executive.processes.reaper import Reaper
from tests.support.waiting import HANG_S, until


@pytest.fixture
def commands(tmp_path):
    with closing(Reaper()) as reaper, closing(ExternalCommands(tmp_path, "lbr", reaper)) as external:
        yield external


def said(commands: ExternalCommands, *argv: str, arguments: tuple[str, ...] = ()) -> tuple[int, str]:
    row = ExternalCommandRow(name="probe", argv=argv, blocking=True)
    return commands.wait(row, commands.start(row, arguments, LINE, 3.5))


LINE = Origin("ann", 1.5)


def test_python_is_the_interpreter_that_the_robot_runs_on(commands):
    script = "import sys; print(sys.executable, sys.argv[1:])"
    assert said(commands, "python", "-c", script, arguments=("left",)) == (0, f"{sys.executable} ['left']")


def test_what_a_blocking_program_said_before_it_took_too_long_is_shown(commands, monkeypatch):
    monkeypatch.setattr(external, "BLOCKING_LIMIT_S", 1.0)
    ended = "'probe' took longer than 1 s and was ended"
    assert said(commands, "/bin/sleep", "60") == (1, ended)
    row = ExternalCommandRow(name="probe", argv=("/bin/sh", "-c", "echo 'which port?'; exec sleep 60"), blocking=True)
    command = commands.start(row, (), LINE, 3.5)
    assert select.select([command.popen.stdout], [], [], HANG_S)[0]
    assert commands.wait(row, command) == (1, f"which port?\n{ended}")


def test_python_finds_no_module_where_the_robot_happened_to_be_started(commands, tmp_path, monkeypatch):
    (tmp_path / "lbr.py").write_text("raise SystemExit(7)")
    monkeypatch.chdir(tmp_path)
    code, text = said(commands, "python", "-c", "import lbr; print(lbr.__file__)")
    assert code == 0
    assert text.endswith("lbr/__init__.py")


def test_a_program_by_its_path_is_started_as_it_is(commands):
    assert said(commands, "/bin/echo", "python") == (0, "python")


def test_a_program_learns_which_robot_called_it_and_by_which_name(commands):
    script = "import os; print(os.environ['LBR_ROBOT'], os.environ['LBR_NAME'])"
    assert said(commands, "python", "-c", script) == (0, "lbr probe")


def test_a_program_learns_whose_line_it_is_and_its_dates_so_that_it_knows_which_stops_are_for_it(commands):
    names = ("LBR_ASKED_BY", "LBR_WRITTEN_S", "LBR_STARTED_S")
    _code, text = said(commands, "python", "-c", f"import os; print(*(os.environ[name] for name in {names}))")
    assert text.split() == ["ann", "1.5", "3.5"]


def test_a_program_has_no_privileges_and_gains_none(commands):
    script = "print(open('/proc/self/status').read())"
    _code, text = said(commands, "python", "-c", script)
    status = dict(line.split(":\t", 1) for line in text.splitlines() if ":\t" in line)
    assert (status["CapEff"], status["NoNewPrivs"], status["Umask"]) == ("0" * 16, "1", "0077")


def test_a_program_whose_row_is_gone_is_asked_to_end_once_and_has_its_time_for_it(commands, tmp_path, monkeypatch):
    monkeypatch.setattr(external, "STOP_S", HANG_S)
    script = (
        "import signal, sys, time; asked = []\n"
        "signal.signal(signal.SIGTERM, lambda *_: asked.append(time.monotonic()))\n"
        "print('up', flush=True)\n"
        "while not asked or time.monotonic() < asked[0] + 0.5: time.sleep(0.01)\n"
        "print('asked', len(asked), flush=True)"
    )
    row = ExternalCommandRow(name="probe", argv=("python", "-c", script), blocking=False)
    command = commands.start(row, (), LINE, 3.5)
    log = tmp_path / "probe.log"
    until(lambda: "up" in log.read_text(), what="it runs")
    until(lambda: commands.prune(set()) or command.over, what="it has ended")
    assert log.read_text().split() == ["up", "asked", "1"]


def test_a_program_whose_row_is_gone_ends_also_if_it_does_not_want_to(commands, tmp_path, monkeypatch):
    monkeypatch.setattr(external, "STOP_S", 0.2)
    script = (
        "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('up', flush=True); time.sleep(60)"
    )
    row = ExternalCommandRow(name="probe", argv=("python", "-c", script), blocking=False)
    command = commands.start(row, (), LINE, 3.5)
    until(lambda: "up" in (tmp_path / "probe.log").read_text(), what="it runs")
    commands.prune({"probe"})
    assert not command.over
    until(lambda: commands.prune(set()) or command.over, what="it has ended")
