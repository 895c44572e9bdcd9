"""The manoeuvres, step by step, each with its endings. Pure.

    `align`: turns its back to the wall of the dock, at a distance at which the beams are wide. Ends: done.
    `search`: looks for a beam, goes aside by a step, looks again, to one side, then the other. Ends: done, not_found.
    `follow`: backs up between the beams. Ends: done (something is touched), lost, timeout.
    `withdraw`: leaves a near dock, towards the middle of its beams. Ends: done.
    `roam`: looks all around, and goes where there is most room, out of a corner or to search elsewhere. Ends: done.

Each may also end with the code of its last motion, such as `obstacle`.
"""

from dataclasses import dataclass
from typing import Literal

from lbr.messages.beacon import Manoeuvre
from lbr.robots.lbr.beacon import BeaconSettings
from lbr.robots.lbr.beacon.follow import follow
from lbr.robots.lbr.beacon.moves import bounded, face, sees, shortest, wait
from lbr.robots.lbr.beacon.view import STAND, Ending, GivenUpError, Go, Script

Side = Literal["left", "right"]

FREE_M = 0.6
SPARE_M = 0.35
WAYS_BLOCKED = frozenset({"obstacle", "stuck", "failed", "timeout"})
"""The codes of a turn that was stopped by something in the way."""
SIDES: dict[Side, float] = {"left": -90.0, "right": 90.0}
POWER = 0.25
STEP_M, STEPS = 0.5, 8
PAST_M = 0.7
WITHDRAW_M, WITHDRAW_DEG = 1.0, 5.0
ROAM_M, ROAM_DEG, ROAM_LOOK_S = 1.5, 45.0, 0.4
"""A whole turn is eight looks; a sensor with ten readings a second misses nothing in each."""


@dataclass(slots=True)
class Memory:
    """The memory of one manoeuvre for the next: the side of the first look, and the middle of the beams.

    `aside` is that from the robot, as it looks: 1 right, -1 left, 0 straight back. Both sides are as the docked robot
    looks, which is the same once it is aligned.
    """

    side: Side
    aside: float = 0.0


def script(manoeuvre: Manoeuvre, settings: BeaconSettings, memory: Memory) -> Script[Ending]:
    """Return the end of a manoeuvre; nothing raises."""
    try:
        match manoeuvre:
            case "align":
                yield from _align(settings)
            case "search":
                yield from _search(settings, memory.side)
            case "follow":
                return (yield from _follow(settings, memory))
            case "withdraw":
                yield from _withdraw(settings, memory.aside)
            case "roam":
                yield from _roam()
    except GivenUpError as err:
        return Ending(good=False, text=str(err), code=err.code)
    return Ending(good=True, text=_DONE[manoeuvre])


_DONE: dict[Manoeuvre, str] = {
    "align": "its back is to the wall of the dock",
    "search": "a beam of the dock is seen",
    "follow": "something is touched",
    "withdraw": "it is away from the dock",
    "roam": "it is elsewhere",
}


def _follow(settings: BeaconSettings, memory: Memory) -> Script[Ending]:
    """Come to rest at the contacts, and store the side of the beams."""
    followed = yield from follow(settings.docked_back_cm / 100)
    memory.aside = followed.aside
    if followed.aside:
        memory.side = "right" if followed.aside > 0.0 else "left"
    return Ending(good=followed.touched, text=followed.why or _DONE["follow"], code=followed.code)


def _withdraw(settings: BeaconSettings, aside: float) -> Script[None]:
    view = yield STAND
    if view.back_m is not None and view.back_m < settings.standoff_cm / 100 - SPARE_M:
        yield from face(aside * WITHDRAW_DEG)
        yield from bounded(Go(POWER, WITHDRAW_M))


def _roam() -> Script[None]:
    """Turn once around, then go towards the most room; directions in which the body cannot turn are left out."""
    ways: list[tuple[float, float]] = []
    began_deg = (yield STAND).direction_deg
    for number in range(round(360.0 / ROAM_DEG)):
        towards_deg = shortest(began_deg + number * ROAM_DEG)
        try:
            yield from face(towards_deg)
        except GivenUpError as err:
            if err.code not in WAYS_BLOCKED:
                raise
            continue
        view = yield from wait(ROAM_LOOK_S)
        if view.forward_m is not None:
            ways.append((view.forward_m, towards_deg))
    if not ways:
        raise GivenUpError("there is no room to any side", "obstacle")
    room_m, towards_deg = max(ways)
    yield from face(towards_deg)
    yield from bounded(Go(POWER, round(min(ROAM_M, max(0.1, room_m - FREE_M)), 2)))


def _align(settings: BeaconSettings) -> Script[None]:
    """Stand with the back to the dock, not too near and not too far."""
    yield from face(0.0)
    view = yield STAND
    if view.back_m is None:
        return
    way_m = settings.standoff_cm / 100 - view.back_m
    if way_m > 0.0 and view.forward_m is not None:
        way_m = min(way_m, view.forward_m - FREE_M)
    if abs(way_m) > SPARE_M:
        yield from bounded(Go(POWER, round(way_m, 2)))
        yield from face(0.0)


def _search(settings: BeaconSettings, side: Side) -> Script[None]:
    """Go along the dock's wall until a beam is seen: to one side, then to the other, past obstacles."""
    other: Side = "right" if side == "left" else "left"
    for towards, steps in ((side, STEPS), (other, 2 * STEPS)):
        for _ in range(steps):
            if (yield from sees()):
                return
            if not (yield from _aside(towards, STEP_M)) and not (yield from _past(towards)):
                break
            yield from _align(settings)
    if not (yield from sees()):
        text = "no beam of the dock was seen; is it plugged in, and the way to it free?"
        raise GivenUpError(text, "not_found")


def _past(side: Side) -> Script[bool]:
    """Try to go aside farther from the wall, then nearer to it; return whether a way was free."""
    for way_m in (PAST_M, -2 * PAST_M):
        yield from bounded(Go(POWER, way_m))
        if (yield from _aside(side, STEP_M)):
            return True
    return False


def _aside(side: Side, distance_m: float) -> Script[bool]:
    """Go to one side and turn the back to the dock again; return whether the way was free."""
    yield from face(SIDES[side])
    ending = yield from bounded(Go(POWER, distance_m))
    view = yield STAND
    free = ending.good or view.forward_m is None or view.forward_m > FREE_M
    yield from face(0.0)
    return free
