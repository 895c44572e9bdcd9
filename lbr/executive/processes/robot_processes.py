"""The processes of a robot: its capabilities on this machine and on others, and the programs of its commands."""

import time
from collections.abc import Callable
from math import inf

import msgspec
from msgspec import Raw
from msgspec.structs import replace

from lbr import home
from lbr.errors import InputError
from lbr.executive.planning import machine
from lbr.executive.planning import plan as plans
from lbr.executive.planning.credentials import bus_certificate
from lbr.executive.planning.plan import Change, Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.processes.doors import Doors, inside_endpoint
from lbr.executive.processes.external import ExternalCommands
from lbr.executive.processes.fork_server import ForkServer
from lbr.executive.processes.overview import Overview
from lbr.executive.processes.process_host import Child, ProcessHost
from lbr.executive.processes.reaper import Reaper
from lbr.executive.processes.supervisor import Supervisor
from lbr.executive.remote.remote_hosts import RemoteHosts
from lbr.executive.service.journal import Journal
from lbr.executive.services import Service
from lbr.messages.system import CapabilityStatus, EstopState
from lbr.names import did_you_mean

NO_REAPER = "if the executive were killed now, frozen processes would be left; the one that ends them cannot be started"


class RobotProcesses(Service):
    """Starts and ends processes by the plan that was adopted last. The `supervisor` has those of this machine.

    `begun(name)` notes a new process, and returns the emergency stop with which it begins. `learnt(name, rows)`
    receives the rows that a capability has learnt.
    """

    def __init__(
        self,
        plan: Plan,
        doors: Doors,
        reaper: Reaper,
        forks: ForkServer,
        hosts: RemoteHosts,
        journal: Journal,
        *,
        present: Callable[[str], bool],
        begun: Callable[[str], EstopState],
        learnt: Callable[[str, dict[str, Raw]], None],
    ) -> None:
        self._plan = plan
        self._doors = doors
        self._reaper = reaper
        self._forks = forks
        self._hosts = hosts
        self.external = ExternalCommands(home.directory("logs"), plan.robot, reaper)
        self._begun = begun
        self._journal = journal
        self._host = ProcessHost(home.directory("logs"), reaper, forks)
        at_once, poll = machine.at_once(), self._host.poll
        self.supervisor = Supervisor(self._start, journal.happened, present, learnt=learnt, at_once=at_once, poll=poll)
        self._overview = Overview(self.supervisor)

    @property
    def reachable(self) -> bool:
        """Return whether a client of this machine gets answers."""
        return self._doors.answers

    def take_over(self, plan: Plan, change: Change) -> None:
        """Start and stop processes as a new plan requires."""
        self._plan = plan
        self._doors.adopt(plan)
        self._hosts.adopt(plan)
        names = plan.local_units.keys() | self.supervisor.parts.keys()
        self.supervisor.adopt(plan.local_units, plans.only(change, names))

    def keep(self, plan: Plan, name: str) -> None:
        """Adopt a plan whose changes a process has already."""
        self._plan = plan
        if name in self.supervisor.parts:
            self.supervisor.parts[name].spec = plan.units[name]
        self._hosts.adopt(plan)

    def step(self, now: float) -> float:
        """Start, watch and end what is due; return when to call again."""
        due = now + self.supervisor.step()
        for text in self._doors.tidy(child.endpoint for _part, child in self.supervisor.children()):
            self._journal.happened("link_mended", EXECUTIVE, text, "warning")
        self.external.prune({row.name for row in self._plan.rows.external_commands})
        self._journal.trouble(NO_REAPER, self._reaper.step())
        return min(due, self._hosts.step(now))

    def shut_down(self, wait: Callable[[float], None]) -> None:
        """End all capabilities, motion first; `wait(seconds)` waits for news."""

        def wait_and_answer(timeout_s: float) -> None:
            wait(timeout_s)
            self._hosts.step(time.monotonic())

        self._hosts.end()
        self.supervisor.shut_down(wait_and_answer)

    def close(self) -> None:
        """End the programs of commands, and stop answering other machines."""
        self.external.close()
        self._hosts.close()

    def capabilities(self) -> tuple[CapabilityStatus, ...]:
        """Return the status of every capability, in start order."""
        known = {one.name: one for one in self._overview.capabilities(time.monotonic())} | self._hosts.capabilities()
        return tuple(known[name] for name in self._plan.units if name in known)

    def movers(self) -> list[str]:
        """Return the running capabilities that move something; may be called from any thread."""
        parts = list(self.supervisor.parts.items())
        return [name for name, part in parts if part.spec.moves and part.child is not None] + self._hosts.movers()

    def process(self, name: str) -> object:
        """Return the process of a capability on this machine; None without one."""
        part = self.supervisor.parts.get(name)
        return part.child if part is not None else None

    def runs_since(self, name: str) -> float:
        """Return when a capability's process was started."""
        part = self.supervisor.parts.get(name)
        return part.started_at if part is not None else inf

    def restart(self, name: str, why: str = "") -> None:
        """Restart a capability, forget its earlier ends, and report why; raise InputError if it does not run."""
        if name not in self._plan.units:
            raise InputError(f"'{name}' does not run; {did_you_mean(name, self._plan.units)}", "unknown_name")
        if why:
            self._journal.happened("restarting", name, why)
        if not self._hosts.restart(name):
            self.supervisor.restart(name)

    def _start(self, spec: ProcessSpec) -> Child | None:
        place = self._doors.place(spec)
        if place is None or self._forks.begins:
            return None
        mates = [other for other in self._plan.local_units.values() if other.process == spec.process]
        reach = tuple(device.address for mate in mates for device in mate.config.devices)
        config = replace(spec.config, estop=self._begun(spec.name), endpoints=(place.endpoint,), reach=reach)
        if spec.lan is not None:
            bus_certificate()
            inside = inside_endpoint(self._plan.robot, spec.name)
            lan = replace(spec.lan, upstream=place.router_id, inside=inside)
            config = replace(config, private=Raw(msgspec.json.encode(lan)))
        waits = not any(mate.moves or mate.serves for mate in mates)
        return self._host.start(spec, config, waits=waits)
