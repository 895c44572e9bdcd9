"""One sender's flood is bounded where it comes in, and another's commands are let in beside it."""

from lbr.bus.inflow import BURST, MOST_SENDERS, RATE_HZ, Inflow

FLOOD_HZ, FLOOD_S = 5000, 4.0


def let_in(name, *, beside=()):
    """Return how many commands of a flood are let in, and which of those that come beside it once in 0.1 s."""
    inflow, count, others = Inflow(), 0, []
    for n in range(int(FLOOD_HZ * FLOOD_S)):
        now = n / FLOOD_HZ
        count += inflow.admits(name(n), now)
        if n % (FLOOD_HZ // 10) == 0:
            others += [inflow.admits(other, now) for other in beside]
    return count, others


def test_a_flood_of_one_sender_is_bounded_and_others_are_let_in_beside_it():
    count, others = let_in(lambda _n: "flood", beside=("console", "web"))
    assert count <= BURST + RATE_HZ * FLOOD_S + 1
    assert all(others)


def test_a_new_name_for_each_command_gains_nothing():
    count, _ = let_in(lambda n: f"flood {n}")
    assert count <= BURST + MOST_SENDERS * FLOOD_S + RATE_HZ * FLOOD_S + 1


def test_who_sends_steadily_is_always_let_in_and_who_paused_has_its_burst_again():
    inflow = Inflow()
    assert all(inflow.admits("web", n / (RATE_HZ / 2)) for n in range(1000))
    assert [inflow.admits("web", 20.0) for _ in range(BURST + 1)] == [True] * BURST + [False]
    assert [inflow.admits("web", 30.0) for _ in range(BURST + 1)] == [True] * BURST + [False]
