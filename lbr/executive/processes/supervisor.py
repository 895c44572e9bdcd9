"""Reconciles the processes with the plan: starts in order, gates on readiness, restarts, stops motion first.

Runs in one thread. The clock, the dice and the way to start a process are given, so that histories can be replayed.
"""

import random
import time
from collections.abc import Callable, Mapping
from math import inf

from msgspec import Raw

from lbr.capability.events import Throttle
from lbr.errors import LbrError
from lbr.executive.planning.plan import Change
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes import starvation as starving
from lbr.executive.processes.busy import Busy
from lbr.executive.processes.managed_process import ManagedProcess
from lbr.executive.processes.process_host import TERM_S, Child
from lbr.executive.processes.restart import CODES, HEALTHY_S, WINDOW_S, End, decide, ended_by
from lbr.executive.processes.scheduling import BACKGROUND, MOTION, niceness
from lbr.executive.processes.starvation import OTHERS_STRETCH, RUNS_SHARE, STARTING_WORK_S, SUSPICIOUS_S, Look, verdict

HANG_S = 1.2
HANG_MOVER_S = 0.8
HANG_APP_S = 2.0
HANG_PROGRAM_S = 3.0
HANG_STARTING_S = 10.0
HANG_DEGRADED_S = 4.0
DEGRADED_PATIENCE_S = 1.5
WAY_S = 0.02
LOOK_AGAIN_S = 0.2
HEARTBEATS_S = 0.05
"""What ready processes report is read together, so often, unless they move something; an end is heard at once."""
LOAD_S, BUSY_SHARE = 3.0, 0.4
"""Whose main thread has waited for so much of three seconds is late with everything; a start makes others wait for
less."""
SETTLING_S = 2.5
"""Until then after its first word, what a capability still waits for is no trouble: it is told if it lasts."""
RUNNING = frozenset({"ready", "degraded"})
HELD = frozenset({"stopped", "failed"})
BEGINS = frozenset({"not_ready", "not_armed"})
"""What a capability lacks that has just begun, and will have in a moment."""
MACHINE = "machine"


