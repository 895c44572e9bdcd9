"""A state table compiled: its cells parsed once, and all its faults with row and column. Pure."""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from math import inf
from typing import NamedTuple

from lbr.apps.behaviours import keys, outputs
from lbr.apps.behaviours.cells import Cell, CellError, Fits, parse
from lbr.apps.behaviours.keys import EVERY, Key
from lbr.messages.behaviour import MOST_ROWS, BehaviourRow, BehaviourTable

STATE, NEXT, TYPE, DEADLINE = "Current State", "Next State", "Type", "Deadline"
MOST_FAULTS = 50
"""The errors after which the rest of a table is not checked. Each error costs a search for similar names, and the
process that checks a table also moves the robot."""
MOST_COMPARED = 100
"""The rows of one state that are compared with all before them; a state written by hand has about ten."""


class Parts(NamedTuple):
    """The parts of a robot: streams to read, requests with an answerer, sensors; None: not known here."""

    streams: frozenset[str] = EVERY
    asks: frozenset[str] | None = None
    sensors: frozenset[str] | None = None


ANY_ROBOT = Parts()


class Fault(NamedTuple):
    """A problem at a row (its step; 0: the whole table) and column. A fault that is not an `error` is only a note."""

    step: int
    column: str
    text: str
    error: bool = True


class Condition(NamedTuple):
    """A cell and the key whose value it checks."""

    key: Key
    cell: Cell
    newest_s: float


class Line(NamedTuple):
    """A row with conditions, which must all hold. `outputs` stay text: a choice is drawn each time."""

    step: int
    conditions: tuple[Condition, ...]
    outputs: Mapping[str, str]
    next_state: str


class State(NamedTuple):
    """A state: its orders on entry, its rows in their order, its deadline, and whether it is an end."""

    name: str
    entry: tuple[Mapping[str, str], ...] = ()
    lines: tuple[Line, ...] = ()
    deadline_s: float = inf
    end: bool = False
    good: bool = True

    @property
    def all_outputs(self) -> tuple[Mapping[str, str], ...]:
        """Return the output cells of all its rows."""
        return (*self.entry, *(line.outputs for line in self.lines))

    @property
    def asks_for_result(self) -> bool:
        """Return whether it reads the result of the last command."""
        return any(condition.key.column == "Result" for line in self.lines for condition in line.conditions)


class Table(NamedTuple):
    """A table that can be run: its states by name, its start, and its failure state."""

    name: str
    states: Mapping[str, State]
    start: str
    failure: str = ""
    max_s: float = inf

    @property
    def keys(self) -> tuple[Key, ...]:
        """Return every key that it reads."""
        read = {
            condition.key: None
            for state in self.states.values()
            for line in state.lines
            for condition in line.conditions
        }
        return tuple(read)

    @property
    def calls(self) -> frozenset[str]:
        """Return the tables that it runs."""
        every = (cells.get("run", "") for state in self.states.values() for cells in state.all_outputs)
        return frozenset(one.strip() for some in every for one in some.split("|") if one.strip())


class Compiled(NamedTuple):
    """A table, None if it has errors, and all its faults in the order of the rows."""

    table: Table | None
    faults: tuple[Fault, ...]

    @property
    def errors(self) -> tuple[Fault, ...]:
        """Return the faults that keep it from being run."""
        return tuple(fault for fault in self.faults if fault.error)


