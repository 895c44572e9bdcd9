"""The tables that come with the humanoids: what they play, in which order, and how they end, without a robot."""

import random
from collections.abc import Callable
from functools import cache
from typing import Any

import msgspec
import pytest

from lbr.apps.behaviours.kernel import DONE, Outcome, Run
from lbr.apps.behaviours.keys import Key
from lbr.apps.behaviours.outputs import Wait
from lbr.apps.behaviours.table import Parts, Table, compile_table, linked
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from lbr.messages.codes import Reason
from lbr.messages.joints import PlayCommand
from lbr.messages.speech import SayCommand
from tests.support import databases

TICK_S = 0.05
FELL = Outcome(False, Reason("fallen", "the robot has fallen"))
NO_TORQUE = Outcome(False, Reason("no_torque", "left_knee has no torque"))
KNEE = "joints.joints.left_knee"
PARTS = {
    "bioloid": Parts(frozenset({"joints", "motions", "attitude", "power"}), frozenset({"play"})),
    "uxa90": Parts(frozenset({"joints", "motions", "attitude", "tracking"}), frozenset({"play"})),
}
"""What each robot has as it comes: no voice."""
STANDS = {
    "motions.fallen": "",
    "attitude.roll_rad": 0.0,
    "attitude.pitch_rad": 0.0,
    f"{KNEE}.position_rad": 0.0,
    f"{KNEE}.torque": 1.0,
}
FALLEN = {
    "face": {"motions.fallen": "face", "attitude.roll_rad": 0.0, "attitude.pitch_rad": 1.5},
    "back": {"motions.fallen": "back", "attitude.roll_rad": 0.0, "attitude.pitch_rad": -1.5},
    "side": {"motions.fallen": "side", "attitude.roll_rad": 1.5, "attitude.pitch_rad": 0.0},
}


@cache
def tables(robot: str) -> dict[str, Table]:
    """The tables of a robot's rows, as it compiles them."""
    rows, _ = databases.tables()

    def mine(table: str) -> list[dict[str, Any]]:
        return [{name: row[name] for name in row if name != "robot"} for row in rows[table] if row["robot"] == robot]

    heads = {row["name"]: msgspec.convert(row, BehaviourTable, strict=False) for row in mine("behaviour")}
    lines = [
        BehaviourRow(**{**row, **{name: msgspec.json.decode(row[name]) for name in ("conditions", "outputs")}})
        for row in mine("behaviour_row")
    ]
    compiled = {
        name: compile_table(head, [row for row in lines if row.behaviour == name], PARTS[robot])
        for name, head in heads.items()
    }
    found = linked(compiled)
    assert not [fault for one in found.values() for fault in one.errors]
    return {name: one.table for name, one in found.items() if one.table is not None}


class Played:
    """A table played to its end on a robot of which a test says what it measures, and what comes of each motion."""

    def __init__(
        self,
        robot: str,
        name: str,
        values: dict[str, float | str],
        becomes: Callable[[str, dict[str, float | str]], Outcome] = lambda _motion, _values: DONE,
        seed: int = 1,
    ) -> None:
        self.values = {**STANDS, **values}
        self.motions: list[str] = []
        self.said: list[str] = []
        now, every = 100.0, tables(robot)
        self.run = Run(every[name], every, now, random.Random(seed).randrange)
        ticket = -1
        while self.run.over is None:
            now += TICK_S
            assert now < 100.0 + every[name].max_s, f"it does not end: {self.run.state}"
            self.run.step(now, self.look)
            order = self.run.order
            if isinstance(order, PlayCommand) and self.run.ticket != ticket:
                self.motions.append(order.motion)
                ticket = self.run.ticket
                self.run.ended(becomes(order.motion, self.values), now)
            elif isinstance(order, SayCommand):
                self.said.append(order.text)
                self.run.ended(DONE, now)
            else:
                assert order is None or isinstance(order, Wait | PlayCommand), order

    def look(self, key: Key, _newest_s: float) -> float | str | None:
        return self.values.get(key.name)

    @property
    def end(self) -> tuple[bool, str]:
        """Whether it ended well, and where."""
        return self.run.good, self.run.state


