"""One session of an agent with a robot: from the first report to the loss of contact, with the share in between."""

import time
from collections import deque
from collections.abc import Callable
from math import inf
from pathlib import Path

from msgspec import Raw
from msgspec.structs import replace

from lbr import home, plugins
from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.bus.links import Links
from lbr.bus.session import Session
from lbr.capability import registry
from lbr.console.remote import RefusedError
from lbr.console.target import Target
from lbr.errors import BusError, MalformedError
from lbr.executive.planning import machine
from lbr.executive.planning import plan as plans
from lbr.executive.planning.process_specs import ProcessSpec, with_learnt
from lbr.executive.processes.fork_server import ForkServer
from lbr.executive.processes.logs import trim_all
from lbr.executive.processes.mainthread import MainThread
from lbr.executive.processes.overview import Overview
from lbr.executive.processes.process_host import Child, ProcessHost
from lbr.executive.processes.reaper import Reaper
from lbr.executive.processes.supervisor import Supervisor
from lbr.executive.remote import host_protocol
from lbr.executive.remote.host_protocol import HostReport, HostShare, Learnt, Placed
from lbr.messages.system import EstopState, Event, Status

ANSWER_S = 1.0
TAKEN_S = host_protocol.GONE_S + 1.0
"""By then the robot has forgotten a dead agent, and this one takes its place."""
END_S, LOST_END_S = 2.5, 0.5
"""The time for the processes to end; without contact, nothing that they wait for comes."""
TRIM_S = 1.0
MOST_WAITING = 64
_shares = Decoder(HostShare)
_latches = Decoder(EstopState)
_statuses = Decoder(Status)


