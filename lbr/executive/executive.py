"""The executive: runs a robot by services that take turns, until asked to shut down. Motion ends first.

One thread owns the database, the processes and the plan. Console lines run in a pool beside it, and reach it by
`MainThread.call`.
"""

import os
import secrets
import time
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from msgspec import Raw

from lbr import home, plugins
from lbr.bus import keys, session, wire
from lbr.bus.access import TOOLS
from lbr.database.store import Database
from lbr.executive.notify import Notifier
from lbr.executive.planning import machine
from lbr.executive.planning.credentials import token_key
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.plan import Change, Plan
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.planning.watch import RowWatch
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.processes import doors
from lbr.executive.processes.doors import Doors, core_endpoint, local_endpoint
from lbr.executive.processes.fork_server import ForkServer
from lbr.executive.processes.logs import add
from lbr.executive.processes.mainthread import MainThread
from lbr.executive.processes.plugging import Plugging
from lbr.executive.processes.reaper import Reaper
from lbr.executive.processes.robot_processes import RobotProcesses
from lbr.executive.remote.remote_hosts import RemoteHosts
from lbr.executive.service import terminal
from lbr.executive.service.console_service import ConsoleService
from lbr.executive.service.dispatch import Dispatcher
from lbr.executive.service.edits import Edits
from lbr.executive.service.emergency import Emergency
from lbr.executive.service.journal import Journal
from lbr.executive.service.latch import Latch
from lbr.executive.service.pages import Pages
from lbr.executive.service.pairing import Pairing
from lbr.executive.service.pairing_service import Grants, PairingService
from lbr.executive.service.robot import Robot
from lbr.executive.service.row_service import RowService
from lbr.executive.service.status_service import StatusService
from lbr.executive.services import Service
from lbr.executive.shutdown import SIGNALS, Shutdown
from lbr.messages.system import EstopState


def run(
    profile: Profile,
    profile_name: str,
    database: Database,
    lock: home.RunLock,
    listen: tuple[str, ...],
    *,
    console: terminal.Start | None,
) -> int:
    """Run a robot until it is asked to shut down; return the exit code."""
    robot, core = profile.robot, (core_endpoint(profile.robot),)
    since, main, notifier = time.monotonic(), MainThread(), Notifier.from_environment()
    identity = RunIdentity(
        home=str(home.home()), endpoints=core, secret=secrets.token_bytes(32), listen=listen, token_key=token_key()
    )
    watch = RowWatch(database, profile, identity, machine.this_machine)
    plan = watch.first()
    shutdown = Shutdown(main.wake, signals=SIGNALS)
    shutdown.heed_signals()
    connect = partial(session.open_client, core, identity.credentials(doors.EXECUTIVE), lease_ms=session.HELD_MS)

    def publish(plan: Plan) -> None:
        """Publish on this machine how to reach the robot."""
        lock.publish(
            home.Running(
                robot=robot,
                pid=os.getpid(),
                endpoints=(local_endpoint(robot),),
                core=core_endpoint(robot),
                password=identity.credentials(TOOLS).password,
                lan=plan.lan,
                profile=profile_name,
                database=str(database.path),
            )
        )

    kinds = {kind.name for kind in plan.kinds.values()}
    with closing(Reaper()) as reaper:
        reaper.beat()
        with (
            closing(ForkServer(reaper, robot, kinds)) as forks,
            closing(Doors(plan, identity, main.wake)) as routers,
            connect() as bus,
        ):
            ground = Ground(since, main, shutdown, notifier, identity, reaper, forks, routers, bus, connect, publish)
            return compose(ground, profile, profile_name, database, watch, plan, console=console).run()


class Ground(NamedTuple):
    """The parts that are open before a robot is composed."""

    since: float
    main: MainThread
    shutdown: Shutdown
    notifier: Notifier
    identity: RunIdentity
    reaper: Reaper
    forks: ForkServer
    routers: Doors
    bus: session.Session
    connect: Callable[[], session.Session]
    publish: Callable[[Plan], None]


