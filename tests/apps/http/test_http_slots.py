import pytest

from lbr.apps.http.slots import LIMIT_S, Slot, Slots
from lbr.apps.http.turns import Turns


def made(who: str, since: float = 0.0, phase: str = "idle") -> Slot:
    return Slot(who, lambda: None, lambda: False, since, phase)  # type: ignore[arg-type]


def test_a_new_connection_is_always_let_in_and_the_one_that_waited_longest_goes():
    slots = Slots(3)
    first, second, third = (made("a", float(at)) for at in range(3))
    assert [slots.enter(one) for one in (first, second, third)] == [None, None, None]
    slots.to(first, "asking", 5.0)
    slots.to(first, "idle", 6.0)
    assert slots.enter(made("a", 7.0)) is second
    assert len(slots) == 3


def test_of_several_askers_the_one_with_most_makes_room():
    slots = Slots(4)
    for at, who in enumerate(("b", "a", "a", "a")):
        slots.enter(made(who, float(at)))
    victim = slots.enter(made("c", 9.0))
    assert (victim.peer, victim.since) == ("a", 1.0)


@pytest.mark.parametrize(
    ("phases", "goes"),
    [
        (("idle", "asking", "stopping"), "idle"),
        (("head", "asking", "stopping"), "head"),
        (("greeting", "asking", "stopping"), "greeting"),
        (("asking", "leaving", "idle"), "leaving"),
        (("stopping", "asking", "stopping"), "asking"),
        (("stopping", "stopping", "stopping"), "stopping"),
    ],
)
def test_what_is_stopped_by_is_cut_last(phases, goes):
    slots = Slots(3)
    for phase in phases:
        slots.enter(made("a", phase=phase))
    assert slots.enter(made("a", 1.0)).phase == goes


def test_who_watches_takes_nobodys_place():
    slots = Slots(2)
    for _ in range(9):
        slots.enter(made("a", phase="watching"))
    assert slots.enter(made("b")) is None
    assert slots.overdue(1e9) != []
    assert len(slots) == 9


@pytest.mark.parametrize("phase", LIMIT_S)
def test_what_takes_too_long_is_cut(phase):
    slots = Slots()
    slot = made("a", 1.0, phase)
    slots.enter(slot)
    assert slots.overdue(1.0 + LIMIT_S[phase]) == []
    assert slots.overdue(1.1 + LIMIT_S[phase]) == [slot]
    assert len(slots) == 0


def test_what_is_being_closed_and_is_not_read_is_cut():
    slots = Slots()
    slot = Slot("a", lambda: None, lambda: True, 0.0, "watching")
    slots.enter(slot)
    assert slots.overdue(100.0) == []
    assert slots.overdue(100.0 + LIMIT_S["leaving"] + 0.1) == [slot]


def test_turns_are_bounded_for_one_and_for_all():
    turns = Turns(2, 3)
    with turns.turn("a"), turns.turn("a"):
        assert turns.why_not("a") == "2 of one asker"
        assert not turns.why_not("b")
        with turns.turn("b"):
            assert turns.why_not("c") == "3"
        assert not turns.why_not("c")
    assert not turns.why_not("a")
