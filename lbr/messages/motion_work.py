"""Requests about motions to a process beside the robot, and its answers: checks of balance, files, earlier versions."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.faces import Motor
from lbr.messages.joints import MAX_FRAMES, Interpolation, Joint, JointRad, KeyFrame, Motion
from lbr.messages.units import Name

LONGEST_CHECK_S = 600.0
"""Of a motion: a longer one is checked in parts."""
Frames = Annotated[tuple[KeyFrame, ...], Meta(min_length=1, max_length=MAX_FRAMES)]
Millimetres = tuple[int, int]


class BalanceSample(Struct, frozen=True, kw_only=True):
    """The posture at a time, in millimetres from the first place of its feet, along its first heading.

    `tilt_rad` is the lean of the trunk against its stance. `mass` is the projection of the centre of mass on the floor,
    `pressure` the centre of pressure. `support` are the corners of the support polygon. `margin_mm` is the distance of
    `mass` inside it, negative outside; null if nothing touches the floor. `frame` counts from 1; 0: in the lead-in.
    """

    t_s: float
    frame: int
    tilt_rad: float
    roll_rad: float
    pitch_rad: float
    mass: Millimetres
    pressure: Millimetres | None = None
    support: tuple[Millimetres, ...] = ()
    margin_mm: int | None = None


class BalanceReport(Struct, frozen=True, kw_only=True):
    """The verdict on a motion: does it leave the simulated body on its feet?

    `falls_s` and `falls_frame` are the moment when it leant too far to recover, null: it did not. `begins`: it stood by
    itself in the first pose; otherwise no more is known. `led`: it did not stand in `start`, and was led into the first
    key frame, as by a hand. `least_mm` is the least margin of the motion, at `least_s`.
    """

    stands: bool
    begins: bool
    led: bool = False
    duration_s: float
    least_mm: int | None = None
    least_s: float | None = None
    falls_s: float | None = None
    falls_frame: int | None = None
    took_s: float = 0.0
    body: str = ""
    trace: tuple[BalanceSample, ...] = ()


class CheckJob(Struct, frozen=True, kw_only=True, tag="check"):
    """Play key frames with the robot's simulated body, standing in `start` first; `lead_in` comes before them.

    Joints that `start` leaves out are at zero, or as near to it as their limits permit.
    """

    robot: Name
    home: str
    database: str = ""
    joints: tuple[Joint, ...]
    frames: Frames
    lead_in: Annotated[tuple[KeyFrame, ...], Meta(max_length=MAX_FRAMES)] = ()
    start: dict[str, JointRad] = {}
    interpolation: Interpolation = "smooth"


class ReadJob(Struct, frozen=True, kw_only=True, tag="read"):
    """Read the motions in a file, by the suffix of its name, for the joints of a robot; `clip` cuts to their limits."""

    content: bytes
    suffix: str
    joints: tuple[Joint, ...]
    motors: tuple[Motor, ...] = ()
    clip: bool = True


class WriteJob(Struct, frozen=True, kw_only=True, tag="write"):
    """Write a motion as the content of a file, by the suffix of its name."""

    robot: Name
    motion: Motion
    suffix: str
    joints: tuple[Joint, ...]
    motors: tuple[Motor, ...] = ()


class VersionsJob(Struct, frozen=True, kw_only=True, tag="versions"):
    """List the earlier versions of a motion, from the revisions of a database."""

    robot: Name
    database: str
    motion: Name


Job = CheckJob | ReadJob | WriteJob | VersionsJob


class Progress(Struct, frozen=True, kw_only=True, tag="progress"):
    """The progress, 0 to 1."""

    part: float


class Checked(Struct, frozen=True, kw_only=True, tag="checked"):
    """The result of a check."""

    report: BalanceReport


class ReadMotions(Struct, frozen=True, kw_only=True, tag="read"):
    """The motions of a file, with notes for people; `cut` counts angles that were limited."""

    motions: tuple[Motion, ...]
    notes: tuple[str, ...] = ()
    cut: int = 0


class Written(Struct, frozen=True, kw_only=True, tag="written"):
    """The content of a file, and the losses of the conversion."""

    content: bytes
    notes: tuple[str, ...] = ()


class MotionVersion(Struct, frozen=True, kw_only=True):
    """A version of a motion, from `since` on, until the next; `revision` is the last change of rows in it."""

    revision: int
    since: str
    motion: Motion


class Versions(Struct, frozen=True, kw_only=True, tag="versions"):
    """The versions of a motion, newest first; the first one is the present one."""

    versions: tuple[MotionVersion, ...]


class NotDone(Struct, frozen=True, kw_only=True, tag="refused"):
    """The reason why there is no result, as a sentence."""

    reason: str
    code: str = "failed"


JobMessage = Progress | Checked | ReadMotions | Written | Versions | NotDone
