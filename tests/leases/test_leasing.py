"""Borrowing something that moves and has no wheels: what each function of the package promises."""

from itertools import product
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.leases import decide, ending, rules
from lbr.leases.ask import resolve
from lbr.leases.halts import Halts
from lbr.leases.lease import (
    IDLE,
    Ended,
    EstopChanged,
    Happened,
    LeaseRequest,
    LeaseTable,
    Phrasing,
    Stop,
    first,
)
from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE, CommandReply, refused

PHRASING = Phrasing(noun="the hand", rest="pause before moving again", idle="nobody moves it")
TTL_S = 0.3


class Hand:
    """The smallest kernel there is: its motion is a word."""

    def __init__(self) -> None:
        self.leases: LeaseTable[str] = first(PHRASING, TTL_S, ahead_s=0.01)
        self.now = 100.0
        self.said: list[Ended[str] | Happened] = []
        self._ids = 0
        self.reply = CommandReply(accepted=True)

    def ask(self, what: str = "wave", *, source: str = "console", **more) -> str:
        """Decide a command; return why it is refused, or nothing."""
        self._ids += 1
        known = {"lease": "", "received": self.now, "new_lease": f"lease{self._ids}"} | more
        request = LeaseRequest(source=source, content=what, moves=bool(what), **known)
        self._take(*ending.lapse(self.leases, self.now))
        ask = resolve(self.leases, request, self.now)
        if ask.wants == "stop":
            return self.stop(source)
        self.reply = CommandReply(accepted=True)
        if why := rules.refusal(ask):
            self.leases, refused = decide.refuse(ask, why)
            self.reply = refused.message
        elif ask.wants == "renewal":
            self.leases = decide.renew(ask)
        else:
            self._take(*decide.grant(self.leases, ask, what))
        return self.reply.reason

    def refusal(self, **more) -> str:
        """Decide a command; return the code of its refusal, or nothing."""
        self.ask(**more)
        return "" if self.reply.accepted else self.reply.code

    def stop(self, source: str = "phone", **said) -> str:
        event = Stop(**{"source": source, "received": self.now} | said)
        self._take(*decide.stop(self.leases, event, self.now))
        return ""

    def latch(self, *, engaged: bool, by: str = "") -> None:
        self._take(*decide.latch(self.leases, EstopChanged(engaged=engaged, reason="button", by=by), self.now))

    def wait(self, seconds: float) -> None:
        self.now += seconds
        self._take(*ending.lapse(self.leases, self.now))

    @property
    def motion(self) -> str:
        return self.leases.live.motion if self.leases.live else ""

    @property
    def ends(self) -> list[tuple[str, str, bool]]:
        return [(one.lease.motion, one.how, one.held) for one in self.said if isinstance(one, Ended)]

    def _take(self, held: LeaseTable[str], said: tuple[Ended[str] | Happened, ...]) -> None:
        self.leases = held
        self.said += said


@pytest.fixture
def hand():
    return Hand()


def test_one_holder_at_a_time_unless_somebody_takes_over(hand):
    assert hand.leases.reason.text == PHRASING.idle
    assert (hand.ask(), hand.leases.reason) == ("", IDLE)
    hand.wait(0.01)
    assert hand.ask("clap", source="phone") == "held by console; stop it first"
    assert hand.leases.persistent == {}
    assert hand.ask("clap", source="phone", take_over=True) == ""
    assert hand.motion == "clap"
    assert hand.ends == [("wave", "superseded", True)]
    told = [(one.text, one.about) for one in hand.said if isinstance(one, Happened)]
    assert told == [("console took the hand", "console"), ("phone took the hand from console", "console")]


def test_a_lease_that_is_not_renewed_lapses_a_little_early_and_is_dead(hand):
    hand.ask()
    hand.wait(TTL_S - 0.02)
    assert hand.motion
    hand.wait(0.011)
    assert not hand.motion
    assert hand.ends == [("wave", "lapsed", True)]
    assert hand.refusal(lease="lease1") == "dead_lease"
    assert (hand.reply.cause, "not renewed within 0.3 s" in hand.reply.note) == ("lapsed", True)


def test_it_lapses_early_by_a_fifth_of_its_life_at_most(hand):
    hand.ask(ttl_s=0.02)
    for passed_s, lives in ((0.0155, True), (0.001, False)):
        hand.wait(passed_s)
        assert bool(hand.motion) is lives


