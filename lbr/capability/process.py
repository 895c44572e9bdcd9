"""A capability's process: `python -m lbr.capability.process`, started by the executive.

Its document comes as one line on standard input, which stays open as the lifeline: when it closes, the executive is
gone, and the process stops its motion and ends, also if it was frozen. If it is shared, further lines are orders to
begin with one more capability, or to let one end. Every way out that is not a requested stop ends in `os._exit(70)`,
because a thread of the bus library would keep a process alive that Python has left.
"""

import os
import signal
import threading
from collections.abc import Iterator
from types import FrameType

import msgspec

from lbr.bus import wire
from lbr.capability import leaving, lifeline
from lbr.capability.config import ProcessConfig
from lbr.capability.confine import confine
from lbr.capability.loop import Loop
from lbr.capability.reporter import HEARTBEAT_VARIABLE, Reporter
from lbr.capability.shared_process import SharedProcess


def _lines() -> Iterator[bytes]:
    """Yield what comes on standard input, line by line, until it closes."""
    rest = b""
    while part := os.read(0, 65536):
        *lines, rest = (rest + part).split(b"\n")
        yield from lines


def _document(lines: Iterator[bytes]) -> ProcessConfig:
    for line in lines:
        return msgspec.json.decode(line, type=ProcessConfig)
    raise SystemExit("no document on standard input; the executive starts this program")


def _obey(lines: Iterator[bytes], process: SharedProcess | Loop) -> None:
    """Follow orders until the executive is gone, and then end."""
    for line in lines:
        if isinstance(process, SharedProcess):
            process.obey(line)
    leaving.within(2 * leaving.CLOSE_LIMIT_S)
    process.stop()


def _crash(loop: Loop | None, reporter: Reporter, err: BaseException) -> None:
    try:
        leaving.within(leaving.CLOSE_LIMIT_S)
        reporter.phase("failed", leaving.told(err), "failed")
        try:
            if loop is not None:
                loop.close()
        finally:
            leaving.trace(err)
    finally:
        os._exit(leaving.CRASHED)


def _heed(ends: SharedProcess | Loop) -> None:
    """End when asked by a signal."""

    def stop(_signal: int, _frame: FrameType | None) -> None:
        ends.stop()

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole terminal; the executive decides
    signal.signal(signal.SIGHUP, signal.SIG_IGN)


def _share(config: ProcessConfig, lines: Iterator[bytes], fd: int) -> None:
    """Be the process that several share; the main thread hears orders."""
    shared = SharedProcess(fd)
    try:
        wire.on_callback_error = shared.crash
        threading.excepthook = lambda args: shared.crash(args.exc_value or RuntimeError("thread died"))
        _heed(shared)
        shared.begin(config)
        _obey(lines, shared)
        shared.wait()
    except BaseException as err:  # noqa: BLE001 - this thread's outermost frame: stop the motion and leave
        shared.crash(err)


def main() -> None:
    """Read the document, run the capability, and leave for certain."""
    fd = int(os.environ[HEARTBEAT_VARIABLE])
    reporter = Reporter(fd)
    loop: Loop | None = None
    try:
        lifeline.wake(0, os.getpid())
        lines = _lines()
        config = _document(lines)
        confine((config.home, *config.reach, *(device.address for device in config.devices)))
        if config.process:
            _share(config, lines, fd)
        else:
            loop = running = Loop(config, reporter)
            wire.on_callback_error = lambda err: _crash(None, reporter, err)
            threading.excepthook = lambda args: _crash(None, reporter, args.exc_value or RuntimeError("thread died"))
            _heed(running)
            threading.Thread(target=_obey, args=(lines, running), daemon=True).start()
            running.run()
    except BaseException as err:  # noqa: BLE001 - the outermost frame: whatever it is, stop the motion and leave
        _crash(loop, reporter, err)
    os._exit(0)


if __name__ == "__main__":
    main()
