"""The speed of a stick is limited by the age of what its hand drives by."""

import pytest

from lbr.apps.web.api.link_age import FULL_S, OLDEST_S, SMOOTH_S, LinkAge, share, slowed
from lbr.messages.description import CommandDescription

WAIT_S = 0.2


def driven(by):
    return CommandDescription(leased=True, role="operate", schema={"title": by})


def aged(*ages, every_s=0.08, to=None):
    """Return the age after messages of these ages, one after another."""
    found = to if to is not None else LinkAge(WAIT_S)
    for number, age_s in enumerate(ages):
        found.note(age_s, 10.0 + number * every_s)
    return found


@pytest.mark.parametrize(("age_s", "left"), [(0.0, 1.0), (0.15, 1.0), (0.2, 0.75), (0.3, 0.5), (0.5, 0.3)])
def test_within_its_age_a_base_goes_no_further_than_at_full_speed_within_the_first(age_s, left):
    assert share(age_s) == pytest.approx(left)
    assert share(age_s) * max(age_s, FULL_S) == pytest.approx(FULL_S)


@pytest.mark.parametrize(("age_s", "left"), [(0.02, 1.0), (0.15, 1.0), (0.2, 0.8), (0.3, 0.5), (0.42, 0.4), (0.5, 0.3)])
def test_a_link_of_one_age_has_one_share_within_two_seconds(age_s, left):
    found = aged(*[age_s] * 25)
    assert found.share == pytest.approx(left)
    assert found.news.age_ms == pytest.approx(age_s * 1000, abs=20)


def test_a_first_message_that_waited_for_a_frame_slows_nothing():
    assert aged(WAIT_S + 0.01).share == 1.0


def test_one_packet_that_was_lost_and_all_that_waited_behind_it_slow_nothing():
    found = aged(*[0.05] * 25)
    for age_s in (0.25, 0.21, 0.17, 0.13, 0.09):
        found.note(age_s, 12.2)
    assert found.share == 1.0


def test_a_link_that_heals_has_its_speed_again():
    found = aged(*[0.4] * 25)
    assert found.share < 0.5
    for number in range(30):
        found.note(0.05, 12.0 + number * 0.08)
    assert found.share == 1.0


def test_a_share_that_wavers_within_the_play_stays():
    found = aged(*[0.3] * 25)
    left = found.share
    for number in range(100):
        found.note(0.3 + 0.03 * (-1) ** number, 12.0 + number * 0.08)
        assert found.share == left


@pytest.mark.parametrize("age_s", [float("nan"), -0.1])
def test_a_time_that_was_never_told_says_nothing(age_s):
    found = aged(*[0.05] * 25)
    found.note(age_s, 13.0)
    assert (found.share, found.news.age_ms) == (1.0, 50)


def test_one_message_from_an_hour_ago_does_not_last():
    found = aged(0.05, 3600.0)
    assert found.age_s < OLDEST_S
    assert aged(*[0.05] * 30, to=found).share == 1.0
    assert SMOOTH_S < 30 * 0.08


@pytest.mark.parametrize(
    ("by", "message", "left"),
    [
        ("DriveCommand", {"power": 0.8, "angle_deg": 90}, {"power": 0.4, "angle_deg": 90}),
        ("TwistCommand", {"vx_mps": 0.4, "wz_rps": -1.0}, {"vx_mps": 0.2, "wz_rps": -0.5}),
        ("DriveCommand", {"power": "much"}, {"power": "much"}),
        ("DriveCommand", {"power": True}, {"power": True}),
        ("DriveCommand", {"power": 0.8, "distance_cm": 50}, {"power": 0.8, "distance_cm": 50}),
        ("TurnCommand", {"angle_deg": 90}, {"angle_deg": 90}),
        ("PlayCommand", {"motion": "wave"}, {"motion": "wave"}),
    ],
)
def test_a_stick_alone_is_slowed(by, message, left):
    assert slowed(driven(by), message, 0.5) == left
    assert slowed(driven(by), message, 1.0) == message
    assert slowed(None, message, 0.5) == message