@pytest.mark.parametrize("remote", [False, True])
def test_without_a_reserve_it_lives_for_just_as_long_as_it_says(hand, remote):
    hand.leases = first(PHRASING, 0.25)
    hand.ask(remote=remote)
    for passed_s, lives in ((0.234375, True), (0.015625, False)):
        hand.wait(passed_s)
        assert bool(hand.leases.offers if remote else hand.leases.live) is lives


def test_who_had_a_lease_of_before_a_restart_hears_of_that_and_a_program_what_to_do():
    reply = refused(rules.not_live(first(PHRASING, TTL_S, ahead_s=0.01), "lease1"))
    assert reply.why == Reason("dead_lease", rules.FORGOTTEN)
    assert (reply.code, "without quoting" in reply.reason) == ("dead_lease", True)


def test_the_same_again_renews_and_another_motion_changes_under_one_lease(hand):
    hand.ask()
    for what in ("wave", "wave", "clap", "clap"):
        hand.wait(0.2)
        assert hand.ask(what, lease="lease1") == ""
    assert (hand.motion, hand.leases.live.id) == ("clap", "lease1")
    assert hand.ends == [("wave", "superseded", False)]
    hand.wait(0.05)
    hand.ask("clap", lease="lease1", ttl_s=0.1)
    hand.wait(0.1)
    assert not hand.motion, "each renewal says for how long"


def test_rest_that_was_overtaken_brings_no_motion_of_before_back(hand):
    hand.ask()
    assert hand.ask("", lease="lease1", received=hand.now - 0.1) == ""
    assert hand.refusal(what="clap", lease="lease1", received=hand.now - 0.05) == "repeated"


def test_what_was_sent_before_a_stop_begins_nothing(hand):
    sent = hand.now
    hand.wait(0.1)
    hand.stop()
    assert (hand.leases.reason.text, hand.leases.stopped_by) == ("stopped by phone", "phone")
    assert [hand.refusal(received=at) for at in (sent, hand.now)] == ["stopped", "stopped"]
    hand.wait(0.01)
    assert hand.ask() == ""


def test_a_stop_that_a_later_one_has_overtaken_lets_nothing_of_between_begin(hand):
    hand.stop()
    hand.stop("page", received=hand.now - 0.1)
    assert hand.refusal(received=hand.now - 0.05) == "stopped"
    assert hand.leases.stopped_by == "phone"


def test_rest_is_asked_for_by_anybody_and_moves_nothing(hand):
    hand.ask()
    assert hand.ask("", source="a stranger") == ""
    assert not hand.motion


def test_who_sent_on_without_its_lease_may_still_have_rest_under_it(hand):
    hand.ask()
    hand.wait(0.01)
    assert hand.refusal() == "held"
    assert hand.ask("", lease="lease1") == ""
    assert (hand.motion, hand.leases.live.id) == ("", "lease1")


def test_from_afar_nothing_moves_until_the_offer_is_quoted(hand):
    assert hand.ask(remote=True, source="page") == ""
    assert not hand.motion
    hand.wait(0.05)
    assert hand.ask(remote=True, source="page", lease="lease1") == ""
    assert hand.motion == "wave"
    assert hand.ends == [], "what confirms an offer goes on with it"


def test_an_offer_stays_its_senders_whoever_quotes_it(hand):
    hand.ask(source="phone")
    hand.wait(0.01)
    hand.ask(remote=True, source="page", take_over=True)
    hand.wait(0.01)
    assert hand.ask(lease="lease2") == ""
    assert hand.leases.live.source == "page"
    assert hand.said[-1].text == "page took the hand from phone"


def test_of_offers_the_eight_newest_wait(hand):
    for number in range(10):
        hand.ask(remote=True, source=f"page {number}")
        newest = [f"page {earlier}" for earlier in range(max(0, number - 7), number + 1)]
        assert [offer.source for offer in hand.leases.offers] == newest


@pytest.mark.parametrize(("offer_s", "confirmation_s"), [(0.1, 0.0), (0.0, 0.1)])
def test_the_quickest_message_under_a_lease_dates_those_after_it(hand, offer_s, confirmation_s):
    page = {"remote": True, "source": "page"}
    hand.ask(**page, sender_s=hand.now - offer_s)
    hand.wait(0.15)
    hand.ask(**page, sender_s=hand.now - confirmation_s, lease="lease1")
    began = hand.now
    hand.wait(0.18)
    assert hand.ask(**page, sender_s=began + 0.03, lease="lease1") == ""
    hand.wait(0.17)
    assert not hand.motion


