"""Motion that a page holds: it goes on only while its page says so, and whatever ends it is told."""

import msgspec
import pytest

from lbr.apps.web.api.holds import AGAIN_S, Hand, Holds
from lbr.apps.web.api.page_message import Wanted
from lbr.apps.web.api.patience import BOUNDED_S, SILENT_S, silent_s
from lbr.bus.stamp import Origin
from lbr.errors import BusError
from lbr.messages.codes import Reason
from lbr.messages.description import CommandDescription
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.joints import JointMove, JointsCommand, PlayCommand
from lbr.messages.leases import CommandReply
from tests.apps.web.api_stage import Lender, Lent

ROUND_S = 0.02


class Bench:
    """Hands on one base, in a loop whose time is the test's."""

    def __init__(self) -> None:
        self.now = 100.0
        self.lender = Lender(lambda: self.now)
        self.lost = False
        self.holds = Holds(self._transport, self._keys, lambda: self.now, self._patience_s, self._slowed)

    def _patience_s(self, wanted):
        return BOUNDED_S if wanted.to == "motions/play" else SILENT_S

    def _slowed(self, wanted, speed):
        return {name: value * speed for name, value in wanted.message.items()}

    def _transport(self, source, keys, origin):
        if self.lost:
            raise BusError("the bus is away")
        return Lent(self.lender, source, dict(keys), lambda: None, origin)

    def _keys(self, wanted):
        return {"motion": f"r/{wanted.to}", "halt": f"r/{wanted.capability}/stop"}

    def hand(self, source="web:phone", may=lambda _wanted: None, **how):
        told = []
        found = Hand(source, may, told.append, **how)
        found.told = told
        self.holds.add(found)
        return found

    def want(self, hand, n, power=0.3, to="drive/command"):
        hand.hold(Wanted(to=to, message={"power": power}, n=n), self.now)
        self.run(ROUND_S)

    def run(self, seconds, *keeping):
        """Go on for a time, in which hands that keep something say so each 0.1 s; a hand that has none is silent."""
        end, say = self.now + seconds, self.now
        while self.now < end - 1e-9:
            if self.now >= say - 1e-9:
                say += 0.1
                for hand, n in keeping:
                    hand.keep(n, self.now)
            self.holds.step()
            self.now += ROUND_S
        self.holds.step()


@pytest.fixture
def bench():
    return Bench()


def last(hand):
    return hand.told[-1]


