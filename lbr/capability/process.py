"""A capability's process: `python -m lbr.capability.process`, started by the executive.

Its document comes as one line on standard input, which stays open as the lifeline: when it closes, the executive is
gone, and the process stops its motion and ends, also if it was frozen. Every way out that is not a requested stop ends
in `os._exit(70)`, because a thread of the bus library would keep a process alive that Python has left.
"""

import gc
import os
import queue
import signal
import sys
import threading
import time
import traceback
from pathlib import Path
from types import FrameType
from typing import Any

import msgspec

from lbr.bus import wire
from lbr.capability import lifeline, registry
from lbr.capability.base import Capability
from lbr.capability.config import ProcessConfig
from lbr.capability.confine import confine
from lbr.capability.reporter import BEAT_S, HEARTBEAT_VARIABLE, Reporter, Said
from lbr.capability.runtime import ProcessContext
from lbr.capability.suspended import Suspended
from lbr.errors import DeviceError
from lbr.messages.codes import Reason

CRASHED = 70
CLOSE_LIMIT_S = 0.5
RETRY_FIRST_S = 0.2
RETRY_MOST_S = 2.0
STEADY_S = 5.0
TELL_DEGRADED_S = 0.5
TELL_MISSED_S = 1.0
COLLECT_S = 10.0


class Wake:
    """Wakes the main loop from any thread or signal handler; a SimpleQueue is safe in both."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._set = False

    def set(self) -> None:
        """Wake the loop, or let its next wait return at once."""
        if not self._set:
            self._set = True
            self._queue.put(None)

    def wait(self, timeout_s: float) -> None:
        """Sleep until woken, at most `timeout_s`."""
        try:
            self._queue.get(timeout=max(timeout_s, 0.0))
        except queue.Empty:
            return
        self._set = False


class Process:
    """The main loop of one capability: opens it, steps it, reopens it when its device comes back, closes it."""

    def __init__(self, config: ProcessConfig, reporter: Reporter) -> None:
        self._config = config
        self._reporter = reporter
        self._wake = Wake()
        self._stopping = False
        self._capability: Capability[Any] | None = None
        self._suspended = Suspended()
        self._tell_at = 0.0
        self._collect_at = 0.0

    def stop(self) -> None:
        """Ask the loop to end; from any thread or a signal handler."""
        self._stopping = True
        self._wake.set()

    def run(self) -> None:
        """Run until asked to stop; raise whatever the capability raises."""
        kind = registry.find(self._config.kind, Path(self._config.home), trial=False)
        make = kind.load()
        streams = self._wake.set if getattr(make, "woken_by_streams", True) else None
        ctx = ProcessContext(self._config, kind, self._reporter, self._wake.set, streams)
        self._capability = capability = make(ctx)
        if kind.moves:
            gc.disable()  # collected at moments of our choice, so that no round takes longer than the others
        retry_s, opened = RETRY_FIRST_S, time.monotonic()
        while not self._stopping:
            said = self._reporter.said
            try:
                capability.open()
                self._settle()
                opened = time.monotonic()
                self._loop(ctx, capability, said)
            except DeviceError as err:
                capability.close()
                if time.monotonic() - opened > STEADY_S:
                    retry_s = RETRY_FIRST_S
                self._wait_degraded(ctx, capability, Reason(err.code, str(err)), retry_s)
                retry_s = min(retry_s * 2, RETRY_MOST_S)
        self._reporter.phase("stopping")
        capability.close()
        ctx.close()

    def close(self) -> None:
        """Stop the motion of a capability that crashed; the caller sets a bound."""
        if self._capability is not None:
            self._capability.close()

    def _loop(self, ctx: ProcessContext, capability: Capability[Any], said: Said) -> None:
        """Step until asked to stop; ready is who has stepped once and has not said what it waits for."""
        due, begins = time.monotonic(), True
        while not self._stopping:
            period = 1.0 / capability.rate_hz
            now = time.monotonic()
            ctx.on_tick = now >= due
            if ctx.on_tick:
                due = due + period if now < due + period else now + period
            self._round(ctx, capability)
            if begins and self._reporter.said is said:
                ctx.ready()
            begins = False
            due = min(due, now + 1.0 / capability.rate_hz)  # its rate may have risen, as when it begins something
            self._wake.wait(min(due - time.monotonic(), BEAT_S))

    def _round(self, ctx: ProcessContext, capability: Capability[Any]) -> None:
        if slept_s := self._suspended.for_s():
            capability.woke(slept_s)
        for call in ctx.calls():
            capability.command(call)
        capability.step()
        self._reporter.beat(ctx.counts())
        if ctx.on_tick:
            self._keep_house(ctx)

    def _settle(self) -> None:
        """Once all is there, let no later collection look again at what lives as long as the process."""
        if not self._collect_at:
            self._collect_at = time.monotonic() + COLLECT_S
            gc.collect()
            gc.freeze()

    def _keep_house(self, ctx: ProcessContext) -> None:
        """Do what may wait, right after a tick: nothing else is due for almost a period."""
        now = time.monotonic()
        ctx.tell_recorder()
        if now >= self._tell_at:
            self._tell_at = now + TELL_MISSED_S
            ctx.tell_missed()
            ctx.drop_unread()
        if now >= self._collect_at:
            self._collect_at = now + COLLECT_S
            gc.collect()

    def _wait_degraded(self, ctx: ProcessContext, capability: Capability[Any], reason: Reason, wait_s: float) -> None:
        ctx.warn(reason)
        tell, until = 0.0, time.monotonic() + wait_s
        while not self._stopping and time.monotonic() < until:
            if time.monotonic() >= tell:
                tell = time.monotonic() + TELL_DEGRADED_S
                capability.degraded(str(reason))
            for call in ctx.calls():
                call.refuse(f"{ctx.name}: {reason}", reason.code)
            self._reporter.beat(ctx.counts())
            ctx.tell_recorder()
            self._wake.wait(min(until - time.monotonic(), BEAT_S))


def _read_document() -> bytes:
    parts: list[bytes] = []
    while not parts or b"\n" not in parts[-1]:
        part = os.read(0, 65536)
        if not part:
            raise SystemExit("no document on standard input; the executive starts this program")
        parts.append(part)
    return b"".join(parts).partition(b"\n")[0]


def _watch_lifeline(process: Process) -> None:
    while os.read(0, 4096):
        pass
    _end_within(2 * CLOSE_LIMIT_S)
    process.stop()


def _end_within(seconds: float) -> None:
    """Let the kernel end this process then, whatever hangs in it, and whichever thread holds the interpreter."""
    signal.setitimer(signal.ITIMER_REAL, seconds)


def _told(err: BaseException) -> str:
    """Say what was raised, and in which line of whose file: the last that is not the runtime's own."""
    try:
        frames = traceback.extract_tb(err.__traceback__)
        last = next((frame for frame in reversed(frames) if "/lbr/capability/" not in frame.filename), None)
        where = f" ({Path(last.filename).name}, line {last.lineno})" if last else ""
        return f"{type(err).__name__}: {err}{where}"
    except Exception:  # noqa: BLE001 - an exception that cannot even be told is one all the same
        return type(err).__name__


