"""Who stopped the robot last is known for each who may ask, however the stops came in."""

from math import inf

from hypothesis import given
from hypothesis import strategies as st

from lbr.leases.halts import Halts

SOURCES = ("", "phone", "console", "script")
STOPS = st.lists(st.tuples(st.integers(0, 12), st.sampled_from(SOURCES)), max_size=12)


def after(stops: list[tuple[int, str]]) -> Halts:
    known = Halts()
    for at, source in stops:
        known = known.noted(float(at), source)
    return known


@given(STOPS, st.sampled_from([*SOURCES, "another"]))
def test_the_last_stop_of_another_is_the_last_of_all_that_were_not_ones_own(stops, who):
    others = [(at, source) for at, source in stops if source != who or not source]
    at, source = after(stops).by_others(who)
    assert at == max((at for at, _ in others), default=-inf)
    assert not others or (at, source) in others


@given(STOPS)
def test_what_is_known_never_grows_and_no_stop_takes_back_a_later_one(stops):
    known = Halts()
    for at, source in stops:
        before, known = known, known.noted(float(at), source)
        assert known.at >= max(before.at, float(at))
        assert known.before >= before.before
        assert known.before <= known.at


def test_a_stop_without_a_name_counts_against_everybody():
    assert after([(3, "")]).by_others("")[0] == 3.0
    assert after([(3, ""), (4, "phone")]).by_others("phone") == (3.0, "")
