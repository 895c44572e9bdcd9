"""What a part says of itself, as links: what the drive, motors, joints, servos, cameras, supplies and sensors tell."""

from collections.abc import Callable, Iterator
from typing import Any

from lbr.messages.attitude import AttitudeState
from lbr.messages.camera import CameraState
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveState
from lbr.messages.gamepad import TeleopState
from lbr.messages.joints import JointsState
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.power import PowerState, UpsState
from lbr.messages.sensing import Ranges
from lbr.messages.servos import ServosState
from lbr.messages.why import Link
from lbr.why import bodies, leases
from lbr.why.snapshot import Part, Snapshot

SLOW = 0.5
"""A camera that gives less than this part of its pictures is told of."""
CLOSING = frozenset({"countdown", "parking", "powering_off", "off"})


def links(now: Snapshot, part: Part) -> Iterator[Link]:
    """Yield what a part says that holds it, or that it is well; nothing for one of which nothing is known here."""
    for message, told in _TELLERS.items():
        if message.__name__ in part.outputs.values():
            found = now.heard(part, message)
            if found is not None:
                said, topic, age_s = found
                yield from told(now, part, said, topic, age_s)


def works(now: Snapshot, part: Part) -> bool:
    """Say whether a driver that is degraded moves all the same what it can: the other servos of its bus."""
    servos = now.heard(part, ServosState)
    return servos is not None and servos[0].armed


def _drive(now: Snapshot, part: Part, said: DriveState, topic: str, age_s: float | None) -> Iterator[Link]:
    yield from leases.holder(now, part, said.holder, topic, age_s, moving=said.moving and not said.limited_by)
    if said.holder and said.limited_by:
        how = "slowed" if said.moving else "stopped"
        yield Link(
            name="rule",
            about=part.name,
            state="doubt" if said.moving else "held",
            text=f"'{part.name}' is {how} by {said.limited_by}" + (f": {said.reason}" if said.reason else ""),
            code=said.code or "limit",
            age_s=age_s,
            evidence=topic,
            do="move away from it, or see what the sensor sees: lbr topic echo ranges/readings",
        )
    yield leases.last(now, part, said.holder, said.code, said.reason, topic, age_s, stopped_by=said.stopped_by)


def _motors(now: Snapshot, part: Part, said: MotorsState, topic: str, age_s: float | None) -> Iterator[Link]:
    if said.faults and not said.estop:
        yield Link(
            name="fault",
            about=part.device or part.name,
            state="doubt" if said.armed else "held",
            text=f"the motor controller reports {', '.join(said.faults)}",
            code="latched",
            since_s=now.since_s(part.name, ("fault",)),
            age_s=age_s,
            evidence=topic,
            do="remove the cause; a fault that stays is released by switching the controller off and on",
        )
    if not said.armed and not (said.faults and not said.estop):
        enable = now.facts.say(f"{part.name}.enable", "", enabled=True)
        yield Link(
            name="arming",
            about=part.name,
            state="held",
            text=f"the motors are not armed: {said.reason or 'no reason given'}",
            code="estop" if said.estop else "not_armed",
            since_s=now.since_s(part.name, ("trip", "fault", "degraded")),
            age_s=age_s,
            evidence=topic,
            do="stop, then move again" + (f"; if they were disabled: {enable}" if enable else ""),
        )
    elif said.armed:
        if said.heard is False:
            yield bodies.unheard(part, "the motor controller", topic, age_s)
        powers = [said.left, said.right, *(one.power for one in said.motors.values())]
        text = "the motors are armed" + (", and turn" if any(powers) else ", at zero")
        yield Link(name="motor", about=part.name, state="ok", text=text, age_s=age_s, evidence=topic)


