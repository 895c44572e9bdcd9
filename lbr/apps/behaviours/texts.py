"""Tables and runs as text for people: lists, graphs, and why a row is not taken. Pure."""

from collections.abc import Iterable, Mapping, Sequence

from lbr.apps.behaviours.table import Compiled, Fault
from lbr.messages.behaviour import BehaviourRow, BehaviourState, BehaviourTable, Unmet

MOST_FAULTS = 12


def faults(name: str, found: Sequence[Fault]) -> str:
    """Return what is wrong with a table, one fault a line."""
    more = [f"... and {len(found) - MOST_FAULTS} more"] if len(found) > MOST_FAULTS else []
    return "\n".join([*(f"behaviour '{name}', {fault(one)}" for one in found[:MOST_FAULTS]), *more])


def fault(error: Fault, lines: Mapping[int, int] | None = None) -> str:
    """Return where a fault is, by the line of its row in a file if that is known, and what is to be done."""
    line = (lines or {}).get(error.step, 0)
    at = f"line {line}" if line else f"row {error.step}" if error.step else ""
    where = ", ".join(filter(None, (at, error.column)))
    return f"{where}: {error.text}" if where else error.text


def listed(tables: Mapping[str, BehaviourTable], compiled: Mapping[str, Compiled], now: BehaviourState) -> str:
    """Return every table with what it is for, and the first fault of one that cannot be run."""
    width = max(map(len, tables), default=0)
    lines = []
    for name, table in sorted(tables.items()):
        wrong = compiled[name].errors
        runs = now.phase in {"running", "paused"} and name in {now.table, *now.called}
        mark = "▶" if runs else "✗" if wrong else " "
        said = f"{len(wrong)} faults, the first: {fault(wrong[0])}" if wrong else table.help
        lines.append(f"{mark} {name:{width}}  {said}".rstrip())
    return "\n".join(lines) or "there are no behaviours: 'lbr behaviour import FILE' takes one"


def why(state: BehaviourState) -> str:
    """Return where a run is, and for each row what does not hold and by how much."""
    if state.phase == "resting":
        return "no behaviour ran yet"
    if state.phase == "ended":
        return (
            f"{state.table} ended well in '{state.state}'"
            if state.good
            else f"{state.table} failed in '{state.state}': {state.reason}"
        )
    at = " > ".join((*state.called, state.table))
    lines = [f"{at} is {state.phase} in '{state.state}', {state.state_s:.1f} s"]
    if state.doing:
        lines.append(f"  does: {state.doing}")
    if state.result:
        lines.append(f"  the last command: {state.result}")
    if state.variables:
        lines.append("  " + ", ".join(f"${name} = {_number(value)}" for name, value in state.variables.items()))
    for row in state.rows:
        said = "; ".join(_unmet(one) for one in row.unmet) or "holds"
        lines.append(f"  row {row.step} -> {row.next_state}: {said}")
    return "\n".join(lines)


def graph(table: BehaviourTable, rows: Iterable[BehaviourRow], at: str = "") -> str:
    """Return a table as a graph in text: each state, and what leads out of it; `at` is where the robot is."""
    ordered = sorted((row for row in rows if row.type != "#"), key=lambda row: row.step)
    ends = {row.state: row.type for row in ordered if row.type in {"end", "fail"}}
    start = next((row.state for row in ordered if row.type == "start"), "")
    lines = [f"{table.name}: {table.help}" if table.help else table.name]
    for state in dict.fromkeys(row.state for row in ordered):
        sign = {"end": "◎", "fail": "✗"}.get(ends.get(state, ""), "●" if state == start else "○")
        here = "  ◀ the robot is here" if state == at else ""
        lines.append(f"{sign} {state}{here}")
        of_state = [row for row in ordered if row.state == state]
        for number, row in enumerate(of_state):
            corner = "└─" if number == len(of_state) - 1 else "├─"
            to = "" if state in ends or row.type == "entry" else f" ─▶ {row.next_state}"
            parts = [_conditions(row), *([f"[{_outputs(row)}]"] if row.outputs else [])]
            deadline = f" (within {row.deadline_s:g} s)" if row.deadline_s is not None else ""
            told = " ".join(part for part in parts if part)
            if told or to:
                lines.append(f"  {corner} {told}{to}{deadline}".replace("─  ", "─ "))
    return "\n".join(lines)


def _conditions(row: BehaviourRow) -> str:
    if row.type == "entry":
        return "on entering"
    if row.type in {"end", "fail"}:
        return ""
    said = " and ".join(f"{column} {text}" for column, text in row.conditions.items() if text.strip())
    return said or "at once"


def _outputs(row: BehaviourRow) -> str:
    return ", ".join(f"{column} {text}" for column, text in row.outputs.items())


def _unmet(one: Unmet) -> str:
    seen = "nothing" if one.seen is None else _number(one.seen)
    by = f", off by {_number(one.by)}" if one.by is not None and not one.text else ""
    return f"{one.column} is {seen}, not {one.condition}{by}" + (f" ({one.text})" if one.text else "")


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
