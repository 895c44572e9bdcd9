"""A lease as its client keeps it: asked for once, renewed at 10 Hz, ended by a result, a refusal, silence or a release."""

from dataclasses import replace

import pytest

from lbr.leases.client import LeaseClient, LeaseTarget
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, GoalResult
from lbr.messages.leases import CommandReply, StopCommand, refused
from tests.leases.lending import Drive
from tests.support.replies import dead

TARGET = LeaseTarget("go", "halt", "drive", "no answer from drive")
SLOW = DriveCommand(power=0.2)
FAST = DriveCommand(power=0.4)


@pytest.fixture
def drive():
    return Drive()


def kept(drive, lease, seconds, message=SLOW):
    for _ in range(round(seconds / 0.02)):
        drive.now += 0.02
        lease.step()
        lease.keep(message)


def test_it_is_asked_for_once_and_then_quoted_ten_times_a_second(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    assert not lease.holds
    kept(drive, lease, 1.0)
    assert (lease.holds, lease.silent) == (True, False)
    assert [message.lease for message in drive.sent] == ["", *["L1"] * (len(drive.sent) - 1)]
    assert 9 <= len(drive.sent) - 1 <= 11


def test_another_motion_is_sent_at_once(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.05)
    before = len(drive.sent)
    lease.keep(FAST)
    lease.keep(FAST)
    assert [message.power for message in drive.sent[before:]] == [0.4]


def test_a_dead_lease_ends_it_with_how_that_ended_and_stops_nobody_else(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.05)
    drive.reply = dead("stopped by phone", "stopped")
    kept(drive, lease, 0.3)
    assert lease.ended == Reason("stopped", "stopped by phone")
    assert drive.halts == []
    before = len(drive.sent)
    kept(drive, lease, 1.0)
    assert len(drive.sent) == before


def test_a_refused_change_halts_what_went_before_and_the_refusal_is_the_reason(drive):
    lease = LeaseClient(drive, replace(TARGET, result_s=0.5), SLOW)
    kept(drive, lease, 0.05)
    drive.reply = refused(Reason("obstacle", "something is in the way"))
    kept(drive, lease, 0.1, FAST)
    lease.hear(GoalResult(goal="goal-1", result="stopped", reason="stopped by us", code="stopped", elapsed_s=0.1))
    kept(drive, lease, 0.1, FAST)
    assert lease.ended == Reason("obstacle", "something is in the way")
    assert [halt.reason for halt in drive.halts] == ["something is in the way"]


def test_of_two_refusals_the_first_is_the_reason_and_halts_what_went_before_once(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.05)
    for code in ("obstacle", "limit"):
        drive.reply = refused(Reason(code, code))
        lease.send(FAST)
    lease.step()
    assert lease.ended == Reason("obstacle", "obstacle")
    assert drive.halts == [StopCommand(reason="obstacle", own=True)]


def test_what_is_not_vital_may_be_refused(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.05)
    drive.reply = refused(Reason("limit", "too far"))
    lease.send(FAST, vital=False)
    lease.step()
    assert (lease.ended, drive.halts) == (None, [])
    drive.reply = dead("stopped by phone", "stopped")
    lease.send(FAST, vital=False)
    lease.step()
    assert lease.ended == Reason("stopped", "stopped by phone")


def test_the_result_of_its_goal_ends_it_and_no_other(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.02)
    lease.hear(GoalResult(goal="goal-77", result="fault", reason="another's", elapsed_s=1.0))
    lease.step()
    assert lease.ended is None
    lease.hear(GoalResult(goal="goal-1", result="reached", reason="there", code="done", elapsed_s=1.0))
    lease.step()
    assert (lease.good, lease.ended) == (True, Reason("done", "there"))


def test_its_goal_is_that_of_the_newest_answer_that_has_one(drive):
    lease = LeaseClient(drive, TARGET, given=CommandReply(accepted=True, lease="L1"))
    for goal, over in (("", ""), ("goal-1", ""), ("goal-2", "goal-1"), ("", "goal-1"), ("", "goal-2")):
        assert lease.ended is None
        drive.reply = CommandReply(accepted=True, lease="L1", goal=goal)
        lease.send(SLOW)
        lease.step()
        lease.hear(GoalResult(goal=over, result="superseded", reason="another", code="superseded", elapsed_s=1.0))
        lease.step()
    assert lease.ended == Reason("superseded", "another")


def test_a_result_that_comes_a_little_after_the_lease_died_says_why(drive):
    target = LeaseTarget("go", "halt", "drive", "silent", result_s=0.3)
    given = CommandReply(accepted=True, lease="L1", goal="goal-0")
    for heard in (True, False):
        lease = LeaseClient(drive, target, given=given)
        drive.reply = dead("a fault", "stuck")
        kept(drive, lease, 0.1)
        assert (lease.holds, lease.lost, lease.ended) == (False, True, None)
        if heard:
            lease.hear(
                GoalResult(goal="goal-0", result="fault", reason="the wheels stand", code="stuck", elapsed_s=1.0)
            )
        kept(drive, lease, 0.4)
        assert lease.ended == Reason("stuck", "the wheels stand" if heard else "a fault")


@pytest.mark.parametrize("reply", [None, {}])
def test_silence_ends_it_but_not_while_we_were_held_up_ourselves(drive, reply):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.05)
    drive.now += 60.0
    lease.step()
    assert lease.ended is None
    drive.mute, drive.reply = reply is None, reply
    kept(drive, lease, 0.7)
    assert (lease.silent, str(lease.ended)) == (True, "no answer from drive")


