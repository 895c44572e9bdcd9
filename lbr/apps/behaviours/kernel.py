"""A run of a table: its state, its order now, and why it stays. Pure: time, values and dice are arguments.

    step(now, look)
        state: check the rows in their order
        first row whose conditions hold: its orders, one after the other
    ended(outcome)
        the next order; after the last one, the next state

The run offers one order at a time, in `order`. Its driver carries the order out, and reports the end by `ended`.
"""

from collections.abc import Callable, Mapping
from math import inf, isfinite
from typing import NamedTuple

from lbr.apps.behaviours import outputs
from lbr.apps.behaviours.cells import Value
from lbr.apps.behaviours.keys import RUN, VARIABLE, Key, Look
from lbr.apps.behaviours.outputs import Aside, Assign, CallTable, Order, OutputError, Wait, described
from lbr.apps.behaviours.table import Condition, Line, State, Table
from lbr.leases.holder import FINAL, bounded
from lbr.messages.beacon import SeekCommand
from lbr.messages.behaviour import RowView, Unmet
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand

SETTLE_S = 0.3
"""The pause for decisions after a motion: three periods of the odometry, so that its values are of the new place."""
RETRY_S = 1.0
"""The pause before a retry; a brief obstacle, such as a busy machine, is mostly gone by then."""
LONGEST_ORDER_S = 120.0
"""The longest motion: at a tenth of full power a room is crossed in less. Waits and tables have times of their own."""
LONGEST_SEARCH_S = 400.0
"""The longest search by beams: twelve metres along a wall and back, at walking pace, with a look at each step."""
DEEPEST = 8
"""The depth of tables within tables. A table that runs itself is refused when it is read."""


class Outcome(NamedTuple):
    """The end of an order: `good` if it went as planned, and the reason with its code."""

    good: bool
    why: Reason


DONE = Outcome(True, Reason("done", "done"))


class _Held:
    """The memory of a cell within one state: since when it holds, and whether it held the last time."""

    __slots__ = ("before", "since")

    def __init__(self) -> None:
        self.since = inf
        self.before: bool | None = None


class _Frame:
    """A table on the stack: the running one, or one that waits for the table it called."""

    def __init__(self, table: Table, now: float, chance: float) -> None:
        self.table = table
        self.visits: dict[str, int] = {}
        self.enter(table.start, now, chance)

    def enter(self, name: str, now: float, chance: float) -> None:
        """Enter a state."""
        self.state: State = self.table.states[name]
        self.since = now
        self.chance = chance
        self.visits[name] = self.visits.get(name, 0) + 1
        self.held: dict[tuple[int, int], _Held] = {}
        self.todo: list[Order] = []
        self.retries = self.left = 0
        self.next_state = ""
        self.ending = self.state.end


