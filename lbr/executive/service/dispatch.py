"""One console line, from any sender: understood by the verb rows, asked on the bus, answered in words."""

import ast
import contextlib
import io
import json
import time
import traceback
from collections.abc import Callable, Mapping

import msgspec
from msgspec import Struct, field

from lbr import home
from lbr.bus import codec, keys, stamp, wire
from lbr.bus.session import Session
from lbr.capability.kind import STOP
from lbr.console.printable import clean
from lbr.console.stops import stop_in
from lbr.console.verbs import ExternalCall, ExternalStop, Parsed, PythonLine, VerbCall
from lbr.errors import InputError, LbrError, MalformedError
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.service import greeting, looking, reports
from lbr.executive.service.completion_values import choices
from lbr.executive.service.letting_in import OPERATE, LettingIn
from lbr.executive.service.reports import Reports
from lbr.executive.service.robot import Robot
from lbr.messages.leases import StopCommand
from lbr.messages.schema import JsonObject
from lbr.messages.system import RANKS, CapabilityStatus, ConsoleResult, Hold, Role, role_missing
from lbr.why import rendering
from lbr.why.chain import explain

DONE, FAILED, BAD_INPUT = 0, 1, 2
STOPPED = "stopped"
Outcome = tuple[str, bool]
"""A text, and whether all is well."""
MAX_RUN_S = 30.0
BOUNDED_RUN_S = 86_400.0
"""A motion with an end of its own is held until then, unless its capability sets a limit."""
STOP_S, AGAIN_S = 2.0, 0.1
"""The time in which a stop is answered, and the pause before a mover that restarts is asked again."""
MOST_LEASES = 256
MOST_RECORDED = 200
ROWS = "rows"
"""A report that on other machines and pages is only for those who may look at rows there."""


class Sender(Struct, frozen=True):
    """The sender of a line: its rights, whether it is the robot's own terminal, and the time by the monotonic clock.

    `remote_stamp` is the stamp of a line from another machine, which is passed on unchanged. `waited_s` is the age that
    the line had when it was sent. `page`: the server for people sends it in a person's name.
    """

    source: str
    role: Role
    local: bool = False
    sent_s: float = field(default_factory=time.monotonic)
    remote_stamp: bytes = b""
    waited_s: float = 0.0
    page: bool = False

    @property
    def audit_name(self) -> str:
        """Return the name for the audit trail; from another machine, with the token that the door has verified."""
        if not self.remote_stamp:
            return self.source
        found = stamp.read(self.remote_stamp)
        proven = f"by token '{found.token}'" if found is not None and found.token else "token not told"
        return f"{self.source} on another machine ({proven})"

    @property
    def is_recorded(self) -> bool:
        """Return whether its lines go into the audit trail: those from another machine, and of people on a web page."""
        return bool(self.remote_stamp) or self.page

    @property
    def origin(self) -> stamp.Origin:
        """Return the origin of the line, for a program that it starts."""
        return stamp.Origin(self.source, self.sent_s - self.waited_s)

    def holder(self, capability: str) -> tuple[str, str, bool]:
        """Return the holder of a capability's motion: a name from another machine is never that of a local sender."""
        return capability, self.source, bool(self.remote_stamp)


