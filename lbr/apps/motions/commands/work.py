"""`python -m lbr.apps.motions.commands.work`: one job with a motion, in a process that may be killed at any time.

It reads a job as one line of JSON, and writes its progress and its result as lines of JSON. Nothing that moves the
robot waits for it: it has a low priority, and bounds on time and memory.
"""

import os
import resource
import sys
import time
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

import msgspec
from msgspec.structs import replace

from lbr.apps.motions.commands import motion_files
from lbr.errors import InputError, LbrError
from lbr.messages.faces import Motor
from lbr.messages.joints import Joint, KeyFrame, Motion, MotionRow, MotionStep, motions_of
from lbr.messages.motion_work import (
    LONGEST_CHECK_S,
    Checked,
    CheckJob,
    Job,
    JobMessage,
    NotDone,
    Progress,
    ReadJob,
    ReadMotions,
    Versions,
    VersionsJob,
    WriteJob,
    Written,
)
from lbr.messages.rows import Row
from lbr.messages.unreadable import UNREADABLE
from lbr.robot import registry
from lbr.simulation.humanoid.settings import HumanoidWorldSettings

R = TypeVar("R", bound="Row")
NICENESS = 10
MOST_CPU_S = 120
MOST_BYTES = 4 << 30
"""The bound on address space, which is more than memory: libraries reserve far more than they use."""
LARGEST_JOB_BYTES = 16 << 20
WORLD = "humanoid_world"
SMOOTHEST = 1.5
"""The ratio of a smooth motion's time to a straight one's at the same greatest speed."""


def main() -> int:
    """Do the job on standard input; return 0 if it has a result."""
    os.nice(NICENESS)
    resource.setrlimit(resource.RLIMIT_CPU, (MOST_CPU_S, MOST_CPU_S))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    last: JobMessage = NotDone(reason="there was no job")
    try:
        for last in done(msgspec.json.decode(sys.stdin.buffer.readline(LARGEST_JOB_BYTES), type=Job)):
            _say(last)
    except LbrError as err:
        last = NotDone(reason=str(err), code=err.code if isinstance(err, InputError) else "failed")
        _say(last)
    except (MemoryError, *UNREADABLE) as err:
        last = NotDone(reason=f"this cannot be read: {err or type(err).__name__}", code="bad_value")
        _say(last)
    except BrokenPipeError:
        return 1
    return 1 if isinstance(last, NotDone) else 0


def done(job: Job) -> Iterator[JobMessage]:
    """Do a job: yield its progress, and then its result; raise LbrError with the reason of a failure."""
    match job:
        case CheckJob():
            yield from _checked(job)
        case ReadJob():
            yield _read(job)
        case WriteJob():
            yield _written(job)
        case VersionsJob():
            yield _versions(job)


def _say(said: JobMessage) -> None:
    sys.stdout.buffer.write(msgspec.json.encode(said) + b"\n")
    sys.stdout.buffer.flush()


def _checked(job: CheckJob) -> Iterator[JobMessage]:
    from lbr.operations.joints import trajectory  # noqa: PLC0415 - each job loads what it needs
    from lbr.simulation.humanoid.balance import Balance  # noqa: PLC0415

    joints = {joint.name: joint for joint in job.joints}
    frames = (*job.lead_in, *job.frames)
    if unknown := sorted({name for frame in frames for name in frame.positions} - set(joints)):
        raise InputError(f"there is no joint '{unknown[0]}' here", "unknown_name")
    start = {name: _within(joint, job.start.get(name, 0.0)) for name, joint in joints.items()}
    speeds, world = {name: joint.speed_rps for name, joint in joints.items()}, _world(job)
    before, last, begun = len(job.lead_in), len(job.frames), time.monotonic()

    def balance(start: dict[str, float]) -> Balance:
        way = trajectory.plan(start, _reached(start, frames, joints), speeds, job.interpolation)
        if not way.duration_s <= LONGEST_CHECK_S:
            text = f"it takes {way.duration_s:.0f} s, and {LONGEST_CHECK_S:.0f} s is the most that is checked at once"
            raise InputError(text, "bad_value")
        return Balance(
            world,
            job.joints,
            job.home,
            goals=lambda t: {**start, **trajectory.positions(way, t)},
            duration_s=way.duration_s,
            frame=lambda t: max(0, min(last, trajectory.passed(way, t) + 1 - before)),
        )

    for pose in (start, {**start, **frames[0].positions}):
        tried = balance(pose)
        for part in tried.play():
            yield Progress(part=round(part, 3))
        if tried.report.begins:
            break
    yield Checked(report=replace(tried.report, led=pose is not start, took_s=round(time.monotonic() - begun, 2)))


