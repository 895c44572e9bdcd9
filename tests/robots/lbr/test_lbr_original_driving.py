"""Driving by lbr's old API without a robot: a drive that lends one lease, and time that is what a test says."""

import json
from typing import Any

import pytest

from lbr.apps.web.bridge import Bridge
from lbr.apps.web.face import Refused
from lbr.apps.web.kind import KIND, WebSettings
from lbr.apps.web.robot import Robot
from lbr.messages.drive import DriveCommand, GoalResult, HeadingCommand, TurnCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.robots.lbr.original import wishes
from lbr.robots.lbr.original.driving import Client, Driver
from lbr.testing import FakeContext

ROUND_S = 0.02
ME, OTHER = Client("this machine", "", "python-requests"), Client("10.0.0.7", "phone", "app")
AHEAD, BACK = {"level": 0.3, "angle": 0}, {"level": 0.3, "angle": 180}
TIMED, TURN = {"level": 0.3, "angle": 0, "duration": 5}, {"turn": 90}


class Context(FakeContext):
    """Answers as a drive does that lends one lease."""

    def __init__(self) -> None:
        super().__init__(KIND, WebSettings(faces=("lbr_original",)), robot="lbr", name="web_api")
        self.live = ""
        self.moves: Any = None
        self.leases = 0
        self.cause = "done"
        self.refusal: CommandReply | None = None
        self.deaf = False
        self.stops: list[StopCommand] = []

    def answer(self, request: str, message: Any) -> dict[str, CommandReply | None] | None:
        if self.deaf:
            return None
        if request == "halt":
            self.stops.append(message)
            self.live, self.moves = "", None
            return {"drive": CommandReply(accepted=True)}
        return {"drive": self.refusal or self.lend(message)}

    def lend(self, message: Any) -> CommandReply:
        if message.lease and message.lease != self.live:
            return CommandReply(accepted=False, reason="lease is dead", code="dead_lease", cause=self.cause)
        if self.live and not message.lease:
            return CommandReply(accepted=False, reason="held by another", code="held")
        if not self.live:
            self.leases += 1
            self.live = f"lease-{self.leases}"
        self.moves = message
        bounded = not isinstance(message, DriveCommand) or message.interval_s > 0.0 or message.range_cm > 0.0
        goal = f"goal-{self.leases}" if bounded else ""
        return CommandReply(accepted=True, lease=self.live, ttl_s=0.5, goal=goal)


class Bench:
    """The driver in a loop of its own."""

    def __init__(self) -> None:
        self.ctx = Context()
        self.failed: list[Exception] = []
        self.bridge = Bridge(lambda: None, self.failed.append)
        self.robot = Robot(self.ctx, self.bridge, None, None)  # type: ignore[arg-type]
        self.driver = Driver(self.robot, 1.5, 10.0)

    def ask(self, body: Any, client: Client = ME) -> Any:
        asked = wishes.asked(json.dumps(body).encode())
        work = self.driver.stop(client, "stopped") if asked.stop else self.driver.move(client, asked)
        promise = self.robot.start(work)
        self.run()
        return promise.result(0)

    def run(self, seconds: float = 2 * ROUND_S) -> None:
        for _ in range(round(seconds / ROUND_S)):
            self.ctx.now += ROUND_S
            self.bridge.serve()
            self.driver.step(self.ctx.now)
            self.robot.moved = ()
        assert self.failed == []

    @property
    def renewals(self) -> list[Any]:
        return [one.message for one in self.ctx.asked if getattr(one.message, "lease", "")]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_client_drives_for_as_long_as_it_is_heard_and_not_longer(bench):
    bench.ask(AHEAD)
    assert bench.ctx.moves == DriveCommand(power=0.3, ttl_s=0.5, lease=bench.ctx.moves.lease)
    for _ in range(6):
        bench.run(1.0)
        bench.driver.beat(ME)
    assert bench.ctx.live
    assert len(bench.renewals) > 50, "renewed ten times a second"
    bench.run(1.4)
    assert bench.ctx.live
    bench.run(0.2)
    assert not bench.ctx.live
    assert [stop.lost for stop in bench.ctx.stops] == [True]
    assert bench.ctx.codes == ["holder_gone"]
    assert bench.driver.holder == ""
    before = len(bench.ctx.asked)
    bench.driver.beat(ME)
    bench.run(1.0)
    assert len(bench.ctx.asked) == before, "a client that is heard again moves nothing by that"


