"""The room as an environment of Gymnasium: by its own checker, by seeds, through the drive's rules."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from msgspec.structs import replace

from lbr import gym
from lbr.errors import InputError
from lbr.simulation.settings import BoxSettings
from lbr.simulation.trials import places

AHEAD = np.array([1.0, 0.0], np.float32)
BEFORE_A_WALL = (3.0, 0.0, 0.0)
DOCKS = (-0.4, 1.2, 0.0)


@pytest.fixture(scope="module")
def room():
    with gymnasium.make(gym.ID) as made:
        yield made.unwrapped


@pytest.mark.filterwarnings("error")
def test_it_passes_gymnasiums_own_checker(room):
    check_env(room)


def test_a_seed_gives_the_same_episode_and_another_seed_another(room):
    def episode(seed):
        seen = [room.reset(seed=seed)[1]["pose"]]
        for number in range(5):
            _, _, _, _, told = room.step(np.array([0.4, 0.2 * number], np.float32))
            seen.append(told["pose"])
        return seen

    first = episode(5)
    assert episode(5) == first
    assert episode(6) != first


def test_full_speed_at_a_wall_is_stopped_by_the_drives_rules_before_it_touches(room):
    room.reset(seed=1, options={"start": BEFORE_A_WALL})
    refused, total = set(), 0.0
    for _ in range(60):
        seen, reward, *_, told = room.step(AHEAD)
        refused.add(told["refused"])
        total += reward
        assert not told["touching"]
    assert "obstacle" in refused
    assert abs(told["speed_mps"]) < 0.02
    assert seen["ranges_m"][0] < 0.4
    assert total == pytest.approx(60 * gym.TIME)


def test_what_is_no_number_stops_it(room):
    room.reset(seed=1, options={"start": (1.0, 0.0, 0.0)})
    for _ in range(5):
        *_, told = room.step(AHEAD)
    assert told["speed_mps"] > 0.1
    for _ in range(15):
        *_, told = room.step(np.array([np.nan, 1.0], np.float32))
    assert abs(told["speed_mps"]) < 0.02


def test_an_action_that_is_not_two_numbers_is_said_to_be_none(room):
    room.reset(seed=1)
    for action in (np.zeros(3), np.zeros((2, 2)), "ab", None, 1.0):
        with pytest.raises(InputError, match="an action is two numbers"):
            room.step(action)


def test_it_ends_when_the_dock_charges_the_robot(room):
    room.reset(seed=2, options={"start": DOCKS})
    for _ in range(200):
        seen, reward, ended, _, told = room.step(np.array([-0.3, 0.0], np.float32))
        if ended:
            break
    assert ended
    assert told["charging"]
    assert reward > gym.DOCKED / 2
    assert seen["beacon"].any()


@pytest.mark.parametrize("start", [(float("nan"), 0.0, 0.0), (0.0, float("inf"), 0.0), (0.0, 0.0, -float("inf"))])
def test_a_start_that_is_no_place_is_said_to_be_none(room, start):
    with pytest.raises(InputError, match="is of finite numbers"):
        room.reset(options={"start": start})


@pytest.mark.parametrize("start", [(2.0, 0.9, 1.57), (1.0,), "there"])
def test_a_start_without_room_is_refused(room, start):
    with pytest.raises(InputError, match=r"room|yaw"):
        room.reset(options={"start": start})


@pytest.mark.parametrize(
    ("options", "said"),
    [({"strat": (0, 0, 0)}, "no option 'strat'"), ({"start": (1e308, 0, 0)}, r"<= 1000.* `\$\.x_m`")],
)
def test_what_is_no_option_or_too_far_away_is_refused(room, options, said):
    with pytest.raises(InputError, match=said):
        room.reset(options=options)


@pytest.mark.parametrize("max_s", [0.0, -1.0, float("nan"), "x", None])
def test_a_length_that_is_no_time_is_refused(max_s):
    with pytest.raises(InputError, match="is no number of seconds above 0"):
        gym.Room(max_s=max_s)


def test_a_robot_without_wheels_and_one_that_is_not_there_are_refused():
    with pytest.raises(InputError, match="no wheels in a room"):
        gym.Room(robot="bioloid")
    with pytest.raises(InputError, match="no robot 'nothing'"):
        gym.Room(robot="nothing")


def test_a_room_without_room_to_turn_is_refused(room, monkeypatch):
    block = BoxSettings(name="block", x_m=0.0, y_m=0.0, length_m=20.0, width_m=20.0)
    monkeypatch.setattr(places, "MOST_TRIES", 2)
    monkeypatch.setattr(room, "_world", replace(room._world, walls=(block,)))
    with pytest.raises(InputError, match="no room for the robot to turn anywhere"):
        room.reset(seed=1)