def _camera(now: Snapshot, part: Part, said: CameraState, topic: str, age_s: float | None) -> Iterator[Link]:
    short = part.name.removeprefix("camera_")
    pub = f"lbr topic pub {part.name}/switch '{{\"on\": true}}'"
    if not said.on:
        others = (one.name for one in now.facts.parts.values() if "CamerasState" in one.outputs.values())
        chooser = next(others, "")
        yield Link(
            name="switch",
            about=part.name,
            state="held",
            text=f"'{part.name}' is switched off, for privacy: its device is closed",
            code="off",
            since_s=now.since_s(part.name, ("switched", "camera", "off")),
            age_s=age_s,
            evidence=topic,
            do=now.facts.say(f"{chooser}.select", pub, name=short) if chooser else pub,
        )
    elif said.phase != "streaming":
        yield Link(
            name="line",
            about=part.device or part.name,
            state="held",
            text=f"'{part.name}' gives no pictures" + (f": {said.reason}" if said.reason else f": it is {said.phase}"),
            code="unreachable" if said.phase == "lost" or said.reason else "not_ready",
            since_s=now.since_s(part.name, ("degraded", "lost")),
            age_s=age_s,
            evidence=topic,
            do="what it says; else wait a second",
        )
    else:
        yield from _rate(now, part, said, topic, age_s)


def _rate(now: Snapshot, part: Part, said: CameraState, topic: str, age_s: float | None) -> Iterator[Link]:
    unit = now.unit(part.name)
    wanted = float(part.settings.get("fps", 15))
    rate = unit.rates_hz.get("frame", 0.0) if unit is not None else (said.fps or 0.0)
    young = unit is not None and (unit.uptime_s or 0.0) < 5.0
    size = f"{said.width_px} x {said.height_px}" if said.width_px else ""
    if rate >= SLOW * wanted or young or (said.rests and rate > 0.0):
        yield Link(
            name="rate",
            about=part.name,
            state="ok",
            text=f"{rate:.0f} pictures a second {size}".strip(),
            age_s=age_s,
            evidence=topic,
        )
        return
    yield Link(
        name="rate",
        about=part.name,
        state="held" if rate == 0.0 else "doubt",
        text=f"'{part.name}' gives {rate:.0f} pictures a second, where its row asks for {wanted:.0f}",
        code="timeout",
        age_s=age_s,
        evidence=f"@status: rates_hz; {topic}: dropped {said.dropped}",
        do="more light, a smaller picture, or less for the machine to do",
    )


def _ranges(now: Snapshot, part: Part, said: Ranges, topic: str, age_s: float | None) -> Iterator[Link]:
    del part
    rules = [
        (one["sensor"], one["direction"], float(one["stop_m"]))
        for each in now.facts.parts.values()
        for one in _rules(each)
    ]
    for sensor, direction, stop_m in dict.fromkeys(rules):
        status = said.status.get(sensor, "ok")
        metres = said.metres(sensor)
        blind = said.tells_of(sensor) and metres is None and status != "over_range"
        if blind:
            text = f"sensor '{sensor}' reads nothing ({status}): what goes {direction} is refused"
            yield Link(
                name="reading",
                about=sensor,
                state="doubt",
                text=text,
                code="stale_sensor",
                age_s=age_s,
                evidence=topic,
                do="check that sensor's cable; other directions go",
            )
        elif metres is not None and metres <= stop_m:
            text = f"something is {metres:.2f} m from sensor '{sensor}', nearer than {stop_m:.2f} m: what goes {direction} is refused"
            yield Link(
                name="reading",
                about=sensor,
                state="doubt",
                text=text,
                code="obstacle",
                age_s=age_s,
                evidence=topic,
                do="move the other way, or take it away",
            )


def _rules(part: Part) -> list[dict[str, Any]]:
    found = part.settings.get("rules", []) if "DriveState" in part.outputs.values() else []
    return [one for one in found if isinstance(one, dict) and {"sensor", "direction", "stop_m"} <= one.keys()]


def oldest_s(part: Part, message: str) -> float | None:
    """Return how old what a drive hears may be by its settings, before it moves no more by it; None if nothing says."""
    if "DriveState" not in part.outputs.values():
        return None
    if message == "Ranges":
        return min((float(one["max_age_s"]) for one in _rules(part) if "max_age_s" in one), default=None)
    found = part.settings.get(
        {"AttitudeState": "attitude_max_age_s", "MotorsState": "motors_max_age_s"}.get(message, "")
    )
    return float(found) if isinstance(found, int | float) else None