@pytest.mark.parametrize(
    "asker",
    [OTHER, Client("this machine", "", "curl"), Client("this machine", "phone", ""), Client("10.0.0.7", "", ME.agent)],
)
def test_another_client_keeps_nothing_alive(bench, asker):
    bench.ask(AHEAD)
    for _ in range(4):
        bench.run(0.5)
        bench.driver.beat(asker)
    assert not bench.ctx.live


def test_a_token_is_known_again_and_so_is_its_program_without_it(bench):
    client = Client("10.0.0.7", "fsm", "python-requests")
    assert client.is_alive_by(Client("10.0.0.7", "fsm", "curl"))
    assert client.is_alive_by(Client("10.0.0.7", "", "python-requests"))
    assert not client.is_alive_by(Client("10.0.0.7", "", "Mozilla/5.0"))
    assert not client.is_alive_by(Client("10.0.0.7", "iot", "python-requests"))


def test_the_same_again_is_a_sign_of_life_and_begins_nothing_new(bench):
    for _ in range(5):
        bench.ask(AHEAD)
        bench.run(1.0)
    assert (bench.ctx.leases, bench.ctx.live) == (1, "lease-1")


@pytest.mark.parametrize(
    ("body", "expected"), [(BACK, DriveCommand), (TURN, TurnCommand), ({"heading": 95}, HeadingCommand)]
)
def test_another_motion_goes_on_under_the_same_lease(bench, body, expected):
    bench.ask(AHEAD)
    bench.run(0.3)
    bench.ask(body)
    bench.run(0.5)
    assert isinstance(bench.ctx.moves, expected)
    assert (bench.ctx.leases, bench.ctx.stops) == (1, [])
    assert {type(one) for one in bench.renewals[-3:]} == {expected}


def test_what_was_over_when_it_was_to_be_changed_begins_again(bench):
    bench.ask(TURN)
    bench.run(0.5)
    bench.ctx.live = ""  # it has just arrived, and nobody has heard of it yet
    bench.ask(AHEAD)
    assert (bench.ctx.leases, bench.ctx.live) == (2, "lease-2")
    assert isinstance(bench.ctx.moves, DriveCommand)


def test_what_is_refused_says_so_and_ends_what_moved(bench):
    bench.ask(BACK)
    bench.ctx.refusal = CommandReply(accepted=False, reason="forward 20 cm", code="obstacle")
    with pytest.raises(Refused, match="forward 20 cm") as refused:
        bench.ask(AHEAD)
    assert (refused.value.status, refused.value.code) == (409, "obstacle")
    assert not bench.ctx.live
    assert bench.driver.holder == ""


def test_a_range_that_is_there_already_is_no_refusal(bench):
    bench.ctx.refusal = CommandReply(accepted=False, reason="forward is 40 cm already", code="done")
    bench.ask(AHEAD | {"range": 40})
    assert bench.driver.holder == ""


def test_a_drive_that_does_not_answer_is_told(bench):
    bench.ctx.deaf = True
    promise = bench.robot.start(bench.driver.move(ME, wishes.asked(json.dumps(AHEAD).encode())))
    bench.run(1.9)
    with pytest.raises(Refused) as refused:
        promise.result(0)
    assert refused.value.status in {409, 503}
    assert bench.driver.holder == ""


def test_one_client_drives_at_a_time_and_everyone_stops(bench):
    bench.ask(AHEAD)
    with pytest.raises(Refused, match="held by this machine"):
        bench.ask(BACK, OTHER)
    assert bench.ctx.live
    bench.ask({"level": 0, "angle": 0}, OTHER)
    assert not bench.ctx.live
    assert bench.ctx.stops[-1].whole
    bench.ask(BACK, OTHER)
    assert bench.ctx.moves.angle_deg == 180.0


def test_a_client_that_goes_on_asking_after_another_stopped_it_must_rest_first(bench):
    bench.ask(AHEAD)
    bench.ask({"level": 0, "angle": 0}, OTHER)
    for _ in range(4):
        bench.run(0.5)
        with pytest.raises(Refused, match="stopped by another") as refused:
            bench.ask(AHEAD)
        assert refused.value.code == "rest_first"
    assert not bench.ctx.live
    bench.ask({"level": 0, "angle": 0})
    bench.ask(AHEAD)
    assert bench.ctx.live