def test_nobody_there_nobody_wired_and_a_refusal_begin_nothing(drive):
    drive.mute = True
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 1.4)
    assert lease.ended is None, "an answer may still come"
    kept(drive, lease, 0.2)
    assert lease.ended == Reason("unreachable", "no answer from drive")
    drive.mute, drive.absent = False, True
    lease = LeaseClient(drive, TARGET, SLOW)
    lease.step()
    assert lease.ended is not None
    assert lease.ended.code == "wiring"
    drive.absent, drive.reply = False, {}
    lease = LeaseClient(drive, TARGET, SLOW)
    lease.step()
    assert (lease.ended, lease.silent) == (Reason("unreachable", "'drive' does not answer"), True)
    drive.reply = refused(Reason("held", "held by phone"))
    lease = LeaseClient(drive, TARGET, SLOW)
    lease.step()
    assert (lease.ended, lease.accepted) == (Reason("held", "held by phone"), None)
    assert drive.halts == []


def test_a_release_halts_it_also_before_it_was_accepted_and_once(drive):
    drive.mute = True
    lease = LeaseClient(drive, TARGET, SLOW)
    assert lease.release("enough", lost=True) is not None
    assert lease.release("enough") is None
    assert drive.halts == [StopCommand(reason="enough", lost=True, own=True)]


def test_what_is_too_long_to_be_sent_is_cut(drive):
    LeaseClient(drive, TARGET, SLOW).release("e" * 201, by="b" * 201)
    assert drive.halts == [StopCommand(reason="e" * 200, own=True, by="b" * 200)]


def test_without_a_request_to_halt_it_what_moves_ends_with_its_lease(drive):
    lease = LeaseClient(drive, LeaseTarget("go"), SLOW)
    kept(drive, lease, 0.02)
    assert lease.release("enough") is None
    lease.hear(GoalResult(goal="goal-1", result="reached", reason="there", code="done", elapsed_s=1.0))
    lease.step()
    assert lease.ended == Reason("cancelled", "enough")
    assert {request for request, _ in drive.asked} == {"go"}


def test_no_more_is_sent_than_is_answered(drive):
    lease = LeaseClient(drive, TARGET, SLOW)
    kept(drive, lease, 0.02)
    lease.step()
    drive.mute = True
    sent = [lease.send(FAST) for _ in range(20)]
    assert sum(asked is not None for asked in sent) == 8
    assert sent[-1] is None


def test_fields_are_a_motion_too(drive):
    lease = LeaseClient(drive, TARGET, {"power": 0.2})
    kept(drive, lease, 0.02, {"power": 0.3})
    assert drive.sent[-1] == {"power": 0.3, "lease": "L1"}


@pytest.mark.parametrize(("others", "known"), [(7, True), (8, False)])
def test_the_results_of_others_goals_are_kept_for_a_while_and_no_longer(drive, others, known):
    lease = LeaseClient(drive, TARGET, SLOW)
    for goal in ("goal-1", *(f"other-{number}" for number in range(others))):
        lease.hear(GoalResult(goal=goal, result="reached", reason="there", elapsed_s=1.0))
    lease.step()
    lease.step()
    assert (lease.result is not None) is known


@pytest.mark.parametrize(
    "reply",
    [
        CommandReply(accepted=True, reason="done, without a lease"),
        CommandReply(accepted=False, code="held", reason="no", lease="L9"),
    ],
)
def test_without_a_yes_that_names_a_lease_nothing_is_borrowed(drive, reply):
    drive.reply = reply
    lease = LeaseClient(drive, TARGET, SLOW)
    lease.step()
    assert lease.ended == reply.why
    assert not lease.holds
    assert lease.send(FAST) is None
