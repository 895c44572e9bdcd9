"""Tables and runs as text for people: lists, graphs, and the unmet conditions of rows. Pure."""

from collections.abc import Iterable, Mapping, Sequence

from lbr.apps.behaviours.table import Compiled, Fault
from lbr.messages.behaviour import BehaviourRow, BehaviourState, BehaviourTable, Unmet

MOST_FAULTS = 12


def faults(name: str, found: Sequence[Fault]) -> str:
    """Return the faults of a table, one a line."""
    more = [f"... and {len(found) - MOST_FAULTS} more"] if len(found) > MOST_FAULTS else []
    return "\n".join([*(f"behaviour '{name}', {fault(one)}" for one in found[:MOST_FAULTS]), *more])


def fault(error: Fault, lines: Mapping[int, int] | None = None) -> str:
    """Return the place and text of a fault; the place is a line of its file if that is known."""
    line = (lines or {}).get(error.step, 0)
    at = f"line {line}" if line else f"row {error.step}" if error.step else ""
    where = ", ".join(filter(None, (at, error.column)))
    return f"{where}: {error.text}" if where else error.text


def listed(tables: Mapping[str, BehaviourTable], compiled: Mapping[str, Compiled], now: BehaviourState) -> str:
    """Return every table with its help, or with the first of its faults."""
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
    """Return the state of a run, and the unmet conditions of each row."""
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
    """Return a table as a graph in text: each state and the ways out of it; `at` is the robot's state."""
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