def test_a_stop_at_the_console_has_it_rest_too_and_silence_is_rest(bench):
    bench.ask(TURN)
    bench.robot.moved = (
        GoalResult(goal="goal-1", result="stopped", reason="stopped by console", code="stopped", elapsed_s=1.0),
    )
    bench.ctx.live = ""
    bench.run()
    with pytest.raises(Refused, match="stopped by another"):
        bench.ask(AHEAD)
    bench.run(1.1)
    bench.ask(AHEAD)
    assert bench.ctx.live


def test_a_process_that_was_held_up_takes_its_own_silence_for_no_rest(bench):
    bench.ask(AHEAD)
    bench.ask({"level": 0, "angle": 0}, OTHER)
    bench.ctx.now += 5.0
    bench.run()
    with pytest.raises(Refused) as refused:
        bench.ask(AHEAD)
    assert refused.value.code == "rest_first"
    assert not bench.ctx.live


def test_a_change_that_comes_just_after_anothers_stop_is_no_new_beginning(bench):
    bench.ask(AHEAD)
    bench.ctx.live, bench.ctx.cause = "", "stopped"
    with pytest.raises(Refused):
        bench.ask(BACK)
    with pytest.raises(Refused, match="stopped by another"):
        bench.ask(BACK)
    assert not bench.ctx.live


def test_its_own_stop_needs_no_rest(bench):
    bench.ask(AHEAD)
    bench.ask({"level": 0, "angle": 0})
    bench.ask(BACK)
    assert bench.ctx.live


def test_a_stop_overtakes_what_has_not_been_answered_yet(bench):
    bench.ctx.deaf = True
    moving = bench.robot.start(bench.driver.move(ME, wishes.asked(json.dumps(AHEAD).encode())))
    bench.run(0.1)
    bench.ctx.deaf = False
    bench.ask({"level": 0, "angle": 0})
    bench.run(0.1)
    with pytest.raises(Refused, match="stopped"):
        moving.result(0)
    assert not bench.ctx.live
    assert bench.driver.holder == ""


def test_whatever_stops_the_server_stops_what_moves(bench):
    bench.ask(AHEAD)
    bench.driver.give_up("the server ends")
    bench.run(0.1)
    assert not bench.ctx.live


@pytest.mark.parametrize("body", [TIMED, TURN])
def test_what_ends_by_itself_goes_on_without_its_client_but_not_for_ever(bench, body):
    bench.ask(body)
    bench.run(9.5)
    assert bench.ctx.live, "nobody was heard since, and the client only began it"
    bench.run(1.0)
    assert not bench.ctx.live


def test_a_goal_that_is_reached_is_over(bench):
    bench.ask(TURN)
    bench.robot.moved = (GoalResult(goal="goal-1", result="reached", reason="turned 90", elapsed_s=2.0),)
    bench.ctx.live = ""
    bench.run()
    assert bench.driver.holder == ""
    assert bench.ctx.stops == []
    bench.ask(TURN)
    assert bench.ctx.leases == 2


def test_a_clock_that_is_none_stops_it(bench):
    bench.ask(AHEAD)
    bench.driver.step(float("nan"))
    assert not bench.ctx.live


def test_what_came_before_a_stop_and_is_read_after_it_moves_nothing(bench):
    """What came before a stop, and is read after it, moves nothing"""
    ahead = wishes.asked(json.dumps(AHEAD).encode())

    def moves(client: Client, came_s: float) -> str:
        promise = bench.robot.start(bench.driver.move(client, ahead, came_s))
        bench.run()
        try:
            promise.result(0)
        except Refused as err:
            return err.code
        return ""

    came_s = bench.ctx.now
    bench.run(0.1)
    bench.driver.give_up("stopped by the page")
    bench.run(0.1)
    assert moves(OTHER, came_s) == "stopped"
    assert not bench.ctx.live
    assert moves(OTHER, bench.ctx.now) == ""
    stop_came_s = bench.ctx.now
    behind_s = stop_came_s + 0.01
    bench.run(0.1)
    promise = bench.robot.start(bench.driver.stop(OTHER, "stopped", stop_came_s))
    bench.run()
    promise.result(0)
    assert moves(OTHER, stop_came_s) == "stopped"
    assert moves(OTHER, behind_s) == ""
