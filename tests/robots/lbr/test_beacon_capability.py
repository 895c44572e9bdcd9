"""The beacon as a capability: whom it asks to move and for how long, what ends a manoeuvre, and what stops with it."""

import pytest

from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.beacon import SeekCommand
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveCommand, GoalResult, TurnCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.sensing import Ranges
from lbr.robots.lbr.beacon import KIND, BeaconSettings
from lbr.testing import FakeCall, FakeContext
from tests.support.replies import drive_state

ROUND_S = 0.05


class Stage:
    """A beacon on a robot that accepts what it is asked and never comes to an end of it, unless a test says so."""

    def __init__(self, **settings):
        self.ctx = FakeContext(KIND, BeaconSettings(**settings), name="beacon")
        self.ctx.answer = self._answer
        self.goals = 0
        self.refusal = None
        self.silent: set[str] = set()
        self.turned_deg, self.back_m, self.beams, self.volts = 0.0, 1.8, (), 12.5
        self.drive = drive_state()
        self.lease = ""
        self.beacon = KIND.load()(self.ctx)
        self.beacon.open()
        self.play(0.3)

    def _answer(self, request, message):
        if request not in {"move", "turn"}:
            return {"drive": CommandReply(accepted=True)}
        if self.refusal is not None:
            return {"drive": self.refusal}
        self.goals += not message.lease
        bounded = request == "turn" or message.distance_cm
        goal = f"g{self.goals}" if bounded else ""
        return {"drive": CommandReply(accepted=True, lease=f"l{self.goals}", ttl_s=0.5, goal=goal)}

    def seek(self, manoeuvre, **given):
        call = FakeCall("seek", SeekCommand(manoeuvre=manoeuvre, **given), arrived=self.ctx.now, source="behaviour")
        self.beacon.command(call)
        self.lease = call.answer.lease or self.lease
        return call.answer

    def play(self, seconds, *, renew=""):
        until = self.ctx.now + seconds
        while self.ctx.now < until:
            self.ctx.now += ROUND_S
            self._hear()
            if renew:
                self.seek(renew, lease=self.lease)
            self.beacon.step()

    def _hear(self):
        ages = {f"{beam}_age_s": 0.05 for beam in self.beams}
        seen = {beam: beam in self.beams for beam in ("left", "right", "power")}
        told = {
            "attitude": AttitudeState(
                valid=True, heading_deg=self.turned_deg, turned_deg=self.turned_deg, epoch="1", measured_s=self.ctx.now
            ),
            "ranges": Ranges(forward_m=2.0, back_m=self.back_m, left_m=None, right_m=None, bottom_m=None, status={}),
            "drive": self.drive,
            "dock": DockSignal(**seen, **ages),
            "battery": BatteryState(valid=True, rest_voltage_v=self.volts, charging=False),
        }
        for port, message in told.items():
            if port not in self.silent:
                self.ctx.arrive(port, message)

    def drive_ends(self, result="reached", code="done", reason="there"):
        self.ctx.arrive(
            "results", GoalResult(goal=f"g{self.goals}", result=result, reason=reason, code=code, elapsed_s=1.0)
        )

    def asked(self, kind):
        return [one.message for one in self.ctx.asked if isinstance(one.message, kind)]

    @property
    def result(self):
        said = self.ctx.said("result")
        return said[-1] if said else None


def test_a_manoeuvre_borrows_the_drive_for_as_long_as_it_is_renewed_and_tells_how_it_ended():
    stage = Stage()
    stage.turned_deg = 40.0
    answer = stage.seek("align")
    assert answer.accepted
    stage.play(1.0, renew="align")
    turn = stage.asked(TurnCommand)
    assert (turn[0].angle_deg, turn[0].lease) == (-40.0, "")
    assert {one.lease for one in turn[1:]} == {"l1"}
    stage.turned_deg = 0.0
    stage.drive_ends()
    stage.play(1.0, renew="align")
    assert (stage.result.goal, stage.result.result, stage.result.code) == (answer.goal, "reached", "done")
    assert stage.ctx.said("state")[-1].manoeuvre == ""


def test_a_lease_that_is_not_renewed_stops_the_drive():
    stage = Stage()
    stage.back_m = 4.0
    stage.seek("align")
    stage.play(0.3)
    assert stage.asked(DriveCommand)
    assert not stage.asked(StopCommand)
    stage.play(0.5)
    assert stage.asked(StopCommand)
    assert (stage.result.result, stage.result.code) == ("lapsed", "lapsed")
    moved = len(stage.asked(DriveCommand))
    stage.play(1.0)
    assert len(stage.asked(DriveCommand)) == moved


