"""Messages and rows of `behaviour/*`: state tables that anyone can write, and the robot's progress in one."""

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from lbr.messages.codes import ReasonCode
from lbr.messages.rows import Row
from lbr.messages.units import Name, StepNumber

MOST_ROWS = 4000
"""Of one table: a thousand states of four rows each, which is too long for a spreadsheet."""
LONGEST_CELL = 300
LARGEST_FILE = 45_000
"""In bytes, for a file that is sent to the robot as a command: with base64 it fits into one.

`lbr behaviour import` accepts larger ones.
"""
StateName = Annotated[str, Meta(max_length=80)]
Cell = Annotated[str, Meta(max_length=LONGEST_CELL)]
Heading = Annotated[str, Meta(min_length=1, max_length=80)]
RowType = Literal["", "start", "end", "fail", "entry", "#"]
"""The kind of a row of a table. Empty: an alternative of its state. `start`: the same, in the first state.

`end`, `fail`: a good or bad end. `entry`: an action on entering the state. `#`: a comment.
"""


class BehaviourTable(Row, frozen=True, kw_only=True):
    """Behaviours: state tables, edited in any spreadsheet (docs/behaviours.md)."""

    TABLE = "behaviour"
    KEY = ("name",)

    name: Annotated[Name, "its name in commands"]
    help: Annotated[str, "one line for people"] = ""
    max_s: Annotated[float, Meta(ge=0.0, le=86400.0), "longest run; 0: until its end or a stop"] = 600.0


class BehaviourRow(Row, frozen=True, kw_only=True):
    """The rows of a behaviour. In a state, the first whose conditions all hold is taken. A wrong cell stops only it."""

    TABLE = "behaviour_row"
    KEY = ("behaviour", "step")
    PART_OF = "behaviour"

    behaviour: Annotated[Name, "its behaviour"]
    step: Annotated[StepNumber, "the order, from 1"]
    type: Annotated[
        RowType, "start: the first state; end, fail: good and bad ends; entry: done on entering; #: comment"
    ] = ""
    state: Annotated[StateName, "its state"] = ""
    conditions: Annotated[dict[Heading, Cell], 'column to condition, such as {"Forward": "< 40"}'] = field(
        default_factory=dict
    )
    outputs: Annotated[dict[Heading, Cell], 'what is done, such as {"level": "0.2", "angle": "0"}'] = field(
        default_factory=dict
    )
    next_state: Annotated[StateName, "the next state"] = ""
    deadline_s: (
        Annotated[float, Meta(gt=0.0, le=86400.0), "longest time in its state, then the behaviour fails"] | None
    ) = None


class RunBehaviour(Struct, frozen=True, kw_only=True):
    """Run a table from its start."""

    name: Name


class NamedBehaviour(Struct, frozen=True, kw_only=True):
    """Show a table; without a name, the one that runs or ran last."""

    name: Annotated[str, Meta(max_length=40)] = ""


class BehaviourOrder(Struct, frozen=True, kw_only=True):
    """Pause, go on, or do one step."""


class Unmet(Struct, frozen=True, kw_only=True):
    """A condition that does not hold: the value (null: none that is new enough), and by how much it misses.

    `by`: in the column's unit; null without a distance, as between texts.
    """

    column: str
    condition: str
    seen: float | str | None = None
    by: float | None = None
    text: str = ""


class RowView(Struct, frozen=True, kw_only=True):
    """A row of the current state, and its conditions that do not hold."""

    step: int
    next_state: str
    unmet: tuple[Unmet, ...] = ()


class BehaviourState(Struct, frozen=True, kw_only=True):
    """The running behaviour, its state, and why it stays there.

    `called`: the tables on the way to `table`, outermost first. `doing`: the command under way. `row`: the step of the
    row taken last. `state_s`, `run_s`: time in this state and in all. `reason`: the end of the last run.
    """

    phase: Literal["resting", "running", "paused", "ended"]
    table: str = ""
    state: str = ""
    called: tuple[str, ...] = ()
    doing: str = ""
    state_s: float = 0.0
    run_s: float = 0.0
    transitions: int = 0
    row: int = 0
    result: str = ""
    variables: dict[str, float | str] = {}
    rows: tuple[RowView, ...] = ()
    good: bool | None = None
    reason: str = ""
    code: ReasonCode = ""


class BehaviourFault(Struct, frozen=True, kw_only=True):
    """A problem in a table: its row by step, or line of a file (0: all of it), the column, and the cure.

    `error`: the table cannot run; otherwise it is only odd.
    """

    step: int = 0
    line: int = 0
    column: str = ""
    text: str
    error: bool = True


class BehaviourSummary(Struct, frozen=True, kw_only=True):
    """A table of the robot, and its problems; without errors it can run."""

    name: str
    help: str
    rows: int
    faults: tuple[BehaviourFault, ...] = ()


class BehaviourTables(Struct, frozen=True, kw_only=True):
    """The tables that the robot has, by name."""

    tables: tuple[BehaviourSummary, ...]


class CheckBehaviour(Struct, frozen=True, kw_only=True):
    """Report the problems of a table with this name and these rows; nothing is kept."""

    name: Name
    rows: tuple[BehaviourRow, ...]


class ReadBehaviour(Struct, frozen=True, kw_only=True):
    """Read a CSV or JSON file as a table of this name; nothing is kept."""

    name: Name
    file: Annotated[str, Meta(max_length=255)]
    content: Annotated[bytes, Meta(max_length=LARGEST_FILE)]


class BehaviourChecked(Struct, frozen=True, kw_only=True):
    """The problems of a table, and its rows as they were read."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    faults: tuple[BehaviourFault, ...] = ()
    rows: tuple[BehaviourRow, ...] = ()


class WriteBehaviour(Struct, frozen=True, kw_only=True):
    """Write a table as a file: CSV with commas or semicolons, or JSON."""

    name: Name
    form: Literal["csv", "semicolons", "json"] = "csv"


class BehaviourWritten(Struct, frozen=True, kw_only=True):
    """The bytes of the file."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    content: bytes = b""
