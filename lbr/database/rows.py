"""The rows as the rest of the program sees them: checked, frozen, free of the database they came from."""

from datetime import datetime
from typing import Any, Literal

from msgspec import Struct

from lbr.messages.system import Role, TokenRole

Side = Literal["left", "right", "centre"]
Restart = Literal["never", "on-failure", "always"]
GoodFor = Literal["bus", "web", "both"]
Argument = tuple[str, ...] | str


class Problem(Struct, frozen=True):
    """What is wrong with one row: `row` is its key as people read it, `column` may be empty for the whole row."""

    table: str
    row: str
    column: str
    text: str

    def __str__(self) -> str:
        where = f"{self.table} '{self.row}'" if self.row else self.table
        return f"{where}, {self.column}: {self.text}" if self.column else f"{where}: {self.text}"


class RobotRow(Struct, frozen=True, kw_only=True):
    """The robot itself; times are ISO 8601 in UTC, empty before the first. A latch that cannot be read is engaged."""

    name: str
    model: str = ""
    description: str = ""
    owner: str = ""
    last_start: str = ""
    last_shutdown: str = ""
    estop_engaged: bool = True
    estop_reason: str = ""


class CapabilityRow(Struct, frozen=True, kw_only=True):
    """One process to run: `settings` is the text of a JSON object, for the kind to parse; `needs` start before it."""

    name: str
    kind: str
    enabled: bool = True
    settings: str = "{}"
    restart: Restart = "on-failure"
    needs: tuple[str, ...] = ()
    help: str = ""


class ChannelRow(Struct, frozen=True, kw_only=True):
    """A wire from an output to an input, both `capability.port`; at most `rate_hz` (None: every one)."""

    source: str
    target: str
    rate_hz: float | None = None
    history: int = 1
    enabled: bool = True

    @property
    def source_end(self) -> tuple[str, str]:
        """Capability and port it comes from."""
        return split_end(self.source)

    @property
    def target_end(self) -> tuple[str, str]:
        """Capability and port it goes to."""
        return split_end(self.target)


class DeviceRow(Struct, frozen=True, kw_only=True):
    """What is plugged in, and where."""

    name: str
    type: str
    address: str
    settings: dict[str, Any] = {}


class VerbRow(Struct, frozen=True, kw_only=True):
    """One console line: `pattern` binds path fields to the target's message, `payload` fixes the others."""

    word: str
    pattern: str
    target: str
    role: Role
    help: str
    payload: dict[str, Any] | None = None

    @property
    def target_end(self) -> tuple[str, str]:
        """Capability and command it asks; the capability `executive` is built in."""
        return split_end(self.target)


class ExternalCommandRow(Struct, frozen=True, kw_only=True):
    """A program started by name, without a shell.

    `arguments` says for each argument that may be typed after the name which words it may be, or the regular
    expression that all of it must fit.
    """

    name: str
    argv: tuple[str, ...]
    blocking: bool = False
    enabled: bool = True
    help: str = ""
    arguments: tuple[Argument, ...] = ()
    role: Role = "operate"


class PhraseRow(Struct, frozen=True, kw_only=True):
    """What the robot says, in one language."""

    name: str
    language: str
    text: str


class ChoreographyRow(Struct, frozen=True, kw_only=True):
    """One move of a dance: this power and angle for so many beats."""

    dance: str
    step: int
    power: float
    angle_deg: float
    beats: int


class CalibrationRow(Struct, frozen=True, kw_only=True):
    """One measured number of a device."""

    device: str
    name: str
    value: float
    measured_at: str


class JointRow(Struct, frozen=True, kw_only=True):
    """One joint of a humanoid: which servo moves it, how the two angles relate, and how far and fast it may go.

    Where the joint is at 0, the servo is at `zero_rad`; `sign` says whether it turns the way the joint counts.
    """

    name: str
    device_id: int
    side: Side = "centre"
    sign: int = 1
    zero_rad: float = 0.0
    lower_rad: float
    upper_rad: float
    speed_rps: float


class MotionRow(Struct, frozen=True, kw_only=True):
    """A motion; its key frames are rows of their own. `lead_in` and `lead_out` name what is played before and after.

    One with a `slot` is kept and played by the robot's own controller, which takes `slot_s` for it.
    """

    name: str
    help: str = ""
    lead_in: str = ""
    lead_out: str = ""
    slot: int | None = None
    slot_s: float | None = None
    limp: bool = False
    builtin: bool = False