def compile_table(table: BehaviourTable, rows: Iterable[BehaviourRow], robot: Parts = ANY_ROBOT) -> Compiled:
    """Compile a table for a robot with these parts."""
    every = sorted((row for row in rows if row.type != "#"), key=lambda row: row.step)
    faults: list[Fault] = []
    if len(every) > MOST_ROWS:
        return Compiled(None, (Fault(0, "", f"it has {len(every)} rows, and {MOST_ROWS} are the most"),))
    lines: list[Line] = []
    errors = 0
    for row in every:
        found: list[Fault] = []
        lines.append(_line(row, robot, found))
        faults += found
        errors += sum(fault.error for fault in found)
        if errors >= MOST_FAULTS:
            faults.append(Fault(row.step, "", "what comes after it is not looked at: mend what was found first"))
            return Compiled(None, tuple(faults))
    ends = list(dict.fromkeys(row.state for row in every if row.type == "end"))
    fails = list(dict.fromkeys(row.state for row in every if row.type == "fail"))
    if not fails and len(ends) > 1:
        fails = [ends[1]]
    states = _states(every, lines, ends, fails)
    faults += _of_shape(every, states, ends, fails)
    faults += _of_variables(every)
    unread = {fault.step for fault in faults if fault.error}
    for state in states.values():
        faults += _shadowed([line for line in state.lines if line.step not in unread])
    faults.sort(key=lambda fault: fault.step)
    start = next((row.state for row in every if row.type == "start"), "")
    made = Table(table.name, states, start, fails[0] if fails else "", table.max_s or inf)
    return Compiled(None if any(fault.error for fault in faults) else made, tuple(faults))


def compiled_alone(
    tables: Iterable[BehaviourTable], rows: Iterable[BehaviourRow], robot: Parts = ANY_ROBOT
) -> dict[str, Compiled]:
    """Return the compiled tables by name, each checked by itself."""
    of: dict[str, list[BehaviourRow]] = {}
    for row in rows:
        of.setdefault(row.behaviour, []).append(row)
    return {
        one.name: compile_table(one, of.get(one.name, ()), robot) for one in sorted(tables, key=lambda one: one.name)
    }


def cell_faults(rows: Iterable[BehaviourRow], robot: Parts = ANY_ROBOT) -> tuple[Fault, ...]:
    """Return the errors within single rows; the rows need not be a whole table."""

    def errors() -> Iterator[Fault]:
        for row in rows:
            faults: list[Fault] = []
            if row.type != "#":
                _line(row, robot, faults)
            yield from (fault for fault in faults if fault.error)

    return tuple(islice(errors(), MOST_FAULTS))


def linked(compiled: Mapping[str, Compiled]) -> dict[str, Compiled]:
    """Check the calls between tables: a called table must exist, have no errors, and not call its caller again."""
    checked = {}
    for name, each in compiled.items():
        more = list(_of_calls(name, compiled)) if each.table is not None else []
        checked[name] = Compiled(None, (*each.faults, *more)) if more else each
    faulty = {name for name, each in checked.items() if each.table is None}
    while True:  # a table that runs a faulty table is faulty
        worse = {name: each for name, each in checked.items() if each.table is not None and each.table.calls & faulty}
        if not worse:
            return checked
        for name, each in worse.items():
            assert each.table is not None
            which = min(each.table.calls & faulty)
            fault = Fault(0, "O:run", f"'{which}' has errors of its own: 'lbr behaviour check {which}' names them")
            checked[name] = Compiled(None, (*each.faults, fault))
        faulty |= worse.keys()


def _line(row: BehaviourRow, robot: Parts, faults: list[Fault]) -> Line:
    conditions = []
    for column, text in row.conditions.items():
        if not text.strip():
            continue
        if len(faults) >= MOST_FAULTS:
            break
        try:
            key = keys.resolve(column, robot.streams)
            cell = parse(text, turning=key.turning)
        except CellError as err:
            faults.append(Fault(row.step, column, str(err)))
            continue
        if why := _never(key, cell):
            faults.append(Fault(row.step, column, why))
        conditions.append(Condition(key, cell, key.newest_s if cell.newest_s is None else cell.newest_s))
    bad = islice(outputs.faults(row.outputs), MOST_FAULTS)
    faults += [Fault(row.step, f"O:{column}", text) for column, text in bad]
    faults += _lacking(row, robot)
    return Line(row.step, tuple(conditions), row.outputs, row.next_state)