def test_an_offer_that_is_answered_with_something_else_is_superseded(hand):
    hand.ask(remote=True, source="page")
    hand.wait(0.05)
    request = LeaseRequest(source="page", lease="lease1", content="clap", moves=True, received=hand.now, new_lease="x")
    assert resolve(hand.leases, request, hand.now).confirms is None
    hand.ask("clap", remote=True, source="page", lease="lease1")
    assert (hand.motion, hand.ends) == ("clap", [("wave", "superseded", False)])
    assert resolve(hand.leases, request, hand.now).confirms is None, "that renews"


def test_the_emergency_stop_refuses_all_and_whoever_insisted_has_to_pause(hand):
    hand.ask()
    hand.latch(engaged=True)
    hand.wait(0.01)
    assert (hand.refusal(), "button" in hand.reply.reason) == ("estop", True)
    hand.latch(engaged=False)
    hand.wait(0.1)
    assert hand.refusal() == "rest_first"
    assert PHRASING.rest in hand.reply.reason
    hand.wait(0.25)
    assert hand.ask() == ""


def test_a_renewal_under_way_as_the_emergency_stop_is_latched_leaves_its_sender_free_after_the_reset(hand):
    hand.ask()
    sent = hand.now + 0.01
    hand.wait(0.02)
    hand.latch(engaged=True)
    hand.wait(0.01)
    assert hand.ask(lease="lease1", received=sent) == "lease is dead: emergency stop: button"
    hand.latch(engaged=False)
    hand.wait(0.01)
    assert hand.ask(lease="lease1"), "the reset brings no lease back"
    assert not hand.motion
    assert hand.ask("clap") == ""


def test_rest_under_a_dead_lease_does_not_count_as_going_on(hand):
    hand.ask()
    hand.latch(engaged=True)
    hand.wait(0.01)
    assert hand.refusal(what="", lease="lease1") == "dead_lease"
    hand.latch(engaged=False)
    hand.wait(0.01)
    assert hand.ask() == ""


@pytest.mark.parametrize("lease", ["", "lease1"])
def test_a_stream_through_the_emergency_stop_moves_nothing_after_the_reset(hand, lease):
    hand.ask()
    hand.latch(engaged=True)
    for _ in range(3):
        hand.wait(0.1)
        assert hand.ask(lease=lease)
    hand.latch(engaged=False)
    for _ in range(10):
        hand.wait(0.1)
        assert hand.refusal() == "rest_first"
        assert not hand.motion
    hand.ask("")
    hand.wait(0.01)
    assert hand.ask() == "", "it has come to rest"


def test_who_sent_without_permission_is_forgotten_a_second_after_its_pause(hand):
    hand.latch(engaged=True)
    for source, passed_s, noted in (("a", 0.0, {"a"}), ("b", 1.0, {"a", "b"}), ("c", 0.25, {"b", "c"})):
        hand.wait(passed_s)
        assert hand.refusal(source=source) == "estop"
        assert hand.leases.persistent.keys() == noted


def test_a_clock_that_went_back_ends_all_and_lets_begin_anew(hand):
    hand.stop()
    hand.wait(0.01)
    hand.ask()
    hand._take(*ending.lose_time(hand.leases, hand.now, 5.0))
    hand.now = 5.0
    assert (hand.motion, hand.leases.stopped_by) == ("", "")
    hand.wait(0.01)
    assert hand.refusal(waited_s=0.02) == "stopped_since"
    assert hand.ask(waited_s=0.005) == ""


@pytest.mark.parametrize(("paused_s", "code"), [(0.1, "rest_first"), (0.25, "")])
def test_a_clock_that_went_back_makes_no_stream_of_before_a_new_wish(hand, paused_s, code):
    hand.latch(engaged=True)
    hand.ask()
    hand.latch(engaged=False)
    hand.wait(paused_s)
    hand._take(*ending.lose_time(hand.leases, hand.now, 5.0))
    hand.now = 5.0
    hand.wait(0.01)
    assert hand.refusal() == code


