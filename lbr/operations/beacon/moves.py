"""What manoeuvres are made of: wait, look, turn, drive a distance. Pure."""

from math import copysign

from lbr.messages.codes import Code
from lbr.operations.beacon.view import STAND, Bend, Ending, GivenUpError, Go, Script, Turn, View

CLOSE_DEG = 3.0
TURNS, STRAIGHT_TURNS = 9, 3
ELSEWHERE_M, ELSEWHERE_POWER = 0.25, 0.15
BEND_DEG, BEND_S = 60.0, 1.5
"""By fourteen places among the simulated furniture where the robot did not come out: with these it came out of eight."""
LEAST_DEG, MOST_IN_VAIN = 1.0, 2
"""Whom so many bends have not turned so far, bends turn nowhere."""
LOOK_S = 0.7
AGAIN_S = 1.0
START_S, SLOWEST_DPS, SLOWEST_MPS = 4.0, 12.0, 0.3
"""What takes longer pushes against something: at full power a base does 0.5 m/s or more, and turns by 40 degrees a second."""


def wait(seconds: float) -> Script[View]:
    """Stand for a while."""
    view = yield STAND
    until = view.time_s + seconds
    while view.time_s < until:
        view = yield STAND
    return view


def sees() -> Script[bool]:
    """Stand and look for the dock's beams for a while."""
    view = yield STAND
    until = view.time_s + LOOK_S
    while not view.beams and view.time_s < until:
        view = yield STAND
    return bool(view.beams)


def bounded(action: Turn | Bend | Go) -> Script[Ending]:
    """Turn or drive to the end, in at most the time that it may take; what another sender ended is not begun again."""
    view = yield action
    until = view.time_s + _longest_s(action)
    while view.ending is None and view.time_s < until:
        view = yield action
    ending = view.ending or Ending(good=False, text="it does not come to its end in time", code="timeout")
    if ending.final:
        raise GivenUpError(ending.text, ending.code)
    if not ending.good:
        yield from wait(AGAIN_S)
    return ending


def _longest_s(action: Turn | Bend | Go) -> float:
    if isinstance(action, Turn):
        return START_S + abs(action.angle_deg) / SLOWEST_DPS
    if isinstance(action, Bend):
        return START_S + action.seconds
    return START_S + abs(action.distance_m) / (action.power * SLOWEST_MPS)


def face(direction_deg: float) -> Script[None]:
    """Turn until the robot looks there: on the spot, a little elsewhere, or at last bit by bit as cars do."""
    why = ""
    code: Code = "failed"
    in_vain = 0
    for attempt in range(TURNS):
        view = yield STAND
        missing_deg = shortest(direction_deg - view.direction_deg)
        if abs(missing_deg) <= CLOSE_DEG:
            return
        ending = yield from bounded(Turn(missing_deg))
        if ending.good:
            continue
        why, code = ending.text, ending.code
        sense = 1.0 if attempt % 2 else -1.0
        if attempt < STRAIGHT_TURNS:  # a corner of the body touches something: turn elsewhere
            yield from bounded(Go(ELSEWHERE_POWER, sense * ELSEWHERE_M))
            continue
        yield from bounded(Bend(sense * ELSEWHERE_POWER, copysign(BEND_DEG, missing_deg), BEND_S))
        came_deg = shortest((yield STAND).direction_deg - view.direction_deg)
        in_vain = in_vain + 1 if abs(came_deg) < LEAST_DEG else 0
        if in_vain >= MOST_IN_VAIN:
            break
    view = yield STAND
    if abs(shortest(direction_deg - view.direction_deg)) > 2 * CLOSE_DEG:
        raise GivenUpError(f"the robot cannot turn there: {why or 'it does not come to look there'}", code)


def shortest(angle_deg: float) -> float:
    """Return the same turn by the shorter way."""
    return (angle_deg + 180.0) % 360.0 - 180.0