def _attitude(now: Snapshot, part: Part, said: AttitudeState, topic: str, age_s: float | None) -> Iterator[Link]:
    del now
    if not said.valid:
        text = f"'{part.name}' does not know how the robot lies: {said.reason or 'no reason given'}"
        yield Link(
            name="reading",
            about=part.name,
            state="held",
            text=text,
            code="stale_sensor",
            age_s=age_s,
            evidence=topic,
            do="keep the robot still for some seconds",
        )


def _odometry(now: Snapshot, part: Part, said: OdometryState, topic: str, age_s: float | None) -> Iterator[Link]:
    del now
    if not said.valid:
        text = f"'{part.name}' does not know how far the robot came: {said.reason or 'no reason given'}"
        yield Link(
            name="reading",
            about=part.name,
            state="held",
            text=text,
            code="stale_sensor",
            age_s=age_s,
            evidence=topic,
            do="look at the encoders' wiring",
        )
    elif said.stalled:
        text = "the motors push and the wheels stand"
        yield Link(
            name="motor",
            about=part.name,
            state="held",
            text=text,
            code="stuck",
            age_s=age_s,
            evidence=topic,
            do="free the wheels",
        )


def _dock(now: Snapshot, part: Part, said: DockSignal, topic: str, age_s: float | None) -> Iterator[Link]:
    del now
    seen = [name for name in ("left", "right", "power") if getattr(said, name)]
    if seen:
        yield Link(
            name="reading",
            about=part.name,
            state="ok",
            text=f"beams are seen: {', '.join(seen)}",
            age_s=age_s,
            evidence=topic,
        )
        return
    ages = [age for name in ("left", "right", "power") if (age := getattr(said, f"{name}_age_s")) is not None]
    last = f"the last one {min(ages):.0f} s ago" if ages else "none since it started"
    text = f"no beam of a dock is seen, {last}"
    yield Link(
        name="reading",
        about=part.name,
        state="doubt",
        text=text,
        code="stale_sensor",
        since_s=min(ages, default=None),
        age_s=age_s,
        evidence=topic,
        do="turn the robot so that the receiver looks at the dock, and see that the dock has power",
    )


def _power(now: Snapshot, part: Part, said: PowerState, topic: str, age_s: float | None) -> Iterator[Link]:
    if said.phase in CLOSING:
        left = f" in {said.remaining_s:.0f} s" if said.remaining_s is not None else ""
        text = f"the computer is shut down{left}: {said.reason or said.phase}"
        yield Link(
            name="power",
            about=part.name,
            state="held",
            text=text,
            code="shutting_down",
            age_s=age_s,
            evidence=topic,
            do=now.facts.say(f"{part.name}.cancel", "cancel"),
        )


def _ups(now: Snapshot, part: Part, said: UpsState, topic: str, age_s: float | None) -> Iterator[Link]:
    if said.relay is False:
        text = "the relay of the motors' power is off"
        yield Link(
            name="power",
            about=part.name,
            state="held",
            text=text,
            code="off",
            since_s=now.since_s(part.name, ("relay",)),
            age_s=age_s,
            evidence=topic,
            do=now.facts.say(f"{part.name}.relay", "/relay/on", on=True),
        )
    elif not said.valid:
        text = f"'{part.name}' cannot be read: {said.reason or 'no reason given'}"
        yield Link(
            name="power",
            about=part.name,
            state="doubt",
            text=text,
            code="stale_sensor",
            age_s=age_s,
            evidence=topic,
            do="check its wiring",
        )


def _teleop(now: Snapshot, part: Part, said: TeleopState, topic: str, age_s: float | None) -> Iterator[Link]:  # noqa: ARG001 - as all
    moves = said.driving or bool(said.line)
    text = f"it says '{said.line}'" if said.line else said.reason
    missing = not said.pad
    yield Link(
        name="input",
        about=part.name,
        state="ok" if moves else "doubt" if missing else "held",
        text=text if moves else f"the gamepad moves nothing: {text}",
        code="" if moves else said.code,
        age_s=age_s,
        evidence=topic,
        do=""
        if moves
        else "lbr devices says what is plugged in"
        if missing
        else "hold its dead-man button, and then push a stick from its centre",
    )


_TELLERS: dict[type[Any], Callable[[Snapshot, Part, Any, str, float | None], Iterator[Link]]] = {
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
    return frozenset(message.__name__ for message in _TELLERS)
