"""Messages on `joints/*` and `motions/*`: commands for a humanoid, and the state of its joints."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct
from msgspec.structs import asdict

from lbr.messages.codes import Code, ReasonCode
from lbr.messages.drive import LoopStatistics
from lbr.messages.leases import LeaseId
from lbr.messages.rows import Fault, Others, Row, short
from lbr.messages.servos import ServoId, ServoPhase, ServoState
from lbr.messages.units import Name, NameOrNone, StepNumber, TtlS

JointRad = Annotated[
    float,
    Meta(ge=-10.0, le=10.0, description="radians from the joint's zero", extra={"meant": "an angle in radians"}),
]
JointDeg = Annotated[float, Meta(ge=-360.0, le=360.0, description="degrees from the joint's zero")]
JointRps = Annotated[
    float, Meta(gt=0.0, le=100.0, description="radians a second", extra={"zero": "0 would never get anywhere"})
]
DurationS = Annotated[
    float, Meta(gt=0.0, le=60.0, description="seconds", extra={"zero": "0 is no time to get anywhere"})
]
BusOfJoints = Annotated[NameOrNone, Meta(description="which bus, where the robot has several")]
Strength = Annotated[float, Meta(gt=0.0, le=1.0, description="fraction of a servo's most")]
Interpolation = Literal["smooth", "linear"]
MAX_FRAMES = 1000


def _servo_of(joint: "Joint") -> tuple[str, int]:
    return joint.bus, joint.device_id


def _servo(row: "Joint", others: Others) -> Iterator[Fault]:
    known = others.index(Joint, _servo_of)
    first = known.get(("", row.device_id)) or known[_servo_of(row)]  # a row without a bus name applies to every bus
    if first.name != row.name:
        yield "device_id", f"servo {row.device_id} moves joint '{first.name}' already"


def _bus(row: "Joint", others: Others) -> Iterator[Fault]:
    if row.bus and row.bus not in others.names("device"):
        yield "bus", f"there is no device '{row.bus}'; name the device row of the servos' line, or leave it empty"


class Joint(Row, frozen=True, kw_only=True):
    """Humanoids: the joints. A servo's angle is `zero_rad + sign * joint angle`."""

    TABLE = "joint"
    KEY = ("name",)
    ASCENDING = (("lower_rad", "upper_rad"),)
    CHECKS = (_servo, _bus)

    name: Annotated[Name, "its name in motions"]
    device_id: ServoId
    side: Annotated[Literal["left", "right", "centre"], "its half of the body"] = "centre"
    sign: Annotated[Literal[1, -1], "-1: the servo turns against the joint"] = 1
    zero_rad: Annotated[JointRad, "the servo's angle where the joint is at 0"] = 0.0
    lower_rad: Annotated[JointRad, "limits of the joint's angle"]
    upper_rad: Annotated[JointRad, "see lower_rad"]
    speed_rps: Annotated[JointRps, "the fastest it may move, radians a second"]
    bus: Annotated[NameOrNone, "its servo's device row; empty: the only line"] = ""


Slot = Annotated[int, Meta(ge=1, le=255)]
SlotS = Annotated[float, Meta(gt=0.0, le=600.0, description="seconds", extra={"zero": "0 is no time to play anything"})]


class StoredMotion(Struct, frozen=True, kw_only=True):
    """A motion that the robot's own controller keeps under a number and plays: how long, and where it leads.

    Joints that `pose` leaves out are measured afterwards. `limp`: all are released at its end. `stable`: stopped on its
    way, the robot may go straight to `pose` and stands there.
    """

    slot: Slot
    duration_s: SlotS
    pose: dict[str, JointRad] = {}
    limp: bool = False
    stable: bool = False


class KeyFrame(Struct, frozen=True, kw_only=True):
    """The angles of the named joints `duration_s` after the frame before; joints left out stay.

    `stable`: the robot may rest here on its feet. A stopped motion goes on to the nearest such frame within 0.8 s.
    """

    positions: dict[str, JointRad]
    duration_s: DurationS
    stable: bool = False


def motion_there(row: Any, others: Others) -> Iterator[Fault]:
    """Check that the motion named in a row exists."""
    if row.motion and row.motion not in others.names("motion"):
        yield "motion", f"there is no motion '{row.motion}'"


def _lead(column: str, row: "MotionRow", others: Others) -> Iterator[Fault]:
    other = getattr(row, column)
    if other and (other not in others.names("motion") or other == row.name):
        yield column, f"there is no other motion '{other}'"