def rises_at(attempt: int) -> Callable[[str, dict[str, float | str]], Outcome]:
    """A robot that is up after so many motions, and lies on its face after each before."""
    left = [attempt]

    def becomes(_motion: str, values: dict[str, float | str]) -> Outcome:
        left[0] -= 1
        values.update(STANDS if left[0] == 0 else FALLEN["face"])
        return DONE

    return becomes


@pytest.mark.parametrize("robot", ["bioloid", "uxa90"])
@pytest.mark.parametrize(
    ("lies", "attempt", "motions", "end"),
    [
        ("face", 1, ["get_up_face"], (True, "Upright")),
        ("side", 1, ["get_up_side"], (True, "Upright")),
        ("side", 3, ["get_up_side", "get_up_face", "get_up_face"], (True, "Upright")),
        ("face", 4, ["get_up_face"] * 3, (False, "Not up")),
        ("back", 2, ["get_up_back", "get_up_face"], (True, "Upright")),
    ],
)
def test_it_gets_up_by_the_motion_of_the_side_on_which_it_lies_and_tries_three_times(
    robot, lies, attempt, motions, end
):
    played = Played(robot, "get_up", FALLEN[lies], rises_at(attempt))
    assert (played.motions, played.end) == (motions, end)
    assert bool(played.said) is (end[1] == "Not up")


@pytest.mark.parametrize("robot", ["bioloid", "uxa90"])
def test_one_that_stands_already_plays_nothing_to_get_up(robot):
    played = Played(robot, "get_up", {})
    assert (played.motions, played.end) == ([], (True, "Upright"))


@pytest.mark.parametrize("robot", ["bioloid", "uxa90"])
def test_without_an_attitude_it_says_that_it_is_blind_and_plays_nothing(robot):
    blind = Played(robot, "get_up", {"attitude.roll_rad": None, "attitude.pitch_rad": None})
    assert (blind.motions, blind.end) == ([], (False, "Blind"))


@pytest.mark.parametrize("robot", ["bioloid", "uxa90"])
def test_it_falls_again_as_it_gets_up_and_tries_once_more(robot):
    outcomes = [FELL, DONE]

    def becomes(_motion, values):
        outcome = outcomes.pop(0)
        values.update(FALLEN["side"] if outcome is FELL else STANDS)
        return outcome

    played = Played(robot, "get_up", FALLEN["face"], becomes)
    assert (played.motions, played.end) == (["get_up_face", "get_up_side"], (True, "Upright"))


@pytest.mark.parametrize(
    ("robot", "name", "values", "end"),
    [
        ("bioloid", "get_up", FALLEN["face"], "Refused"),
        ("bioloid", "greet", {}, "Not greeted"),
        ("bioloid", "show", {}, "Broken off"),
        ("uxa90", "get_up", FALLEN["back"], "Refused"),
        ("uxa90", "greet", {}, "Not greeted"),
        ("uxa90", "show", {}, "Broken off"),
    ],
)
def test_a_motion_that_is_refused_ends_in_a_named_failure_and_tells_why(robot, name, values, end):
    played = Played(robot, name, values, lambda _motion, _values: NO_TORQUE)
    assert played.end == (False, end)
    assert len(played.motions) == 1
    assert f"play {played.motions[0]}: left_knee has no torque" in str(played.run.over)


@pytest.mark.parametrize("refused", range(6))
def test_a_show_that_is_refused_on_its_way_is_broken_off(refused):
    count = [0]

    def becomes(_motion, _values):
        count[0] += 1
        return NO_TORQUE if count[0] > refused else DONE

    assert Played("bioloid", "show", {}, becomes).end == (False, "Broken off")


