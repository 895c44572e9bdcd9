"""The robot's own console, beside the executive that may end before it is there."""

import contextlib
import os
import pty
import sys
import threading
from unittest import mock

import pytest

from lbr.console import local, terminal
from tests.support.waiting import HANG_S, until


@pytest.mark.parametrize("at", [os.pipe, pty.openpty], ids=["a pipe", "a terminal"])
def test_a_console_that_is_to_be_left_before_it_is_there_ends_at_once(monkeypatch, at):
    leaving = threading.Thread(target=local.leave)

    def connect():
        if leaving.ident is None:
            leaving.start()
            until(lambda: local._open.leaving, what="the wish to leave")
        return contextlib.nullcontext()

    one, other = at()
    try:
        with open(one if at is os.pipe else other, closefd=False) as source, open(other, "w", closefd=False) as screen:
            monkeypatch.setattr(sys, "stdin", source)
            monkeypatch.setattr(sys, "stdout", screen)
            monkeypatch.setattr(local, "BusOperator", mock.Mock())
            monkeypatch.setattr(terminal, "Terminal", mock.Mock(side_effect=AssertionError("no prompt is to be shown")))
            assert local.run_local("lbr", connect, mock.Mock(), mock.Mock()) == 0
        leaving.join(HANG_S)
        assert not leaving.is_alive()
        assert not local._open.leaving
    finally:
        os.close(other)
        os.close(one)
