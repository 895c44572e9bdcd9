"""Consoles as processes have them: the robot's own, in a thread beside it, and one on a robot elsewhere."""

import atexit
import contextlib
import sys
import termios
import threading
from collections.abc import Callable, Sequence

from lbr import home
from lbr.bus import session
from lbr.console import target
from lbr.console.interrupt import interruptible
from lbr.console.lines import Lines
from lbr.console.operator import BusOperator
from lbr.messages.system import ConsoleResult

LOCAL_SOURCE = "console"
RESTORE_S = 1.0


def run_local(robot: str, endpoints: Sequence[str], submit: Callable[[str], ConsoleResult]) -> int:
    """Run the robot's own console in this thread, until it is left; `submit` says a line directly."""
    with session.open_client(endpoints) as bus, session.open_client(endpoints) as streams:
        operator = BusOperator(bus, robot, LOCAL_SOURCE, submit=submit, streams=streams)
        return _run(operator, local=True)


def run_remote(found: target.Target, *, hold_s: float | None = None) -> int:
    """Run a console on a robot, until it is left; the robot runs on."""
    with target.connected(found) as bus, target.connected(found) as streams:
        operator = BusOperator(bus, found.robot, target.source("console"), token=found.token, streams=streams)
        return _run(operator, local=False, hold_s=hold_s)


def _run(operator: BusOperator, *, local: bool, hold_s: float | None = None) -> int:
    try:
        if sys.stdin.isatty() and sys.stdout.isatty():
            return _run_terminal(operator, local=local)
        with interruptible():
            return Lines(operator, sys.stdout, sys.stderr, hold_s=hold_s).run(sys.stdin)
    finally:
        operator.close()


def _run_terminal(operator: BusOperator, *, local: bool) -> int:
    from lbr.console.terminal import Terminal  # noqa: PLC0415 - prompt-toolkit is for those who have a terminal

    terminal = Terminal(operator, local=local, history=home.home() / "history")
    over = threading.Event()
    modes = termios.tcgetattr(sys.stdin)

    def restore() -> None:
        """Leave the terminal as it was when the process ends while somebody still types."""
        if not over.is_set():
            terminal.close()
            over.wait(RESTORE_S)
            with contextlib.suppress(termios.error):
                termios.tcsetattr(sys.stdin, termios.TCSADRAIN, modes)

    atexit.register(restore)
    try:
        with interruptible(lambda _number, _frame: terminal.close()):
            return terminal.run()
    finally:
        over.set()
        atexit.unregister(restore)
