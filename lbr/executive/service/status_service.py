"""The status of the robot, and the report of its start: that all parts run, or which do not."""

import json
import os
import time
from collections.abc import Set as AbstractSet

from msgspec.structs import replace

from lbr import home
from lbr.bus import keys, wire
from lbr.bus.session import Session
from lbr.console.outlet import say
from lbr.console.toolbar import state_of
from lbr.executive.notify import Notifier
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.processes.doors import local_endpoint
from lbr.executive.processes.logs import trim_all
from lbr.executive.processes.readiness import readiness
from lbr.executive.processes.robot_processes import RobotProcesses
from lbr.executive.service.emergency import Emergency
from lbr.executive.service.journal import Journal
from lbr.executive.services import Service
from lbr.messages.system import Status

STATUS_S = 1.0
REACHES_S = 0.01
"""The interval of looks for whether clients can reach the ready robot, which takes some 0.1 s at a start."""


class StatusService(Service):
    """Publishes the status each second and at each event; reports the start, also on standard output if `announce`."""

    def __init__(
        self,
        bus: Session,
        profile: str,
        rows: LiveRows,
        processes: RobotProcesses,
        emergency: Emergency,
        journal: Journal,
        notifier: Notifier,
        *,
        since: float,
        announce: bool,
    ) -> None:
        self._profile = profile
        self._rows = rows
        self._processes = processes
        self._emergency = emergency
        self._journal = journal
        self._notifier = notifier
        self._announce = announce
        self._since = since
        self._due = 0.0
        self._ready = False
        self._failed: AbstractSet[str] = frozenset()
        self._publisher = wire.Publisher(bus, keys.status(rows.plan.robot), EXECUTIVE, renew=self._as_of_now)

    def soon(self) -> None:
        """Publish in this turn, because something has happened."""
        self._due = 0.0

    def step(self, now: float) -> float:
        """Publish when due, and judge the start once each part runs or has given up."""
        if now >= self._due:
            self._due = now + STATUS_S
            trim_all(home.home() / "logs")
            status = self.status()
            self._publisher.put(status)
            self._notifier.status(state_of(status)[1])
        if not self._ready and self._processes.supervisor.settled():
            if not self._processes.reachable:
                return now + REACHES_S
            self._judge_start()
        return self._due

    def close(self) -> None:
        """Close the socket of the service manager."""
        self._notifier.close()

    def status(self) -> Status:
        """Return the present status."""
        capabilities = self._processes.capabilities()
        return self._as_of_now(
            Status(
                robot=self._rows.plan.robot,
                profile=self._profile,
                ready=self._ready and not any(one.phase == "failed" for one in capabilities),
                pid=os.getpid(),
                uptime_s=round(time.monotonic() - self._since, 1),
                estop=self._emergency.state(),
                capabilities=capabilities,
                revision=self._rows.plan.rows.revision,
                degraded=readiness(capabilities).degraded if self._ready else {},
            )
        )

    def _as_of_now(self, status: Status) -> Status:
        """Return a status with the present emergency stop and problems; no event is newer than those."""
        rows, troubles = self._rows.problems, tuple(self._journal.troubles.values())
        return replace(
            status,
            estop=self._emergency.state(),
            problems=(*rows, *troubles),
            problem_codes=(*(self._rows.code for _ in rows), *("failed" for _ in troubles)),
        )

    def _judge_start(self) -> None:
        """Report that all parts run, or which do not: once for each set of failures, until all run."""
        outcome = readiness(self._processes.capabilities())
        if not outcome.ready and outcome.failed.keys() == self._failed:
            return
        self._ready, self._failed = outcome.ready, outcome.failed.keys()
        text = outcome.words(time.monotonic() - self._since)
        if outcome.ready:
            self._rows.well()
            self._journal.happened("ready", EXECUTIVE, text, "warning" if outcome.degraded else "info")
            self._notifier.ready()
        else:
            self._journal.happened("not_ready", EXECUTIVE, text, "error")
        self._publisher.put(self.status())
        if self._announce:
            plan = self._rows.plan
            line = {
                "ready": outcome.ready,
                "robot": plan.robot,
                "pid": os.getpid(),
                "endpoints": [local_endpoint(plan.robot)],
                "lan": list(plan.lan),
                "failed": outcome.failed,
                "degraded": outcome.degraded,
            }
            if why := say(json.dumps(line)):
                text = f"the ready line cannot be printed: standard output cannot be written ({why})"
                self._journal.happened("trouble", EXECUTIVE, text, "warning")
