"""The executive: reads the rows, runs what they say, and answers all who speak to the robot.

One thread owns the database, the processes and the plan; console lines run in a pool beside it and reach it by `call`.
"""

import contextlib
import json
import math
import os
import secrets
import signal
import time
from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Raw
from msgspec.structs import replace

from lbr import home
from lbr.bus import keys, session, wire
from lbr.bus.access import TOOLS
from lbr.bus.stamp import Origin
from lbr.console.outlet import say
from lbr.console.toolbar import state_of
from lbr.console.verbs import ExternalCall, Vocabulary
from lbr.database import edits, store
from lbr.database.reading import Problem
from lbr.database.rows import RobotRows
from lbr.errors import InputError, LbrError
from lbr.executive.lastresort import SIGNALS, LastResort, noted_signals
from lbr.executive.notify import Notifier
from lbr.executive.planning import machine, planner, wiring
from lbr.executive.planning import plan as plans
from lbr.executive.planning.credentials import bus_certificate, token_key
from lbr.executive.planning.last_good_copy import LastGoodCopy
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.planning.watch import RowWatch
from lbr.executive.processes.doors import EXECUTIVE, Doors, core_endpoint, inside_endpoint, local_endpoint
from lbr.executive.processes.external import ExternalCommands
from lbr.executive.processes.fork_server import ForkServer
from lbr.executive.processes.logs import add, trim_all
from lbr.executive.processes.mainthread import MainThread
from lbr.executive.processes.plugging import Plugging
from lbr.executive.processes.process_host import Child, ProcessHost
from lbr.executive.processes.readiness import readiness
from lbr.executive.processes.reaper import Reaper
from lbr.executive.processes.supervisor import Supervisor
from lbr.executive.remote import host_protocol
from lbr.executive.remote.remote_hosts import RemoteHosts
from lbr.executive.service import terminal
from lbr.executive.service.conditions import Conditions
from lbr.executive.service.console_service import ConsoleService
from lbr.executive.service.dispatch import DONE, FAILED, Dispatcher
from lbr.executive.service.edits import Edits, oversized
from lbr.executive.service.emergency import Emergency
from lbr.executive.service.journal import Journal
from lbr.executive.service.latch import Latch, LatchKeeper
from lbr.executive.service.overview import Overview
from lbr.executive.service.pages import Pages
from lbr.executive.service.pairing import GOOD_FOR_S, Code, Pairing
from lbr.executive.service.pairing_service import Grants, PairingService
from lbr.executive.service.row_service import RowService
from lbr.messages.system import CapabilityStatus, ConsoleResult, EstopState, Event, Role, Status
from lbr.names import did_you_mean

LOOK_AT_ROWS_S = 0.2
LOOK_SHARE = 5.0
"""Rows that are slow to read are looked at less often: they get a fifth of the main thread's time."""
STATUS_S = 1.0
NO_REAPER = "if the executive were killed now, frozen processes would be left; the one that ends them cannot be started"