class Run:
    """A run of a table, begun at `now`; `draw(n)` returns a random number from 0 to n - 1.

    - `order`: the order to carry out now, or None. A new `ticket` marks a new order.
    - `keeps`: a motion without an end, which goes on meanwhile.
    - `row`: the step of the row taken last; 0 before the first.
    - `tables`: the tables that apply from the next state on.
    - `over`: the reason of the run's end; `good`: whether it ended well.
    """

    def __init__(self, table: Table, tables: Mapping[str, Table], now: float, draw: Callable[[int], int]) -> None:
        self.order: Order | None = None
        self.ticket = 0
        self.keeps: DriveCommand | None = None
        self.over: Reason | None = None
        self.good = False
        self.transitions = 0
        self.row = 0
        self.variables: dict[str, Value] = {}
        self.result = ""
        self.tables = dict(tables) | {table.name: table}
        self._draw = draw
        self._began = self._now = now
        self._lost_s = 0.0
        self._paused_at: float | None = None
        self._renew: tuple[DriveCommand, float] | None = None
        self._keeps_left = 0
        self._one_step = False
        self._wait_until = self._settled_at = self._ordered_at = self._again_at = -inf
        self._failing: Reason | None = None
        self._missed = ""
        self._frames = [_Frame(table, now, self._chance())]
        self._begin_state(now)

    @property
    def paused(self) -> bool:
        """Return whether the run is paused."""
        return self._paused_at is not None

    @property
    def table(self) -> str:
        """Return the current table."""
        return self._frames[-1].table.name

    @property
    def state(self) -> str:
        """Return the current state."""
        return self._frames[-1].state.name

    @property
    def called(self) -> tuple[str, ...]:
        """Return the tables that wait for the current one, outermost first."""
        return tuple(frame.table.name for frame in self._frames[:-1])

    @property
    def doing(self) -> str:
        """Return the current order or kept motion, for people."""
        if self.order is not None:
            return described(self.order)
        return described(self.keeps) if self.keeps is not None else ""

    def times(self, now: float) -> tuple[float, float]:
        """Return the time in this state and the time of the run, both without pauses."""
        at = self._at(now)
        return at - self._frames[-1].since, at - self._began

    def step(self, now: float, look: Look) -> None:
        """Advance: take the first row whose conditions all hold, unless an order is under way."""
        if self.over is not None or self.paused:
            return
        self._now, at = now, self._at(now)
        if self._renew is not None and at >= self._renew[1]:
            self.keeps, self._renew = self._renew[0], None
            self.ticket += 1
        if not self._too_long(at):
            self._go_forward(at, now, look)

    def _too_long(self, at: float) -> bool:
        """End the run or the state if it has lasted too long; return whether it has."""
        frame, max_s = self._frames[-1], self._frames[0].table.max_s
        if at - self._began >= max_s:
            self._end(good=False, why=Reason("time_over", f"it ran for {max_s:g} s, the longest it may"))
        elif at - frame.since >= frame.state.deadline_s and not frame.ending:
            said = f"'{frame.state.name}' lasted for {frame.state.deadline_s:g} s, the longest it may"
            self._fail(Reason("timeout", said))
        else:
            return False
        return True

    def _go_forward(self, at: float, now: float, look: Look) -> None:
        frame = self._frames[-1]
        if isinstance(self.order, Wait):
            if at >= self._wait_until:
                self.ended(DONE, now)
        elif self.order is not None:
            longest_s = LONGEST_SEARCH_S if isinstance(self.order, SeekCommand) else LONGEST_ORDER_S
            if at - self._ordered_at >= longest_s:
                why = f"it is not done after {longest_s:g} s"
                self.ended(Outcome(False, Reason("timeout", why)), now)
        elif frame.todo:
            if at >= self._again_at:
                self._next_order(now)
        elif frame.next_state or frame.ending:
            self._leave(now)
        elif at >= self._settled_at:
            self._look_around(at, now, look)

    def ended(self, outcome: Outcome, now: float) -> None:
        """Receive the outcome of the current order."""
        if self.over is not None or self.order is None:
            return
        frame, order = self._frames[-1], self.order
        self._now = now
        if not isinstance(order, Wait | Aside):
            self.result = outcome.why.code
            self._settled_at = self._at(now) + SETTLE_S
            if not frame.ending:
                self._missed = "" if outcome.good else f", after {described(order)}: {outcome.why.text}"
        if outcome.good or frame.ending:
            self.order = None
            if isinstance(order, DriveCommand) and not bounded(order) and outcome.good:
                self.keeps, self._keeps_left = order, frame.retries
            frame.todo.pop(0)
            frame.left = frame.retries
            return
        if outcome.why.code in FINAL:
            self._end(good=False, why=outcome.why)
        elif frame.left > 0:
            frame.left -= 1
            self.order, self._again_at = None, self._at(now) + RETRY_S
        else:
            self.order = None
            self._after_failure(outcome.why, described(order))

    def lost(self, outcome: Outcome) -> None:
        """Receive the end of the kept motion."""
        if self.over is not None or self.keeps is None:
            return
        order, self.keeps = self.keeps, None
        self.result = outcome.why.code
        if self._keeps_left > 0 and outcome.why.code not in FINAL:
            self._keeps_left -= 1
            self._renew = order, self._at(self._now) + RETRY_S
            return
        frame = self._frames[-1]
        if outcome.why.code in FINAL:
            self._end(good=False, why=outcome.why)
        elif not frame.ending and not frame.state.asks_for_result:
            self._fail(Reason(outcome.why.code, f"{described(order)}: {outcome.why.text}"))

    def pause(self, now: float) -> None:
        """Stand still from now on; `resume` begins the current order again."""
        if self.over is None and self._paused_at is None:
            self._paused_at = now

    def resume(self, now: float, *, one_step: bool = False) -> None:
        """Go on after a pause; with `one_step` only up to the next state."""
        self._one_step = one_step
        if self._paused_at is not None:
            self._lost_s += now - self._paused_at
            self._paused_at = None
            self.ticket += 1

    def stop(self, why: Reason) -> None:
        """End the run at once."""
        self._end(good=False, why=why)

    def replace(self, tables: Mapping[str, Table]) -> None:
        """Apply these tables from the next state on; end the run if one that is under way is missing."""
        self.tables = dict(tables)
        for frame in self._frames:
            if frame.table.name not in tables and self.over is None:
                self._end(
                    good=False, why=Reason("changed", f"the table '{frame.table.name}' was taken away while it ran")
                )

    def why(self, now: float, look: Look) -> tuple[RowView, ...]:
        """Return the rows of the state with their unmet conditions; changes nothing."""
        frame, at = self._frames[-1], self._at(now)
        return tuple(
            RowView(
                step=line.step,
                next_state=line.next_state,
                unmet=tuple(
                    unmet
                    for place, condition in enumerate(line.conditions)
                    if (unmet := self._unmet(frame, (number, place), condition, at, look)) is not None
                ),
            )
            for number, line in enumerate(frame.state.lines)
        )

    def _at(self, now: float) -> float:
        """Return the run's own time, which stands still during a pause."""
        return (now if self._paused_at is None else self._paused_at) - self._lost_s

    def _chance(self) -> float:
        return self._draw(10_000) / 100.0

    def _look_around(self, at: float, now: float, look: Look) -> None:
        frame = self._frames[-1]
        for number, line in enumerate(frame.state.lines):
            # check every condition, even after one that does not hold: `for` and `becomes` have a memory
            holds = [self._holds(frame, (number, place), one, at, look) for place, one in enumerate(line.conditions)]
            if all(holds):
                self._take(line, now)
                return

    def _take(self, line: Line, now: float) -> None:
        self.row = line.step
        self._frames[-1].next_state = line.next_state
        self._orders(line.outputs)
        self._go_on(now)

    def _orders(self, cells: Mapping[str, str]) -> None:
        frame = self._frames[-1]
        try:
            made = outputs.make(cells, self._draw, self.variables)
        except OutputError as err:
            self._fail(Reason("bad_value", f"O:{err.column}: {err}"))
            return
        frame.todo += made.orders
        frame.retries = frame.left = made.retries

    def _go_on(self, now: float) -> None:
        due = self._at(now) >= self._again_at
        if self.over is None and self._frames[-1].todo and self.order is None and due:
            self._next_order(now)

    def _next_order(self, now: float) -> None:
        """Begin the next order; assignments are done at once."""
        frame = self._frames[-1]
        while frame.todo and isinstance(frame.todo[0], Assign):
            self._assign(frame.todo.pop(0))  # type: ignore[arg-type]
            if self._frames[-1] is not frame:
                return  # the assignment failed and changed the state: skip the other orders of the row
        if not frame.todo or self.over is not None:
            return
        order = frame.todo[0]
        self.ticket += 1
        self._offer(order, now)

    def _offer(self, order: Order, now: float) -> None:
        self.order = order
        self._ordered_at = self._at(now)
        if isinstance(order, Wait):
            self._wait_until = self._at(now) + order.seconds
        elif isinstance(order, CallTable):
            self._call(order, now)
        elif not isinstance(order, Aside):
            self.keeps = self._renew = None

    def _call(self, order: CallTable, now: float) -> None:
        table = self.tables.get(order.name)
        if table is None or len(self._frames) >= DEEPEST:
            why = f"there is no table '{order.name}'" if table is None else f"more than {DEEPEST} tables run each other"
            self.ended(Outcome(False, Reason("unknown_name", why)), now)
            return
        self.order = None
        self._frames.append(_Frame(table, self._at(now), self._chance()))
        self._begin_state(now)

    def _assign(self, order: Assign) -> None:
        if order.how == "=":
            self.variables[order.name] = order.value
            return
        before = self.variables.get(order.name, 0.0)
        if isinstance(before, str) or isinstance(order.value, str):
            self._fail(Reason("bad_value", f"O:set: ${order.name} is '{before}', to which nothing is added"))
            return
        after = before + (order.value if order.how == "+=" else -order.value)
        if not isfinite(after):  # a condition on infinity or NaN would hold forever, or never
            self._fail(Reason("bad_value", f"O:set: ${order.name} is more than can be reckoned with"))
            return
        self.variables[order.name] = after

    def _leave(self, now: float) -> None:
        """Enter the next state, or end the table."""
        frame = self._frames[-1]
        if frame.ending:
            self._return(now, good=frame.state.good)
            return
        newest = self.tables.get(frame.table.name, frame.table)
        if frame.next_state not in newest.states:
            self._fail(
                Reason("changed", f"the state '{frame.next_state}' was taken out of '{newest.name}' while it ran")
            )
            return
        frame.table = newest
        self.transitions += 1
        frame.enter(frame.next_state, self._at(now), self._chance())
        self._begin_state(now)
        if self._one_step:
            self._one_step = False
            self.pause(now)

    def _begin_state(self, now: float) -> None:
        frame = self._frames[-1]
        state = frame.state
        for cells in state.entry:
            self._orders(cells)
            if self._frames[-1] is not frame or frame.state is not state:
                return  # an order failed and changed the state: skip the other orders of this one
        if not self.paused:
            self._go_on(now)

    def _return(self, now: float, *, good: bool) -> None:
        """End a table: end the run, or go on in the table that called it."""
        frame = self._frames[-1]
        why = self._failing if self._failing is not None and not good else None
        if len(self._frames) == 1:
            at = Reason("done" if good else "failed", f"ended in '{frame.state.name}'{'' if good else self._missed}")
            self._end(good=good, why=why or at)
            return
        self._frames.pop()
        self._failing = None
        self.order = self._frames[-1].todo[0]
        outcome = (
            DONE
            if good
            else Outcome(
                False,
                Reason(
                    why.code if why else "failed", f"'{frame.table.name}' failed" + (f": {why.text}" if why else "")
                ),
            )
        )
        self.ended(outcome, now)

    def _after_failure(self, why: Reason, order: str) -> None:
        """Go on after a failed order if the next state asks for the result; else fail."""
        frame = self._frames[-1]
        following = frame.table.states.get(frame.next_state) if frame.next_state else frame.state
        if following is not None and following.asks_for_result:
            frame.todo.clear()
        else:
            self._fail(Reason(why.code, f"{order}: {why.text}"))

    def _fail(self, why: Reason) -> None:
        """Enter the failure state; without one, or from an end, end the table."""
        frame = self._frames[-1]
        self.order = self.keeps = self._renew = None
        failure = frame.table.failure
        self._failing = why
        if frame.ending or not failure:
            self._return(self._now, good=False)
            return
        self.transitions += 1
        frame.enter(failure, self._at(self._now), self._chance())
        for cells in frame.state.entry:
            self._orders(cells)

    def _end(self, *, good: bool, why: Reason) -> None:
        if self.over is None:
            self.over, self.good = why, good
            self.order = self.keeps = self._renew = None

    def _value(self, frame: _Frame, condition: Condition, at: float, look: Look) -> Value | None:
        key = condition.key
        if key.stream == RUN:
            return self._of_the_run(frame, key, at)
        if key.stream == VARIABLE:
            return self.variables.get(key.path[0])
        return look(key, condition.newest_s)

    def _of_the_run(self, frame: _Frame, key: Key, at: float) -> Value | None:
        match key.column:
            case "Time":
                return at - frame.since
            case "Run Time":
                return at - self._began
            case "Visits":
                return float(frame.visits[frame.state.name])
            case "Chance":
                return frame.chance
        return self.result or None

    def _holds(self, frame: _Frame, place: tuple[int, int], condition: Condition, at: float, look: Look) -> bool:
        cell = condition.cell
        value = self._value(frame, condition, at, look)
        fits = cell.fits.off(value, turning=condition.key.turning) == 0.0
        if not (cell.for_s or cell.becomes):
            return fits
        held = frame.held.setdefault(place, _Held())
        before, held.before = held.before, fits
        held.since = inf if not fits else min(held.since, at)
        if cell.becomes and not cell.for_s:
            return fits and before is False
        long_enough = at - held.since >= cell.for_s
        return fits and long_enough

    def _unmet(
        self, frame: _Frame, place: tuple[int, int], condition: Condition, at: float, look: Look
    ) -> Unmet | None:
        cell, key = condition.cell, condition.key
        value = self._value(frame, condition, at, look)
        off = cell.fits.off(value, turning=key.turning)
        text, by = "", None if off == inf else off
        if value is None and off:
            text = "nothing that is new enough"
        elif off == 0.0:
            held = frame.held.get(place)
            if cell.for_s:
                lacking = cell.for_s - (at - held.since if held is not None and held.since != inf else 0.0)
                if lacking <= 0.0:
                    return None
                text, by = f"holds, for {lacking:.1f} s too short", lacking
            elif cell.becomes:
                text, by = "holds already: it has to be otherwise first", None
            else:
                return None
        return Unmet(column=key.column, condition=cell.text, seen=value, by=by, text=text)
