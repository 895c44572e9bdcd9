"""The reports of a part about itself, as links: of the drive, motors, joints, servos, cameras, supplies and sensors."""

from collections.abc import Callable, Iterator
from typing import Any

from lbr.messages.attitude import AttitudeState
from lbr.messages.camera import CameraState
from lbr.messages.codes import ReasonCode
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveState
from lbr.messages.gamepad import TeleopState
from lbr.messages.joints import JointsState
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.power import PowerState, UpsState
from lbr.messages.sensing import Ranges
from lbr.messages.servos import ServosState
from lbr.messages.why import Link, LinkState
from lbr.why import bodies, leases
from lbr.why.snapshot import Part, Report, Snapshot

SLOW = 0.5
"""A camera with less than this share of its pictures is reported."""
CLOSING = frozenset({"countdown", "parking", "powering_off", "off"})


def links(now: Snapshot, part: Part) -> Iterator[Link]:
    """Yield the hindrances that a part reports, or that it is well; nothing for a part of unknown type."""
    for message, of_state in _STATES.items():
        if message.__name__ in part.outputs.values() and (report := now.report(part, message)) is not None:
            yield from of_state(report)


def works(now: Snapshot, part: Part) -> bool:
    """Return whether a degraded driver still moves the other servos of its bus."""
    report = now.report(part, ServosState)
    return report is not None and report.state.armed


def _drive(report: Report[DriveState]) -> Iterator[Link]:
    state = report.state
    yield from leases.holder(report, moving=state.moving and not state.limited_by)
    if state.holder and state.limited_by:
        how = "slowed" if state.moving else "stopped"
        text = f"'{report.part.name}' is {how} by {state.limited_by}" + (f": {state.reason}" if state.reason else "")
        do = "move away from it, or see what the sensor sees: lbr topic echo ranges/readings"
        yield report.link("rule", "doubt" if state.moving else "held", text, state.code or "limit", do=do)
    yield leases.last(report)


def _motors(report: Report[MotorsState]) -> Iterator[Link]:
    state, part = report.state, report.part
    if state.faults and not state.estop:
        text = f"the motor controller reports {', '.join(state.faults)}"
        do = "remove the cause; a fault that stays is released by switching the controller off and on"
        holds: LinkState = "doubt" if state.armed else "held"
        yield report.link("fault", holds, text, "latched", do=do, about=part.device, since=("fault",))
    if state.armed:
        if state.heard is False:
            yield bodies.unheard(report, "the motor controller")
        turns = any(motor.power for motor in state.each.values())
        yield report.link("motor", "ok", "the motors are armed" + (", and turn" if turns else ", at zero"))
    elif not state.faults or state.estop:
        enable = report.now.facts.say(f"{part.name}.enable", "", enabled=True)
        text = f"the motors are not armed: {state.reason or 'no reason given'}"
        code: ReasonCode = "estop" if state.estop else state.code or "not_armed"
        do = "stop, then move again" + (f"; if they were disabled: {enable}" if enable else "")
        yield report.link("arming", "held", text, code, do=do, since=("trip", "fault", "degraded"))


def _camera(report: Report[CameraState]) -> Iterator[Link]:
    state, part, facts = report.state, report.part, report.now.facts
    if not state.on:
        do = f"lbr topic pub {part.name}/switch '{{\"on\": true}}'"
        chooser = next((one.name for one in facts.parts.values() if "CamerasState" in one.outputs.values()), "")
        if chooser:
            do = facts.say(f"{chooser}.select", do, name=part.name.removeprefix("camera_"))
        text = f"'{part.name}' is switched off, for privacy: its device is closed"
        yield report.link("switch", "held", text, "off", do=do, since=("switched", "camera", "off"))
    elif state.phase != "streaming":
        text = f"'{part.name}' gives no pictures: {state.reason or f'it is {state.phase}'}"
        code: ReasonCode = "unreachable" if state.phase == "lost" or state.reason else "not_ready"
        do = "follow that sentence; else wait a second"
        yield report.link("line", "held", text, code, do=do, about=part.device, since=("degraded", "lost"))
    else:
        yield _rate(report)


def _rate(report: Report[CameraState]) -> Link:
    state, part = report.state, report.part
    unit = report.now.unit(part.name)
    wanted = float(part.settings.get("fps", 15))
    rate = unit.rates_hz.get("frame", 0.0) if unit is not None else (state.fps or 0.0)
    young = unit is not None and (unit.uptime_s or 0.0) < 5.0
    if rate >= SLOW * wanted or young or (state.rests and rate > 0.0):
        size = f"{state.width_px} x {state.height_px}" if state.width_px else ""
        return report.link("rate", "ok", f"{rate:.0f} pictures a second {size}".strip())
    text = f"'{part.name}' gives {rate:.0f} pictures a second, where its row asks for {wanted:.0f}"
    evidence = f"@status: rates_hz; {report.topic}: dropped {state.dropped}"
    do = "more light, a smaller picture, or less for the machine to do"
    return report.link("rate", "held" if rate == 0.0 else "doubt", text, "timeout", do=do, evidence=evidence)


