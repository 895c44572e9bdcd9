"""The main loop of one capability: opens it, steps it, reopens it when its device comes back, closes it."""

import gc
import queue
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from math import inf
from pathlib import Path

from msgspec import Struct

from lbr.capability import leaving, registry
from lbr.capability.base import Capability
from lbr.capability.calls import BusCall
from lbr.capability.config import ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.reporter import BEAT_S, CALM_BEAT_S, Phase, Reporter
from lbr.capability.runtime import Join, ProcessContext
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
"""The time for a start, on a slow computer that imports many modules."""
EARLY_S = 1e-9
"""Sums of periods have rounding errors: a step may come this early."""
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
    """Collects a process's garbage, at times that its loops choose."""

    def __init__(self) -> None:
        self._freeze_until = time.monotonic() + BEGINS_S
        self._collect_at = 0.0

    def wait_for_us(self) -> None:
        """Collect only at times that a loop chooses, so that no round takes longer than the others."""
        gc.disable()

    def settle(self) -> None:
        """Exclude all present objects from later collections; called once a loop has all that it needs.

        Only in the first minute of a process: the objects of later loops may end before it.
        """
        now = time.monotonic()
        self._collect_at = now + COLLECT_S
        gc.collect()
        if now < self._freeze_until:
            gc.freeze()

    def collect(self, now: float) -> None:
        """Collect if it is time; to be called when nothing else is due for a while."""
        if now >= self._collect_at:
            self._collect_at = now + COLLECT_S
            gc.collect()