def _lacking(row: BehaviourRow, robot: Parts) -> Iterator[Fault]:
    """Yield the outputs that no part of this robot carries out."""
    for column, way in outputs.WAYS.items():
        if row.outputs.get(column, "").strip() and robot.asks is not None and way not in robot.asks:
            text = f"this robot has no {outputs.NEEDS[way]} that runs"
            yield Fault(row.step, f"O:{column}", text, error=way not in outputs.ASIDE)
    sensors = robot.sensors
    for name in outputs.sensors(row.outputs) if sensors is not None else ():
        if sensors is not None and name not in sensors:
            there = ", ".join(sorted(sensors)) or "none"
            yield Fault(row.step, "O:sensor", f"this robot has no sensor '{name}': there is {there}")


def _states(
    rows: Sequence[BehaviourRow], lines: Sequence[Line], ends: Sequence[str], fails: Sequence[str]
) -> dict[str, State]:
    by_state: dict[str, list[tuple[BehaviourRow, Line]]] = {}
    for row, line in zip(rows, lines, strict=True):
        by_state.setdefault(row.state, []).append((row, line))
    states = {}
    for name, of_state in by_state.items():
        end = name in ends or name in fails
        first = [row.outputs for row, _ in of_state if row.type == "entry" or end]
        deadlines = [row.deadline_s for row, _ in of_state if row.deadline_s is not None]
        states[name] = State(
            name,
            entry=tuple(first[:1] if end else first),
            lines=tuple(line for row, line in of_state if row.type in {"", "start"} and not end),
            deadline_s=min(deadlines, default=inf),
            end=end,
            good=name not in fails,
        )
    return states


def _of_shape(
    rows: Sequence[BehaviourRow], states: Mapping[str, State], ends: Sequence[str], fails: Sequence[str]
) -> Iterator[Fault]:
    """Yield the faults of states, and of the ways between them."""
    if not rows:
        yield Fault(0, "", "it has no rows: a table needs a start and an end")
        return
    if not ends:
        yield Fault(0, TYPE, "no row has the type 'end': write it in the row of the state where the table ends well")
    elif not fails:
        yield Fault(0, TYPE, "no row has the type 'fail': without it nothing is done when something fails", error=False)
    for row in rows:
        yield from _of_row(row, states)
    yield from _from_the_start(rows, states, fails)
    for name, state in states.items():
        if not state.end and not state.lines:
            step = next(row.step for row in rows if row.state == name)
            yield Fault(
                step, STATE, f"nothing leads out of '{name}': give it a row with a next state, or the type 'end'"
            )


def _from_the_start(rows: Sequence[BehaviourRow], states: Mapping[str, State], fails: Sequence[str]) -> Iterator[Fault]:
    """Yield the faults of the start, and unreachable states."""
    starts = [row for row in rows if row.type == "start"]
    if not starts:
        yield Fault(rows[0].step, TYPE, "no row has the type 'start': write it in the row where the table starts")
        return
    for row in starts:
        if row.state != starts[0].state:
            yield Fault(row.step, TYPE, f"the table starts in '{starts[0].state}' already: there is one start")
    first = {row.state: row for row in reversed(rows) if row.state}
    for state in first.keys() - _reached(starts[0].state, states, fails):
        row = first[state]
        yield Fault(row.step, STATE, f"no row leads to the state '{state}'", error=row.type not in {"fail", "end"})


def _of_row(row: BehaviourRow, states: Mapping[str, State]) -> Iterator[Fault]:
    if not row.state.strip():
        yield Fault(row.step, STATE, "the state has no name")
    elif states[row.state].end:
        if row.type not in {"end", "fail"}:
            yield Fault(row.step, TYPE, f"'{row.state}' is an end in another row: an end has rows of its type alone")
        elif row.next_state not in {"", row.state}:
            yield Fault(row.step, NEXT, f"'{row.state}' is an end: nothing comes after it")
        elif row.conditions and any(map(str.strip, row.conditions.values())):
            yield Fault(row.step, STATE, "conditions of an end are not asked", error=False)
    elif row.type == "entry":
        if row.next_state or any(map(str.strip, row.conditions.values())):
            yield Fault(row.step, TYPE, "a row of the type 'entry' has outputs alone, no conditions and no next state")
    elif not row.next_state:
        yield Fault(row.step, NEXT, "it does not say which state comes next; the same state again is one, too")
    elif row.next_state not in states:
        near = [name for name in states if name.lower().strip() == row.next_state.lower().strip()]
        meant = f"; did you mean '{near[0]}'?" if near else f"; there is {', '.join(list(states)[:8])}"
        yield Fault(row.step, NEXT, f"there is no state '{row.next_state}'{meant}")