def test_a_holder_whose_process_is_gone_stops_the_drive_at_once():
    stage = Stage()
    stage.back_m = 4.0
    stage.seek("align")
    stage.play(0.2, renew="align")
    stage.ctx.gone.add("behaviour")
    stage.play(0.1)
    assert stage.asked(StopCommand)
    assert stage.result.code == "holder_gone"


@pytest.mark.parametrize("how", ["stop", "estop", "close"])
def test_a_stop_ends_it_whichever_way_it_comes(how):
    stage = Stage()
    stage.back_m = 4.0
    stage.seek("align")
    stage.play(0.3, renew="align")
    if how == "stop":
        stage.beacon.command(FakeCall("stop", StopCommand(), arrived=stage.ctx.now))
    elif how == "estop":
        stage.ctx.estop.engaged = True
        stage.play(0.1)
    else:
        stage.beacon.close()
    assert stage.asked(StopCommand)
    assert stage.result.result == ("fault" if how == "estop" else "stopped")
    assert stage.seek("align", lease=stage.lease).code == "dead_lease"


def test_a_stop_of_the_drive_by_another_counts_also_when_one_of_its_own_comes_right_behind_it():
    stage = Stage()
    stage.seek("search")
    at = stage.ctx.now + 0.01
    stage.drive = drive_state(stopped_s=at + 0.01, stopped_by="beacon", halted_s=at, halted_by="console")
    stage.play(0.1, renew="search")
    assert (stage.result.code, stage.result.reason) == ("stopped", "stopped by console")


def test_a_stop_of_the_drive_by_another_ends_it_also_while_it_stands_and_its_own_does_not():
    stage = Stage()
    stage.seek("search")
    stage.drive = drive_state(stopped_s=stage.ctx.now + 0.01, stopped_by="beacon")
    stage.play(0.3, renew="search")
    assert stage.result is None
    stage.drive = drive_state(stopped_s=stage.ctx.now + 0.01, stopped_by="console", reason="stopped by console")
    stage.play(0.1)
    assert (stage.result.code, stage.result.reason) == ("stopped", "stopped by console")


@pytest.mark.parametrize("sense", ["attitude", "ranges", "drive"])
def test_what_has_to_be_known_is_waited_for_standing_and_then_it_gives_up(sense):
    stage = Stage()
    stage.back_m = 4.0
    stage.seek("align")
    stage.play(0.4, renew="align")
    stage.silent.add(sense)
    stage.play(1.5, renew="align")
    assert stage.asked(StopCommand)
    assert stage.result is None
    stage.play(5.0, renew="align")
    assert (stage.result.result, stage.result.code) == ("fault", "stale_sensor")


@pytest.mark.parametrize(("code", "within_s"), [("held", 1.0), ("unreachable", 1.0), ("not_armed", 30.0)])
def test_a_drive_that_refuses_is_told_by_its_code(code, within_s):
    stage = Stage()
    stage.back_m = 4.0
    stage.refusal = CommandReply(accepted=False, reason="no", code=code)
    stage.seek("align")
    stage.play(within_s, renew="align")
    assert stage.result is not None
    assert stage.result.code == ("done" if code == "not_armed" else code), (
        "an align that cannot come nearer stays where it is"
    )


def test_it_follows_the_beams_under_one_lease_and_says_when_they_are_lost():
    stage = Stage()
    stage.beams = ("left", "right")
    stage.seek("follow")
    stage.play(1.0, renew="follow")
    stage.beams = ("left",)
    stage.play(1.0, renew="follow")
    backs = stage.asked(DriveCommand)
    assert {one.lease for one in backs} == {"", "l1"}
    assert len({one.angle_deg for one in backs}) > 3, "it steers"
    assert stage.ctx.said("state")[-1].manoeuvre == "follow"
    stage.beams, stage.volts = (), 12.7
    stage.play(2.0, renew="follow")
    assert (stage.result.result, stage.result.code) == ("fault", "lost")
    state = stage.ctx.said("state")[-1]
    assert (state.dock_side, state.risen_v, state.code) == ("right", 0.2, "lost")
    assert stage.asked(StopCommand)


def test_one_manoeuvre_at_a_time():
    stage = Stage()
    stage.seek("search")
    stage.play(0.1)
    other = FakeCall("seek", SeekCommand(manoeuvre="align"), arrived=stage.ctx.now, source="console")
    stage.beacon.command(other)
    assert (other.answer.accepted, other.answer.code) == (False, "held")


def test_a_robot_without_a_drive_says_so():
    stage = Stage()
    stage.ctx.gone.add("move")
    assert stage.seek("align").code == "unreachable"
