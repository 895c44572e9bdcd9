"""How to dock, step by step. Pure.

| step | does | then | |---|---|---| | announce | says where it is going | | | station | turns its back to the wall
where the dock stands, at a distance at which the beams are wide | | | search | looks for a beam; sees none: goes aside
by a step and looks again; to one side, then to the other | no beam at all: give up | | follow | backs up between the
beams | lost: withdraw towards the middle, and from station on again | | touch | stands, and looks for the power beam, a
voltage that rises, or a charger | nothing: withdraw, and again | | verify | waits until the battery is being charged |
is not: give up |

A motion that was stopped is not begun again. After `tries` it gives up.
"""

from dataclasses import dataclass
from typing import Literal

from lbr.apps.autodock.follow import follow
from lbr.apps.autodock.moves import bounded, face, sees
from lbr.apps.autodock.view import STAND, Ending, GivenUpError, Go, Say, Script

Side = Literal["left", "right"]

RISE_V = 0.08
FREE_M = 0.6
SPARE_M = 0.35
SIDES: dict[Side, float] = {"left": -90.0, "right": 90.0}


@dataclass(frozen=True, slots=True)
class Manner:
    """How docking goes about it.

    `side` is where it looks for the dock first, as the docked robot looks. `docked_back_m` is what its rear sensor
    reads there: how far the wall is behind it.
    """

    side: Side = "left"
    power: float = 0.25
    docked_back_m: float = 0.36
    standoff_m: float = 1.8
    step_m: float = 0.5
    steps: int = 8
    past_m: float = 0.7
    withdraw_m: float = 1.0
    withdraw_deg: float = 5.0
    tries: int = 5
    touch_s: float = 6.0
    verify_s: float = 100.0


def dock(manner: Manner) -> Script[Ending]:
    """Return how it ended."""
    try:
        text = yield from _dock(manner)
        ending, phrase = Ending(good=True, text=text), "docked"
    except GivenUpError as err:
        ending, phrase = Ending(good=False, text=str(err)), "dock_failed"
    yield Say(phrase, ending.text)
    return ending


def _dock(manner: Manner) -> Script[str]:
    view = yield STAND
    if view.charging:
        return "on the dock already: the battery is being charged"
    yield Say("docking", "going to the dock")
    yield from _approach(manner)
    return (yield from _verify(manner))


def _approach(manner: Manner) -> Script[None]:
    """Come to stand at the contacts."""
    why, side = "", manner.side
    for _ in range(manner.tries):
        yield from _station(manner)
        yield from _search(side, manner)
        before = (yield STAND).rest_voltage_v
        found = yield from follow(manner.docked_back_m)
        if found.touched and (yield from _touches(before, manner)):
            return
        why = "something is touched, but it is no contact of the dock" if found.touched else found.why
        side = side if not found.aside else "right" if found.aside > 0.0 else "left"
        yield from _withdraw(manner, found.aside)
    raise GivenUpError(f"not docked after {manner.tries} tries: {why}")


def _withdraw(manner: Manner, aside: float) -> Script[None]:
    """Drive away from a dock that is near, towards its middle line."""
    view = yield STAND
    if view.back_m is not None and view.back_m < manner.standoff_m - SPARE_M:
        yield from face(aside * manner.withdraw_deg)
        yield from bounded(Go(manner.power, manner.withdraw_m))


def _station(manner: Manner) -> Script[None]:
    """Stand with the back to the dock, not too near and not too far."""
    yield from face(0.0)
    view = yield STAND
    if view.back_m is None:
        return
    way_m = manner.standoff_m - view.back_m
    if way_m > 0.0 and view.forward_m is not None:
        way_m = min(way_m, view.forward_m - FREE_M)
    if abs(way_m) > SPARE_M:
        yield from bounded(Go(manner.power, round(way_m, 2)))
        yield from face(0.0)


def _search(side: Side, manner: Manner) -> Script[None]:
    """Go along the dock's wall until a beam is seen: to one side, then to the other, past what stands in the way."""
    other: Side = "right" if side == "left" else "left"
    for towards, steps in ((side, manner.steps), (other, 2 * manner.steps)):
        for _ in range(steps):
            if (yield from sees()):
                return
            if not (yield from _aside(towards, manner.step_m, manner)) and not (yield from _past(towards, manner)):
                break
            yield from _station(manner)
    if not (yield from sees()):
        raise GivenUpError("no beam of the dock was seen; is it plugged in, and the way to it free?")


def _past(side: Side, manner: Manner) -> Script[bool]:
    """Try to go aside farther from the wall, then nearer to it; say whether a way was free."""
    for way_m in (manner.past_m, -2 * manner.past_m):
        yield from bounded(Go(manner.power, way_m))
        if (yield from _aside(side, manner.step_m, manner)):
            return True
    return False


def _aside(side: Side, distance_m: float, manner: Manner) -> Script[bool]:
    """Go to one side and turn the back to the dock again; say whether the way was free."""
    yield from face(SIDES[side])
    ending = yield from bounded(Go(manner.power, distance_m))
    view = yield STAND
    free = ending.good or view.forward_m is None or view.forward_m > FREE_M
    yield from face(0.0)
    return free


def _touches(before_v: float | None, manner: Manner) -> Script[bool]:
    """Say whether anything tells that the contacts have current."""
    view = yield STAND
    until = view.time_s + manner.touch_s
    while view.time_s < until:
        risen = None not in (before_v, view.rest_voltage_v) and view.rest_voltage_v >= before_v + RISE_V  # type: ignore[operator]
        if view.charging or "power" in view.beams or risen:
            return True
        view = yield STAND
    return False


def _verify(manner: Manner) -> Script[str]:
    view = yield STAND
    until = view.time_s + manner.verify_s
    while view.time_s < until:
        if view.charging:
            volts = f", {view.rest_voltage_v:.1f} V" if view.rest_voltage_v is not None else ""
            return f"docked: the battery is being charged{volts}"
        view = yield STAND
    raise GivenUpError(f"on the dock, but the battery is not being charged after {manner.verify_s:.0f} s")
