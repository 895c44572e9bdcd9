"""Lines that capabilities send, such as a gamepad's buttons: the robot must know each of them, for its role."""

from collections.abc import Iterator, Mapping

from lbr.capability.kind import Kind
from lbr.console.verbs import PythonLine, VerbCall, Vocabulary
from lbr.database.reading import Problem
from lbr.database.rows import RobotRows
from lbr.errors import InputError
from lbr.executive.planning.draft import Draft
from lbr.executive.planning.wiring import EXECUTIVE, least_roles
from lbr.messages.system import RANKS, LineCommand

LINE = f"{EXECUTIVE}.line"


def vocabulary(rows: RobotRows, kinds: Mapping[str, Kind]) -> Vocabulary:
    """Return the vocabulary of a robot, whose rows include the words of its kinds."""
    messages = {f"{name}.{command}": kind for name in kinds for command, kind in kinds[name].messages.items()}
    return Vocabulary(rows.verbs, rows.external_commands, messages, least_roles(kinds))


def problems(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the lines that capabilities send."""
    words = vocabulary(draft.rows, draft.kinds)
    wired = {row.source_end for row in draft.rows.channels if row.enabled and row.target == LINE}
    for name, kind in draft.kinds.items():
        lines: Mapping[str, str] = getattr(draft.settings.get(name), kind.says, {}) if kind.says else {}
        ports = {port for port, message in kind.requests.items() if message is LineCommand}
        if lines and not any((name, port) in wired for port in ports):
            port = min(ports, default="say")
            text = f"{kind.says}: a channel row from {name}.{port} to {LINE} is needed to send them"
            yield draft.problem(name, "settings", text)
        for of, line in lines.items():
            if fault := _fault(words, line):
                yield draft.problem(name, "settings", f"{kind.says}.{of}: {fault}")


def _fault(words: Vocabulary, line: str) -> str:
    """Return why a capability cannot send a line; empty if it can."""
    try:
        parsed = words.parse(line)
    except InputError as err:
        return str(err)
    if parsed is None or isinstance(parsed, PythonLine):
        return "it has no line, or it has Python, which runs only at the terminal that started the robot"
    needed = parsed.verb.role if isinstance(parsed, VerbCall) else parsed.command.role
    if RANKS[needed] > RANKS["operate"]:
        return f"'{line}' needs the role {needed}, and lines of a capability have the role operate"
    return ""
