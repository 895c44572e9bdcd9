"""Healthy snapshots of the robots that come with lbr, out of their own rows, for tests that break one thing in them."""

from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.database import store
from lbr.database.rows import RobotRows
from lbr.executive.planning.facts import facts
from lbr.executive.planning.profile import Profile
from lbr.messages.attitude import AttitudeState
from lbr.messages.camera import CameraState
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveState
from lbr.messages.gamepad import TeleopState
from lbr.messages.joints import JointsState, JointState
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.power import PowerState, UpsState
from lbr.messages.sensing import ranges
from lbr.messages.servos import ServosState
from lbr.messages.system import CapabilityStatus, EstopState, Event, Status
from lbr.why.snapshot import Facts, LatestMessage, Snapshot
from tests.support import databases
from tests.support.planning import planned

WALL_NS = 1_800_000_000_000_000_000
AGE_S = 0.02


def robot_rows(folder: Path) -> dict[str, RobotRows]:
    """Return the rows of every robot that comes with lbr."""
    path = folder / "robot.db"
    databases.fresh(path)
    with store.Database.open(path) as database:
        return {name: database.load(name) for name in database.robots()}


def facts_of(rows: RobotRows, without: tuple[str, ...] = ()) -> Facts:
    """Return what rows say, which must be good, under a profile without these capabilities."""
    plan = planned(rows, Profile(robot=rows.robot.name, simulate=True, without=without))
    return facts(plan, f"{rows.robot.name}-sim")


def snapshot(of: Facts) -> Snapshot:
    """Return a robot of which every part is well, and of which nothing is asked."""
    units = tuple(unit(name, of) for name, part in of.parts.items() if part.runs)
    found = {
        f"{part.name}/{port}": LatestMessage(message=_message(name, of), age_s=AGE_S)
        for part in of.parts.values()
        if part.runs
        for port, name in part.outputs.items()
        if name in _MESSAGES
    }
    measured = {
        wire.source.replace(".", "/"): LatestMessage(message={}, age_s=AGE_S) for wire in of.channels if wire.enabled
    }
    status = Status(
        robot=of.robot,
        profile=of.profile,
        ready=True,
        pid=1,
        uptime_s=600.0,
        estop=EstopState(engaged=False, reason=""),
        capabilities=units,
    )
    return Snapshot(facts=of, status=status, messages=measured | found, wall_ns=WALL_NS, asker="lbr why@here:1")


def unit(name: str, of: Facts, **fields: Any) -> CapabilityStatus:
    """Return a process that has run well for long."""
    rates = dict.fromkeys(of.parts[name].outputs, 20.0)
    well = CapabilityStatus(
        name=name, kind=of.parts[name].kind, phase="ready", pid=7, restarts=0, uptime_s=600.0, reason="", rates_hz=rates
    )
    return replace(well, **fields)


def with_unit(now: Snapshot, name: str, **fields: Any) -> Snapshot:
    """Return the robot with one process in another state."""
    assert now.status is not None
    units = tuple(replace(one, **fields) if one.name == name else one for one in now.status.capabilities)
    return replace(now, status=replace(now.status, capabilities=units))


def with_said(now: Snapshot, topic: str, age_s: float | None = AGE_S, **fields: Any) -> Snapshot:
    """Return the robot with other fields in the newest message of a stream."""
    message = {**now.messages[topic].message, **msgspec.to_builtins(fields)}
    return replace(now, messages={**now.messages, topic: LatestMessage(message=message, age_s=age_s)})


def with_joint(now: Snapshot, name: str, **fields: Any) -> Snapshot:
    """Return the robot with another state of one joint."""
    joints = dict(now.messages["joints/state"].message["joints"])
    joints[name] = {**joints[name], **fields}
    return with_said(now, "joints/state", joints=joints)


def with_estop(now: Snapshot, **fields: Any) -> Snapshot:
    """Return the robot with its emergency stop latched."""
    assert now.status is not None
    return replace(now, status=replace(now.status, estop=EstopState(engaged=True, **fields)))


def with_event(now: Snapshot, kind: str, subject: str, ago_s: float, text: str = "") -> Snapshot:
    """Return the robot after this happened."""
    event = Event(kind=kind, subject=subject, text=text or kind, wall_ns=WALL_NS - int(ago_s * 1e9))
    return replace(now, events=(*now.events, event))


def edited(rows: RobotRows, table: str, name: str, **fields: Any) -> RobotRows:
    """Return rows with one row changed: by its name, or a channel by `source > target`."""

    def meant(row: Any) -> bool:
        return bool((f"{row.source} > {row.target}" if table == "channels" else row.name) == name)

    assert any(meant(row) for row in getattr(rows, table)), name
    return replace(
        rows, **{table: tuple(replace(row, **fields) if meant(row) else row for row in getattr(rows, table))}
    )


def _message(name: str, of: Facts) -> dict[str, Any]:
    made = _MESSAGES[name](of)
    return dict(msgspec.to_builtins(made))


@cache
def _joint_states(joints: tuple[tuple[str, int, float, float], ...]) -> dict[str, JointState]:
    return {
        name: JointState(id=servo, position_rad=(lower + upper) / 2, torque=1.0, age_s=AGE_S)
        for name, servo, lower, upper in joints
    }


def _joints(of: Facts) -> Struct:
    rows = tuple((one.name, one.servo, one.lower_rad, one.upper_rad) for one in of.joints)
    states = _joint_states(rows)
    return JointsState(sequence=1, measured_s=1.0, moving=False, phase="following", joints=states, code="idle")


def _ups(_: Facts) -> UpsState:
    return UpsState(valid=True, source="external", external_v=12.0, relay=True)


_MESSAGES: dict[str, Any] = {
    "DriveState": lambda _: DriveState(
        moving=False, power=0.0, angle_deg=0.0, left=0.0, right=0.0, holder=None, goal=None, limited_by="",
        reason="no sender drives", estop=False, loop=None, code="idle",
    ),
    "JointsState": _joints,
    "MotorsState": lambda _: MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False),
    "ServosState": lambda _: ServosState(sweep=1, measured_s=1.0, armed=True, phase="following", servos=()),
    "CameraState": lambda _: CameraState(on=True, phase="streaming", device="camera", width_px=640, height_px=360, fps=15),
    "Ranges": lambda _: ranges(dict.fromkeys(("forward", "back", "left", "right"), 2.0) | {"bottom": 0.3}, {}),
    "AttitudeState": lambda _: AttitudeState(valid=True, epoch="1", measured_s=1.0),
    "OdometryState": lambda _: OdometryState(valid=True, epoch="1"),
    "DockSignal": lambda _: DockSignal(left=True, right=True, power=False, left_age_s=0.1, right_age_s=0.1),
    "PowerState": lambda of: PowerState(phase="watching", armed=True, warn_v=10.5, shutdown_v=9.9, ups=_ups(of)),
    "UpsState": _ups,
    "TeleopState": lambda _: TeleopState(pad=True, dead_man=True, driving=True, reason="it drives", code="done"),
}  # fmt: skip