@pytest.mark.parametrize(
    ("values", "first"),
    [({}, "initial"), ({f"{KNEE}.position_rad": -2.2}, "stand_up")],
)
def test_the_bioloid_greets_upright_and_stands_up_first_if_it_sits(values, first):
    played = Played("bioloid", "greet", values)
    assert played.end == (True, "Greeted")
    assert played.motions[0] == first
    assert played.motions[1:] in (["wave"], ["wave_both"])
    assert len(played.said) == 1


@pytest.mark.parametrize("name", ["greet", "show"])
@pytest.mark.parametrize(
    ("values", "end"),
    [
        (FALLEN["side"], "Lies"),
        ({"motions.fallen": None}, "Blind"),
        ({f"{KNEE}.position_rad": None}, "Blind"),
    ],
)
def test_a_bioloid_that_lies_or_does_not_know_how_it_is_plays_nothing(name, values, end):
    played = Played("bioloid", name, values)
    assert (played.motions, played.end) == ([], (False, end))


def test_the_bioloids_show_plays_each_motion_once_in_an_order_by_chance():
    orders = set()
    for seed in range(20):
        played = Played("bioloid", "show", {}, seed=seed)
        assert played.end == (True, "Over")
        assert played.motions[0] == played.motions[-1] == "initial"
        assert sorted(played.motions[1:-1]) == ["sit", "stand_up", "turn_left", "walk", "wave", "wave_both"]
        assert played.motions.index("stand_up") == played.motions.index("sit") + 1
        orders.add(tuple(played.motions))
    assert len(orders) >= 10


@pytest.mark.parametrize("falls", ["wave", "walk", "sit", "stand_up"])
def test_a_show_goes_on_after_a_fall_from_which_it_gets_up(falls):
    fell = []

    def becomes(motion, values):
        if motion == falls and not fell:
            fell.append(motion)
            values.update(FALLEN["face"])
            return FELL
        values.update(STANDS)
        return DONE

    played = Played("bioloid", "show", {}, becomes)
    assert played.end == (True, "Over")
    at = played.motions.index(falls)
    assert played.motions[at + 1 : at + 3] == ["get_up_face", "initial"]


def test_a_show_that_cannot_get_up_again_says_so():
    def becomes(motion, values):
        values.update(FALLEN["back"] if motion == "wave" else {})
        return FELL if motion == "wave" else DONE

    played = Played("bioloid", "show", {}, becomes)
    assert played.end == (False, "Broken off")
    assert "'get_up' failed" in str(played.run.over)


@pytest.mark.parametrize(
    ("values", "first"),
    [
        ({}, []),
        ({f"{KNEE}.torque": 0.0}, ["reset"]),
        ({f"{KNEE}.position_rad": -2.4}, ["reset"]),
        ({f"{KNEE}.position_rad": None}, ["reset"]),
    ],
)
def test_the_uxa90_stands_up_first_unless_it_is_known_to_stand(values, first):
    assert Played("uxa90", "greet", values).motions == [*first, "demo_introduction"]


def test_the_uxa90s_show_ends_with_its_dance_and_keeps_to_where_it_stood():
    orders = set()
    for seed in range(20):
        played = Played("uxa90", "show", {}, seed=seed)
        assert played.end == (True, "Over")
        assert sorted(played.motions[:-2]) == ["kick_right", "turn_left", "turn_right", "walk_left", "walk_right"]
        assert played.motions[-2:] == ["dance_gangnamstyle", "reset"]
        orders.add(tuple(played.motions))
    assert len(orders) >= 10


@pytest.mark.parametrize("robot", ["bioloid", "uxa90"])
def test_every_motion_that_a_table_plays_is_a_row(robot):
    rows, _ = databases.tables()
    there = {row["name"] for row in rows["motion"] if row["robot"] == robot}
    played = {
        motion.strip()
        for table in tables(robot).values()
        for state in table.states.values()
        for cells in state.all_outputs
        for motion in cells.get("motion", "").split("|")
        if motion.strip()
    }
    assert played
    assert played <= there
