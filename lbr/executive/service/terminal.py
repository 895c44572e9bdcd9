"""The robot's own console: a thread beside the executive's, at the terminal that started it."""

import sys
import threading
from collections.abc import Callable

from lbr.bus.session import Session
from lbr.errors import LbrError
from lbr.executive import threads
from lbr.executive.service.dispatch import Dispatcher, Sender
from lbr.messages.system import ConsoleResult

Start = Callable[[str, Callable[[], Session], Dispatcher, Callable[[str, int], None]], None]
"""Opens the console of a robot."""


def start(
    robot: str,
    connect: Callable[[], Session],
    dispatcher: Dispatcher,
    ended: Callable[[str, int], None],
    *,
    verbose: bool,
) -> None:
    """Open the console; `ended(why, code)` is called when it is left or its input ends.

    `verbose` shows each part's reports while it starts.
    """
    from lbr.console.greeting import Greeting  # noqa: PLC0415 - for those who have a console
    from lbr.console.local import run_local  # noqa: PLC0415 - prompt-toolkit is for those who have a console

    at_terminal = sys.stdin.isatty() and sys.stdout.isatty()  # another program may have written the input of a pipe

    def submit(line: str, waited_s: float) -> ConsoleResult:
        return dispatcher.execute(line, Sender("console", "admin", local=at_terminal, waited_s=waited_s))

    def talk() -> None:
        code, why = 0, "console closed"
        try:
            code = run_local(robot, connect, submit, Greeting(dispatcher.greeting, verbose=verbose))
        except LbrError as err:
            code, why = 1, str(err)
        except OSError as err:
            code, why = 1, f"the console's output cannot be written ({err.strerror})"
        finally:
            ended(why, code)

    threading.Thread(target=talk, name="terminal", daemon=True).start()


def leave() -> threading.Thread | None:
    """Begin to close the console, if there is one; return the thread that waits for its end, None without one."""
    local = sys.modules.get("lbr.console.local")
    if local is None:
        return None
    return threads.begin(local.leave, "leave-terminal")