class Dispatcher:
    """Executes lines. Blocks the calling thread until the robot answers, two seconds at most."""

    def __init__(self, robot: Robot, bus: Session, namespace: Mapping[str, object]) -> None:
        self._robot = robot
        self._bus = bus
        self._reports = Reports(robot, bus)
        self._namespace = dict(namespace)
        self._leases: dict[tuple[str, str, bool], str] = {}
        self._letting_in = LettingIn(robot, self._address)
        self._built_in: dict[str, Callable[[VerbCall, Sender], ConsoleResult]] = {
            "stop": self._stop,
            "report": self._report,
            "status": lambda _call, _by: ConsoleResult(code=DONE, text=self._reports.health()),
            "estop": self._estop,
            "reset": lambda _call, by: robot.estop_reset(by.source, by.sent_s - by.waited_s),
            "help": self._help,
            "shutdown": self._shutdown,
            "restart": self._restart,
            "why": self._why,
            "phone": lambda _call, by: self._letting_in.phone(by.audit_name),
            "pair": lambda call, by: self._letting_in.pair(str(call.payload.get("role", OPERATE)), by.audit_name),
            "open": lambda _call, by: self._letting_in.open(by.audit_name),
            "close": lambda _call, by: self._letting_in.close(by.audit_name),
        }

    def execute(self, line: str | bytes, by: Sender) -> ConsoleResult:
        """Return the result of a line; never raises."""
        try:
            line = stop_in(line) or line
            parsed = self._robot.vocabulary.parse(line)
            return self._run(parsed, by, clean(line)) if parsed is not None else ConsoleResult(code=DONE, text="")
        except InputError as err:
            return ConsoleResult(code=BAD_INPUT, text=str(err), reason_code=err.code)
        except LbrError as err:
            return ConsoleResult(code=FAILED, text=str(err), reason_code="failed")
        except Exception as err:  # noqa: BLE001 - a fault in one word must not silence the others
            traceback.print_exception(err)
            text = f"this word is broken: {type(err).__name__}: {err}"
            return ConsoleResult(code=FAILED, text=text, reason_code="failed")

    def greeting(self) -> str:
        """Return the greeting of the robot's own console, once all parts run."""
        page = no_page = ""
        try:
            page = self._letting_in.page()
        except LbrError as err:
            no_page = str(err)
        return "\n".join(greeting.lines(self._robot.status(), page, no_page))

    def _run(self, parsed: Parsed, by: Sender, line: str) -> ConsoleResult:
        if isinstance(parsed, PythonLine):
            return self._python(parsed.code, by)
        needed = parsed.verb.role if isinstance(parsed, VerbCall) else parsed.command.role
        if why := role_missing(needed, by.role):
            return ConsoleResult(code=FAILED, text=why.text, reason_code=why.code)
        if by.is_recorded and RANKS[needed] > RANKS["view"]:
            self._robot.record("line", by.audit_name, line[:MOST_RECORDED])
        if isinstance(parsed, ExternalStop):
            text = self._robot.stop_external(parsed.command.name, by.audit_name, by.source)
            return ConsoleResult(code=DONE, text=text)
        if isinstance(parsed, ExternalCall):
            return self._robot.run_external(parsed, by.audit_name, by.origin, by.sent_s)
        if parsed.capability == EXECUTIVE:
            return self._built_in[parsed.command](parsed, by)
        return self._ask(parsed, by)

    def _estop(self, call: VerbCall, by: Sender) -> ConsoleResult:
        return self._robot.estop(str(call.payload.get("reason", "")), by.source)

    def _ask(self, call: VerbCall, by: Sender) -> ConsoleResult:
        name = call.capability
        if name not in self._robot.plan.units:
            text = f"'{name}' is not running: its row is disabled or the profile leaves it out"
            return ConsoleResult(code=FAILED, text=text, reason_code="unreachable")
        if outright := self._robot.vocabulary.confirming(call):
            text = f"{outright.help}. To do it, say {outright.pattern}"
            return ConsoleResult(code=FAILED, text=text, reason_code="confirm", confirm=outright.pattern)
        kind = self._robot.plan.kinds[name]
        moves = call.command in kind.commands and kind.command(call.command).leased
        payload = dict(call.payload)
        lease = self._leases.get(by.holder(name), "") if moves else ""
        answer = self._query(call, payload | ({"lease": lease} if lease else {}), by)
        if lease and answer is not None and answer.get("code") == "dead_lease":
            # The motion that we held is over; this line may begin a new one, with its own date.
            self._leases.pop(by.holder(name), None)
            answer = self._query(call, payload, by)
        if answer is None:
            text = f"'{name}' did not answer; {self._why_silent(name)}"
            return ConsoleResult(code=FAILED, text=text, reason_code="unreachable")
        return self._result_of(call, payload, answer, by)

    def _result_of(self, call: VerbCall, payload: JsonObject, answer: JsonObject, by: Sender) -> ConsoleResult:
        if "accepted" not in answer:
            return ConsoleResult(code=DONE, text=json.dumps(answer), reason_code="done", data=answer)
        reason = str(answer.get("reason", ""))
        if not answer["accepted"]:
            code, cause = str(answer.get("code") or "refused"), str(answer.get("cause", ""))
            return ConsoleResult(code=FAILED, text=reason or "refused", reason_code=code, cause=cause, data=answer)
        lease = str(answer.get("lease", ""))
        if not lease:
            said = {name: value for name, value in answer.items() if name not in {"accepted", "reason", "code"}}
            text = reason or (reports.flat({call.command: said}) if said else "done")
            return ConsoleResult(code=DONE, text=text, reason_code=str(answer.get("code") or "done"), data=answer)
        self._leases[by.holder(call.capability)] = lease
        while len(self._leases) > MOST_LEASES:
            self._leases.pop(next(iter(self._leases)))
        robot, name = self._robot.plan.robot, call.capability
        hold = Hold(
            lease=lease,
            ttl_s=float(answer.get("ttl_s") or 0.3),
            key=keys.port(robot, name, call.command),
            stop_key=keys.port(robot, name, "stop"),
            result_key=keys.port(robot, name, "result"),
            payload=payload | {"lease": lease},
            goal=str(answer.get("goal", "")),
            max_run_s=self._max_run_s(name, bounded=bool(answer.get("goal"))),
        )
        return ConsoleResult(code=DONE, text=reason or "accepted", hold=hold, data=answer)

    def _max_run_s(self, name: str, *, bounded: bool) -> float:
        settings = self._robot.plan.kinds[name].parse(self._robot.plan.units[name].config.settings)
        return float(getattr(settings, "max_run_s", BOUNDED_RUN_S if bounded else MAX_RUN_S))

    def _query(self, call: VerbCall, payload: dict[str, object], by: Sender) -> dict[str, object] | None:
        key = keys.port(self._robot.plan.robot, call.capability, call.command)
        answers = wire.ask(
            self._bus,
            key,
            payload,
            source=by.source,
            timeout_s=2.0,
            sent_s=by.sent_s,
            attachment=by.remote_stamp,
            waited_s=by.waited_s,
        )
        if not answers:
            return None
        decoded = codec.decode(answers[0].payload)
        return decoded if isinstance(decoded, dict) else {"answer": decoded}

    def _why_silent(self, name: str) -> str:
        if (found := self._status_of(name)) is None:
            return "it does not run"
        return f"it is {found.phase}" + (f": {found.reason}" if found.reason else "")

    def _status_of(self, name: str) -> CapabilityStatus | None:
        return next((unit for unit in self._robot.status().capabilities if unit.name == name), None)

    def _stop(self, call: VerbCall, by: Sender) -> ConsoleResult:
        """Stop all motion at the same time: a mover that does not answer delays no other stop."""
        movers = {keys.port(self._robot.plan.robot, name, STOP): name for name in self._robot.plan.stoppable()}
        if not movers:
            return ConsoleResult(code=DONE, text="nothing of this robot moves by commands: there is nothing to stop")
        outcomes, silent = self._stopped(movers, str(call.payload.get("reason", "")), by)
        texts = [
            *dict.fromkeys(text for text, _ in outcomes.values()),
            *(f"'{name}' did not answer; {self._why_silent(name)}" for name in silent),
        ]
        good = not silent and all(good for _, good in outcomes.values())
        text = "; ".join(texts) or f"nothing runs that could move: {', '.join(movers.values())}"
        code = "done" if good else "unreachable" if silent else "refused"
        return ConsoleResult(code=DONE if good else FAILED, text=text, reason_code=code)

    def _stopped(self, movers: Mapping[str, str], reason: str, by: Sender) -> tuple[dict[str, Outcome], list[str]]:
        """Return how a stop ended at each mover, and the movers that did not answer.

        A process that ends stops its motion. The next one is asked until it answers.
        """
        payload, end = wire.encode(StopCommand(reason=reason, whole=True)), time.monotonic() + STOP_S
        attachment = by.remote_stamp or stamp.make(by.source, 0, sent_s=by.sent_s)
        outcomes: dict[str, Outcome] = {}
        while True:
            asked = {key: name for key, name in movers.items() if name not in outcomes}
            wait_s = end - time.monotonic()
            came = wire.ask_all(self._bus, asked, payload, source=by.source, timeout_s=wait_s, attachment=attachment)
            answers = {asked[one.key]: codec.decode(one.payload) for one in came if one.key in asked}
            outcomes |= {name: how for name, answer in answers.items() if (how := _outcome(name, answer)) is not None}
            running = {unit.name for unit in self._robot.status().capabilities if unit.pid is not None}
            silent = [name for name in asked.values() if name in running - outcomes.keys()]
            if not silent or time.monotonic() + AGAIN_S >= end:
                return outcomes, silent
            time.sleep(AGAIN_S)

    def _report(self, call: VerbCall, by: Sender) -> ConsoleResult:
        name = str(call.payload.get("name", "telemetry"))
        if name == ROWS and by.is_recorded and (why := role_missing("operate", by.role)):
            return ConsoleResult(code=FAILED, text=why.text, reason_code=why.code)
        data, text = self._reports.make(name)
        return ConsoleResult(code=DONE, text=text, data=data)

    def _why(self, call: VerbCall, by: Sender) -> ConsoleResult:
        now = looking.look(self._robot, self._bus, asker=by.source, role=by.role)
        found = explain(now, str(call.payload.get("part", "")))
        text = "\n".join(rendering.lines(found))
        return ConsoleResult(code=DONE, text=text, reason_code=found.code or "done", data=msgspec.to_builtins(found))

    def _help(self, call: VerbCall, _by: Sender) -> ConsoleResult:
        words = self._robot.vocabulary
        entries = words.entries(choices(self._robot.plan, home.home()))
        if not (word := str(call.payload.get("word", "")).strip("/")):
            return ConsoleResult(code=DONE, text=words.help(self._robot.plan.units), data=entries)
        found = [entry for entry in entries if word in {entry["word"], entry["target"].partition(".")[0]}]
        return ConsoleResult(code=DONE, text=words.tell(word, found), data=found)

    def _shutdown(self, _call: VerbCall, by: Sender) -> ConsoleResult:
        self._robot.shutdown(by.source)
        return ConsoleResult(code=DONE, text="shutting down")

    def _restart(self, call: VerbCall, _by: Sender) -> ConsoleResult:
        name = str(call.payload.get("name", ""))
        if (found := self._status_of(name)) is not None and found.host and found.phase == "waiting":
            raise InputError(f"'{name}' does not run: {found.reason}", "unreachable")
        self._robot.restart(name)
        return ConsoleResult(code=DONE, text=f"'{name}' is restarting")

    def _address(self, name: str, timeout_s: float) -> dict[str, object] | None:
        """Return the address of a server; None if it does not answer."""
        key = keys.port(self._robot.plan.robot, name, "address")
        for answer in wire.ask(self._bus, key, {}, source=EXECUTIVE, timeout_s=timeout_s):
            with contextlib.suppress(MalformedError):
                said = codec.decode(answer.payload)
                return said if isinstance(said, dict) else None
        return None

    def _python(self, code: str, by: Sender) -> ConsoleResult:
        if not by.local:
            text = "Python runs at the terminal that started the robot, and nowhere else"
            return ConsoleResult(code=FAILED, text=text, reason_code="denied")
        self._robot.note("python", f"{by.source}: {code[:400]}", about=by.source)
        printed = io.StringIO()
        try:
            with contextlib.redirect_stdout(printed):
                value = _evaluate(code, self._namespace)
        except BaseException as err:  # noqa: BLE001 - whatever the operator typed, the console lives on
            text = f"{printed.getvalue()}{type(err).__name__}: {err}"
            return ConsoleResult(code=FAILED, text=text, reason_code="failed")
        text = printed.getvalue() + ("" if value is None else repr(value))
        return ConsoleResult(code=DONE, text=text.rstrip("\n"))


def _outcome(name: str, answer: object) -> Outcome | None:
    """Return the text of one mover's answer to a stop, and whether it stopped; None if its process ends."""
    reply = answer if isinstance(answer, dict) else {}
    if reply.get("accepted"):
        return str(reply.get("reason", "")) or STOPPED, True
    if reply.get("code") == "shutting_down":
        return None
    return f"'{name}' did not stop: {reply.get('reason') or 'it gave no reason'}", False


def _evaluate(code: str, namespace: dict[str, object]) -> object:
    try:
        tree = ast.parse(code, mode="eval")
    except SyntaxError:
        exec(compile(code, "console", "exec"), namespace)  # noqa: S102 - what the operator's terminal is for
        return None
    return eval(compile(tree, "console", "eval"), namespace)  # noqa: S307 - likewise