class Supervisor:
    """Owns every process of the plan. `happened(kind, subject, text, level, code)` is told whatever people should know.

    `present(name)` says whether a capability has announced itself on the bus; until then it is not ready for others.
    `learnt(name, rows)` is told which rows a capability has learnt, by table. `start(unit)` returns None while its way
    onto the bus is being opened. At most `at_once` start at a time; what moves, drives a device or serves waits for no
    place among them.
    """

    def __init__(
        self,
        start: Callable[[ProcessSpec], Child | None],
        happened: Callable[[str, str, str, str, str], None],
        present: Callable[[str], bool] = lambda _name: True,
        *,
        clock: Callable[[], float] = time.monotonic,
        dice: random.Random | None = None,
        learnt: Callable[[str, dict[str, Raw]], None] = lambda _name, _rows: None,
        at_once: int = 1000,
        look: Callable[..., Look] | None = None,
    ) -> None:
        self.slots: dict[str, ManagedProcess] = {}
        self._leaving: list[ManagedProcess] = []
        self._throttle = Throttle()
        self._start = start
        self._happened = happened
        self._present = present
        self._learnt = learnt
        self._at_once = at_once
        self._look = look or starving.Looker().look
        self._busy = Busy()
        self._load_at = 0.0
        self._clock = clock
        self._dice = dice or random.Random()

    def adopt(self, units: Mapping[str, ProcessSpec], change: Change) -> None:
        """Take over a plan's processes: stop what is gone, restart what changed, start what is new; leave the rest
        alone.

        Who is to be told of devices or rows goes on, unless it is still starting: then it may not hear of them.
        """
        told = (*change.plug, *change.follow)
        starting = tuple(name for name in told if self.slots[name].phase == "starting")
        for name in (*change.stop, *change.restart, *starting):
            self._retire(self.slots.pop(name))
        for name in (*change.restart, *starting, *change.start):
            self.slots[name] = ManagedProcess(units[name])
        for name in told:
            self.slots[name].unit = units[name]
        self.slots = {name: self.slots[name] for name in units}

    def restart(self, name: str) -> None:
        """Restart a capability, with its past forgotten."""
        slot = self.slots[name]
        self._retire(slot)
        self.slots[name] = ManagedProcess(slot.unit)

    def children(self) -> list[tuple[ManagedProcess, Child]]:
        """Return every process that still runs."""
        slots = {id(slot): slot for slot in (*self.slots.values(), *self._leaving)}
        return [(slot, slot.child) for slot in slots.values() if slot.child is not None]

    def awaited(self, timeout_s: float) -> tuple[float, set[int]]:
        """Return for how many seconds at most to wait for news of processes, and on which descriptors."""
        fds: set[int] = set()
        for slot, child in self.children():
            if child.heard:
                timeout_s = 0.0
            if slot.phase == "ready" and not slot.unit.moves:
                timeout_s = min(timeout_s, HEARTBEATS_S)
                fds.add(child.fds[0])
            else:
                fds.update(child.fds)
        return timeout_s, fds

    def settled(self) -> bool:
        """Say whether everything that should run does, or has given up; what is degraded gets a moment to recover.

        Who says that it has just begun gets as long as its first troubles are not told.
        """
        return not self._leaving and all(self._is_settled(slot) for slot in self.slots.values())

    def _is_settled(self, slot: ManagedProcess) -> bool:
        begins = slot.code in BEGINS
        patience_over = self._clock() > (slot.settled_at if begins else slot.started_at + DEGRADED_PATIENCE_S)
        return slot.phase in HELD | {"ready"} or (slot.phase == "degraded" and patience_over) or self._held_up(slot)

    def _held_up(self, slot: ManagedProcess) -> bool:
        """Say whether it waits for something that will not come by itself."""
        needs = [self.slots[need] for need in slot.unit.needs if need in self.slots]
        lost = [need for need in needs if need.phase in HELD or (need.phase == "waiting" and self._held_up(need))]
        if slot.phase != "waiting" or not lost:
            return False
        slot.reason, slot.code = f"waits for '{lost[0].unit.name}', which is {lost[0].phase}", "unreachable"
        return True

    def step(self) -> float:
        """Do what is due; return the seconds until the next thing that may be due without news from a process."""
        now = self._clock()
        for slot, child in self.children():
            self._listen(slot, child, now)
            code = child.returncode()
            if code is not None:
                self._ended(slot, child, code, now)
            else:
                self._watch(slot, child, now)
        self._leaving = [slot for slot in self._leaving if slot.child is not None]
        if now >= self._load_at:
            self._load_at = now + LOAD_S
            self._look_at_load(now)
        if text := self._busy.over(now):
            self._happened("busy_over", MACHINE, text, "info", "")
        for slot in self.slots.values():
            if slot.child is not None and slot.tell_at is not None and now >= slot.tell_at and not self._busy.on:
                self._tell_phase(slot)
            if slot.child is None and slot.due_at is not None and now >= slot.due_at and self._may_start(slot):
                self._launch(slot, now)
        return self._next(now)

    def shut_down(self, tick: Callable[[float], None], limit_s: float = 2.5) -> None:
        """Stop motion first, then apps, operations, drivers and simulation; kill what does not end.

        `tick(seconds)` waits for news from the processes.
        """
        end = self._clock() + limit_s
        waves = [
            [slot for slot in self.slots.values() if slot.unit.moves],
            [slot for slot in self.slots.values() if slot.unit.family in {"app", "program"}],
            [slot for slot in self.slots.values() if slot.unit.family == "operation"],
            [slot for slot in self.slots.values() if slot.unit.family == "driver"],
            list(self.slots.values()),
        ]
        for wave in waves:
            for slot in reversed(wave):
                self._retire(slot, TERM_S)
            while any(slot.child is not None for slot in wave) and self._clock() < end:
                self.step()
                tick(0.02)
        for _slot, child in self.children():
            child.kill()
        while self.children():
            self.step()
            tick(0.02)

    def _may_start(self, slot: ManagedProcess) -> bool:
        if any(leaving.unit.name == slot.unit.name for leaving in self._leaving):
            return False
        if niceness(slot.unit) != MOTION and self._starting() >= self._at_once:
            return False
        return all(self.slots[need].phase in RUNNING for need in slot.unit.needs if need in self.slots)

    def _starting(self) -> int:
        return sum(slot.phase == "starting" for slot in self.slots.values())

    def _launch(self, slot: ManagedProcess, now: float) -> None:
        try:
            child = self._start(slot.unit)
        except (OSError, ValueError, LbrError) as err:
            self._after_end(slot, End.CRASHED, f"could not be started: {err}", now)
            return
        if child is None:
            slot.due_at = now + WAY_S
            return
        slot.child = child
        slot.due_at, slot.hung, slot.taken_along, slot.started_at, slot.beat_at = None, False, False, now, now
        slot.told, slot.tell_at = ("", ""), None
        slot.reason = slot.code = slot.final_report = ""
        slot.phase, slot.said = "starting", None
        if slot.unit.program is not None:
            slot.said = ("ready", "", "")
            if slot.unit.program.ready == "start":
                self._phase(slot, *slot.said)
                slot.said = None

    def _listen(self, slot: ManagedProcess, child: Child, now: float) -> None:
        for report in child.reports():
            slot.beat_at = now
            if report.counts:
                self._count(slot, report.counts, now)
            if report.learnt:
                self._learnt(slot.unit.name, report.learnt)
            if report.phase in {"ready", "degraded", "stopping"} and slot.wanted:
                slot.said = (report.phase, report.reason, report.code)
            elif report.phase in {"failed", "hung", "taken_along"}:
                slot.final_report = report.reason
                slot.hung, slot.taken_along = report.phase == "hung", report.phase == "taken_along"
        if slot.said is not None and self._present(slot.unit.name):
            self._phase(slot, *slot.said)
            slot.said = None

    @staticmethod
    def _count(slot: ManagedProcess, counts: dict[str, int], now: float) -> None:
        spent = now - slot.counted_at
        if slot.counts and spent > 0:
            slot.rates = {name: round((n - slot.counts.get(name, 0)) / spent, 1) for name, n in counts.items()}
        slot.counts, slot.counted_at = counts, now

    def _phase(self, slot: ManagedProcess, phase: str, reason: str, code: str) -> None:
        slot.code = code
        if slot.phase == phase and slot.reason == reason:
            return
        now = self._clock()
        if slot.phase == "starting":
            slot.settled_at = now + SETTLING_S
            if phase == "ready" and slot.child is not None:
                slot.child.settle()
        slot.phase, slot.reason = phase, reason  # type: ignore[assignment]
        if phase == "degraded" and (now < slot.settled_at or self._busy.on):
            slot.tell_at = max(now, slot.settled_at)
        elif phase in {"ready", "degraded"}:
            self._tell_phase(slot)

    def _tell_phase(self, slot: ManagedProcess) -> None:
        """Tell how it is, unless that is what was told last."""
        before, slot.told, slot.tell_at = slot.told, (slot.phase, slot.reason), None
        if slot.told == before:
            return
        if slot.phase == "ready":
            self._tell("recovered" if before[0] else "started", slot, slot.reason or "ready", "info")
        elif slot.phase == "degraded":
            self._tell("degraded", slot, slot.reason, "warning")

    def _watch(self, slot: ManagedProcess, child: Child, now: float) -> None:
        if slot.kill_at is not None and now >= slot.kill_at:
            slot.kill_at = None
            child.kill()
        elif slot.wanted and not slot.hung and (why := self._why_hung(slot, child, now)):
            slot.hung, slot.final_report = True, why
            child.kill()

    def _why_hung(self, slot: ManagedProcess, child: Child, now: float) -> str:
        """Say why a process counts as hung, or nothing; a program is known by its token alone, if it has one."""
        if slot.unit.program is None:
            return f"no heartbeat for {now - slot.beat_at:.1f} s" if self._hangs(slot, child, now) else ""
        if slot.unit.program.ready == "start":
            return ""
        if self._present(slot.unit.name):
            slot.beat_at = now
        missing = f"its liveliness token is missing for {now - slot.beat_at:.1f} s"
        return missing if self._hangs(slot, child, now) else ""

    def _hangs(self, slot: ManagedProcess, child: Child, now: float) -> bool:
        """Say whether a silence is a hang; who is not given the processor does not hang."""
        silent_s, patience_s = now - slot.beat_at, _patience_s(slot)
        if not silent_s > SUSPICIOUS_S or now < slot.look_at:
            return False
        seen = self._look(child.pid, now, main=child.thread)
        if slot.suspect is None or slot.suspect.at < slot.beat_at:
            slot.suspect = slot.newest = seen
        slot.newest = starving.following(slot.newest or slot.suspect, seen)
        if not silent_s > patience_s:
            slot.look_at = min(now + LOOK_AGAIN_S, max(now, slot.beat_at + patience_s))
            return False
        slot.look_at = now + WAY_S
        program = slot.unit.program is not None  # its token is shown by any of its threads
        said = verdict(
            silent_s,
            patience_s,
            slot.suspect,
            slot.newest,
            stretch=inf if program else OTHERS_STRETCH,
            may_run_s=inf if program or slot.phase not in RUNNING else RUNS_SHARE * patience_s,
            work_s=STARTING_WORK_S if slot.phase == "starting" and not program else 0.0,
        )
        if said == "starved":
            slot.look_at = now + LOOK_AGAIN_S
            self._starved(slot, silent_s, now)
        return said == "hung"

    def _look_at_load(self, now: float) -> None:
        """See who of those that run waits more for the processor than it has it; starting always takes a while."""
        for slot, child in self.children():
            before, slot.usual = slot.usual, None
            if slot.phase not in RUNNING or niceness(slot.unit) == BACKGROUND:
                continue
            seen = self._look(child.pid, now, all_threads=False, main=child.thread)
            slot.usual = starving.following(before, seen) if before is not None else seen
            waited_s = starving.waited_s(before, slot.usual) if before is not None else 0.0
            if before is not None and waited_s > BUSY_SHARE * (now - before.at):
                self._starved(slot, waited_s, now)

    def _starved(self, slot: ManagedProcess, waited_s: float, now: float) -> None:
        text = self._busy.starved(slot.unit.name, waited_s, now)
        if text:
            self._happened("too_busy", MACHINE, text, "warning", "busy")

    def _ended(self, slot: ManagedProcess, child: Child, code: int, now: float) -> None:
        child.close()
        slot.child, slot.kill_at = None, None
        if not slot.wanted:
            slot.phase, slot.reason, slot.code = "stopped", "", "done"
            self._tell("stopped", slot, "stopped", "info")
            return
        clean = code == 0 and slot.unit.program is not None
        end = End.HUNG if slot.hung else End.TAKEN if slot.taken_along else End.CLEAN if clean else End.CRASHED
        why = (
            slot.final_report
            if slot.final_report and end is not End.CLEAN
            else ended_by(code, program=slot.unit.program is not None)
        )
        why += "" if end is End.CLEAN else f"; its log: logs/{slot.unit.log}"
        if now - slot.started_at > HEALTHY_S:
            slot.deaths = ()
        self._after_end(slot, end, why, now)

    def _after_end(self, slot: ManagedProcess, end: End, why: str, now: float) -> None:
        decision = decide(slot.unit.restart, end, slot.deaths, now, self._dice.uniform(-1, 1))
        if end is not End.TAKEN:
            slot.deaths = (*(death for death in slot.deaths if now - death < WINDOW_S), now)
        slot.rates, slot.counts = {}, {}
        slot.reason = slot.last_end = f"{end.value}: {why}"
        slot.code = slot.end_code = CODES[end]
        if decision.what == "restart":
            slot.restarts += 1
            slot.phase, slot.due_at = "waiting", now + decision.delay_s
            self._tell(end.value, slot, f"{slot.reason}; restart in {decision.delay_s:.1f} s", "error")
        else:
            slot.phase, slot.due_at = decision.what, None
            slot.reason = slot.last_end = f"{slot.reason}; {decision.reason}"
            level = "info" if decision.what == "stopped" else "error"
            self._tell(decision.what if end is End.CLEAN else end.value, slot, slot.reason, level)
        self._tell_dependants(slot)

    def _tell_dependants(self, gone: ManagedProcess) -> None:
        for slot in self.slots.values():
            if gone.unit.name in slot.unit.needs and slot.phase in RUNNING:
                text = f"'{gone.unit.name}', which it needs, has {gone.reason}"
                self._tell("need_lost", slot, text, "warning", "unreachable")

    def _retire(self, slot: ManagedProcess, patience_s: float | None = None) -> None:
        slot.wanted = False
        slot.due_at = None
        if slot.child is None:
            slot.phase = "stopped"
            return
        if slot.kill_at is None:
            slot.phase = "stopping"
            slot.child.terminate()
            slot.kill_at = self._clock() + (slot.child.patience_s if patience_s is None else patience_s)
        if slot not in self._leaving:
            self._leaving.append(slot)

    def _next(self, now: float) -> float:
        times = [slot.due_at for slot in self.slots.values() if slot.due_at is not None and self._may_start(slot)]
        times += [slot.kill_at for slot, _ in self.children() if slot.kill_at is not None]
        if not self._busy.on:
            times += [slot.tell_at for slot, _ in self.children() if slot.tell_at is not None]
        times += [_look_due(slot) for slot, _ in self.children() if slot.unit.program is None and slot.wanted]
        return max(0.0, min((due - now for due in times), default=1.0))

    def _tell(self, kind: str, slot: ManagedProcess, text: str, level: str, code: str | None = None) -> None:
        if not self._throttle.take(f"{slot.unit.name} {kind}", self._clock()):
            return
        self._happened(kind, slot.unit.name, text, level, slot.code if code is None else code)


def _look_due(slot: ManagedProcess) -> float:
    """Return when its silence, if it lasts, is looked at next."""
    if slot.suspect is None or slot.suspect.at < slot.beat_at:
        return slot.beat_at + SUSPICIOUS_S + WAY_S
    return slot.look_at


def _patience_s(slot: ManagedProcess) -> float:
    patience = {"starting": HANG_STARTING_S, "degraded": HANG_DEGRADED_S}
    waits = niceness(slot.unit) == BACKGROUND  # such a one runs when others leave it time
    usual = HANG_MOVER_S if slot.unit.moves else HANG_APP_S if waits else HANG_S
    return patience.get(slot.phase, usual if slot.unit.program is None else HANG_PROGRAM_S)