def test_a_page_that_goes_on_saying_so_goes_on_moving(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    bench.run(5.0, (hand, 1))
    assert bench.lender.moving
    assert [(news.n, news.holds) for news in hand.told] == [(1, True)]
    assert len(bench.lender.moves) <= 5.0 / 0.1 + 3


def test_a_silent_page_is_released_within_a_round_of_its_time(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    said = hand.wish.at
    bench.run(1.0)
    ((at, _, stop),) = bench.lender.halts
    assert at - said <= SILENT_S + 2 * ROUND_S
    assert stop["lost"]
    assert not bench.lender.moving
    assert (last(hand).holds, last(hand).code) == (False, "lapsed")


def test_a_page_that_was_silent_moves_nothing_until_it_begins_anew(bench):
    hand = bench.hand()
    for n, moves in ((1, True), (1, False), (2, True)):
        bench.want(hand, n)
        assert bench.lender.moving is moves
        bench.run(2 * SILENT_S)


def test_a_hand_that_resumes_goes_on_after_a_silence(bench):
    hand = bench.hand(resumes=True)
    for _ in range(3):
        bench.want(hand, 1)
        assert bench.lender.moving
        bench.run(2 * SILENT_S)
        assert (bench.lender.moving, last(hand).code) == (False, "lapsed")


def test_a_hand_that_resumes_sends_again_what_came_late(bench):
    hand = bench.hand(resumes=True)
    bench.lender.refusal = CommandReply(accepted=False, code="late", reason="this command came 0.4 s after it was sent")
    bench.want(hand, 1)
    bench.run(ROUND_S, (hand, 1))
    assert (bench.lender.moving, last(hand).code) == (False, "late")
    bench.lender.refusal = None
    bench.run(AGAIN_S + 2 * ROUND_S, (hand, 1))
    assert bench.lender.moving


@pytest.mark.parametrize("by", ["web:desk", "web:phone"])
@pytest.mark.parametrize("silent_s", [0.0, 2 * SILENT_S])
def test_a_hand_that_resumes_does_not_go_on_with_what_another_has_stopped_meanwhile(bench, silent_s, by):
    """Also where the silence comes before its end was read, and where the stop came from the hand's own address: the mover
    refuses what was wanted before a stop."""
    hand = bench.hand(resumes=True)
    bench.want(hand, 1)
    bench.lender.holder, bench.lender.stopped = "", Origin(by, bench.now)
    bench.run(silent_s)
    for _ in range(5):
        bench.want(hand, 1)
        assert not bench.lender.moving
        bench.run(2 * SILENT_S)
    assert [news.code for news in hand.told if not news.holds][-1] == "stopped_since"
    bench.want(hand, 2)
    assert bench.lender.moving


def test_keeping_begins_nothing_again(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    bench.run(0.5)
    before = len(bench.lender.moves)
    bench.run(1.0, (hand, 1))
    assert len(bench.lender.moves) == before


def test_the_speed_that_the_age_of_its_words_leaves_holds_from_the_first_on_and_is_told_once(bench):
    hand = bench.hand()
    hand.hold(Wanted(to="drive/command", message={"power": 0.4}, n=1), bench.now, 0.5)
    bench.run(1.0)
    assert bench.lender.moves[0][2]["power"] == 0.2
    hand.hold(Wanted(to="drive/command", message={"power": 0.4}, n=2), bench.now, 0.5)
    bench.run(ROUND_S)
    for speed in (0.5, 0.25, 0.25, 1.0, 1.0):
        hand.keep(2, bench.now, speed)
        bench.run(2 * ROUND_S)
    assert [move["power"] for _, _, move in bench.lender.moves if "power" in move][-3:] == [0.2, 0.1, 0.4]


def test_letting_go_halts_at_once(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    bench.run(0.5, (hand, 1))
    at = bench.now
    hand.release()
    bench.run(ROUND_S)
    assert [(halted, stop["lost"]) for halted, _, stop in bench.lender.halts] == [(at, False)]
    assert not last(hand).holds
    assert last(hand).code == ""


def test_the_same_number_may_be_used_again_after_letting_go(bench):
    hand = bench.hand()
    for _ in range(3):
        bench.want(hand, 1)
        assert bench.lender.moving
        hand.release()
        bench.run(ROUND_S)
        assert not bench.lender.moving


def test_a_page_that_is_gone_is_released_at_once_and_forgotten(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    at = bench.now
    hand.release(for_good=True)
    bench.run(ROUND_S)
    assert [(halted, stop["lost"]) for halted, _, stop in bench.lender.halts] == [(at, True)]
    assert not bench.holds._hands


def test_a_change_is_sent_in_the_next_round(bench):
    hand = bench.hand()
    bench.want(hand, 1, 0.3)
    bench.want(hand, 2, 0.7)
    assert bench.lender.moves[-1][2]["power"] == 0.7
    assert bench.lender.moves[-1][2]["lease"]


def test_who_has_it_is_told_and_keeps_it(bench):
    first, second = bench.hand("web:anna"), bench.hand("web:ben")
    bench.want(first, 1)
    bench.want(second, 1)
    assert (last(second).holds, last(second).code, last(second).holder) == (False, "held", "web:anna")
    second.release()
    bench.run(0.5, (first, 1))
    assert bench.lender.moving
    assert not bench.lender.halts
    assert [news.holds for news in first.told] == [True]


def test_a_refused_stick_may_be_pushed_elsewhere_but_not_too_often(bench):
    hand = bench.hand()
    bench.lender.refusal = CommandReply(accepted=False, code="obstacle", reason="a wall is ahead")
    for n in range(1, 51):
        bench.want(hand, n, n / 100)
    assert len(bench.lender.moves) <= 50 * ROUND_S / AGAIN_S + 2
    assert last(hand).reason == "a wall is ahead"
    bench.lender.refusal = None
    bench.run(AGAIN_S)
    bench.want(hand, 60, 0.2)
    assert bench.lender.moving


@pytest.mark.parametrize("code", ["stopped", "taken_over", "estop"])
def test_what_another_ended_does_not_begin_again_under_a_stick_that_is_still_pushed(bench, code):
    hand = bench.hand()
    bench.want(hand, 1)
    bench.lender.ended = CommandReply(
        accepted=False, code="dead_lease", cause=code, reason="over", note="ben stopped it"
    )
    bench.lender.holder = ""
    for n in range(2, 40):
        bench.want(hand, n, n / 100)
    assert not bench.lender.moving
    assert [news.code for news in hand.told if not news.holds][:2] == [code, "rest_first"]
    assert "ben stopped it" in last(hand).reason
    assert last(hand).reason.count("release it first") == 1
    hand.release()
    bench.want(hand, 41)
    assert bench.lender.moving


def test_silence_is_a_rest_as_well(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    bench.lender.ended = CommandReply(accepted=False, code="dead_lease", cause="stopped", reason="over")
    bench.lender.holder = ""
    bench.run(0.2, (hand, 1))
    assert last(hand).code == "stopped"
    bench.run(SILENT_S + 2 * ROUND_S)
    bench.want(hand, 2)
    assert bench.lender.moving


def test_what_is_not_for_this_page_is_never_asked(bench):
    hand = bench.hand(may=lambda _wanted: Reason("role", "this needs the role 'operate', and you have 'view'"))
    for n in range(1, 20):
        bench.want(hand, n)
    assert not bench.lender.moves
    assert last(hand).code == "role"


def test_to_want_something_else_gives_up_what_was_held(bench):
    hand = bench.hand()
    bench.want(hand, 1)
    bench.want(hand, 2, to="joints/command")
    assert len(bench.lender.halts) == 1
    assert not bench.lender.halts[0][2]["lost"]
    assert not [news for news in hand.told if news.code]


def test_a_bus_that_is_away_is_told_and_moves_nothing(bench):
    hand = bench.hand()
    bench.lost = True
    bench.want(hand, 1)
    assert (last(hand).holds, last(hand).code) == (False, "unreachable")


def test_one_that_was_not_granted_yet_is_given_up_when_it_is(bench):
    hand, answer = bench.hand(), Unanswered()
    lent, asked = bench._transport("web:phone", bench._keys(Wanted(to="drive/command", n=1)), None), []
    bench._transport = lambda _source, _keys, _origin: lent
    bench.holds._transport = bench._transport
    lent.ask, ask = (lambda *said: asked.append(said) or answer), lent.ask
    bench.want(hand, 1)
    hand.release()
    bench.run(0.1)
    assert len(asked) == 1  # what may be another's is not stopped
    lent.ask = ask
    answer.given = CommandReply(accepted=True, lease="l1", ttl_s=0.3)
    bench.run(ROUND_S)
    assert len(bench.lender.halts) == 1


class Unanswered:
    given = None

    def answers(self):
        return {"drive": self.given} if self.given is not None else None


def test_the_end_of_the_server_releases_everything(bench):
    hands = [bench.hand(), bench.hand("web:other")]
    bench.want(hands[0], 1)
    bench.holds.close("the server ends")
    assert bench.lender.halts
    assert last(hands[0]).code == "shutting_down"


def test_a_motion_that_ends_by_itself_outlasts_a_page_that_draws_slowly(bench):
    hand = bench.hand()
    bench.want(hand, 1, to="motions/play")
    for _ in range(5):
        bench.run(BOUNDED_S - 4 * ROUND_S)
        hand.keep(1, bench.now)
    assert bench.lender.moving
    assert [(news.n, news.holds) for news in hand.told] == [(1, True)]


def test_it_is_released_when_the_page_stays_silent(bench):
    hand = bench.hand()
    bench.want(hand, 1, to="motions/play")
    said = hand.wish.at
    bench.run(BOUNDED_S + 1.0)
    ((at, _, stop),) = bench.lender.halts
    assert SILENT_S < at - said <= BOUNDED_S + 2 * ROUND_S
    assert stop["lost"]
    assert (last(hand).code, last(hand).reason) == ("lapsed", f"the page sent nothing for {BOUNDED_S:g} s")


@pytest.mark.parametrize(("gap_s", "stops"), [(0.1, 0), (0.2, 10), (0.3, 10), (0.4, 10)])
def test_a_link_with_a_gap_each_second_leaves_bounded_goals_alone_and_stops_a_stick_within_its_time(
    bench, gap_s, stops
):
    goal, stick = bench.hand("web:desk"), bench.hand("web:phone")
    bench.want(goal, 1, to="motions/play")
    for _ in range(10):
        bench.run(1.0 - gap_s, (goal, 1))
        bench.run(gap_s)
    assert [(news.n, news.holds) for news in goal.told] == [(1, True)]
    goal.release()
    bench.run(ROUND_S)
    before = len(bench.lender.halts)
    for n in range(10):
        bench.want(stick, n)  # a page that is back wants it anew
        bench.run(1.0 - gap_s, (stick, n))
        said = stick.wish.at
        bench.run(gap_s)
        assert not stops or bench.lender.halts[-1][0] - said <= SILENT_S + 2 * ROUND_S
    assert len(bench.lender.halts) - before == stops


@pytest.mark.parametrize("gone", [True, False])
def test_it_ends_at_once_with_its_socket_or_by_its_pages_word(bench, gone):
    hand = bench.hand()
    bench.want(hand, 1, to="motions/play")
    bench.run(1.0)
    at = bench.now
    hand.release(for_good=gone)
    bench.run(ROUND_S)
    assert [halted for halted, _, _ in bench.lender.halts] == [at]


def test_it_begins_by_a_word_that_is_new_and_driving_after_it_is_kept_no_longer(bench):
    hand = bench.hand()
    bench.lender.refusal = CommandReply(accepted=False, code="busy", reason="another is played")
    bench.want(hand, 1, to="motions/play")
    bench.run(SILENT_S + 2 * ROUND_S)
    bench.lender.refusal = None
    bench.run(1.0)
    assert not bench.lender.moving
    bench.want(hand, 2, to="motions/play")
    assert bench.lender.moving
    bench.want(hand, 3)
    said = hand.wish.at
    bench.run(1.0)
    assert bench.lender.halts[-1][0] - said <= SILENT_S + 2 * ROUND_S


KEPT = {"motion": "bow"}
FRAME = {"positions": {"neck": 0.1}, "duration_s": 1.0}


@pytest.mark.parametrize(
    ("message", "said", "expected_s"),
    [
        (PlayCommand, KEPT, BOUNDED_S),
        (JointsCommand, {"frames": [FRAME]}, BOUNDED_S),
        (TurnCommand, {"angle_deg": 90}, BOUNDED_S),
        (HeadingCommand, {"heading_deg": 0}, BOUNDED_S),
        (DriveCommand, {"power": 0.3, "angle_deg": 0, "distance_cm": 50}, BOUNDED_S),
        (DriveCommand, {"power": 0.3, "angle_deg": 0, "range_cm": 40, "sensor": "forward", "interval_s": 0}, BOUNDED_S),
        (DriveCommand, {"power": 0.3, "angle_deg": 0, "interval_s": 5}, BOUNDED_S),
        (DriveCommand, {"power": 0.3, "angle_deg": 0, "interval_s": 0}, SILENT_S),
        (TwistCommand, {"vx_mps": 0.1}, SILENT_S),
        (JointsCommand, {"positions": {"neck": 0.1}}, SILENT_S),
        (JointsCommand, {"frames": [FRAME], "stay": True}, SILENT_S),
        (JointsCommand, {"frames": [FRAME], "append": True}, SILENT_S),
        (JointsCommand, {"frames": [FRAME], "join": True}, SILENT_S),
        (JointMove, {"joint": "neck", "angle_deg": 3, "frames": [FRAME]}, SILENT_S),
        (DriveCommand, {"power": 0.3, "angle_deg": 0, "motion": "bow", "frames": [FRAME]}, SILENT_S),
    ],
)
def test_only_what_ends_by_itself_where_its_rows_say_is_kept_for_longer(message, said, expected_s):
    command = CommandDescription(schema=msgspec.json.schema(message), role="operate", leased=True)
    assert silent_s(command, said) == expected_s


def test_a_command_that_is_not_known_is_kept_as_driving_is():
    assert silent_s(None, KEPT) == SILENT_S
    assert silent_s(CommandDescription(schema={}, role="operate", leased=True), KEPT) == SILENT_S