def _ranges(report: Report[Ranges]) -> Iterator[Link]:
    rules = [
        (one["sensor"], one["direction"], float(one["stop_m"]))
        for each in report.now.facts.parts.values()
        for one in _rules(each)
    ]
    for sensor, direction, stop_m in dict.fromkeys(rules):
        status = report.state.status.get(sensor, "ok")
        metres = report.state.metres(sensor)
        refused = f"what goes {direction} is refused"
        if report.state.tells_of(sensor) and metres is None and status != "over_range":
            text = f"sensor '{sensor}' reads nothing ({status}): {refused}"
            do = "check that sensor's cable; other directions go"
            yield report.link("reading", "doubt", text, "stale_sensor", do=do, about=sensor)
        elif metres is not None and metres <= stop_m:
            text = f"something is {metres:.2f} m from sensor '{sensor}', nearer than {stop_m:.2f} m: {refused}"
            do = "move the other way, or take it away"
            yield report.link("reading", "doubt", text, "obstacle", do=do, about=sensor)


def _rules(part: Part) -> list[dict[str, Any]]:
    found = part.settings.get("rules", []) if "DriveState" in part.outputs.values() else []
    return [one for one in found if isinstance(one, dict) and {"sensor", "direction", "stop_m"} <= one.keys()]


def oldest_s(part: Part, message: str) -> float | None:
    """Return the greatest age of a message with which a drive still moves, by its settings; None if they have none."""
    if "DriveState" not in part.outputs.values():
        return None
    if message == "Ranges":
        return min((float(one["max_age_s"]) for one in _rules(part) if "max_age_s" in one), default=None)
    found = part.settings.get(
        {"AttitudeState": "attitude_max_age_s", "MotorsState": "motors_max_age_s"}.get(message, "")
    )
    return float(found) if isinstance(found, int | float) else None


def _attitude(report: Report[AttitudeState]) -> Iterator[Link]:
    if not report.state.valid:
        text = f"'{report.part.name}' does not know how the robot lies: {report.state.reason or 'no reason given'}"
        yield report.link("reading", "held", text, "stale_sensor", do="keep the robot still for some seconds")


def _odometry(report: Report[OdometryState]) -> Iterator[Link]:
    state = report.state
    if not state.valid:
        text = f"'{report.part.name}' does not know how far the robot came: {state.reason or 'no reason given'}"
        yield report.link("reading", "held", text, "stale_sensor", do="look at the encoders' wiring")
    elif state.stalled:
        yield report.link("motor", "held", "the motors push and the wheels stand", "stuck", do="free the wheels")


def _dock(report: Report[DockSignal]) -> Iterator[Link]:
    state = report.state
    if seen := [name for name in ("left", "right", "power") if getattr(state, name)]:
        yield report.link("reading", "ok", f"beams are seen: {', '.join(seen)}")
        return
    ages = [age for age in (state.left_age_s, state.right_age_s, state.power_age_s) if age is not None]
    last = f"the last one {min(ages):.0f} s ago" if ages else "none since it started"
    text = f"no beam of a dock is seen, {last}"
    do = "turn the robot so that the receiver looks at the dock, and see that the dock has power"
    yield report.link("reading", "doubt", text, "stale_sensor", do=do, since_s=min(ages, default=None))


def _power(report: Report[PowerState]) -> Iterator[Link]:
    state = report.state
    if state.phase in CLOSING:
        left = f" in {state.remaining_s:.0f} s" if state.remaining_s is not None else ""
        text = f"the computer is shut down{left}: {state.reason or state.phase}"
        do = report.now.facts.say(f"{report.part.name}.cancel", "cancel")
        yield report.link("power", "held", text, "shutting_down", do=do)


def _ups(report: Report[UpsState]) -> Iterator[Link]:
    state, part = report.state, report.part
    if state.relay is False:
        do = report.now.facts.say(f"{part.name}.relay", "/relay/on", on=True)
        yield report.link("power", "held", "the relay of the motors' power is off", "off", do=do, since=("relay",))
    elif not state.valid:
        text = f"'{part.name}' cannot be read: {state.reason or 'no reason given'}"
        yield report.link("power", "doubt", text, "stale_sensor", do="check its wiring")


def _teleop(report: Report[TeleopState]) -> Iterator[Link]:
    state = report.state
    text = f"it says '{state.line}'" if state.line else state.reason
    if state.driving or state.line:
        yield report.link("input", "ok", text)
        return
    text = f"the gamepad moves nothing: {text}"
    if state.pad:
        do = "hold its dead-man button, and then push a stick from its centre"
        yield report.link("input", "held", text, state.code, do=do)
    else:
        yield report.link("input", "doubt", text, state.code, do="lbr devices lists what is plugged in")


_STATES: dict[type[Any], Callable[[Report[Any]], Iterator[Link]]] = {
    DriveState: _drive,
    JointsState: bodies.joints,
    MotorsState: _motors,
    ServosState: bodies.servos,
    CameraState: _camera,
    Ranges: _ranges,
    AttitudeState: _attitude,
    OdometryState: _odometry,
    DockSignal: _dock,
    TeleopState: _teleop,
    PowerState: _power,
    UpsState: _ups,
}


def understood() -> frozenset[str]:
    """Return the names of the messages that are read here."""
    return frozenset(message.__name__ for message in _STATES)
