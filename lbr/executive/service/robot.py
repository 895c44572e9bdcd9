"""A running robot, as the console sees it."""

import json
from dataclasses import dataclass

from lbr import home
from lbr.bus.stamp import Origin
from lbr.console.verbs import ExternalCall, Vocabulary
from lbr.database import edits
from lbr.database.store import Database
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.processes.mainthread import MainThread
from lbr.executive.processes.robot_processes import RobotProcesses
from lbr.executive.service.emergency import RELEASED, Emergency
from lbr.executive.service.journal import Journal
from lbr.executive.service.pairing import GOOD_FOR_S, Code, Pairing
from lbr.executive.service.status_service import StatusService
from lbr.executive.shutdown import Shutdown
from lbr.messages.system import ConsoleResult, Event, Role, Status


@dataclass(frozen=True, slots=True)
class Robot:
    """Carries out console lines. Every method may be called from any thread."""

    main: MainThread
    ending: Shutdown
    rows: LiveRows
    processes: RobotProcesses
    emergency: Emergency
    journal: Journal
    glance: StatusService
    pairing: Pairing
    database: Database

    @property
    def plan(self) -> Plan:
        """Return the running plan."""
        return self.rows.plan

    @property
    def vocabulary(self) -> Vocabulary:
        """Return the words of the robot."""
        return self.rows.vocabulary

    def status(self) -> Status:
        """Return the robot at a glance."""
        return self.main.call(self.glance.status)

    def recent_events(self) -> list[Event]:
        """Return the newest events, oldest first."""
        return list(self.journal.recent)

    def estop(self, reason: str, source: str) -> ConsoleResult:
        """Latch the emergency stop. The result names the devices that have acknowledged or not."""
        state = self.emergency.press(reason, source)
        done = state.engaged and not state.waiting
        text = state.text if state.engaged else "the emergency stop was sent, but is not confirmed yet"
        return ConsoleResult(code=0 if done else 1, text=text, reason_code="" if done else "timeout")

    def estop_reset(self, source: str, written_s: float) -> ConsoleResult:
        """Release the emergency stop, unless it was pressed after the line was written; moves nothing."""
        if why_not := self.emergency.release(source, written_s):
            return ConsoleResult(code=1, text=why_not.text, reason_code=why_not.code)
        return ConsoleResult(code=0, text=RELEASED)

    def shutdown(self, source: str) -> None:
        """Begin the shutdown."""
        self.ending.begin(f"Shutdown by {source}")

    def restart(self, name: str) -> None:
        """Restart a capability; InputError if none of that name runs."""
        self.main.call(lambda: self.processes.restart(name))

    def pair(self, role: Role, requester: str) -> Code:
        """Draw a code that gives a device a token with a role. Its requester is reported, the code is not."""
        code = self.main.call(lambda: self.pairing.begin(role, requester))
        text = f"{requester} asked for a code: who types it within {GOOD_FOR_S:g} s gets a token with the role '{role}'"
        self.note("pair", text, requester)
        return code

    def listen_at(self, name: str, host: str, requester: str) -> None:
        """Set `host` in a server's row; raise RowError or InputError if that is refused."""
        with Database.open(self.database.path, program="executive") as database:
            edits.write_setting(database, self.plan.robot, name, "host", host, self.rows.judge, by=requester).good()
        self.note("edit", f"{requester} had '{name}' listen at {host}", requester)

    def run_external(self, call: ExternalCall, requester: str, origin: Origin, said_s: float) -> ConsoleResult:
        """Start an external command, after recording its requester, and wait for a blocking one."""
        row = call.command
        argv = json.dumps([*row.argv, *call.arguments], ensure_ascii=False)
        self.note("external", f"'{row.name}' is started by {requester}: {argv}", origin.source)
        command = self.main.call(lambda: self.processes.external.start(row, call.arguments, origin, said_s))
        if not row.blocking:
            log = f"it writes to {home.directory('logs') / f'{row.name}.log'}, and 'stop {row.name}' ends it"
            return ConsoleResult(code=0, text=f"'{row.name}' started (pid {command.pid}); {log}")
        code, output = self.processes.external.wait(row, command)
        return ConsoleResult(
            code=0 if code == 0 else 1,
            text=output or f"'{row.name}' ended with {code}",
            reason_code="" if code == 0 else "failed",
        )

    def stop_external(self, name: str, requester: str, about: str) -> str:
        """End an external command, and record its requester."""
        ended = self.processes.external.stop(name)
        self.note("external", f"'{name}' was ended by {requester}", about)
        return ended

    def note(self, kind: str, text: str, about: str = "") -> None:
        """Record an event of the executive's own, and return once it is recorded."""

        def note() -> None:
            self.journal.happened(kind, EXECUTIVE, text, about=about)
            self.journal.flush()

        self.main.call(note)

    def record(self, kind: str, requester: str, text: str) -> None:
        """Add an entry to the audit trail, soon: no line, and no stop, waits for it."""
        self.main.post(lambda: self.journal.record(kind, requester, text))
