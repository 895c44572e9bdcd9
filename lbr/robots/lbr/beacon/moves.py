"""The parts of manoeuvres: wait, look, turn, drive a distance. Pure."""

from lbr.messages.codes import Code
from lbr.robots.lbr.beacon.view import STAND, Ending, GivenUpError, Go, Script, Turn, View

CLOSE_DEG = 3.0
TURNS = 5
ELSEWHERE_M, ELSEWHERE_POWER = 0.25, 0.15
LOOK_S = 0.7
AGAIN_S = 1.0
START_S, SLOWEST_DPS, SLOWEST_MPS = 4.0, 12.0, 0.3
"""The start and the slowest rates of a move; a slower one pushes against something. At full power a base does 0.5 m/s
or more, and turns by 40 degrees a second."""


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


def bounded(action: Turn | Go) -> Script[Ending]:
    """Turn or drive to the end, within its time limit; a move ended by another sender is not repeated."""
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


def _longest_s(action: Turn | Go) -> float:
    if isinstance(action, Turn):
        return START_S + abs(action.angle_deg) / SLOWEST_DPS
    return START_S + abs(action.distance_m) / (action.power * SLOWEST_MPS)


def face(direction_deg: float) -> Script[None]:
    """Turn on the spot until the robot looks there."""
    why = ""
    code: Code = "failed"
    for attempt in range(TURNS):
        view = yield STAND
        missing_deg = shortest(direction_deg - view.direction_deg)
        if abs(missing_deg) <= CLOSE_DEG:
            return
        ending = yield from bounded(Turn(missing_deg))
        if not ending.good:  # a corner of the body touches something: turn elsewhere
            why, code = ending.text, ending.code
            yield from bounded(Go(ELSEWHERE_POWER, ELSEWHERE_M if attempt % 2 else -ELSEWHERE_M))
    view = yield STAND
    if abs(shortest(direction_deg - view.direction_deg)) > 2 * CLOSE_DEG:
        raise GivenUpError(f"the robot cannot turn there: {why or 'it does not come to look there'}", code)


def shortest(angle_deg: float) -> float:
    """Return the equal turn by the shorter way."""
    return (angle_deg + 180.0) % 360.0 - 180.0