def _crash(process: Process | None, reporter: Reporter, err: BaseException) -> None:
    try:
        _end_within(CLOSE_LIMIT_S)
        reporter.phase("failed", _told(err), "failed")
        if process is not None:
            process.close()
        traceback.print_exception(err)
        sys.stderr.flush()
    finally:
        os._exit(CRASHED)


def main() -> None:
    """Read the document, run the capability, and leave for certain."""
    reporter = Reporter(int(os.environ[HEARTBEAT_VARIABLE]))
    process: Process | None = None
    try:
        lifeline.wake(0, os.getpid())
        config = msgspec.json.decode(_read_document(), type=ProcessConfig)
        confine((config.home, *(device.address for device in config.devices)))
        process = running = Process(config, reporter)

        def stop(_signal: int, _frame: FrameType | None) -> None:
            running.stop()

        wire.on_callback_error = lambda err: _crash(None, reporter, err)
        threading.excepthook = lambda args: _crash(None, reporter, args.exc_value or RuntimeError("thread died"))
        signal.signal(signal.SIGTERM, stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole terminal; the executive decides
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        threading.Thread(target=_watch_lifeline, args=(process,), daemon=True).start()
        process.run()
    except BaseException as err:  # noqa: BLE001 - the outermost frame: whatever it is, stop the motion and leave
        _crash(process, reporter, err)
    os._exit(0)


if __name__ == "__main__":
    main()
