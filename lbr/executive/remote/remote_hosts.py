"""The other machines that run a robot's processes, as the executive sees them: presence, and state of the shares."""

from collections.abc import Callable, Mapping
from math import inf

from msgspec import Raw
from msgspec.structs import replace

from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.errors import MalformedError
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.remote.host_protocol import GONE_S, TOLD, HostReport, HostShare, Placed, mark
from lbr.executive.services import Service
from lbr.messages.leases import CommandReply
from lbr.messages.system import CapabilityStatus

RUNNING = frozenset({"starting", "ready", "degraded", "stopping"})
_reports = Decoder(HostReport)


class Host:
    """One machine: its share, and its agent while there is one."""

    def __init__(self, name: str, served: wire.QueryServer) -> None:
        self.name = name
        self.served = served
        self.units: dict[str, ProcessSpec] = {}
        self.share: tuple[Placed, ...] = ()
        self.mark = ""
        self.agent = self.where = ""
        self.heard_at = -inf
        self.seen = False
        self.states: dict[str, CapabilityStatus] = {}


class RemoteHosts(Service):
    """Answers agents, at the key that `served` has for each host, from one thread.

    `happened(kind, subject, text, level, code)` receives events for people, `learnt(name, rows)` rows to write down,
    and `begun(name)` each new process there. `present(name)` is whether a capability is on the bus.
    """

    def __init__(
        self,
        served: Mapping[str, wire.QueryServer],
        *,
        version: str,
        happened: Callable[[str, str, str, str, str], None],
        learnt: Callable[[str, dict[str, Raw]], None],
        begun: Callable[[str], object],
        present: Callable[[str], bool],
    ) -> None:
        self._version = version
        self._happened = happened
        self._learnt = learnt
        self._begun = begun
        self._ways: tuple[str, ...] = ()
        self._present = present
        self._restarts: dict[str, int] = {}
        self._ended = False
        self._hosts = {name: Host(name, one) for name, one in served.items()}

    def adopt(self, plan: Plan) -> None:
        """Adopt a plan; each host gets its share with the answer to its next report."""
        self._ways = plan.lan
        for host in self._hosts.values():
            host.units = {name: unit for name, unit in plan.units.items() if unit.config.host == host.name}
        self._deal()

    def _deal(self) -> None:
        for host in self._hosts.values():
            host.share = tuple(Placed(unit=u, restarts=self._restarts.get(n, 0)) for n, u in host.units.items())
            host.mark = mark(host.share)

    def restart(self, name: str) -> bool:
        """Have a process restarted, if it is on another machine; return whether it is."""
        host = next((host for host in self._hosts.values() if name in host.units), None)
        if host is not None:
            self._restarts[name] = self._restarts.get(name, 0) + 1
            self._deal()
        return host is not None

    def end(self) -> None:
        """Have all processes on other machines end: the robot shuts down."""
        self._ended = True

    def step(self, now: float) -> float:
        """Answer reports, and detect lost agents; return when to be called again."""
        for host in self._hosts.values():
            for request in host.served.take():
                request.reply(self._answer(host, request, now), "executive")
            if host.agent and (why := self._why_gone(host, now)):
                self._lose(host, f"the agent at {host.where} {why}", "error")
        return min((host.heard_at + GONE_S for host in self._hosts.values() if host.agent), default=inf)

    def capabilities(self) -> dict[str, CapabilityStatus]:
        """Return the status of every process on other machines."""
        return {name: self._status(host, unit) for host in self._hosts.values() for name, unit in host.units.items()}

    def movers(self) -> list[str]:
        """Return the capabilities that move something, run, and are in contact; may be called from any thread."""
        return [
            name
            for host in self._hosts.values()
            if host.agent
            for name, state in list(host.states.items())
            if state.phase in RUNNING and name in host.units and host.units[name].moves
        ]

    def close(self) -> None:
        """Stop answering."""
        for host in self._hosts.values():
            host.served.close()

    def _answer(self, host: Host, request: wire.Request, now: float) -> HostShare | CommandReply:
        try:
            report = _reports.decode(request.payload)
        except MalformedError as err:
            return CommandReply(accepted=False, code="malformed", reason=f"malformed report: {err}")
        answer = HostShare(accepted=True, version=self._version, share=host.mark, ended=self._ended)
        if host.agent and host.agent != report.agent:
            text = f"host '{host.name}' has an agent already, at {host.where}"
            return replace(answer, accepted=False, reason=text, code="denied")
        if report.leaving:
            if host.agent:
                self._lose(host, f"the agent at {host.where} has ended", "warning")
            return answer
        if self._ended:
            return answer
        if not host.agent:
            host.agent, host.where, host.states = report.agent, report.where[:80], {}
            names = ", ".join(host.units) or "nothing at present"
            self._happened("host_joined", host.name, f"{host.where} runs {names}", "info", "")
        host.heard_at = now
        self._hear(host, report)
        return answer if report.share == host.mark else replace(answer, units=host.share)

    def _hear(self, host: Host, report: HostReport) -> None:
        states = {state.name: replace(state, host=host.name) for state in report.states if state.name in host.units}
        for name, state in states.items():
            before = host.states.get(name)
            if state.pid is not None and (before is None or before.pid != state.pid):
                self._begun(name)
        host.states = states
        for event in report.events:
            if event.subject in host.units and event.kind in TOLD:
                self._happened(event.kind, event.subject, event.text, event.level, event.code)
        for one in report.learnt:
            if one.name in host.units:
                self._learnt(one.name, one.rows)

    def _why_gone(self, host: Host, now: float) -> str:
        """Return why an agent counts as gone, or an empty text; its token may come shortly after its first report."""
        here = self._present(keys.agent(host.name))
        lost, host.seen = host.seen and not here, here
        return "is out of reach" if lost else "is silent" if not now - host.heard_at < GONE_S else ""

    def _lose(self, host: Host, why: str, level: str) -> None:
        running = [name for name, state in host.states.items() if state.phase in RUNNING]
        host.agent, host.states, host.seen = "", {}, False
        lost = f"; gone with it: {', '.join(running)}" if running else ""
        code = "unreachable" if level == "error" else "shutting_down"
        self._happened("host_lost", host.name, f"{why}{lost}", level, code)

    def _status(self, host: Host, unit: ProcessSpec) -> CapabilityStatus:
        found = host.states.get(unit.name) if host.agent else None
        if found is not None:
            ready = found.phase not in {"ready", "degraded"} or self._present(unit.name)
            return found if ready else replace(found, phase="starting")  # it runs, but cannot be asked from here yet
        reason = f"host '{host.name}' begins" if host.agent else self._what_to_type(host.name, unit)
        return CapabilityStatus(
            name=unit.name,
            kind=unit.kind,
            phase="waiting",
            pid=None,
            restarts=0,
            uptime_s=None,
            reason=reason,
            code="not_ready" if host.agent else "unreachable",
            rates_hz={},
            host=host.name,
        )

    def _what_to_type(self, name: str, unit: ProcessSpec) -> str:
        if unit.config.credentials is None:
            return f"waits for host '{name}', which has no token; here, type: lbr token add {name} --role host"
        if not self._ways:
            return f"waits for host '{name}', which cannot come in: the robot needs --listen tls/0.0.0.0:7447"
        endpoint = self._ways[0].replace("0.0.0.0", "ROBOT").replace("[::]", "ROBOT")  # noqa: S104 - for people to read
        return f"waits for host '{name}'; there, type: lbr agent {name} --connect {endpoint}"
