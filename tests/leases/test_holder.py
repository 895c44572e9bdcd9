"""A holder: one motion after another, renewed while it is wanted, given up when whoever wanted it is gone."""

import pytest

from lbr.leases.client import LeaseTarget
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, GoalResult
from lbr.messages.joints import JointsCommand
from lbr.messages.leases import CommandReply, StopCommand, refused
from tests.leases.lending import Drive

TARGET = LeaseTarget("go", "halt", "drive", "no answer from drive")
SLOW, FAST = DriveCommand(power=0.2), DriveCommand(power=0.4)
METRE = DriveCommand(power=0.2, distance_cm=100.0)


@pytest.fixture
def drive():
    return Drive()


def stepped(drive, holder, seconds, *, results=(), gone=None):
    """Step for this long; return what it said of the end, each time it said so."""
    ends = []
    for _ in range(round(seconds / 0.02)):
        drive.now += 0.02
        ends.append(holder.step(results, gone))
    return [end for end in ends if end is not None]


def test_a_motion_is_repeated_ten_times_a_second_under_its_lease(drive):
    holder = Holder(drive)
    assert (holder.asks, holder.holds, holder.ended) == (False, False, None)
    holder.begin(TARGET, METRE)
    assert (holder.asks, holder.holds) == (True, False)
    assert stepped(drive, holder, 1.0) == []
    assert (holder.asks, holder.holds, holder.ended) == (True, True, None)
    assert 9 <= len(drive.sent) - 1 <= 11
    assert {message.distance_cm for message in drive.sent} == {100.0}


def test_a_renewal_is_sent_in_place_of_a_motion_that_would_begin_again(drive):
    holder = Holder(drive, renewal=JointsCommand())
    holder.begin(TARGET, JointsCommand(positions={"neck": 0.1}))
    stepped(drive, holder, 0.5)
    assert [message.positions for message in drive.sent][:2] == [{"neck": 0.1}, {}]
    assert all(not message.positions for message in drive.sent[1:])
    assert 4 <= len(drive.sent) - 1 <= 6


def test_a_drive_without_an_end_goes_over_into_another_and_any_other_motion_begins_anew(drive):
    holder = Holder(drive)
    holder.begin(TARGET, SLOW)
    stepped(drive, holder, 0.1)
    assert holder.holds
    assert holder.begin(TARGET, FAST) is holder.lease
    assert drive.sent[-1].power == 0.4
    assert (drive.sent[-1].lease, drive.halts) == ("L1", [])
    stepped(drive, holder, 0.2)
    assert (drive.sent[-1].power, holder.motion) == (0.4, FAST)
    assert holder.begin(TARGET, METRE) is holder.lease
    assert drive.sent[-1].lease == ""
    assert drive.halts == [StopCommand(reason="another motion begins", own=True)]


def test_the_end_is_told_once_and_stays_known_until_the_next_motion(drive):
    holder = Holder(drive)
    holder.begin(TARGET, METRE)
    stepped(drive, holder, 0.1)
    result = GoalResult(goal="goal-1", result="reached", elapsed_s=1.0, reason="there", code="done")
    assert stepped(drive, holder, 0.1, results=[result]) == [Reason("done", "there")]
    assert (holder.ended, holder.good, holder.asks) == (Reason("done", "there"), True, False)
    assert holder.release("it is over") is None
    holder.change(SLOW)
    assert (holder.ended, drive.halts, SLOW in drive.sent) == (None, [], False)


@pytest.mark.parametrize(("code", "lost"), [("holder_gone", True), ("timeout", False)])
def test_without_whoever_wanted_it_the_motion_stands_and_is_renewed_no_more(drive, code, lost):
    holder = Holder(drive)
    holder.begin(TARGET, METRE)
    stepped(drive, holder, 0.1)
    before, gone = len(drive.sent), Reason(code, "nobody is there")
    assert stepped(drive, holder, 0.5, gone=gone) == [gone]
    assert [(halt.reason, halt.lost) for halt in drive.halts] == [("nobody is there", lost)]
    assert (len(drive.sent), holder.asks, holder.good) == (before, False, False)


def test_an_end_by_others_goes_before_the_reason_of_who_is_gone(drive):
    holder = Holder(drive)
    drive.reply = refused(Reason("held", "held by another"))
    holder.begin(TARGET, METRE)
    assert stepped(drive, holder, 0.1, gone=Reason("timeout", "late")) == [Reason("held", "held by another")]
    assert drive.halts == []


def test_a_lease_that_was_given_is_kept_and_halts_no_motion_before_it(drive):
    holder = Holder(drive)
    for lease in ("L7", "L8"):
        holder.begin(TARGET, {"power": 0.2}, given=CommandReply(accepted=True, lease=lease, ttl_s=0.3))
        stepped(drive, holder, 0.1)
    assert (drive.sent[0]["lease"], drive.sent[-1]["lease"], drive.halts) == ("L7", "L8", [])
    holder.release("enough")
    assert [halt.reason for halt in drive.halts] == ["enough"]
    assert not holder.asks
