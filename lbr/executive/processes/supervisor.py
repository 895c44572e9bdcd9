"""Reconciles the processes with the plan: starts in order, gates on readiness, restarts, stops motion first.

Runs in one thread. Clock, random numbers and process start are injected, so that tests can replay histories.
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
from lbr.executive.processes.part import Part
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
SUSPICIOUS = {True: SUSPICIOUS_S, False: starving.CALM_SUSPICIOUS_S}
"""By whether it moves something."""
LOAD_S, BUSY_SHARE = 3.0, 0.4
"""A process whose main thread waited for this share of the time is late with everything; a start delays others less."""
SETTLING_S = 2.5
"""A capability that is degraded at its start is reported after this time: the reason may go away by itself."""
RUNNING = frozenset({"ready", "degraded"})
HELD = frozenset({"stopped", "failed"})
BEGINS = frozenset({"not_ready", "not_armed", "no_setpoint"})
"""The codes of a capability that has just begun, gone in a moment."""
MACHINE = "machine"


class Supervisor:
    """Owns every process of the plan. `happened(kind, subject, text, level, code)` receives events for people.

    A capability is ready for others once it is `present(name)` on the bus. `learnt(name, rows)` receives the rows that
    it has learnt, by table. `start(spec)` returns None while its router is being opened. At most `at_once` start at a
    time; movers, drivers and servers are exempt from that. `poll()` checks which processes have news.
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
        poll: Callable[[], None] = lambda: None,
    ) -> None:
        self.parts: dict[str, Part] = {}
        self._leaving: list[Part] = []
        self._throttle = Throttle()
        self._start = start
        self._happened = happened
        self._present = present
        self._learnt = learnt
        self._at_once = at_once
        self._look = look or starving.Looker().look
        self._poll = poll
        self._busy = Busy()
        self._load_at = 0.0
        self._clock = clock
        self._dice = dice or random.Random()

    def adopt(self, specs: Mapping[str, ProcessSpec], change: Change) -> None:
        """Adopt the processes of a plan: stop, restart and start those that changed, and leave the others alone.

        A process that is to receive devices or rows goes on. If it is still starting, it may miss them, and is
        restarted.
        """
        informed = (*change.plug, *change.follow)
        starting = tuple(name for name in informed if self.parts[name].phase == "starting")
        for name in (*change.stop, *change.restart, *starting):
            self._retire(self.parts.pop(name))
        for name in (*change.restart, *starting, *change.start):
            self.parts[name] = Part(specs[name])
        for name in informed:
            self.parts[name].spec = specs[name]
        self.parts = {name: self.parts[name] for name in specs}

    def restart(self, name: str) -> None:
        """Restart a capability, and forget its earlier ends."""
        part = self.parts[name]
        self._retire(part)
        self.parts[name] = Part(part.spec)

    def children(self) -> list[tuple[Part, Child]]:
        """Return every process that still runs."""
        parts = {id(part): part for part in (*self.parts.values(), *self._leaving)}
        return [(part, part.child) for part in parts.values() if part.child is not None]

    def awaited(self, timeout_s: float) -> tuple[float, set[int]]:
        """Return how long to wait for news, at most `timeout_s`, and on which descriptors: a ready part may wait."""
        fds: set[int] = set()
        for part, child in self.children():
            if child.has_reports:
                timeout_s = 0.0
            fds.update(child.fds[:1] if part.phase == "ready" else child.fds)
        return timeout_s, fds

    def settled(self) -> bool:
        """Return whether each capability runs or has given up.

        A degraded one gets a moment to recover, a longer one for the reasons in BEGINS.
        """
        return not self._leaving and all(self._is_settled(part) for part in self.parts.values())

    def _is_settled(self, part: Part) -> bool:
        begins = part.code in BEGINS
        patience_over = self._clock() > (part.settled_at if begins else part.started_at + DEGRADED_PATIENCE_S)
        return part.phase in HELD | {"ready"} or (part.phase == "degraded" and patience_over) or self._held_up(part)

    def _held_up(self, part: Part) -> bool:
        """Return whether it waits for something that will not come by itself."""
        needs = [self.parts[need] for need in part.spec.needs if need in self.parts]
        lost = [need for need in needs if need.phase in HELD or (need.phase == "waiting" and self._held_up(need))]
        if part.phase != "waiting" or not lost:
            return False
        part.reason, part.code = f"waits for '{lost[0].spec.name}', which is {lost[0].phase}", "unreachable"
        return True

    def step(self) -> float:
        """Do what is due; return the seconds until the next due step, provided that no process has news."""
        now = self._clock()
        self._poll()
        for part, child in self.children():
            self._listen(part, child, now)
            code = child.returncode()
            if code is not None:
                self._ended(part, child, code, now)
            else:
                self._watch(part, child, now)
        self._leaving = [part for part in self._leaving if part.child is not None]
        if now >= self._load_at:
            self._load_at = now + LOAD_S
            self._look_at_load(now)
        if text := self._busy.over(now):
            self._happened("busy_over", MACHINE, text, "info", "")
        for part in self.parts.values():
            if part.child is not None and now >= part.announce_at and not self._busy.on:
                self._announce_phase(part)
            if part.child is None and now >= part.due_at and self._may_start(part):
                self._launch(part, now)
        return self._next(now)

    def shut_down(self, tick: Callable[[float], None], limit_s: float = 2.5) -> None:
        """Stop motion first, then apps, operations, drivers and simulation; kill processes that do not end.

        `tick(seconds)` waits for news from the processes.
        """
        end = self._clock() + limit_s
        waves = [
            [part for part in self.parts.values() if part.spec.moves],
            [part for part in self.parts.values() if part.spec.family in {"app", "program"}],
            [part for part in self.parts.values() if part.spec.family == "operation"],
            [part for part in self.parts.values() if part.spec.family == "driver"],
            list(self.parts.values()),
        ]
        for wave in waves:
            for part in reversed(wave):
                self._retire(part, TERM_S)
            while any(part.child is not None for part in wave) and self._clock() < end:
                self.step()
                tick(0.02)
        for _part, child in self.children():
            child.kill()
        while self.children():
            self.step()
            tick(0.02)

    def _may_start(self, part: Part) -> bool:
        if any(leaving.spec.name == part.spec.name for leaving in self._leaving):
            return False
        if niceness(part.spec) != MOTION and self._starting() >= self._at_once:
            return False
        return all(self.parts[need].phase in RUNNING for need in part.spec.needs if need in self.parts)

    def _starting(self) -> int:
        return sum(part.phase == "starting" for part in self.parts.values())

    def _launch(self, part: Part, now: float) -> None:
        try:
            child = self._start(part.spec)
        except (OSError, ValueError, LbrError) as err:
            self._after_end(part, End.CRASHED, f"could not be started: {err}", now)
            return
        if child is None:
            part.due_at = now + WAY_S
            return
        part.child = child
        part.due_at, part.hung, part.taken_along, part.started_at, part.beat_at = inf, False, False, now, now
        part.announced, part.announce_at = ("", ""), inf
        part.reason = part.code = part.final_report = ""
        part.phase, part.reported = "starting", None
        if part.spec.program is not None:
            part.reported = ("ready", "", "")
            if part.spec.program.ready == "start":
                self._phase(part, *part.reported)
                part.reported = None

    def _listen(self, part: Part, child: Child, now: float) -> None:
        for report in child.reports():
            part.beat_at = max(part.beat_at, min(now, report.at or now))
            if report.counts:
                self._count(part, report.counts, now)
            if report.learnt:
                self._learnt(part.spec.name, report.learnt)
            if report.phase in {"ready", "degraded", "stopping"} and part.wanted:
                part.reported = (report.phase, report.reason, report.code)
            elif report.phase in {"failed", "hung", "taken_along"}:
                part.final_report = report.reason
                part.hung, part.taken_along = report.phase == "hung", report.phase == "taken_along"
        if part.reported is not None and self._present(part.spec.name):
            self._phase(part, *part.reported)
            part.reported = None

    @staticmethod
    def _count(part: Part, counts: dict[str, int], now: float) -> None:
        spent = now - part.counted_at
        if part.counts and spent > 0:
            part.rates = {name: round((n - part.counts.get(name, 0)) / spent, 1) for name, n in counts.items()}
        part.counts, part.counted_at = counts, now

    def _phase(self, part: Part, phase: str, reason: str, code: str) -> None:
        part.code = code
        if part.phase == phase and part.reason == reason:
            return
        now = self._clock()
        if part.phase == "starting":
            part.settled_at = now + SETTLING_S
            if phase == "ready" and part.child is not None:
                part.child.settle()
        part.phase, part.reason = phase, reason  # type: ignore[assignment]
        if phase == "degraded" and (now < part.settled_at or self._busy.on):
            part.announce_at = max(now, part.settled_at)
        elif phase in {"ready", "degraded"}:
            self._announce_phase(part)

    def _announce_phase(self, part: Part) -> None:
        """Announce its phase and reason, unless they are the ones announced last."""
        before, part.announced, part.announce_at = part.announced, (part.phase, part.reason), inf
        if part.announced == before:
            return
        if part.phase == "ready":
            self._announce("recovered" if before[0] else "started", part, part.reason or "ready", "info")
        elif part.phase == "degraded":
            self._announce("degraded", part, part.reason, "warning")

    def _watch(self, part: Part, child: Child, now: float) -> None:
        if now >= part.kill_at:
            part.kill_at = inf
            child.kill()
        elif part.wanted and not part.hung and (why := self._why_hung(part, child, now)):
            part.hung, part.final_report = True, why
            child.kill()

    def _why_hung(self, part: Part, child: Child, now: float) -> str:
        """Return why a process counts as hung, or an empty text; a program counts by its liveliness token alone."""
        if part.spec.program is None:
            return f"no heartbeat for {now - part.beat_at:.1f} s" if self._hangs(part, child, now) else ""
        if part.spec.program.ready == "start":
            return ""
        if self._present(part.spec.name):
            part.beat_at = now
        missing = f"its liveliness token is missing for {now - part.beat_at:.1f} s"
        return missing if self._hangs(part, child, now) else ""

    def _hangs(self, part: Part, child: Child, now: float) -> bool:
        """Return whether a silence is a hang; a process starved of the processor does not hang."""
        silent_s, patience_s = now - part.beat_at, _patience_s(part)
        if not silent_s > SUSPICIOUS[part.spec.moves] or now < part.look_at:
            return False
        seen = self._look(child.pid, now, main=child.thread)
        if part.suspect is None or part.suspect.at < part.beat_at:
            part.suspect = part.newest = seen
        part.newest = starving.following(part.newest or part.suspect, seen)
        if not silent_s > patience_s:
            part.look_at = min(now + LOOK_AGAIN_S, max(now, part.beat_at + patience_s))
            return False
        part.look_at = now + WAY_S
        program = part.spec.program is not None  # any of its threads shows its token
        judgement = verdict(
            silent_s,
            patience_s,
            part.suspect,
            part.newest,
            stretch=inf if program else OTHERS_STRETCH,
            may_run_s=inf if program or part.phase not in RUNNING else RUNS_SHARE * patience_s,
            work_s=STARTING_WORK_S if part.phase == "starting" and not program else 0.0,
            looked_at_s=starving.LOOKED_AT_S + SUSPICIOUS[part.spec.moves] - SUSPICIOUS_S,
        )
        if judgement == "starved":
            part.look_at = now + LOOK_AGAIN_S
            self._starved(part, silent_s, now)
        return judgement == "hung"

    def _look_at_load(self, now: float) -> None:
        """Find the running processes that wait for the processor for too much of the time; a start always waits."""
        for part, child in self.children():
            before, part.usual = part.usual, None
            if part.phase not in RUNNING or niceness(part.spec) == BACKGROUND:
                continue
            seen = self._look(child.pid, now, all_threads=False, main=child.thread)
            part.usual = starving.following(before, seen) if before is not None else seen
            waited_s = starving.waited_s(before, part.usual) if before is not None else 0.0
            if before is not None and waited_s > BUSY_SHARE * (now - before.at):
                self._starved(part, waited_s, now)

    def _starved(self, part: Part, waited_s: float, now: float) -> None:
        text = self._busy.starved(part.spec.name, waited_s, now)
        if text:
            self._happened("too_busy", MACHINE, text, "warning", "busy")

    def _ended(self, part: Part, child: Child, code: int, now: float) -> None:
        child.close()
        part.child, part.kill_at = None, inf
        if not part.wanted:
            part.phase, part.reason, part.code = "stopped", "", "done"
            self._announce("stopped", part, "stopped", "info")
            return
        program = part.spec.program is not None
        clean = code == 0 and program
        end = End.HUNG if part.hung else End.TAKEN if part.taken_along else End.CLEAN if clean else End.CRASHED
        why = part.final_report if part.final_report and end is not End.CLEAN else ended_by(code, program=program)
        why += "" if end is End.CLEAN else f"; its log: logs/{part.spec.log}"
        if now - part.started_at > HEALTHY_S:
            part.deaths = ()
        self._after_end(part, end, why, now)

    def _after_end(self, part: Part, end: End, why: str, now: float) -> None:
        decision = decide(part.spec.restart, end, part.deaths, now, self._dice.uniform(-1, 1))
        if end is not End.TAKEN:
            part.deaths = (*(death for death in part.deaths if now - death < WINDOW_S), now)
        part.rates, part.counts = {}, {}
        part.reason = part.last_end = f"{end.value}: {why}"
        part.code = part.end_code = CODES[end]
        if decision.phase == "restart":
            part.restarts += 1
            part.phase, part.due_at = "waiting", now + decision.delay_s
            self._announce(end.value, part, f"{part.reason}; restart in {decision.delay_s:.1f} s", "error")
        else:
            part.phase, part.due_at = decision.phase, inf
            part.reason = part.last_end = f"{part.reason}; {decision.reason}"
            level = "info" if decision.phase == "stopped" else "error"
            self._announce(decision.phase if end is End.CLEAN else end.value, part, part.reason, level)
        self._announce_loss(part)

    def _announce_loss(self, gone: Part) -> None:
        for part in self.parts.values():
            if gone.spec.name in part.spec.needs and part.phase in RUNNING:
                text = f"'{gone.spec.name}', which it needs, has {gone.reason}"
                self._announce("need_lost", part, text, "warning", "unreachable")

    def _retire(self, part: Part, patience_s: float | None = None) -> None:
        part.wanted = False
        part.due_at = inf
        if part.child is None:
            part.phase = "stopped"
            return
        if part.kill_at == inf:
            part.phase = "stopping"
            part.child.terminate()
            part.kill_at = self._clock() + (part.child.patience_s if patience_s is None else patience_s)
        if part not in self._leaving:
            self._leaving.append(part)

    def _next(self, now: float) -> float:
        times = [part.due_at for part in self.parts.values() if part.due_at < inf and self._may_start(part)]
        for part, _ in self.children():
            times += [part.kill_at, inf if self._busy.on else part.announce_at]
            if part.spec.program is None and part.wanted:
                times.append(_look_due(part))
        return max(0.0, min([1.0, *(due - now for due in times)]))

    def _announce(self, kind: str, part: Part, text: str, level: str, code: str | None = None) -> None:
        if not self._throttle.take(f"{part.spec.name} {kind}", self._clock()):
            return
        self._happened(kind, part.spec.name, text, level, part.code if code is None else code)


def _look_due(part: Part) -> float:
    """Return when to look at it next if its silence lasts."""
    if part.suspect is None or part.suspect.at < part.beat_at:
        return part.beat_at + SUSPICIOUS[part.spec.moves] + WAY_S
    return part.look_at


def _patience_s(part: Part) -> float:
    patience = {"starting": HANG_STARTING_S, "degraded": HANG_DEGRADED_S}
    waits = niceness(part.spec) == BACKGROUND  # a background process runs when others leave it time
    usual = HANG_MOVER_S if part.spec.moves else HANG_APP_S if waits else HANG_S
    return patience.get(part.phase, usual if part.spec.program is None else HANG_PROGRAM_S)
