"""Behaviours as a capability: runs one state table at a time, moves the robot under leases, and reports the run."""

import random
from collections import deque
from math import inf

from msgspec.structs import replace

from lbr.apps.behaviours import texts
from lbr.apps.behaviours.kernel import DONE, Outcome, Run
from lbr.apps.behaviours.keys import STREAMS
from lbr.apps.behaviours.kind import BehaviourSettings
from lbr.apps.behaviours.library import Library
from lbr.apps.behaviours.low_battery import ALONE_FOR_S, LowBattery
from lbr.apps.behaviours.outputs import Aside, Halt, Motion
from lbr.apps.behaviours.senses import Senses
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context, Received
from lbr.errors import InputError
from lbr.leases.client import PendingReply
from lbr.leases.halts import Halts
from lbr.leases.holder import TARGETS, Holder, bounded
from lbr.messages.behaviour import (
    BehaviourChecked,
    BehaviourState,
    BehaviourWritten,
    CheckBehaviour,
    NamedBehaviour,
    ReadBehaviour,
    RowView,
    RunBehaviour,
    WriteBehaviour,
)
from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE, CommandReply, StopCommand
from lbr.messages.speech import SayCommand

STATE_EVERY_S, RESTING_EVERY_S = 0.25, 1.0
ASIDE_S = 5.0
NOT_DONE = {"say": ("behaviour_silent", "says nothing"), "watch": ("behaviour_blind", "looks for nothing")}
"""For each side request: the event of its failure, and the event's verb."""
BATTERY_S, DRIVE_S = 3.0, 1.0
"""The age at which a state no longer counts: three periods of the battery, ten of the drive."""
RUNNING_HZ, IDLE_HZ = 20.0, 5.0
HELD_UP_S = 3.0
"""The time without a step after which a run ends, whether this process was frozen or the computer asleep."""
MOST_ASIDE = 8
MOST_FILES = 8
"""The requests of pages that may wait for a table's check. The robot checks one table a round, so pages cannot overload
it."""
RESTING = BehaviourState(phase="resting")
WATCHED = frozenset({"drive", "joints"})
"""The streams that report stops by others. Such a stop ends the run, even while it moves nothing."""