class AgentSession:
    """Supervises a host's share on this machine; to be used from the thread of `main`."""

    def __init__(
        self,
        bus: Session,
        robot: Target,
        host: str,
        main: MainThread,
        reaper: Reaper,
        forks: ForkServer,
        *,
        agent: str,
        where: str,
        say: Callable[[str], None],
    ) -> None:
        self._bus = bus
        self._robot = robot
        self._host = host
        self._main = main
        self._reaper = reaper
        self._forks = forks
        self._agent = agent
        self._where = where
        self._say = say
        self._source = f"agent {host}"
        self._home = str(home.home())
        self._version = plugins.version()
        self._mark = ""
        self._placed: dict[str, Placed] = {}
        self._events: deque[Event] = deque(maxlen=MOST_WAITING)
        self._learns: deque[Learnt] = deque()
        self._presence = wire.Presence(bus, robot.robot, lambda _name, _alive: main.wake())
        self._token = wire.alive(bus, robot.robot, keys.agent(host))
        self._links = Links(bus, ("tls", "tcp"), main.wake)
        self._processes = ProcessHost(home.directory("logs"), reaper, forks)
        self._supervisor = Supervisor(
            self._start,
            self._happened,
            lambda name: name in self._presence.names,
            learnt=self._learnt,
            at_once=machine.at_once(),
            poll=self._processes.poll,
        )
        self._overview = Overview(self._supervisor)
        self._since = self._heard_at = time.monotonic()
        self._accepted = False
        self._question: wire.PendingQuery | None = None
        self._told: HostReport | None = None
        self._ask_at = self._trim_at = -inf
        self._over = ""

    def run(self, stopping: Callable[[], bool]) -> str:
        """Return why contact ended, once all processes of the share have; raise RefusedError if it never began."""
        try:
            while not (self._over or stopping()):
                now = time.monotonic()
                due = self._supervisor.step()
                self._converse(now)
                if now >= self._trim_at:
                    self._trim_at = now + TRIM_S
                    trim_all(home.home() / "logs")
                    if why := self._reaper.step():
                        self._say(f"the process that ends what is left over cannot be started: {why}")
                self._wait(max(0.0, min(due, self._ask_at - now if self._question is None else host_protocol.REPORT_S)))
        finally:
            self._supervisor.shut_down(self._wait, limit_s=LOST_END_S if self._over else END_S)
            self._reaper.rest()
        if self._accepted and not self._over:
            self._leave()
        return self._over

    # -- with the executive -------------------------------------------------------------------------------------------

    def _converse(self, now: float) -> None:
        if self._accepted and any(not one.connected for one in self._links.take()):
            self._over = f"contact with robot '{self._robot.robot}' is lost"
            return
        if self._question is None and now >= self._ask_at:
            self._ask_at = now + host_protocol.REPORT_S
            self._question = self._report()
        question = self._question
        if question is not None and question.replies:
            self._question = None
            self._read(question.replies[0], now)
        elif question is not None and question.done:
            self._question = None
        if not now - self._heard_at < (host_protocol.LOST_S if self._accepted else ANSWER_S):
            self._unanswered()

    def _report(self, *, leaving: bool = False) -> wire.PendingQuery:
        events = tuple(self._events)[: host_protocol.MOST_EVENTS]
        self._told = HostReport(
            agent=self._agent,
            where=self._where,
            share=self._mark,
            states=() if leaving else self._overview.capabilities(time.monotonic()),
            events=events,
            learnt=tuple(self._learns),
            leaving=leaving,
        )
        return wire.PendingQuery(
            self._bus,
            keys.host(self._robot.robot, self._host),
            wire.encode(self._told),
            timeout_s=ANSWER_S,
            source=self._source,
            wake=self._main.wake,
        )

    def _read(self, raw: wire.RawMessage, now: float) -> None:
        try:
            share = _shares.decode(raw.payload)
        except MalformedError as err:
            raise RefusedError(f"the robot's answer cannot be read ({err}): {self._versions('another')}") from err
        if not share.accepted:
            if now - self._since > TAKEN_S:
                raise RefusedError(share.reason)
            self._heard_at = now
            return
        if share.version != self._version:
            raise RefusedError(self._versions(share.version))
        self._heard_at = now
        if share.ended:
            self._over = f"robot '{self._robot.robot}' has shut down"
            return
        self._delivered()
        if not self._accepted:
            self._accepted = True
            self._say(f"host '{self._host}' of robot '{self._robot.robot}' at {self._robot.endpoints[0]}")
        if share.units is not None and share.share != self._mark:
            self._adopt(share.units)
            self._mark = share.share

    def _versions(self, theirs: str) -> str:
        return f"the robot has lbr {theirs} and this machine {self._version}; install the same on both"

    def _delivered(self) -> None:
        """Forget the reports that were acknowledged."""
        told = self._told
        if told is not None:
            self._events = deque((one for one in self._events if one not in told.events), self._events.maxlen)
            self._learns = deque(one for one in self._learns if one not in told.learnt)
        self._told = None

    def _unanswered(self) -> None:
        if self._accepted:
            self._over = f"robot '{self._robot.robot}' does not answer any more"
            return
        answers = wire.ask(self._bus, keys.status(self._robot.robot), None, source=self._source, timeout_s=ANSWER_S)
        if not answers:
            raise BusError(f"robot '{self._robot.robot}' does not answer")
        status = _statuses.decode(answers[0].payload)
        known = sorted({one.host for one in status.capabilities if one.host})
        if self._host not in known:
            which = f"it names {', '.join(known)}" if known else "it names no host"
            text = f"robot '{status.robot}' runs by profile '{status.profile}', which places nothing on '{self._host}'"
            raise RefusedError(f"{text}; {which}")
        how = f"'lbr token revoke {self._host}', then 'lbr token add {self._host} --role host' at the robot"
        raise RefusedError(f"the token '{self._host}' is not one for a host: {how}")

    def _leave(self) -> None:
        """Report that the share has ended here, without a long wait."""
        question = self._report(leaving=True)
        until = time.monotonic() + host_protocol.REPORT_S
        while not (question.replies or question.done) and time.monotonic() < until:
            self._main.wait(until - time.monotonic(), ())

    # -- with the processes -------------------------------------------------------------------------------------------

    def _adopt(self, placed: tuple[Placed, ...]) -> None:
        """Start, stop and restart the processes that differ from the running ones."""
        before, after = self._placed, {share.unit.name: share for share in placed}
        change = plans.Change(
            start=tuple(name for name in after if name not in before),
            stop=tuple(name for name in before if name not in after),
            restart=tuple(name for name, share in after.items() if name in before and share != before[name]),
        )
        self._placed = after
        units = {name: share.unit for name, share in after.items()}
        self._supervisor.adopt(units, change)

    def _start(self, unit: ProcessSpec) -> Child | None:
        if self._forks.begins:
            return None
        if not registry.same_content(registry.fingerprint(unit.kind, Path(self._home)), unit.fingerprint):
            raise BusError(f"{self._home}/capabilities/{unit.kind}.py is not the file that the robot has; copy it here")
        config = replace(
            unit.config,
            endpoints=self._robot.endpoints,
            certificate=self._robot.certificate,
            home=self._home,
            estop=self._latch() if unit.moves else unit.config.estop,
        )
        return self._processes.start(unit, config)

    def _latch(self) -> EstopState:
        answers = wire.ask(
            self._bus, keys.estop(self._robot.robot), None, source=self._source, timeout_s=host_protocol.REPORT_S
        )
        if not answers:
            raise BusError("the robot does not say whether its emergency stop is latched")
        return _latches.decode(answers[0].payload)

    def _wait(self, timeout_s: float) -> None:
        self._reaper.beat()
        self._main.wait(*self._supervisor.awaited(timeout_s))

    def _happened(self, kind: str, subject: str, text: str, level: str, code: str) -> None:
        self._say(f"{subject}: {text}")
        told = text[: host_protocol.LONGEST_TEXT]
        event = Event(kind=kind, subject=subject, text=told, level=level, code=code)  # type: ignore[arg-type]
        self._events.append(event)

    def _learnt(self, name: str, rows: dict[str, Raw]) -> None:
        """Keep rows that were learnt here: a share with the same rows restarts nothing."""
        if name in self._placed:
            one = replace(self._placed[name], unit=with_learnt(self._placed[name].unit, rows))
            self._placed[name] = one
            self._supervisor.parts[name].spec = one.unit
        self._learns.append(Learnt(name=name, rows=rows))