class MotionStepRow(Struct, frozen=True, kw_only=True):
    """A key frame: the angles that the named joints have `duration_s` after the step before."""

    motion: str
    step: int
    duration_s: float
    positions: dict[str, float]


class MotorRow(Struct, frozen=True, kw_only=True):
    """A servo as a face to the outside numbers, names and limits it, in the servo's own counts."""

    layer: str
    id: int
    name: str
    description: str = ""
    initial: int
    lowest: int
    highest: int
    rest: int
    inverted: bool = False
    builtin: bool = False


class ButtonRow(Struct, frozen=True, kw_only=True):
    """A motion as a face to the outside numbers and names it; no motion: only the controller is taken over."""

    id: int
    name: str
    button: str = ""
    motion: str = ""
    builtin: bool = False


class RevisionRow(Struct, frozen=True, kw_only=True):
    """One change of a row, as the triggers kept it."""

    id: int
    table: str
    row_key: tuple[str, ...]
    operation: Literal["insert", "update", "delete"]
    old: dict[str, Any] | None
    new: dict[str, Any] | None
    changed_at: str


class TokenRow(Struct, frozen=True, kw_only=True):
    """Somebody's rights: `hash` is of the token; times are ISO 8601 in UTC, None for never."""

    name: str
    role: TokenRole
    hash: str
    created_at: str
    revoked_at: str | None = None
    expires_at: str | None = None
    good_for: GoodFor = "both"

    def lets_in(self, door: Literal["bus", "web"]) -> bool:
        """Say whether it is one for that way in."""
        return self.good_for in {"both", door}

    def has_expired(self, now: datetime) -> bool:
        """Say whether its time is over; one whose end cannot be read is over."""
        if self.expires_at is None:
            return False
        try:
            return not now < datetime.fromisoformat(self.expires_at)
        except (ValueError, TypeError):
            return True


class AuditRow(Struct, frozen=True, kw_only=True):
    """One entry of the audit trail; number and hashes are given when it is written."""

    wall_ns: int
    kind: str
    subject: str
    source: str
    text: str
    id: int = 0
    previous: str = ""
    hash: str = ""


class Faulty(Struct, frozen=True):
    """A row that is left out, as far as it can be read: what stands in its bad `columns` says nothing."""

    table: str
    label: str
    row: Any
    columns: frozenset[str]


class RobotRows(Struct, frozen=True, kw_only=True):
    """One robot's rows out of one transaction: the good ones, and what is wrong with the others.

    Rows of which any column is bad are left out and named in `problems`; they are in `faulty` for further checks of what
    is good in them. `revision` counts the changes of rows,
    `digest` is the hash of all rows that make robots.
    """

    robot: RobotRow
    capabilities: tuple[CapabilityRow, ...] = ()
    channels: tuple[ChannelRow, ...] = ()
    devices: tuple[DeviceRow, ...] = ()
    verbs: tuple[VerbRow, ...] = ()
    external_commands: tuple[ExternalCommandRow, ...] = ()
    phrases: tuple[PhraseRow, ...] = ()
    choreographies: tuple[ChoreographyRow, ...] = ()
    calibrations: tuple[CalibrationRow, ...] = ()
    joints: tuple[JointRow, ...] = ()
    motions: tuple[MotionRow, ...] = ()
    motion_steps: tuple[MotionStepRow, ...] = ()
    motors: tuple[MotorRow, ...] = ()
    buttons: tuple[ButtonRow, ...] = ()
    tokens: tuple[TokenRow, ...] = ()
    revision: int = 0
    digest: str = ""
    problems: tuple[Problem, ...] = ()
    faulty: tuple[Faulty, ...] = ()

    def names(self, table: Literal["capability", "device"]) -> frozenset[str]:
        """Return the names of a table's rows, those that are left out too."""
        rows = self.capabilities if table == "capability" else self.devices
        return frozenset(row.name for row in rows) | {one.row.name for one in self.faulty if one.table == table}


def split_end(end: str) -> tuple[str, str]:
    """Split `capability.port`."""
    capability, _, port = end.partition(".")
    return capability, port