class Executive:
    """A running robot."""

    def __init__(
        self, profile: Profile, profile_name: str, database: store.Database, lock: home.RunLock, listen: tuple[str, ...]
    ) -> None:
        self._profile = profile
        self._profile_name = profile_name
        self._database = database
        self._lock = lock
        self._started_at = time.monotonic()
        self._main = MainThread()
        self._notifier = Notifier.from_environment()
        self._stopping = ""
        self._code = 0
        self._status_due = 0.0
        self._ready = False
        self._failed: AbstractSet[str] = frozenset()
        self._troubles = Conditions(self._happened)
        self._keeper = LastGoodCopy(database.path, self._troubles.tell)
        self._recent: list[Event] = []
        self._site = RunIdentity(
            home=str(home.home()),
            endpoints=(core_endpoint(profile.robot),),
            secret=secrets.token_bytes(32),
            listen=listen,
            token_key=token_key(),
        )
        self._rows = LiveRows(
            database,
            RowWatch(database, profile, self._site, machine.this_machine),
            self._keeper,
            happened=self._happened,
            take_over=self._change,
            kept=self._kept,
            plug=lambda world, devices: self._plugging.ask(world, devices),  # noqa: PLW0108 - it is made with the bus
            follow=lambda name, rows: self._plugging.tell(name, rows),  # noqa: PLW0108 - see above
            capabilities=self._capabilities,
        )
        self._supervisor = Supervisor(
            self._start,
            self._process_happened,
            lambda name: name in self._presence.names,
            learnt=self._rows.learnt,
            at_once=machine.at_once(),
        )
        self._overview = Overview(self._supervisor)

    def run(self, *, console: terminal.Start | None) -> int:
        """Open the bus, start everything and a console, and stay until told to shut down."""
        self._last_resort = LastResort(self._main.wake, signals=SIGNALS)
        noted = signal.set_wakeup_fd(self._last_resort.signal_fd, warn_on_full_buffer=False)
        for number in SIGNALS:
            signal.signal(number, lambda n, _frame: self._stop(f"signal {signal.Signals(n).name}"))
        if signal.SIGINT in noted_signals(noted):
            raise KeyboardInterrupt
        with closing(Reaper()) as self._reaper:
            self._reaper.beat()
            with (
                closing(ForkServer(self._reaper, self.plan.robot)) as self._forks,
                closing(Doors(self.plan, self._site, self._main.wake)) as self._doors,
                self._bus_again() as bus,
            ):
                self._processes = ProcessHost(home.directory("logs"), self._reaper, self._forks)
                self._open(bus)
                try:
                    if console is not None:
                        console(self.plan.robot, self._bus_again, self.dispatcher, self._console_ended)
                    self._loop(announce=console is None)
                finally:
                    self._close()
        return self._code

    @property
    def plan(self) -> Plan:
        """Return the plan that runs."""
        return self._rows.plan

    @property
    def vocabulary(self) -> Vocabulary:
        """Return the words that can be said."""
        return self._rows.vocabulary

    # -- what console lines need; from any thread ---------------------------------------------------------------

    def status(self) -> Status:
        """Return the robot at a glance."""
        return self._main.call(self._status)

    def recent_events(self) -> list[Event]:
        """Return the newest events, oldest first."""
        return list(self._recent)

    def estop(self, reason: str, source: str) -> ConsoleResult:
        """Latch the emergency stop; the answer tells which devices have acknowledged."""
        state = self._emergency.press(reason, source)
        if not state.engaged:
            return ConsoleResult(
                code=FAILED, text="the emergency stop was sent, but is not confirmed yet", reason_code="timeout"
            )
        waits = bool(state.waiting)
        return ConsoleResult(code=FAILED if waits else DONE, text=state.text, reason_code="timeout" if waits else "")

    def estop_reset(self, source: str, written_s: float) -> ConsoleResult:
        """Release the emergency stop, unless another has pressed it since that was written; moves nothing."""
        if why_not := self._emergency.release(source, written_s):
            return ConsoleResult(code=FAILED, text=why_not.text, reason_code=why_not.code)
        return ConsoleResult(code=DONE, text="emergency stop released; the next command may move the robot")

    def shutdown(self, source: str) -> None:
        """Begin the shutdown."""
        self._stop(f"Shutdown by {source}")

    def restart(self, name: str) -> None:
        """Restart a capability; InputError if none of that name runs."""
        self._main.call(lambda: self._restart(name))

    def pair(self, role: Role, who: str) -> Code:
        """Draw a code by which a device gets a token with a role; who asked for it is told, the code is not."""
        code = self._main.call(lambda: self._pairing.begin(role, who))
        text = f"{who} asked for a code: who types it within {GOOD_FOR_S:g} s gets a token with the role '{role}'"
        self.note("pair", text, who)
        return code

    def listen_at(self, name: str, host: str, who: str) -> None:
        """Write where a server listens, a setting of its row, as an edit; RowError or InputError if it may not be."""
        with store.Database.open(self._database.path, program="executive") as database:
            edits.write_setting(database, self.plan.robot, name, "host", host, self._judge, by=who).good()
        self.note("edit", f"{who} had '{name}' listen at {host}", who)

    def run_external(self, call: ExternalCall, who: str, origin: Origin, said_s: float) -> ConsoleResult:
        """Start an external command, and wait for a blocking one; who asked for what is written down before."""
        row = call.command
        argv = json.dumps([*row.argv, *call.arguments], ensure_ascii=False)
        self.note("external", f"'{row.name}' is started by {who}: {argv}", origin.source)
        command = self._main.call(lambda: self._external.start(row, call.arguments, origin, said_s))
        if not row.blocking:
            says = f"it writes to {home.directory('logs') / f'{row.name}.log'}, and 'stop {row.name}' ends it"
            return ConsoleResult(code=DONE, text=f"'{row.name}' started (pid {command.pid}); {says}")
        code, output = self._external.wait(row, command)
        return ConsoleResult(
            code=DONE if code == 0 else FAILED,
            text=output or f"'{row.name}' ended with {code}",
            reason_code="" if code == 0 else "failed",
        )

    def stop_external(self, name: str, who: str, about: str) -> str:
        """End an external command; who asked for that is written down."""
        told = self._external.stop(name)
        self.note("external", f"'{name}' was ended by {who}", about)
        return told

    def note(self, kind: str, text: str, about: str = "") -> None:
        """Write down an event of the executive's own, before anything else."""
        self._main.call(lambda: self._note(kind, text, about))

    def record(self, kind: str, who: str, text: str) -> None:
        """Put an entry into the audit trail, soon: no line, and no stop, waits for it."""
        self._main.post(lambda: self._journal.record(kind, who, text))

    # -- opening and closing --------------------------------------------------------------------------------------

    def _open(self, bus: session.Session) -> None:
        robot = self.plan.robot

        def served(key: str) -> wire.QueryServer:
            return wire.QueryServer(bus, key, self._main.wake, puts=False, source=wiring.EXECUTIVE)

        logs = home.directory("logs")

        self._external = ExternalCommands(logs, robot, self._reaper)

        def written(events: Sequence[Event]) -> None:
            add(logs, events, self.plan.log)

        self._journal = Journal(bus, robot, self._database, self._main.wake, self._troubles.tell, written)
        self._journal.listeners.append(self._remember)
        rows = self.plan.rows.robot
        keeper = LatchKeeper(
            Latch(home.directory("run") / f"{robot}.estop"), self._database, robot, self._journal.flush
        )
        estop = keeper.state(engaged=rows.estop_engaged, reason=rows.estop_reason)
        seen = {"robot": self, "plan": lambda: self.plan, "status": self.status, "bus": bus, "keys": keys, "wire": wire}
        self.dispatcher = Dispatcher(self, bus, seen)
        self._service = ConsoleService(bus, robot, self.dispatcher, reset=self.estop_reset)
        self._hosts = RemoteHosts(
            {name: served(keys.host(robot, name)) for name in self._profile.hosts},
            version=host_protocol.version(),
            happened=self._process_happened,
            learnt=self._rows.learnt,
            begun=self._begun_elsewhere,
            ways=self._lan,
            present=lambda name: name in self._presence.names,
        )
        path = self._database.path
        self._row_service = RowService(
            self._rows,
            Edits(
                served(keys.edit(robot)),
                path,
                self._rows,
                self._judge,
                process=self._process,
                happened=self._happened,
            ),
            Pages(
                served(keys.manage(robot)),
                path,
                plan=lambda: self.plan,
                make=self._planned,
                happened=self._happened,
            ),
            wake=self._main.wake,
        )
        self._pairing = Pairing()
        self._pairings = PairingService(
            served(keys.pair(robot)),
            self._pairing,
            Grants(self._database, self._rows, runs_since=self._runs_since, happened=self._happened),
            happened=self._happened,
        )
        self._plugging = Plugging(bus, robot, process=self._process, restart=self._begin_again, wake=self._main.wake)
        self._emergency = Emergency(
            robot,
            self._bus_again,
            estop,
            movers=self._movers,
            seal=self._site.seal,
            persist=keeper.persist,
            happened=self._happened,
            trouble=self._troubles.tell,
            reset=self._service.answer_reset,
            wake=self._main.wake,
        )
        self._begin(bus, estop)

    def _begin(self, bus: session.Session, estop: EstopState) -> None:
        """Answer, be seen, and start what is planned."""
        robot = self.plan.robot
        self._service.start()
        self._status_out = wire.Publisher(bus, keys.status(robot), "executive", renew=self._as_of_now)
        self._presence = wire.Presence(bus, robot, lambda _name, _alive: self._main.wake())
        self._alive = wire.alive(bus, robot, wiring.EXECUTIVE)
        (Path(self._site.home) / "run" / f"{robot}-devices").mkdir(mode=0o700, exist_ok=True)
        self._say_how_to_reach()
        self._database.record_start(robot)
        self._happened(
            "run", "executive", f"robot '{robot}' with profile '{self._profile_name}'", data=self._rows.adopted()
        )
        if estop.engaged:
            text = f"the emergency stop is still latched ({estop.reason or 'pressed'}); 'reset' releases it"
            self._happened("estop", "executive", text, "warning")
        self._reaper.beat()
        self._take_over(plans.Change(start=tuple(self.plan.units)))

    def _close(self) -> None:
        self._last_resort.begin()
        self._last_resort.heard()
        self._notifier.stopping(self._stopping or "shutdown")
        self._happened("shutdown", "executive", self._stopping or "shutdown", "info")
        leaving = terminal.leave()
        self._hosts.end()
        self._supervisor.shut_down(self._wait_and_answer)
        while leaving is not None and leaving.is_alive():  # its last lines may still ask something of this thread
            self._wait(0.02)
        self._external.close()
        self._service.close()
        self._hosts.close()
        self._row_service.close()
        self._pairings.close()
        self._main.close()
        self._journal.step(time.monotonic())
        self._journal.flush()
        with contextlib.suppress(LbrError):
            self._database.record_shutdown(self.plan.robot)
        self._emergency.close()
        self._notifier.close()

    # -- the loop ---------------------------------------------------------------------------------------------------

    def _loop(self, *, announce: bool) -> None:
        rows_at = 0.0
        while not self._stopping:
            now = time.monotonic()
            due = self._supervisor.step()
            for text in self._doors.tidy(child.endpoint for _slot, child in self._supervisor.children()):
                self._happened("link_mended", "executive", text, "warning")
            again = min(self._emergency.step(now), self._hosts.step(now), self._pairings.step(now))
            self._journal.step(now)
            self._keeper.step(now, self.plan.rows.digest)
            self._plugging.step()
            if self._row_service.step():
                rows_at = now
            if now >= rows_at:
                rows_at = now + LOOK_AT_ROWS_S
                self._rows.look()
                self._external.prune({row.name for row in self.plan.rows.external_commands})
                self._troubles.tell(NO_REAPER, self._reaper.step())
                rows_at = max(rows_at, now + LOOK_SHARE * (time.monotonic() - now))
            if now >= self._status_due:
                self._status_due = now + STATUS_S
                trim_all(home.home() / "logs")
                status = self._status()
                self._status_out.put(status)
                self._notifier.status(state_of(status)[1])
            if not self._ready and self._supervisor.settled():
                self._settled(announce=announce)
            self._wait(max(0.0, min(due, rows_at - now, self._status_due - now, again - now)))

    def _wait(self, timeout_s: float) -> None:
        self._notifier.beat()
        self._reaper.beat()
        self._main.wait(*self._supervisor.awaited(timeout_s))

    def _wait_and_answer(self, timeout_s: float) -> None:
        self._wait(timeout_s)
        self._hosts.step(time.monotonic())

    def _change(self, change: plans.Change) -> None:
        self._take_over(change)
        with contextlib.suppress(OSError):
            self._say_how_to_reach()

    def _take_over(self, change: plans.Change) -> None:
        here = self.plan.here
        self._doors.adopt(self.plan)
        self._hosts.adopt(self.plan.units.values())
        self._supervisor.adopt(here, plans.only(change, here.keys() | self._supervisor.parts.keys()))

    def _planned(self, rows: RobotRows) -> tuple[Plan | None, tuple[Problem, ...]]:
        """Plan for rows that are not written yet; from any thread."""
        on = machine.this_machine(machine.processes(self.plan.rows.capabilities, self.plan.here))
        plan, problems = planner.make(rows, self._profile, self._site, on, before=self.plan.rows)
        return plan, (*problems, *oversized(plan)) if plan is not None else problems

    def _judge(self, rows: RobotRows) -> tuple[Problem, ...]:
        return self._planned(rows)[1]

    def _begun_elsewhere(self, name: str) -> None:
        self._emergency.forget(name)

    def _process(self, name: str) -> object:
        part = self._supervisor.parts.get(name)
        return part.child if part is not None else None

    def _runs_since(self, name: str) -> float:
        part = self._supervisor.parts.get(name)
        return part.started_at if part is not None else math.inf

    def _kept(self, name: str) -> None:
        if name in self._supervisor.parts:
            self._supervisor.parts[name].spec = self.plan.units[name]
        self._hosts.adopt(self.plan.units.values())

    def _settled(self, *, announce: bool) -> None:
        """Say that all is up, or what is not: once for each way of not being ready, until it is."""
        found = readiness(self._capabilities())
        if not found.ready and found.failed.keys() == self._failed:
            return
        self._ready, self._failed = found.ready, found.failed.keys()
        text = found.words(time.monotonic() - self._started_at)
        if found.ready:
            self._keeper.touched(time.monotonic())
            self._happened("ready", "executive", text, "warning" if found.degraded else "info")
            self._notifier.ready()
        else:
            self._happened("not_ready", "executive", text, "error")
        self._status_out.put(self._status())
        if announce:
            said = {
                "ready": found.ready,
                "robot": self.plan.robot,
                "pid": os.getpid(),
                "endpoints": [local_endpoint(self.plan.robot)],
                "lan": list(self._lan()),
                "failed": found.failed,
                "degraded": found.degraded,
            }
            if why := say(json.dumps(said)):
                text = f"the line that says so cannot be printed: standard output cannot be written ({why})"
                self._happened("trouble", "executive", text, "warning")

    # -- small parts ------------------------------------------------------------------------------------------------

    def _restart(self, name: str) -> None:
        if name not in self.plan.units:
            raise InputError(f"'{name}' does not run; {did_you_mean(name, self.plan.units)}", "unknown_name")
        if not self._hosts.restart(name):
            self._supervisor.restart(name)

    def _begin_again(self, name: str, why: str) -> None:
        self._happened("restarting", name, why)
        self._supervisor.restart(name)

    def _start(self, unit: ProcessSpec) -> Child | None:
        place = self._doors.place(unit)
        if place is None or self._forks.begins:
            return None
        self._emergency.forget(unit.name)
        mates = [other for other in self.plan.here.values() if other.process == unit.process]
        reach = tuple(device.address for mate in mates for device in mate.config.devices)
        config = replace(unit.config, estop=self._emergency.state(), endpoints=(place.endpoint,), reach=reach)
        if unit.lan is not None:
            bus_certificate()
            inside = inside_endpoint(self.plan.robot, unit.name)
            config = replace(
                config, private=Raw(msgspec.json.encode(replace(unit.lan, upstream=place.router_id, inside=inside)))
            )
        return self._processes.start(unit, config)

    def _say_how_to_reach(self) -> None:
        robot = self.plan.robot
        self._lock.publish(
            home.Running(
                robot=robot,
                pid=os.getpid(),
                endpoints=(local_endpoint(robot),),
                core=core_endpoint(robot),
                password=self._site.credentials(TOOLS).password,
                lan=self._lan(),
                profile=self._profile_name,
                database=str(self._database.path),
            )
        )

    def _lan(self) -> tuple[str, ...]:
        configs = (unit.lan for unit in self.plan.units.values())
        return tuple(endpoint for lan in configs if lan is not None for endpoint in lan.listen)

    def _movers(self) -> list[str]:
        here = [
            name for name, part in list(self._supervisor.parts.items()) if part.spec.moves and part.child is not None
        ]
        return here + self._hosts.movers()

    def _status(self) -> Status:
        capabilities = self._capabilities()
        return Status(
            robot=self.plan.robot,
            profile=self._profile_name,
            ready=self._ready and not any(one.phase == "failed" for one in capabilities),
            pid=os.getpid(),
            uptime_s=round(time.monotonic() - self._started_at, 1),
            estop=self._emergency.state(),
            capabilities=capabilities,
            revision=self.plan.rows.revision,
            degraded=readiness(capabilities).degraded if self._ready else {},
            **self._problems(),
        )

    def _problems(self) -> dict[str, tuple[str, ...]]:
        """Return what is wrong now, and the codes of that."""
        rows, troubles = self._rows.problems, self._troubles.current
        codes = (*(self._rows.code for _ in rows), *("failed" for _ in troubles))
        return {"problems": (*rows, *troubles), "problem_codes": codes}

    def _as_of_now(self, status: Status) -> Status:
        """Return it with the emergency stop and the problems of now: who heard of one by an event reads nothing
        older."""
        return replace(status, estop=self._emergency.state(), **self._problems())

    def _capabilities(self) -> tuple[CapabilityStatus, ...]:
        here = {one.name: one for one in self._overview.capabilities(time.monotonic())}
        known = here | self._hosts.capabilities()
        return tuple(known[name] for name in self.plan.units if name in known)

    def _note(self, kind: str, text: str, about: str) -> None:
        self._journal.happened(kind, "executive", text, about=about)
        self._status_due = 0.0
        self._journal.flush()

    def _happened(
        self,
        kind: str,
        subject: str,
        text: str,
        level: str = "info",
        data: dict[str, Any] | None = None,
        *,
        code: str | None = None,
    ) -> None:
        self._status_due = 0.0
        self._journal.happened(kind, subject, text, level, data, code=code)

    def _process_happened(self, kind: str, subject: str, text: str, level: str, code: str) -> None:
        self._happened(kind, subject, text, level, code=code)

    def _remember(self, event: Event) -> None:
        self._recent = [*self._recent[-49:], event]

    def _stop(self, why: str) -> None:
        self._stopping = self._stopping or why
        self._last_resort.begin()
        self._main.wake()

    def _console_ended(self, code: int, why: str) -> None:
        self._code = code
        self._stop(why)

    def _bus_again(self) -> session.Session:
        credentials = self._site.credentials(EXECUTIVE)
        return session.open_client(self._site.endpoints, credentials, lease_ms=session.HELD_MS)
