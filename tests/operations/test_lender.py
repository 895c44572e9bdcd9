"""The process around any kernel that lends: which events it makes of what it receives, each once."""

import pytest
from msgspec import Struct
from msgspec.structs import replace

from lbr.leases.lease import EstopChanged, LeaseTable, Phrasing, Reply, Setpoint, Stop, first
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive import KIND
from lbr.operations.lender import LeasingCapability, mark
from lbr.testing import FakeCall, FakeContext
from tests.operations.drive.drive_bench import motors

STOPPED = CommandReply(accepted=True, reason="stopped")


class Table(Struct, frozen=True):
    leases: LeaseTable[str]


class Lender(LeasingCapability):
    """Notes the events of its kernel, which decides nothing but the emergency stop."""

    ends, driver, tick, rate_hz = "it ends", "motors", "tick", 10.0

    def __init__(self, driver="motors"):
        super().__init__(FakeContext(KIND))
        self.driver, self.events, self.outputs, self.reports = driver, [], (), 0
        self.begin()

    def first(self):
        return Table(first(Phrasing(noun="it", rest="rest", idle="nobody moves it"), 0.3))

    def decide(self, event, now):
        del now
        self.events.append(event)
        if isinstance(event, EstopChanged):
            return Table(replace(self._state.leases, estop=event.engaged)), self.outputs
        return self._state, self.outputs

    def driver_seen(self, received):
        return received.message

    def driver_lost(self, names):
        return f"{names} lost"

    def not_at_rest(self):
        return ""

    def report(self):
        self.reports += 1

    def after(self, happens):
        """Return the events of what happens and of the next two rounds, without those of time."""
        self.events.clear()
        happens()
        for _ in range(2):
            self.step()
        return [event for event in self.events if event != self.tick]


def test_each_state_of_its_driver_is_one_event_and_so_is_its_loss():
    lender = Lender()
    lender.ctx.gone.add("motors")
    assert lender.after(lender.listen) == [], "who never came is not lost"
    lender.ctx.gone.clear()
    assert lender.after(lambda: lender.ctx.arrive("motors", motors())) == [motors()]
    assert lender.after(lambda: lender.ctx.gone.add("motors")) == ["motors lost"]


def test_without_a_driver_it_receives_nothing_of_one():
    assert Lender(driver="").after(lambda: None) == []


@pytest.mark.parametrize("remote", [False, True])
def test_from_another_machine_a_stop_is_nobody_elses_and_loses_nobody(remote):
    lender = Lender()
    said = StopCommand(reason="enough", lost=True, whole=True, own=True, by="ann", at_once=True)
    stop = FakeCall("stop", said, lender.ctx.now, "page", remote=remote)
    told = {"reason": "enough", "whole": True, "own": True, "at_once": True}
    told |= {} if remote else {"lost": True, "by": "ann"}
    assert lender.after(lambda: lender.command(stop)) == [Stop(source="page", received=stop.arrived, **told)]


def test_whoever_presses_the_emergency_stop_again_is_one_event_more():
    lender = Lender()

    def pressed(by, *, engaged=True):
        estop = lender.ctx.estop
        estop.engaged, estop.reason, estop.by = engaged, "button", by

    for by, engaged in (("ann", True), ("bob", True), ("ann", False)):
        changed = EstopChanged(engaged=engaged, reason="button", by=by)
        assert lender.after(lambda by=by, engaged=engaged: pressed(by, engaged=engaged)) == [changed]
    assert lender.after(lambda: pressed("bob", engaged=False)) == [], "nothing is pressed"


def test_its_end_is_a_stop_that_it_reports():
    lender = Lender()
    lender.close()
    assert (lender.events[-1].reason, lender.reports) == ("it ends", 1)


def test_a_setpoint_has_the_mark_of_its_lease_and_none_without_one():
    lender = Lender()
    for lease, marked in (("", ""), ("L1", mark("L1"))):
        lender.outputs = (Setpoint(message=MotorSetpoint(left=0.0, right=0.0, lease=lease)),)
        lender.happen(lender.tick)
        assert lender.ctx.said("setpoint")[-1].lease == marked


@pytest.mark.parametrize("late", [{}, {"late": True}])
def test_only_a_late_answer_is_quiet(late):
    class Answered(FakeCall):
        def reply(self, answer, *, quiet=False):
            super().reply((answer, quiet))

    lender = Lender()
    lender.outputs = (Reply(message=STOPPED, **late),)
    stop = Answered("stop", StopCommand(), lender.ctx.now)
    lender.command(stop)
    assert stop.answer == (STOPPED, bool(late))