class Loop:
    """Runs in one thread; another may call `stop` and `close`.

    If the transport has a clock of its own, its owner calls `begin`, `step` whenever it is due or woken, and `end`.
    """

    def __init__(
        self,
        config: ProcessConfig,
        reporter: Reporter,
        garbage: "Garbage | None" = None,
        join: Join | None = None,
        wake: Callable[[], None] | None = None,
        kind: Kind | None = None,
    ) -> None:
        self._config = config
        self._reporter = reporter
        self._garbage = garbage or Garbage()
        self._join = join
        self._kind = kind
        self._wake = Wake()
        self._woken = wake or self._wake.set
        self._stopping = False
        self._capability: Capability[Struct] | None = None
        self._suspended = Suspended()
        self._report_at = 0.0
        self._reported: Phase = ("", "", "")
        self._opened_s = self._due = self._retry_at = -inf
        self._settled = self._open = self._begins = False
        self._retry_s, self._lost = RETRY_FIRST_S, Reason("failed", "")

    def stop(self) -> None:
        """Ask the loop to end; may be called from any thread or signal handler."""
        self._stopping = True
        self._wake.set()

    def run(self) -> None:
        """Run until asked to stop; raise whatever the capability raises."""
        ctx = self.begin()
        while not self._stopping:
            due = self.step()
            self._wake.wait(min(due - ctx.clock(), self._reporter.beat_s))
        self.end()

    def begin(self) -> ProcessContext:
        """Connect the capability to its bus, without opening it."""
        kind, make = self._find()
        streams = getattr(make, "woken_by_streams", True)
        seldom = getattr(make, "received_while_read", frozenset[str]())
        self._ctx = ctx = ProcessContext(self._config, kind, self._reporter, self._woken, streams, self._join, seldom)
        with ExitStack() as failed:
            failed.callback(ctx.close)
            self._capability = make(ctx)
            failed.pop_all()
        self._reporter.beat_s = BEAT_S if kind.moves else CALM_BEAT_S
        if kind.moves:
            self._garbage.wait_for_us()
        self._opened_s = ctx.clock()
        return ctx

    def end(self) -> None:
        """Close the capability, and leave the bus."""
        self._reporter.phase("stopping")
        self.close()
        self._ctx.close()

    @property
    def capability(self) -> Capability[Struct] | None:
        """Return the capability that runs here; None before it has begun."""
        return self._capability

    @property
    def began(self) -> bool:
        """Return whether the capability runs: before that it could do nothing."""
        return self._capability is not None

    def _find(self) -> tuple[Kind, type]:
        """Return the kind and its class; the loops of a process import their modules one after the other."""
        while not _finding.acquire(timeout=BEAT_S):
            self._reporter.beat({})
        try:
            kind = self._kind or registry.accepted(self._config.kind, Path(self._config.home), self._config.source)
            return kind, kind.load()
        finally:
            _finding.release()

    def close(self) -> None:
        """Stop the motion of a capability that crashed; the caller bounds the time."""
        if self._capability is not None:
            self._capability.close()

    def step(self) -> float:
        """Do a round, open, or wait for a missing device; return when the next step is due."""
        ctx, capability = self._ctx, self._capability
        assert capability is not None
        if ctx.clock() < self._retry_at:
            return self._wait_degraded(ctx, capability)
        try:
            if not self._open:
                self._open_it(ctx, capability)
            return self._tick(ctx, capability)
        except DeviceError as err:
            self._open = False
            capability.close()
            now = ctx.clock()
            if now - self._opened_s > STEADY_S:
                self._retry_s = RETRY_FIRST_S
            self._lost, self._report_at, self._retry_at = Reason(err.code, str(err)), 0.0, now + self._retry_s
            self._retry_s = min(self._retry_s * 2, RETRY_MOST_S)
            ctx.warn(self._lost)
            return self._wait_degraded(ctx, capability)

    def _open_it(self, ctx: ProcessContext, capability: Capability[Struct]) -> None:
        self._reported = self._reporter.reported
        capability.open()
        if not self._settled:
            self._settled = True
            self._garbage.settle()
        self._open = self._begins = True
        self._opened_s = self._due = ctx.clock()

    def _tick(self, ctx: ProcessContext, capability: Capability[Struct]) -> float:
        """Do one round; a capability is ready once it has stepped, its device answers, and it lacks nothing."""
        period = 1.0 / capability.rate_hz
        now = ctx.clock()
        ctx.on_tick = now >= self._due - EARLY_S
        if ctx.on_tick:
            self._due = self._due + period if now < self._due + period else now + period
        self._round(ctx, capability)
        if self._begins and capability.answers():
            lacks, own = capability.lacks(), self._reporter.reported is not self._reported
            self._begins = lacks is not None
            if not own:  # its own reports have priority
                ctx.warn(lacks) if lacks else ctx.ready()
                self._reported = self._reporter.reported
        self._due = min(self._due, now + 1.0 / capability.rate_hz)  # its rate may have risen because it began something
        return self._due

    def _round(self, ctx: ProcessContext, capability: Capability[Struct]) -> None:
        if slept_s := self._suspended.for_s():
            capability.woke(slept_s)
        for call in ctx.calls():
            with ctx.on_behalf(call):
                self._command(capability, call)
        capability.step()
        self._reporter.beat(ctx.counts())
        if ctx.on_tick:
            self._keep_house(ctx)

    @staticmethod
    def _command(capability: Capability[Struct], call: BusCall) -> None:
        """Have a command answered. An exception becomes the answer, and ends this process, or its device's session."""
        try:
            capability.command(call)
        except Exception as err:
            if call.open:
                call.refuse(
                    Reason(err.code, str(err)) if isinstance(err, DeviceError) else Reason("failed", leaving.text(err))
                )
            raise

    def _keep_house(self, ctx: ProcessContext) -> None:
        """Do what may wait, right after a tick: nothing else is due for almost a period."""
        now = ctx.clock()
        ctx.tell_recorder()
        if now >= self._report_at:
            self._report_at = now + TELL_MISSED_S
            ctx.tell_missed()
            ctx.drop_unread()
        self._garbage.collect(now)

    def _wait_degraded(self, ctx: ProcessContext, capability: Capability[Struct]) -> float:
        """Refuse commands while the device is away."""
        now = ctx.clock()
        if now >= self._report_at:
            self._report_at = now + TELL_DEGRADED_S
            capability.degraded(str(self._lost))
        for call in ctx.calls():
            call.refuse(f"{ctx.name}: {self._lost}", self._lost.code)
        self._reporter.beat(ctx.counts())
        ctx.tell_recorder()
        return min(self._retry_at, now + BEAT_S)