def _reached(start: str, states: Mapping[str, State], fails: Sequence[str]) -> set[str]:
    reached, waiting = {start, *fails[:1]}, deque([start])
    while waiting:
        for line in states[waiting.popleft()].lines:
            if line.next_state in states and line.next_state not in reached:
                reached.add(line.next_state)
                waiting.append(line.next_state)
    return reached


def _of_variables(rows: Sequence[BehaviourRow]) -> Iterator[Fault]:
    """Yield the variables that are read and never set."""
    given = {name for row in rows for name in outputs.variables_of(row.outputs)}
    for row in rows:
        asked = {column: column[1:] for column, text in row.conditions.items() if column[:1] == "$" and text.strip()}
        asked |= {f"O:{column}": text.strip()[1:] for column, text in row.outputs.items() if text.strip()[:1] == "$"}
        for column, name in asked.items():
            if name.isidentifier() and name not in given:
                yield Fault(row.step, column, f"no row sets the variable ${name}: O:set does, such as {name} = 0")


def _never(key: Key, cell: Cell) -> str:
    """Return why a cell can never hold, empty if it can."""
    fits = cell.fits
    if fits.missing or key.stream == keys.VARIABLE:
        return ""
    if key.sort == "text":
        wanted = fits.texts.of
        if fits.numbers and not (wanted or fits.texts.others):
            return f"'{cell.text}' never holds: {key.column} is a text"
        unknown = sorted(wanted - set(key.choices)) if key.choices and not fits.texts.others else []
        return f"'{unknown[0]}' never holds: {key.column} is one of {', '.join(key.choices)}" if unknown else ""
    if not fits.numbers:
        what = "a number" if key.sort == "number" else "yes or no"
        return f"'{cell.text}' never holds: {key.column} is {what}"
    possible = _domain(key)
    if not fits.both(possible).numbers:
        return f"'{cell.text}' never holds: {key.column} is from {key.low:g} to {key.high:g}"
    return ""


def _domain(key: Key) -> Fits:
    if key.turning:  # a range may be written across north from either side
        return Fits(((-360.0, 720.0),))
    return Fits(((key.low, key.high),))


def _shadowed(lines: Sequence[Line]) -> Iterator[Fault]:
    """Yield the rows that are never taken, because an earlier row has no condition that they lack."""
    asked = [frozenset((one.key, one.cell._replace(text="")) for one in line.conditions) for line in lines]
    for number, line in enumerate(lines[:MOST_COMPARED]):
        earlier = next((lines[at].step for at in range(number) if asked[at] <= asked[number]), 0)
        if earlier:
            text = f"this row is never taken: row {earlier} holds whenever it does, and comes first"
            yield Fault(line.step, STATE, text)


def _of_calls(name: str, compiled: Mapping[str, Compiled]) -> Iterator[Fault]:
    table = compiled[name].table
    for called in sorted(table.calls if table is not None else ()):
        if called not in compiled:
            yield Fault(0, "O:run", f"there is no table '{called}': there is {', '.join(sorted(compiled))}")
        elif name in _called(called, compiled):
            yield Fault(0, "O:run", f"'{called}' runs '{name}' again: a table cannot run within itself")


def _called(name: str, compiled: Mapping[str, Compiled]) -> set[str]:
    """Return a table and all that it runs, at any depth."""
    tables, waiting = {name}, [name]
    while waiting:
        each = compiled.get(waiting.pop())
        for called in each.table.calls if each is not None and each.table is not None else ():
            if called not in tables:
                tables.add(called)
                waiting.append(called)
    return tables
