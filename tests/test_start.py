"""The command `lbr` before it is loaded."""

import signal
import sys
import time
import weakref

import pytest

from lbr import cli, start


@pytest.fixture(autouse=True)
def own_hook(monkeypatch):
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


class Interrupting:
    """Ctrl-C, pressed while the command is loaded."""

    def find_spec(self, name, _path=None, _target=None):
        if name == "lbr.cli":
            raise KeyboardInterrupt


def test_ctrl_c_while_the_command_is_loaded_is_no_traceback(monkeypatch):
    monkeypatch.delitem(sys.modules, "lbr.cli")
    monkeypatch.setattr(sys, "meta_path", [Interrupting(), *sys.meta_path])
    assert start.main() == cli.INTERRUPTED


def test_ctrl_c_counts_where_python_lets_no_exception_out(monkeypatch, capfd):
    def loading(*_arguments, **_options):
        one = Interrupting()
        gone = weakref.ref(one, lambda _gone: signal.raise_signal(signal.SIGINT))
        del one
        assert gone() is None
        time.sleep(9)

    monkeypatch.setattr(cli.cli, "main", loading)
    assert start.main() == cli.INTERRUPTED
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_what_ends_by_ctrl_c_ends_by_signals_too(monkeypatch, number):
    ended = []

    def running(*_arguments, **_options):
        try:
            signal.raise_signal(number)
            time.sleep(9)
        finally:
            ended.append(True)

    signal.signal(number, signal.SIG_DFL)
    monkeypatch.setattr(cli.cli, "main", running)
    assert start.main() == cli.INTERRUPTED
    assert ended


def test_a_signal_that_is_ignored_stays_so(monkeypatch):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as by nohup
    monkeypatch.setattr(cli.cli, "main", lambda *_arguments, **_options: signal.raise_signal(signal.SIGHUP))
    assert start.main() == 0


def test_it_is_the_command(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["lbr", "--version"])
    assert start.main() == 0
    assert capsys.readouterr().out.startswith("lbr ")