def _within(joint: Joint, angle: float) -> float:
    return min(max(angle if isfinite(angle) else 0.0, joint.lower_rad), joint.upper_rad)


def _reached(start: dict[str, float], frames: tuple[KeyFrame, ...], joints: dict[str, Joint]) -> tuple[KeyFrame, ...]:
    """Give the first key frame the time that its slowest joint needs, as when a motion is played."""
    ways = (abs(at - start[name]) / joints[name].speed_rps for name, at in frames[0].positions.items())
    return (replace(frames[0], duration_s=max(frames[0].duration_s, SMOOTHEST * max(ways, default=0.0))), *frames[1:])


def _world(job: CheckJob) -> HumanoidWorldSettings:
    """Return the simulation of the robot: of its own rows, or its package's, or with the body of its name."""
    for settings in (*_settings_in(Path(job.database), job.robot), *_settings_of_package(job.robot)):
        try:
            return msgspec.json.decode(settings, type=HumanoidWorldSettings)
        except UNREADABLE:
            continue
    return HumanoidWorldSettings(model=job.robot)


def _settings_in(database: Path, robot: str) -> Iterator[str]:
    from lbr.database.store import Database  # noqa: PLC0415

    if not database.is_file():
        return
    with Database.open(database) as opened:
        rows = opened.load(robot).capabilities if robot in opened.robots() else ()
    yield from (str(row.settings) for row in rows if row.kind == WORLD)


def _settings_of_package(robot: str) -> Iterator[str]:
    """Yield the settings in the rows of a robot's package."""
    from lbr.database import packaged  # noqa: PLC0415

    found = registry.find(robot)
    if found is None or found.robot is None or found.robot.rows is None:
        return
    rows = packaged.rows_of(found).get("capability", ())
    yield from (str(row["settings"]) for row in rows if row["kind"] == WORLD)


def _read(job: ReadJob) -> ReadMotions:
    rows = _Rows(job.joints, job.motors)
    read = motion_files.read(job.content, job.suffix)
    notes: list[Any] = []
    if isinstance(read, motion_files.MotionFile):
        motions: tuple[Motion, ...] = (replace(read.motion, builtin=False),)
    else:
        motions, notes = read.motions(rows)
    good, cut, texts = [], 0, [str(note) for note in notes]
    for motion in motions:
        try:
            within, count = motion_files.within_limits(motion, job.joints, clip=job.clip)
            motion_files.summary(within, job.joints)
        except InputError as err:
            texts.append(f"{motion.name} is left out: {err}")
            continue
        good.append(within)
        cut += count
    if not good:
        raise InputError("; ".join(texts[-3:]) or "there is no motion in it", "bad_value")
    return ReadMotions(motions=tuple(good), notes=tuple(texts), cut=cut)


def _written(job: WriteJob) -> Written:
    rows: Any = _Rows(job.joints, job.motors)
    content, notes = motion_files.exported(job.robot, job.motion, rows, job.suffix)
    return Written(content=content, notes=tuple(map(str, notes)))


def _versions(job: VersionsJob) -> Versions:
    from lbr.apps.motions.commands import versions as motion_versions  # noqa: PLC0415
    from lbr.database.store import Database  # noqa: PLC0415

    path = Path(job.database)
    if not path.is_file():
        raise InputError(f"the database {path} is not there", "unknown_name")
    with Database.open(path) as opened:
        rows, changes = opened.load(job.robot), opened.changes()
    motions = motions_of(rows.of(MotionRow), rows.of(MotionStep))
    now = next((one for one in motions if one.name == job.motion), None)
    return Versions(versions=motion_versions.versions(now, changes, job.robot, job.motion))


class _Rows:
    """A robot's rows, as far as files of motions need them."""

    def __init__(self, joints: tuple[Joint, ...], motors: tuple[Motor, ...]) -> None:
        self._tables: dict[type, tuple[Any, ...]] = {Joint: joints, Motor: motors}

    def of(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table."""
        return self._tables.get(row, ())


if __name__ == "__main__":
    sys.exit(main())
