"""Teleop beside a drive of the test's own: what it borrows, renews and stops, and what its buttons say."""

import pytest

from lbr.apps.teleop.kind import KIND
from lbr.errors import DeviceError
from lbr.messages.gamepad import GamepadState
from lbr.messages.leases import CommandReply
from lbr.messages.system import ConsoleResult, Hold
from lbr.testing import FakeContext
from tests.support.replies import dead

TICK_S = 0.02
LINES = {"y": "/s/hello", "x": "/play/wave"}


class World(FakeContext):
    """A drive, motions and a console on the other side of the bus; `hand` is what is held on the gamepad."""

    def __init__(self, **settings):
        super().__init__(KIND, KIND.settings(lines=LINES, **settings), robot="lbr", name="teleop")
        self.wired = {"pad": ("gamepad",), "play": ("motions",)}
        self.lease = self.refusal = self.code = self.ended_by = ""
        self.twists: list[tuple[float, float]] = []
        self.renewed = 0
        self.stops = 0
        self.said: list[str] = []
        self.result = ConsoleResult(code=0, text="done")
        self.driver_speaks = True
        self.hand = {"pressed": (), "axes": {}}

    def answer(self, request, message):
        return {"other": getattr(self, f"_{request}")(message)}

    def _twist(self, message):
        if message.lease and message.lease != self.lease:
            return dead("", self.ended_by or "lapsed")
        if self.refusal:
            return CommandReply(accepted=False, reason=self.refusal, code=self.code)
        self.lease = self.lease or f"lease-{len(self.asked)}"
        self.twists.append((message.vx_mps, message.wz_rps))
        return CommandReply(accepted=True, lease=self.lease, ttl_s=message.ttl_s)

    def _halt(self, _message):
        self.lease = ""
        return CommandReply(accepted=True)

    def _stop_all(self, message):
        assert message.whole
        self.stops += 1
        return self._halt(message)

    def _say(self, message):
        self.said.append(message.line)
        return self.result

    def _play(self, message):
        assert message["lease"] == "played"
        self.renewed += 1
        return CommandReply(accepted=True, lease="played", ttl_s=0.5, goal="goal")

    def _play_halt(self, _message):
        return CommandReply(accepted=True)

    @property
    def requests(self):
        return [asked.request for asked in self.asked]

    @property
    def state(self):
        return self.said_states[-1]

    @property
    def said_states(self):
        return [message for name, message in self.published if name == "state"]


@pytest.fixture
def world():
    return World()


@pytest.fixture
def teleop(world):
    teleop = KIND.load()(world)
    teleop.open()
    run(teleop, world, 0.2)
    return teleop


def run(teleop, world, seconds):
    """Let time go on, with a driver that says what is held every tick."""
    for _ in range(round(seconds / TICK_S)):
        if world.driver_speaks:
            world.arrive("pad", GamepadState(connected=True, silent_s=0.0, **world.hand), source="gamepad")
        teleop.step()
        world.now += TICK_S


def hold(world, *pressed, **axes):
    world.hand = {"pressed": pressed, "axes": axes}


def drive(teleop, world):
    """Hold the dead-man button, then push the stick."""
    hold(world)
    run(teleop, world, 0.1)
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", left_y=1.0)
    run(teleop, world, 0.3)
    assert world.lease
    assert world.twists[-1] == (0.4, 0.0)


def test_it_borrows_the_drive_renews_and_follows_the_stick_under_one_lease(teleop, world):
    drive(teleop, world)
    lease = world.lease
    run(teleop, world, 1.0)
    hold(world, "tl", left_y=-1.0)
    run(teleop, world, 0.1)
    assert world.lease == lease
    assert world.twists[-1] == (-0.4, 0.0)
    assert 10 <= len(world.twists) <= 20
    assert (world.state.driving, world.state.vx_mps, world.state.dead_man) == (True, -0.4, True)


@pytest.mark.parametrize("hand", [(), ("tl",)])
def test_a_released_button_and_a_centred_stick_stop_in_the_same_step(teleop, world, hand):
    drive(teleop, world)
    hold(world, *hand)
    run(teleop, world, TICK_S)
    assert world.lease == ""
    assert world.requests[-1] == "halt"


def test_the_stop_button_stops_everything_without_the_dead_man_button(teleop, world):
    hold(world, "b")
    run(teleop, world, 0.1)
    assert world.stops == 1
    drive(teleop, world)
    hold(world, "tl", "b", left_y=1.0)
    run(teleop, world, 0.5)
    assert (world.stops, world.lease) == (2, "")
    hold(world, "tl", left_y=1.0)
    run(teleop, world, 0.5)
    assert world.lease == ""


def test_a_button_latches_the_emergency_stop_where_the_row_says_so():
    world = World(estop="mode")
    teleop = KIND.load()(world)
    run(teleop, world, 0.1)
    hold(world, "mode")
    run(teleop, world, 0.1)
    assert world.latched == ["stopped at the gamepad"]


