"""How well turns end: by angle and to headings, in simulation, beside the open loop that they replace.

Nothing sleeps; the same seed gives the same figures.
"""

from random import Random

from lbr.messages.drive import HeadingCommand, TurnCommand
from lbr.operations.drive.heading_view import shortest_deg
from tests.models.turns.lockstep import Robot
from tests.models.turns.open_loop import OpenLoop
from tests.support.figures import Promise, Results

FAR_DEG, HARD_DEG = 360.0, 10.0
REST_S = (0.6, 1.5)
OVERSHOOT_DEG = 45.0

PROMISES: dict[str, Promise] = {
    "T1": Promise(what="turn by an angle, off by", unit="°", target=1.5, statistic="p50", hard=HARD_DEG),
    "T1 p99": Promise(what="turn by an angle, off by", unit="°", target=4.0, statistic="p99", hard=HARD_DEG),
    "T1 original": Promise(what="the open loop that it replaces, off by", unit="°"),
    "T2": Promise(what="turn to a heading, off by", unit="°", target=1.5, statistic="p50", hard=HARD_DEG),
    "T2 p99": Promise(what="turn to a heading, off by", unit="°", target=4.0, statistic="p99", hard=HARD_DEG),
    "T2 original": Promise(what="the open loop that it replaces, off by, whole revolutions counted", unit="°"),
    "T3": Promise(what="every turn reaches its target within its time, without a revolution too many"),
    "T4": Promise(what="time of a turn, as many times that at constant power", unit="", target=2.0, statistic="p50"),
}


def measure(n: int, seed: int, *, beside: bool = True) -> Results:
    """Turn as often in all, half of it to headings; `beside` has the open loop do the same."""
    results, dice = Results(PROMISES), Random(seed)
    robot, original = Robot(seed), OpenLoop(seed)
    for count in range(n):
        if count % 2 == 0:
            angle_deg = round(dice.uniform(-FAR_DEG, FAR_DEG), 1)
            _by_angle(results, robot, angle_deg)
            if beside:
                before_deg = original.plant.turned_deg
                original.turn(angle_deg)
                results.sample("T1 original", abs(original.plant.turned_deg - before_deg - angle_deg))
        else:
            heading_deg = round(dice.uniform(0.0, FAR_DEG), 1)
            _to_heading(results, robot, heading_deg)
            if beside:
                way_deg = shortest_deg(original.plant.heading_deg, heading_deg)
                before_deg = original.plant.turned_deg
                original.head(heading_deg)
                results.sample("T2 original", abs(original.plant.turned_deg - before_deg - way_deg))
        robot.rest(dice.uniform(*REST_S))
    return results


def _by_angle(results: Results, robot: Robot, angle_deg: float) -> None:
    _turn(results, robot, TurnCommand(angle_deg=angle_deg), angle_deg, "T1")


def _to_heading(results: Results, robot: Robot, heading_deg: float) -> None:
    way_deg = shortest_deg(robot.plant.heading_deg, heading_deg)
    _turn(results, robot, HeadingCommand(heading_deg=heading_deg), way_deg, "T2")


def _turn(results: Results, robot: Robot, command: TurnCommand | HeadingCommand, way_deg: float, figure: str) -> None:
    """Turn, and hold the truth of the world against what was asked."""
    before_deg, began_s = robot.plant.turned_deg, robot.plant.now
    result = robot.turn(command)
    took_s = robot.plant.now - began_s
    robot.rest(0.3)
    turned_deg = robot.plant.turned_deg - before_deg
    if result is None or result.result != "reached":
        results.check("T3", [f"{command} did not end well: {result and result.reason}"])
        return
    too_far = abs(turned_deg) > abs(way_deg) + OVERSHOOT_DEG
    results.check("T3", [f"{command} turned by {turned_deg:.0f} degrees instead of {way_deg:.0f}"] if too_far else [])
    off_deg = abs(turned_deg - way_deg)
    results.sample(figure, off_deg)
    results.sample(f"{figure} p99", off_deg)
    if abs(way_deg) > OVERSHOOT_DEG:
        results.sample("T4", took_s / (abs(way_deg) / _full_dps(robot)))


def _full_dps(robot: Robot) -> float:
    settings = robot.settings
    return settings.turn_power * settings.max_turn_dps