def compose(
    ground: Ground,
    profile: Profile,
    profile_name: str,
    database: Database,
    watch: RowWatch,
    plan: Plan,
    *,
    console: terminal.Start | None,
) -> "Executive":
    """Return the executive of a robot. It answers, is present on the bus, and is about to start its plan.

    Processes, emergency stop and rows depend on each other in a ring: each calls the next through a function.
    """
    robot, bus, main = plan.robot, ground.bus, ground.main
    served = partial(wire.QueryServer, bus, wake=main.wake, puts=False, source=EXECUTIVE)
    logs = home.directory("logs")

    def begun(name: str) -> EstopState:
        emergency.forget(name)
        return emergency.state()

    def learnt(name: str, tables: Mapping[str, Raw]) -> None:
        rows.learnt(name, tables)

    def present(name: str) -> bool:
        return name in presence.names

    journal = Journal(bus, robot, database, main.wake, lambda events: add(logs, events, rows.plan.log))
    presence = wire.Presence(bus, robot, lambda _name, _alive: main.wake())
    hosts = RemoteHosts(
        {name: served(keys.host(robot, name)) for name in profile.hosts},
        version=plugins.version(),
        happened=journal.happened,
        learnt=learnt,
        begun=begun,
        present=present,
    )
    processes = RobotProcesses(
        plan, ground.routers, ground.reaper, ground.forks, hosts, journal, present=present, begun=begun, learnt=learnt
    )
    plugging = Plugging(bus, robot, process=processes.process, restart=processes.restart, wake=main.wake)
    rows = LiveRows(database, watch, plan, journal, processes, plugging, ground.publish)
    latch = Latch(home.directory("run") / f"{robot}.estop", database, robot, journal.flush)
    latched = latch.state(plan.rows.robot)
    emergency = Emergency(
        robot,
        ground.connect,
        latched,
        journal,
        movers=processes.movers,
        seal=ground.identity.seal,
        persist=latch.persist,
        wake=main.wake,
    )
    status = StatusService(
        bus,
        profile_name,
        rows,
        processes,
        emergency,
        journal,
        ground.notifier,
        since=ground.since,
        announce=console is None,
    )
    journal.listeners.append(status.soon)
    path = database.path
    row_service = RowService(
        rows,
        Edits(served(keys.edit(robot)), path, rows, rows.judge, process=processes.process, happened=journal.happened),
        Pages(served(keys.manage(robot)), path, plan=lambda: rows.plan, make=rows.planned, happened=journal.happened),
        wake=main.wake,
    )
    pairing = Pairing()
    grants = Grants(database, rows, runs_since=processes.runs_since, happened=journal.happened)
    pairings = PairingService(served(keys.pair(robot)), pairing, grants, happened=journal.happened)
    asked = Robot(main, ground.shutdown, rows, processes, emergency, journal, status, pairing, database)
    names = {"robot": asked, "plan": lambda: rows.plan, "status": asked.status, "bus": bus, "keys": keys, "wire": wire}
    dispatcher = Dispatcher(asked, bus, names)
    lines = ConsoleService(bus, robot, dispatcher)
    token = wire.alive(bus, robot, EXECUTIVE)
    (home.directory("run") / f"{robot}-devices").mkdir(mode=0o700, exist_ok=True)
    ground.publish(plan)
    database.record_start(robot)
    journal.happened("run", EXECUTIVE, f"robot '{robot}' with profile '{profile_name}'", data=rows.adopted())
    if latched.engaged:
        text = f"the emergency stop is still latched ({latched.reason or 'pressed'}); 'reset' releases it"
        journal.happened("estop", EXECUTIVE, text, "warning")
    ground.reaper.beat()
    processes.take_over(plan, Change(start=tuple(plan.units)))

    def start_console() -> None:
        if console is not None:
            console(robot, ground.connect, dispatcher, ground.shutdown.begin)

    services = (lines, processes, row_service, pairings, plugging, rows, main, journal, emergency, status)
    return Executive(ground, journal, processes, start_console, token, services)


@dataclass(frozen=True, slots=True)
class Executive:
    """Runs a robot: steps its services, and closes them in their order. `token` shows its presence on the bus."""

    ground: Ground
    journal: Journal
    processes: RobotProcesses
    start_console: Callable[[], None]
    token: object
    services: tuple[Service, ...]

    def run(self) -> int:
        """Run until asked to shut down, and close everything; return the exit code."""
        shutdown = self.ground.shutdown
        try:
            self.start_console()
            while not shutdown.why:
                now = time.monotonic()
                due = min(service.step(now) for service in self.services)
                self._wait(due - time.monotonic())
        finally:
            self._close()
        return shutdown.code

    def _wait(self, timeout_s: float) -> None:
        """Wait for news or the next turn, and run the calls of other threads."""
        self.ground.notifier.beat()
        self.ground.reaper.beat()
        self.ground.main.wait(*self.processes.supervisor.awaited(max(0.0, timeout_s)))

    def _close(self) -> None:
        shutdown = self.ground.shutdown
        shutdown.begin("shutdown")
        shutdown.closing()
        self.ground.notifier.stopping(shutdown.why)
        self.journal.happened("shutdown", EXECUTIVE, shutdown.why)
        leaving = terminal.leave()
        self.processes.shut_down(self._wait)
        while leaving is not None and leaving.is_alive():  # its last lines may still need a call on this thread
            self._wait(0.02)
        for service in self.services:
            service.close()