@pytest.mark.parametrize("loss", ["silent", "dead", "unplugged", "held up", "asleep"])
def test_every_loss_stops_and_nothing_resumes_before_the_button_is_pressed_anew(teleop, world, loss):
    drive(teleop, world)
    match loss:
        case "silent":
            world.driver_speaks = False
            run(teleop, world, 0.24)
            world.driver_speaks = True
        case "dead":
            world.gone = {"gamepad"}
            run(teleop, world, TICK_S)
            assert world.lease == ""
            world.gone = set()
        case "unplugged":
            world.arrive("pad", GamepadState(connected=False), source="gamepad")
            world.driver_speaks = False
            run(teleop, world, TICK_S)
            world.driver_speaks = True
        case "held up":
            world.now += 0.5
            world.lease = ""
        case "asleep":
            teleop.woke(60.0)
            run(teleop, world, TICK_S)
    assert world.lease == "" or loss == "held up"
    count = len(world.twists)
    run(teleop, world, 1.0)
    assert (world.lease, len(world.twists)) == ("", count)
    hold(world, "tl")
    run(teleop, world, 0.2)
    hold(world, "tl", left_y=1.0)
    run(teleop, world, 0.2)
    assert (world.lease, len(world.twists)) == ("", count), "the button was never let go"
    drive(teleop, world)


@pytest.mark.parametrize(
    ("code", "button_anew"), [("stopped", True), ("taken_over", True), ("estop", True), ("obstacle", False)]
)
def test_after_a_stop_by_others_the_button_is_pressed_anew_after_an_obstacle_the_stick_is_centred(
    teleop, world, code, button_anew
):
    drive(teleop, world)
    world.lease, world.ended_by = "", code
    run(teleop, world, 0.5)
    assert world.lease == ""
    assert world.state.code in {code, "rest_first"}
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", left_y=-1.0)
    run(teleop, world, 0.2)
    assert (world.lease == "") == button_anew
    drive(teleop, world)


def test_where_another_drives_it_is_refused_once_and_told(teleop, world):
    world.refusal, world.code = "held by console", "held"
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", left_y=1.0)
    run(teleop, world, 1.0)
    assert world.requests.count("twist") == 1
    assert world.state.reason
    world.refusal = ""
    drive(teleop, world)


def test_a_drive_that_does_not_answer_is_given_up(teleop, world):
    drive(teleop, world)
    world.answer = lambda *_: None
    run(teleop, world, 1.0)
    assert not world.state.driving
    assert world.state.code in {"unreachable", "rest_first"}


def test_buttons_say_lines_while_the_dead_man_button_is_held(teleop, world):
    hold(world, "y")
    run(teleop, world, 0.5)
    assert world.said == []
    assert world.told("teleop_line") == ["'/s/hello': the button tl is not held"]
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", "y")
    run(teleop, world, 0.5)
    assert world.said == ["/s/hello"]
    world.result = ConsoleResult(code=1, text="speech is away", reason_code="unreachable")
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", "y")
    run(teleop, world, 0.1)
    assert world.told("teleop_line")[-1] == "'/s/hello': speech is away"
    assert world.codes[-1] == "unreachable"


def begin_motion(world):
    payload = {"motion": "wave", "lease": "played"}
    world.result = ConsoleResult(
        code=0, text="plays", hold=Hold(lease="played", ttl_s=0.5, key="lbr/motions/play", stop_key="lbr/motions/stop",
                                        result_key="lbr/motions/result", payload=payload, goal="goal")
    )  # fmt: skip


def test_what_a_line_moves_goes_on_while_the_dead_man_button_is_held_and_stops_once_it_is_not(teleop, world):
    begin_motion(world)
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", "x")
    run(teleop, world, 1.0)
    assert world.said == ["/play/wave"]
    assert 8 <= world.renewed <= 12
    assert world.state.line == "/play/wave"
    hold(world)
    run(teleop, world, TICK_S)
    assert world.requests[-1] == "play_halt"
    assert "is not held" in world.told("teleop_line")[-1]


def test_what_a_line_moves_is_stopped_if_the_button_is_let_go_before_the_answer(teleop, world):
    begin_motion(world)
    answer, world.answer = world.answer, lambda request, message: None if request == "say" else answer(request, message)
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", "x")
    run(teleop, world, 2 * TICK_S)
    (asked,) = (one for one in world.asked if one.request == "say")
    asked.given = {"executive": world.result}
    hold(world)
    run(teleop, world, 2 * TICK_S)
    assert (world.requests[-1], world.renewed) == ("play_halt", 0)


def test_the_sticks_end_what_a_line_moves(teleop, world):
    begin_motion(world)
    hold(world, "tl")
    run(teleop, world, 0.1)
    hold(world, "tl", "x")
    run(teleop, world, 0.2)
    hold(world, "tl", left_y=1.0)
    run(teleop, world, 0.1)
    assert "play_halt" in world.requests
    assert world.lease


def test_two_gamepads_are_refused_until_a_row_says_which(world):
    world.wired["pad"] = ("gamepad", "gamepad_2")
    with pytest.raises(DeviceError, match="gamepad and gamepad_2 are wired to it"):
        KIND.load()(world).open()


def test_closed_it_stops_what_it_moves(teleop, world):
    drive(teleop, world)
    teleop.close()
    assert world.requests[-1] == "halt"