class Behaviours(Capability[BehaviourSettings]):
    """Runs one table at a time. Every stop ends the run, and so does every failure of its motion. `dice` draws a
    table's random choices. Seed it to repeat a run."""

    rate_hz = IDLE_HZ
    woken_by_streams = False
    received_while_read = frozenset(STREAMS) - WATCHED

    def __init__(self, ctx: Context[BehaviourSettings]) -> None:
        super().__init__(ctx)
        self._senses = Senses(ctx)
        self._library = Library(ctx, self._senses)
        self._holder = Holder(ctx)
        self._run: Run | None = None
        self._streams: frozenset[str] = frozenset()
        self._began = 0.0
        self._stepped_at = ctx.clock()
        self._ticket = -1
        self._aside: list[tuple[str, PendingReply]] = []
        self._last = self._published = RESTING
        self._publish_at = 0.0
        self.dice = random.Random()
        self._stopped_s = -inf
        self._halts = Halts(at=ctx.clock())
        self._files: deque[Call] = deque()
        self._looked = False
        self._low = LowBattery()

    def open(self) -> None:
        """Read the tables."""
        self._library.compile()

    def step(self) -> None:
        """Advance the run; end it after a long gap between steps."""
        now = self.ctx.clock()
        held_up_s, self._stepped_at = now - self._stepped_at, now
        if held_up_s > HELD_UP_S:
            self._held_up(held_up_s)
        if self.ctx.estop.engaged:
            self._stop(Reason("estop", f"emergency stop: {self.ctx.estop.reason}"))
            self.ctx.estop.acknowledge(stopped=True)
        if self.ctx.settings.when_low:
            self._look_after_the_battery(self.ctx.settings.when_low)
        if self._library.is_edited:
            self._follow()
        if self._run is not None:
            self._go_on(self._run)
        self.rate_hz = IDLE_HZ if self._run is None else RUNNING_HZ
        self._read_asides()
        self._looked = bool(self._files)
        if self._files:
            self._answer_or_refuse(self._files.popleft())
        self._publish()

    def command(self, call: Call) -> None:
        """Answer a command. The files of pages are checked one a round; further ones wait."""
        if isinstance(call.message, CheckBehaviour | ReadBehaviour):
            if self._looked and len(self._files) >= MOST_FILES:
                call.refuse("too many tables are looked at at once; ask again", "busy")
                return
            if self._looked:
                self._files.append(call)
                return
            self._looked = True
        self._answer_or_refuse(call)
        self._publish()

    def close(self) -> None:
        """End the run, and stop what it moves."""
        self._stop(Reason("shutting_down", "behaviours are shutting down"))

    def _answer_or_refuse(self, call: Call) -> None:
        try:
            self._answer(call)
        except InputError as err:
            call.refuse(str(err), err.code)

    def _answer(self, call: Call) -> None:
        message = call.message
        match call.name:
            case "stop":
                assert isinstance(message, StopCommand)
                reason = f"stopped by {call.source}" + (f": {message.reason}" if message.reason else "")
                idle = "" if message.whole else "no behaviour runs"
                text = f"{self._run.table} is stopped" if self._run is not None else idle
                self._stopped_s = max(self._stopped_s, call.arrived)
                self._halts = self._halts.noted(call.arrived, call.source)
                self._stop(Reason("stopped", reason))
                call.reply(CommandReply(accepted=True, reason=text))
            case "run":
                assert isinstance(message, RunBehaviour)
                begun = self._begin(message.name, call)
                self._publish()  # whoever got the answer finds the new run in the state
                call.reply(CommandReply(accepted=True, reason=begun))
            case "list":
                call.reply(CommandReply(accepted=True, reason=self._library.listed(self._published)))
            case "show":
                assert isinstance(message, NamedBehaviour)
                call.reply(CommandReply(accepted=True, reason=self._drawing(message.name)))
            case "why":
                call.reply(CommandReply(accepted=True, reason=texts.why(self._state())))
            case "pause" | "resume" | "step":
                call.reply(CommandReply(accepted=True, reason=self._ordered(call.name, call)))
            case _:
                self._answer_of_files(call)

    def _answer_of_files(self, call: Call) -> None:
        """Answer the requests of pages about tables as files."""
        match call.message:
            case CheckBehaviour(name=name, rows=rows):
                call.reply(BehaviourChecked(accepted=True, faults=self._library.faults(name, rows)))
            case ReadBehaviour() as message:
                call.reply(self._library.read(message))
            case WriteBehaviour() as message:
                call.reply(BehaviourWritten(accepted=True, content=self._library.written(message)))
            case _:
                super().command(call)

    def _look_after_the_battery(self, table: str) -> None:
        """Begin a table once the battery is low, unless the robot is stopped, is driven, or runs another table."""
        self._senses.listen(frozenset({"battery", *WATCHED}))
        now = self.ctx.clock()
        battery = [one.message for one in self._senses.newest("battery") if now - one.arrived <= BATTERY_S]
        known = [one for one in battery if one.valid and one.level != "unknown"]
        charging = any(one.charging for one in known)
        low = any(one.level in {"low", "critical"} for one in known) if known else None
        busy = self._run is not None or self.ctx.estop.engaged or self._moved_by_others(now)
        if self._low.due(now, low=low, charging=charging, busy=busy):
            try:
                self._begin(table)
            except InputError as err:
                self.ctx.event("behaviour_refused", f"the battery is low: {err}", level="warning", code=err.code)

    def _moved_by_others(self, now: float) -> bool:
        """Return whether another client holds the drive or joints, or just stopped them; True if no state is known."""
        states = [state for stream in WATCHED for state in self._senses.newest(stream)]
        if not states:
            return True
        return any(
            state.message.holder is not None
            or now - state.arrived > DRIVE_S
            or (
                state.message.stopped_s is not None
                and now - _on_our_clock(state, state.message.stopped_s) < ALONE_FOR_S
            )
            for state in states
        )

    def _begin(self, name: str, call: Call | None = None) -> str:
        if self._run is not None:
            text = (
                f"'{self._run.called[0] if self._run.called else self._run.table}' runs: /behaviour/stop ends it first"
            )
            raise InputError(text, "busy")
        if self.ctx.estop.engaged:
            raise InputError(f"emergency stop: {self.ctx.estop.reason}; reset releases it", "estop")
        table = self._library.runnable(name)
        if call is not None:
            self._refuse_late(call)
        reachable = self._library.reachable(table)
        self._streams = frozenset(key.stream for one in reachable for key in one.keys) & self._senses.streams
        self._senses.listen(self._streams | WATCHED)
        now = self._began = self.ctx.clock()
        self._run = Run(table, self._library.good(), now, self.dice.randrange)
        self._ticket = -1
        text = f"runs {name} from '{self._run.state}'"
        self.ctx.event("behaviour_began", text, code="done", about=self.ctx.name if call is None else call.source)
        return text

    def _refuse_late(self, call: Call) -> None:
        """Refuse a command older than the last stop of this table, or delayed and older than another's stop."""
        if not call.arrived > self._stopped_s:
            raise InputError("a stop came after this command", "stopped")
        if call.waited_s == 0.0:
            return
        self._senses.listen(WATCHED)
        asker = call.by or call.source
        halts = [self._halts.by_others(asker)]
        for received in (one for stream in WATCHED for one in self._senses.newest(stream)):
            at, by = received.message.halted_s, received.message.halted_by
            if at is not None and by not in {"", asker, self.ctx.name}:
                halts.append((_on_our_clock(received, at), by))
        at, by = max(halts)
        if not call.arrived - call.waited_s > at:  # this way round, NaN refuses
            raise InputError(f"{STOPPED_SINCE}{f'by {by}' if by else 'behaviours started over'}", "stopped_since")

    def _go_on(self, run: Run) -> None:
        self._senses.listen(self._streams | WATCHED)
        results = [received.message for received in self.ctx.take("results")]
        self._holder.step(results)
        if why := self._stopped_by_others():
            run.stop(why)
        now = self.ctx.clock()
        self._report(run, now)
        run.step(now, self._senses.look)
        self._do(run, now)
        if run.over is not None:
            self._end(run)

    def _report(self, run: Run, now: float) -> None:
        """Report the end of a motion to the run; a drive without an end is done once it has begun."""
        good, why = self._holder.good, self._holder.ended
        begun = self._holder.holds and not bounded(self._holder.motion)
        if run.paused or not (begun or why):
            return
        outcome = Outcome(good, why) if why else Outcome(True, Reason("done", "it drives"))
        if why:
            self._holder.release("it is over")
        if isinstance(run.order, Motion) and run.ticket == self._ticket:
            run.ended(outcome, now)
        elif run.keeps is not None and why:
            run.lost(outcome)

    def _do(self, run: Run, now: float) -> None:
        """Carry out the run's order."""
        if run.paused or run.over is not None:
            self._holder.release("the table is paused" if run.paused else "the table is over")
            return
        order = run.order
        if isinstance(order, Halt):
            self._holder.release("the table says so")
            run.ended(DONE, now)
        elif isinstance(order, Aside):
            self._ask_aside(run, order, now)
        wanted: Motion | None = order if isinstance(order, Motion) else run.keeps
        if wanted is None:
            if self._holder.lease is not None:
                self._holder.release("the table goes on without it")
        elif self._holder.lease is None or (run.ticket != self._ticket and wanted is order):
            self._holder.begin(TARGETS[type(wanted)], replace(wanted, ttl_s=self.ctx.settings.ttl_s))
        self._ticket = run.ticket

    def _ask_aside(self, run: Run, order: Aside, now: float) -> None:
        """Send a side request, if this robot has an answerer. A table neither waits for it nor fails without it."""
        way = "say" if isinstance(order, SayCommand) else "watch"
        if self.ctx.targets(way):
            self._aside = [*self._aside, (way, self.ctx.ask(way, order, ASIDE_S))][-MOST_ASIDE:]
        run.ended(DONE, now)

    def _read_asides(self) -> None:
        """Report the side requests that failed."""
        for way, asked in [one for one in self._aside if one[1].answers() is not None]:
            self._aside.remove((way, asked))
            for name, reply in (asked.answers() or {}).items():
                if not isinstance(reply, CommandReply) or not reply.accepted:
                    why = reply.reason if isinstance(reply, CommandReply) else "it does not answer"
                    kind, does = NOT_DONE[way]
                    self.ctx.event(kind, f"'{name}' {does}: {why}", level="warning")

    def _stopped_by_others(self) -> Reason | None:
        """Return why another sender stopped the robot since the run began, or None. All messages count, not the newest
        alone: the table's own halt may come right behind another's stop."""
        moved = (*self.ctx.targets("seek"), *self.ctx.targets("play"))  # these report its own stop, too
        own = {"", self.ctx.name, *moved}
        for received in (one for stream in WATCHED for one in self._senses.arrived(stream)):
            state = received.message
            if state.estop and received.arrived > self._began:
                return Reason("estop", state.reason or "emergency stop")
            for at, by in ((state.stopped_s, state.stopped_by), (state.halted_s, state.halted_by)):
                if at is None or by in own:
                    continue
                if _on_our_clock(received, at) > self._began:
                    return Reason("stopped", f"stopped by {by}")
        return None

    def _ordered(self, order: str, call: Call) -> str:
        run, now = self._run, self.ctx.clock()
        if run is None:
            raise InputError("no behaviour runs: /behaviour/run/NAME begins one", "idle")
        if order == "pause":
            run.pause(now)
            self._do(run, now)
            return f"{run.table} is paused in '{run.state}'; /behaviour/resume goes on"
        if order == "step" and not run.paused:
            raise InputError("it is not paused: /behaviour/pause first, then one step at a time", "refused")
        self._refuse_late(call)
        run.resume(now, one_step=order == "step")
        return f"{run.table} goes on from '{run.state}'" + (" up to the next state" if order == "step" else "")

    def woke(self, slept_s: float) -> None:
        """End the run: its purpose lies before the sleep."""
        self._held_up(slept_s)

    def _held_up(self, seconds: float) -> None:
        self._stop(Reason("lapsed", f"it was held up for {seconds:.0f} s; run it again"))

    def _stop(self, why: Reason) -> None:
        if self._run is not None:
            self._run.stop(why)
            self._end(self._run)

    def _end(self, run: Run) -> None:
        """Stand still, and report the end of the run."""
        self._holder.release("the behaviour is over")
        self._last = self._state(over=True)
        self._run = None
        why = run.over or DONE.why
        name = (run.called or (run.table,))[0]
        level = "info" if run.good or why.code == "stopped" else "warning"
        ended = f"{name} {why.text}" if run.good else f"{name} failed in '{self._last.state}': {why.text}"
        self.ctx.event("behaviour_ended", ended, level=level, code=why.code)

    def _follow(self) -> None:
        """Compile edited rows; the table that runs goes by it from its next state on."""
        before = {**self._library.good(), **(self._run.tables if self._run is not None else {})}
        self._library.compile()
        if self._run is None:
            return
        run, tables = self._run, self._library.good()
        for name in {run.table, *run.called} & before.keys():
            if why := self._library.refusal(name):
                tables[name] = before[name]
                self.ctx.event("behaviour_refused", f"it goes on as it was: {why}", level="warning", code="bad_value")
        run.replace(tables)
        self._streams |= frozenset(key.stream for table in tables.values() for key in table.keys) & self._senses.streams

    def _drawing(self, name: str) -> str:
        name = name or self._published.table
        if not name:
            raise InputError("no behaviour ran yet: /behaviour/show/NAME shows one", "idle")
        at = self._published.state if self._run is not None and self._published.table == name else ""
        return self._library.drawing(name, at)

    def _state(self, *, over: bool = False) -> BehaviourState:
        run = self._run
        if run is None:
            return self._last
        now = self.ctx.clock()
        state_s, run_s = run.times(now)
        rows: tuple[RowView, ...] = () if over else run.why(now, self._senses.look)
        why = run.over
        return BehaviourState(
            phase="ended" if over else "paused" if run.paused else "running",
            table=run.table,
            state=run.state,
            called=run.called,
            doing=run.doing,
            state_s=round(state_s, 2),
            run_s=round(run_s, 2),
            transitions=run.transitions,
            row=run.row,
            result=run.result,
            variables=dict(run.variables),
            rows=rows,
            good=run.good if over else None,
            reason=why.text if why is not None else "",
            code=why.code if why is not None else "",
        )

    def _publish(self) -> None:
        """Publish the state of the run: at once after a change, else at a steady rate."""
        now, run = self.ctx.clock(), self._run
        before = self._published
        same = (run is None and before is self._last) or (
            run is not None
            and (before.phase, before.table, before.state, before.doing)
            == ("paused" if run.paused else "running", run.table, run.state, run.doing)
        )
        if same and now < self._publish_at:
            return
        self._publish_at = now + (STATE_EVERY_S if run is not None else RESTING_EVERY_S)
        self._published = self._state()
        self.ctx.publish("state", self._published)


def _on_our_clock(received: Received, at_s: float) -> float:
    """Convert a time of the sender's clock, which may be another machine's, to this machine's clock."""
    stamp = received.stamp
    return at_s if stamp is None else received.arrived - (stamp.mono_ns / 1e9 - at_s)
