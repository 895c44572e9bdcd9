"""What docking is made of: wait, look, turn, drive a distance. Pure."""

from lbr.apps.autodock.view import STAND, Ending, GivenUpError, Go, Script, Turn, View

CLOSE_DEG = 3.0
TURNS = 5
ELSEWHERE_M, ELSEWHERE_POWER = 0.25, 0.15
LOOK_S = 0.7
AGAIN_S = 1.0


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
    """Turn or drive to the end; what another sender ended is not begun again."""
    view = yield action
    while view.ending is None:
        view = yield action
    ending = view.ending
    if ending.final:
        raise GivenUpError(ending.text)
    if not ending.good:
        yield from wait(AGAIN_S)
    return ending


def face(direction_deg: float) -> Script[None]:
    """Turn on the spot until the robot looks there."""
    why = ""
    for attempt in range(TURNS):
        view = yield STAND
        missing_deg = shortest(direction_deg - view.direction_deg)
        if abs(missing_deg) <= CLOSE_DEG:
            return
        ending = yield from bounded(Turn(missing_deg))
        if not ending.good:  # a corner of the body touches something: turn elsewhere
            why = ending.text
            yield from bounded(Go(ELSEWHERE_POWER, ELSEWHERE_M if attempt % 2 else -ELSEWHERE_M))
    view = yield STAND
    if abs(shortest(direction_deg - view.direction_deg)) > 2 * CLOSE_DEG:
        raise GivenUpError(f"the robot cannot turn there: {why}")


def shortest(angle_deg: float) -> float:
    """Return the same turn by the shorter way."""
    return (angle_deg + 180.0) % 360.0 - 180.0
