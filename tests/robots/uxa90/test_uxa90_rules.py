"""The pure rules: what is believed, in which mode the main board is, and which of its motions are played."""

from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.servos import StoredPlay
from lbr.robots.uxa90.driver import pc_control, stored_motions
from lbr.robots.uxa90.driver.packets import Answer
from lbr.robots.uxa90.driver.pc_control import PcControl
from lbr.robots.uxa90.driver.plausibility import GAINS, LOSES, MOVING_CPS, TOLERANCE, Seen, judged
from lbr.robots.uxa90.driver.stored_motions import StoredMotions

PERIOD_S = 0.05
SLOTS = (1, 4, 7)


def told(seen, counts, moving=False, policy="plausible", now=10.0):
    for turn, count in enumerate(counts):
        seen = judged(seen, Answer(5, count), now + turn * PERIOD_S, policy, moving=moving)
    return seen


def known(count=100):
    return told(Seen(), [count] * GAINS, now=9.0)


def test_answers_that_fit_one_another_are_believed_and_others_are_not():
    assert not told(Seen(), [100] * (GAINS - 1)).trusted
    assert known().trusted
    assert not told(Seen(), [10, 200, 30, 150, 90, 240]).trusted
    assert told(known(), [101, 102, 102], now=9.3).position == 102


def test_one_answer_from_elsewhere_changes_nothing_and_several_that_cannot_be_end_belief():
    seen = told(known(), [180], now=9.3)
    assert (seen.trusted, seen.position, seen.implausible) == (True, 100, 1)
    assert told(known(), [180, 100], now=9.3).position == 100
    assert not told(known(), [180] * LOSES, now=9.3).trusted
    assert told(known(), [180] * (LOSES + GAINS), now=9.3).position == 180


def test_a_servo_that_is_pushed_is_followed_once_it_says_so_again():
    seen = told(known(), [105, 105], now=9.3)
    assert seen.position == 100
    assert told(seen, [105], now=9.4).position == 105


def test_a_servo_that_moves_is_followed_at_its_speed():
    way = list(range(100, 200, 18))
    seen = told(known(), way, moving=True, now=9.25)
    assert (seen.trusted, seen.position) == (True, way[-1])


def test_nothing_and_what_no_servo_says_is_never_believed():
    for load, count in ((0, 0), (255, 100), (3, 255)):
        seen = Seen()
        for turn in range(20):
            seen = judged(seen, Answer(load, count), 1.0 + turn * PERIOD_S, "plausible", moving=True)
        assert not seen.trusted


@given(st.lists(st.integers(0, 254), max_size=40), st.booleans())
def test_no_step_that_is_believed_is_longer_than_a_servo_goes(counts, moving):
    seen = known()
    for turn, count in enumerate(counts):
        before, now = seen, 9.3 + turn * PERIOD_S
        seen = judged(seen, Answer(5, count), now, "plausible", moving=moving)
        if seen.trusted and before.trusted:
            assert abs(seen.position - before.position) <= TOLERANCE + MOVING_CPS * (now - before.at)


@given(st.lists(st.integers(0, 255), max_size=30), st.sampled_from(["never", "always"]))
def test_a_row_may_believe_nothing_or_all_that_is_possible(counts, policy):
    seen = told(Seen(), counts, policy=policy)
    possible = [at for at, count in enumerate(counts) if count < 255]
    impossible_since = len(counts) - 1 - possible[-1] if possible else LOSES
    assert seen.trusted == (policy == "always" and impossible_since < LOSES)


def test_control_is_there_soon_after_the_answer_or_when_it_has_settled():
    taking = pc_control.taking(10.0, 1.0)
    assert not pc_control.tick(taking, 10.9).pc
    assert pc_control.tick(taking, 11.0).pc
    answered = pc_control.answered_frame(taking, 10.1)
    assert not pc_control.tick(answered, 10.14).pc
    assert pc_control.tick(answered, 10.16).pc
    assert pc_control.answered_frame(PcControl(), 1.0) == PcControl()
    assert not pc_control.tick(pc_control.normal(12.0), 99.0).pc


asked = st.one_of(
    st.none(),
    st.builds(StoredPlay, slot=st.sampled_from([1, 4, 7, 33]), count=st.integers(1, 6), duration_s=st.just(0.5)),
)
events = st.lists(st.tuples(st.sampled_from(["setpoint", "dead", "stop", "reopen", "wait"]), asked), max_size=60)


@given(events)
def test_whatever_comes_each_count_is_started_once_only_from_the_row_and_in_order(events):
    state, now, started = StoredMotions(), 0.0, []
    for what, play in events:
        now += 0.2
        if what == "stop":
            state = stored_motions.interrupted(state, "stopped")
        elif what == "reopen":
            state = stored_motions.reopened(state, "opened")
        elif what in {"setpoint", "dead"}:
            state = stored_motions.seen(state, play, SLOTS, follows=what == "setpoint")
        if state.wanted:
            started.append(state.asked)
            state = stored_motions.started(state, now)
        state = stored_motions.regained(stored_motions.ended(state, now))
    counts = [play.count for play in started]
    assert counts == sorted(set(counts))
    assert all(play.slot in SLOTS for play in started)
