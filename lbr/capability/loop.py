"""The main loop of one capability: opens it, steps it, reopens it when its device comes back, closes it."""

import gc
import queue
import threading
import time
from pathlib import Path
from typing import Any

from lbr.capability import registry
from lbr.capability.base import Capability
from lbr.capability.config import ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.reporter import BEAT_S, Reporter, Said
from lbr.capability.runtime import ProcessContext
from lbr.capability.suspended import Suspended
from lbr.errors import DeviceError
from lbr.messages.codes import Reason

RETRY_FIRST_S = 0.2
RETRY_MOST_S = 2.0
STEADY_S = 5.0
TELL_DEGRADED_S = 0.5
TELL_MISSED_S = 1.0
COLLECT_S = 10.0
BEGINS_S = 60.0
"""So long a process begins, on a slow computer that imports much."""
_finding = threading.Lock()


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


class Garbage:
    """Collects what a process has left over; its loops say when."""

    def __init__(self) -> None:
        self._freeze_until = time.monotonic() + BEGINS_S
        self._collect_at = 0.0

    def wait_for_us(self) -> None:
        """Collect at moments of a loop's choice only, so that no round takes longer than the others."""
        gc.disable()

    def settle(self) -> None:
        """Once all is there that a loop needs, let no later collection look again at what lives as long as the process.

        What a loop brings that begins later may end sooner, and is collected like all else.
        """
        now = time.monotonic()
        self._collect_at = now + COLLECT_S
        gc.collect()
        if now < self._freeze_until:
            gc.freeze()

    def collect(self, now: float) -> None:
        """Collect, if it is time; to be called where nothing else is due for a while."""
        if now >= self._collect_at:
            self._collect_at = now + COLLECT_S
            gc.collect()


class Loop:
    """Runs in one thread; `stop` and `close` may come from another."""

    def __init__(self, config: ProcessConfig, reporter: Reporter, garbage: "Garbage | None" = None) -> None:
        self._config = config
        self._reporter = reporter
        self._garbage = garbage or Garbage()
        self._wake = Wake()
        self._stopping = False
        self._capability: Capability[Any] | None = None
        self._suspended = Suspended()
        self._tell_at = 0.0
        self._settled = False

    def stop(self) -> None:
        """Ask the loop to end; from any thread or a signal handler."""
        self._stopping = True
        self._wake.set()

    def run(self) -> None:
        """Run until asked to stop; raise whatever the capability raises."""
        kind, make = self._find()
        streams = self._wake.set if getattr(make, "woken_by_streams", True) else None
        ctx = ProcessContext(self._config, kind, self._reporter, self._wake.set, streams)
        try:
            self._capability = capability = make(ctx)
        except BaseException:
            ctx.close()
            raise
        if kind.moves:
            self._garbage.wait_for_us()
        retry_s, opened = RETRY_FIRST_S, time.monotonic()
        while not self._stopping:
            said = self._reporter.said
            try:
                capability.open()
                if not self._settled:
                    self._settled = True
                    self._garbage.settle()
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

    @property
    def began(self) -> bool:
        """Whether there is a capability: before, it could do nothing."""
        return self._capability is not None

    def _find(self) -> tuple[Kind, type]:
        """Return the kind and its class; of several loops of a process one after the other imports what they need."""
        while not _finding.acquire(timeout=BEAT_S):
            self._reporter.beat({})
        try:
            kind = registry.accepted(self._config.kind, Path(self._config.home), self._config.source)
            return kind, kind.load()
        finally:
            _finding.release()

    def close(self) -> None:
        """Stop the motion of a capability that crashed; the caller sets a bound."""
        if self._capability is not None:
            self._capability.close()

    def _loop(self, ctx: ProcessContext, capability: Capability[Any], said: Said) -> None:
        """Step until asked to stop; ready is who has stepped, whose device answers, and who lacks nothing."""
        due, begins = time.monotonic(), True
        while not self._stopping:
            period = 1.0 / capability.rate_hz
            now = time.monotonic()
            ctx.on_tick = now >= due
            if ctx.on_tick:
                due = due + period if now < due + period else now + period
            self._round(ctx, capability)
            if begins and capability.answers():
                lacks, own = capability.lacks(), self._reporter.said is not said
                begins = lacks is not None
                if not own:  # what it has reported itself stands
                    ctx.warn(lacks) if lacks else ctx.ready()
                    said = self._reporter.said
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

    def _keep_house(self, ctx: ProcessContext) -> None:
        """Do what may wait, right after a tick: nothing else is due for almost a period."""
        now = time.monotonic()
        ctx.tell_recorder()
        if now >= self._tell_at:
            self._tell_at = now + TELL_MISSED_S
            ctx.tell_missed()
            ctx.drop_unread()
        self._garbage.collect(now)

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