class MotionRow(Row, frozen=True, kw_only=True):
    """Humanoids: the named motions. The robot's own controller stores and plays a motion that has a slot."""

    TABLE = "motion"
    KEY = ("name",)
    TOGETHER = (("slot", "slot_s"),)
    CHECKS = (partial(_lead, "lead_in"), partial(_lead, "lead_out"))

    name: Annotated[Name, "its name in commands"]
    help: Annotated[str, "one line for people"] = ""
    lead_in: Annotated[NameOrNone, "the motion played once before it; empty: none"] = ""
    lead_out: Annotated[NameOrNone, "the motion played once after it, unless stopped; empty: none"] = ""
    slot: Annotated[Slot | None, "its number in the robot's own controller"] = None
    slot_s: Annotated[SlotS | None, "its duration there"] = None
    limp: Annotated[bool, "1: the controller releases the joints at its end"] = False
    builtin: Annotated[bool, "1: only an edit of the database changes it, never the network"] = False

    def refusal(self, before: Mapping[str, object] | None, parts: Sequence[Row]) -> tuple[str, Code] | None:
        """Return why a capability's edit may not write it: motions in the controller are entered at the robot."""
        if why := super().refusal(before, parts):
            return why
        if (self.slot, self.slot_s, self.limp) != (None, None, False):
            text = f"{self.full_name} would be in a slot: what the controller keeps is entered at the robot itself"
            return text, "not_possible"
        if (before or {}).get("slot") is not None:
            return (
                f"{self.full_name} is in a slot, kept by the controller: its row is edited at the robot itself",
                "read_only",
            )
        return None if parts else (f"{self.full_name} has no key frames", "bad_value")


def _joints(row: "MotionStep", others: Others) -> Iterator[Fault]:
    for name in row.positions:
        if name not in others.names("joint"):
            yield "positions", f"there is no joint '{short(name)}'"


def _range(joint: Joint) -> tuple[str, float, float]:
    return joint.name, joint.lower_rad, joint.upper_rad


def _within(row: "MotionStep", others: Others) -> Iterator[Fault]:
    joints = {joint.name: joint for joint in others.index(Joint, _range).values()}
    for name, angle in row.positions.items():
        joint = joints.get(name)
        if joint is not None and not joint.lower_rad <= angle <= joint.upper_rad:
            text = f"{name}: {angle:g} is outside {joint.lower_rad:g} to {joint.upper_rad:g}, the joint's limits"
            yield "positions", text


class MotionStep(Row, frozen=True, kw_only=True):
    """Humanoids: the key frames of a motion, in order. Those of a motion in a slot show where it leads."""

    TABLE = "motion_step"
    KEY = ("motion", "step")
    PART_OF = "motion"
    CHECKS = (_joints, _within)

    motion: Annotated[Name, "its motion"]
    step: Annotated[StepNumber, "the order, from 1"]
    duration_s: Annotated[DurationS, "from the step before"]
    positions: Annotated[dict[str, JointRad], "joint name to angle in radians; joints left out stay"]
    stable: Annotated[bool, "1: it stands here, and a stopped motion goes on to here"] = False

    @property
    def full_name(self) -> str:
        """Return the key frame and its motion."""
        return f"key frame {self.step} of '{self.motion}'"


class Motion(Struct, frozen=True, kw_only=True):
    """A motion with its key frames, which are rows of their own; those of one in a `slot` say where it leads."""

    name: str
    frames: tuple[KeyFrame, ...]
    help: str = ""
    lead_in: str = ""
    lead_out: str = ""
    slot: int | None = None
    slot_s: float | None = None
    limp: bool = False
    builtin: bool = False

    @property
    def row(self) -> MotionRow:
        """Return its row without the key frames."""
        return MotionRow(**{field: getattr(self, field) for field in MotionRow.__struct_fields__})

    @property
    def rows(self) -> tuple[Row, ...]:
        """Return its row, and those of its key frames, counted from 1."""
        steps = (MotionStep(motion=self.name, step=step, **asdict(frame)) for step, frame in enumerate(self.frames, 1))
        return (self.row, *steps)