@pytest.mark.parametrize(
    ("fields", "code", "about"),
    [
        ({"ttl_s": 2.0}, "bad_value", ("ttl_s 2", "0 to 1")),
        ({"ttl_s": nan}, "bad_value", ("ttl_s nan", "0 to 1")),
        ({"ttl_s": 0.0}, "bad_value", ("ttl_s 0 ", "lapse", "up to 1")),
        ({"received": nan}, "late", ("no date",)),
        ({"received": 99.69}, "late", ("0.3 s",)),
        ({"received": 101.0}, "late", ("no date",)),
        ({"received": -inf}, "late", ("inf s",)),
    ],
)
def test_what_makes_no_sense_is_refused_in_words(hand, fields, code, about):
    assert hand.refusal(**fields) == code
    assert all(name in hand.reply.reason for name in about), hand.reply.reason


@pytest.mark.parametrize(("age_s", "code"), [(0.25, ""), (0.251, "late")])
def test_a_command_may_be_just_as_old_as_it_says(hand, age_s, code):
    assert hand.refusal(received=hand.now - age_s, patience_s=0.25) == code


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["wave", "clap", "", "stop", "wait", "latch", "reset"]),
            st.sampled_from(["console", "phone"]),
            st.integers(0, 6),
            st.booleans(),
            st.booleans(),
        ),
        max_size=40,
    )
)
def test_every_hold_that_began_ends_once_and_no_dead_lease_moves(steps):
    hand = Hand()
    for what, source, lease, take_over, remote in steps:
        hand.now += 0.05
        match what:
            case "stop":
                hand.stop(source)
            case "wait":
                hand.wait(0.3)
            case "latch" | "reset":
                hand.latch(engaged=what == "latch")
            case _:
                quoted = f"lease{lease}" if lease else ""
                before = dict(hand.leases.revoked)
                refused = hand.ask(what, source=source, lease=quoted, take_over=take_over, remote=remote)
                assert refused or quoted not in before
        held = hand.leases.live
        assert not (hand.leases.estop and held)
        assert held is None or held.id not in dict(hand.leases.revoked)
        assert len(hand.leases.offers) <= decide.MOST_OFFERS
    began = [one.data["took"] for one in hand.said if isinstance(one, Happened) and "took" in one.data]
    over = [one for one in hand.said if isinstance(one, Ended) and one.held]
    untold = hand.leases.tally.untold
    assert untold or len(began) == len(over) + (hand.leases.live is not None)


def test_changes_of_holder_in_a_flood_are_counted_and_not_told(hand):
    for told in (20, 25):
        for _ in range(30):
            hand.ask()
            hand.stop()
            hand.now += 0.001
        assert sum(isinstance(one, Happened) for one in hand.said) == told
        hand.wait(1.0)
    hand.ask()
    assert "(and 55 changes" in hand.said[-1].text


@pytest.mark.parametrize(("waited_s", "moves"), [(0.0, True), (0.9, True), (1.0, False), (5.0, False), (nan, False)])
def test_what_waited_since_before_anothers_stop_moves_nothing(hand, waited_s, moves):
    hand.wait(10.0)
    hand.stop("phone")
    hand.wait(1.0)
    why = hand.ask(waited_s=waited_s)
    assert why == ("" if moves else f"{STOPPED_SINCE}by phone")
    assert bool(hand.motion) is moves


def test_an_own_stop_says_nothing_of_what_was_written_behind_it(hand):
    hand.wait(10.0)
    hand.stop("console")
    hand.wait(1.0)
    assert hand.ask(source="console", waited_s=5.0) == ""


def test_an_own_stop_hides_no_stop_by_another(hand):
    hand.wait(10.0)
    hand.stop("phone")
    hand.wait(0.1)
    hand.stop("console")
    hand.wait(0.1)
    assert hand.ask(source="console", waited_s=5.0) == f"{STOPPED_SINCE}by phone"
    assert hand.ask(source="console", waited_s=0.05) == ""


def test_the_end_of_a_holders_own_motion_is_no_stop_of_the_robot_unless_it_says_so(hand):
    for said in ({}, {"whole": True}):
        hand.wait(10.0)
        assert hand.ask(source="phone") == ""
        hand.stop("phone", **said)
        hand.wait(0.1)
        assert bool(hand.ask(source="console", waited_s=5.0)) is bool(said)


