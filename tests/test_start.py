"""The command `lbr` before it is loaded."""

import sys

from lbr import cli, start


class Interrupting:
    """Ctrl-C, pressed while the command is loaded."""

    def find_spec(self, name, _path=None, _target=None):
        if name == "lbr.cli":
            raise KeyboardInterrupt


def test_ctrl_c_while_the_command_is_loaded_is_no_traceback(monkeypatch):
    monkeypatch.delitem(sys.modules, "lbr.cli")
    monkeypatch.setattr(sys, "meta_path", [Interrupting(), *sys.meta_path])
    assert start.main() == cli.INTERRUPTED


def test_it_is_the_command(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["lbr", "--version"])
    assert start.main() == 0
    assert capsys.readouterr().out.startswith("lbr ")