class JointsCommand(Struct, frozen=True, kw_only=True):
    """Move joints to `positions`, or through `frames`, while the lease is renewed.

    Without `duration_s` the longest way sets the time, at `speed_rps` or as the rows allow; no joint goes faster than
    its row. `smooth` passes through frames without a stop, `linear` goes straight between them. `append`: `frames`
    follow those under way; the goal stays. With nothing to move, it renews the lease. `asked_s`: when the original
    sender asked, by the robot's monotonic clock; older than a stop, it does not begin.

    `join`: `positions` begin at once beside what moves, as fast as they may. `torque`: the strength of the named
    joints, a fraction of their most. `torques`: where they differ. `stored`: the robot's controller plays it; nothing
    else moves meanwhile. `stay`: the lease lives on after the end, while it is renewed.
    """

    positions: dict[str, JointRad] = {}
    frames: Annotated[tuple[KeyFrame, ...], Meta(max_length=MAX_FRAMES)] = ()
    duration_s: DurationS | None = None
    speed_rps: JointRps | None = None
    interpolation: Interpolation = "smooth"
    mirror: bool = False
    append: bool = False
    join: bool = False
    stay: bool = False
    torque: Strength | None = None
    torques: dict[str, Strength] = {}
    stored: StoredMotion | None = None
    asked_s: float | None = None
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class JointMove(Struct, frozen=True, kw_only=True):
    """Move one joint, in degrees, at this many degrees a second."""

    joint: Name
    angle_deg: JointDeg
    speed_dps: Annotated[float, Meta(gt=0.0, le=1000.0, description="degrees a second")] = 30.0
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class TorqueCommand(Struct, frozen=True, kw_only=True):
    """Switch the torque of joints on, where they are, or off; no joint named: all.

    All off drops the robot, and needs `confirmed`.
    """

    on: bool
    joints: tuple[Name, ...] = ()
    confirmed: bool = False
    lease: LeaseId = ""


class RecoverCommand(Struct, frozen=True, kw_only=True):
    """Recover joints from a latched fault whose cause is gone; no joint named: all."""

    joints: tuple[Name, ...] = ()


class JointState(ServoState, frozen=True, kw_only=True):
    """One joint as measured last, by its servo; null is not measured. `target_rad`: the end of its way, meanwhile.

    `torque`: as applied, 0 for none.
    """

    target_rad: float | None = None
    code: ReasonCode = ""


class JointsState(Struct, frozen=True, kw_only=True):
    """All joints in one sweep of the bus, their holder, and why they stand still.

    `passed`: key frames of this goal that lie behind. `stored`: the slot that the controller plays, for `left_s` more.
    `feet_s`: what a stopped robot may still need to its stance.
    """

    sequence: int
    measured_s: float
    moving: bool
    phase: ServoPhase
    joints: dict[str, JointState]
    holder: str | None = None
    goal: str | None = None
    passed: int = 0
    stopped_s: float | None = None
    stored: int | None = None
    left_s: float | None = None
    feet_s: float | None = None
    reason: str = ""
    code: ReasonCode = ""
    stopped_by: str = ""
    halted_s: float | None = None
    halted_by: str = ""
    estop: bool = False
    loop: LoopStatistics | None = None


class PlayCommand(Struct, frozen=True, kw_only=True):
    """Play a motion `times` times while the lease is renewed; its lead-in and lead-out once."""

    motion: Name
    times: Annotated[int, Meta(ge=1, le=1000)] = 1
    speed: Annotated[float, Meta(ge=0.1, le=3.0, description="1: as the rows say")] = 1.0
    mirror: bool = False
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class CaptureCommand(Struct, frozen=True, kw_only=True):
    """Append the joints' pose to a motion as a key frame, or begin a new motion with it."""

    motion: Name
    duration_s: DurationS = 1.0
    help: Annotated[str, Meta(max_length=200)] = ""


class MotionsState(Struct, frozen=True, kw_only=True):
    """The motion under way, its key frame and its round, both from 1; `reason` and `code` of the last end.

    `motion` is the lead-in or lead-out while that is played; all takes `left_s` more or less. `fallen`: the side on
    which the robot lies, by its attitude; empty: it does not, or unknown.
    """

    playing: bool
    motion: str = ""
    frame: int = 0
    frames: int = 0
    round: int = 0
    times: int = 0
    left_s: float | None = None
    fallen: Literal["", "face", "back", "side"] = ""
    holder: str | None = None
    reason: str = ""
    code: ReasonCode = ""


def motions_of(rows: Iterable[MotionRow], steps: Iterable[MotionStep]) -> tuple[Motion, ...]:
    """Return motions with their key frames, by name."""
    frames: dict[str, list[KeyFrame]] = {}
    for step in sorted(steps, key=lambda step: step.key):
        frame = KeyFrame(positions=step.positions, duration_s=step.duration_s, stable=step.stable)
        frames.setdefault(step.motion, []).append(frame)
    fields = MotionRow.__struct_fields__
    return tuple(
        Motion(**{field: getattr(row, field) for field in fields}, frames=tuple(frames.get(row.name, ())))
        for row in sorted(rows, key=lambda row: row.name)
    )