def test_what_waited_through_an_emergency_stop_and_its_reset_moves_nothing(hand):
    hand.wait(10.0)
    hand.stop()
    named = {True: "emergency stop: button", False: "the emergency stop was reset"}
    for (engaged, why), by in zip(named.items(), ("the emergency stop", "the emergency stop's reset"), strict=True):
        hand.wait(0.1)
        hand.latch(engaged=engaged)
        leases = hand.leases
        assert (leases.reason.text, leases.halts.source, leases.stopped_by) == (why, by, "")
    hand.wait(1.0)
    assert hand.ask(waited_s=1.5).startswith(STOPPED_SINCE)
    assert hand.ask(waited_s=0.5) == ""


def test_what_waited_changes_no_motion_that_began_meanwhile(hand):
    hand.wait(10.0)
    hand.stop("phone")
    hand.wait(0.1)
    assert hand.ask() == ""
    hand.wait(0.1)
    assert hand.ask("clap", lease="lease1", waited_s=5.0).startswith(STOPPED_SINCE)
    assert hand.motion == "wave"


def test_what_moves_it_began_anew_since_then(hand):
    hand.leases = first(PHRASING, TTL_S, began=hand.now - 1.0)
    assert hand.ask(waited_s=2.0).endswith("started over")
    assert hand.ask(waited_s=0.5) == ""


def test_how_long_it_waited_counts_by_its_senders_clock_alone(hand):
    hand.wait(10.0)
    hand.stop("phone")
    hand.wait(1.0)
    assert hand.ask(remote=True, sender_s=-1e6, waited_s=2.0).startswith(STOPPED_SINCE)
    assert hand.ask(remote=True, sender_s=-1e6, waited_s=0.5) == ""


@pytest.mark.parametrize("asker", "abcd")
def test_the_last_stop_by_another_is_known_in_whatever_order_they_are_heard_of(asker):
    for stops in product(product(range(3), "abc"), repeat=3):
        halts = Halts()
        for at, source in stops:
            halts = halts.noted(at, source)
        assert halts.by_others(asker)[0] == max((at for at, source in stops if source != asker), default=-inf), stops


PEOPLE = st.sampled_from(["ann", "bob", "cy"])
HAPPENINGS = st.one_of(
    st.tuples(st.sampled_from(["whole", "stop", "passed_on", "gives_up", "press", "reset", "moves"]), PEOPLE),
    st.tuples(st.just("time"), st.sampled_from([0.1, 0.5, 1.0])),
)


def live_through(hand: Hand, what: str, who) -> list[str]:
    """Have it happen, and return whose stop it was, if it was one."""
    holds = hand.leases.live is not None and hand.leases.live.source == who
    match what:
        case "time":
            hand.wait(who)
        case "moves":
            hand.ask(source=who)
        case "whole" | "stop":
            hand.stop(who, whole=what == "whole")
            return [who] if what == "whole" or not holds else []
        case "passed_on":
            hand.stop("motions", by=who)
            return [who]
        case "gives_up":
            hand.stop(who, own=True)
        case "press" | "reset":
            hand.latch(engaged=what == "press", by=who)
            return [who]
    return []


@given(st.lists(HAPPENINGS, max_size=12), PEOPLE, st.integers(0, 12), st.booleans())
def test_what_was_written_before_a_stop_of_anothers_moves_nothing_and_ones_own_stops_are_meant(
    happenings, writer, place, by_a_proxy
):
    """Against a list of all stops: refused for exactly those of others that came after the line was written."""
    hand, stops, written = Hand(), [], None
    for number, (what, who) in enumerate(happenings):
        hand.wait(0.01)
        if number == place:
            written = hand.now
        hand.wait(0.01)
        stops += [(hand.now, stopper) for stopper in live_through(hand, what, who)]
    hand.wait(0.5)
    hand.latch(engaged=False, by=writer)  # what is latched refuses for that
    hand.wait(0.5)
    written = hand.now - 0.1 if written is None else written
    waited_s = hand.now - written
    more = {"source": "dance", "by": writer} if by_a_proxy else {"source": writer}
    refusal = hand.ask("clap", waited_s=waited_s, **more)
    others = [at for at, stopper in stops if stopper != writer and at >= written]
    assert refusal.startswith(STOPPED_SINCE) == bool(others), refusal
    assert (hand.motion == "clap") == (not others)


def test_what_a_guest_says_of_whose_stop_it_passes_on_counts_for_nothing(hand):
    """The process around the kernel drops `by` of what comes from another machine; so it is the guest's own."""
    hand.wait(10.0)
    hand.stop("guest", whole=True)
    hand.wait(1.0)
    assert hand.ask(source="ann", waited_s=2.0) == f"{STOPPED_SINCE}by guest"
