import os

import pytest

from lbr.capability.context import Device
from lbr.drivers.gamepad import KIND
from lbr.drivers.gamepad.receiver import Receiver
from lbr.drivers.input_events import EV_ABS, EV_KEY, EVENT
from lbr.errors import DeviceError
from lbr.testing.device import plugged
from lbr.testing.driver import DriverBench
from tests.drivers.peers import DriverContext, Pty
from tests.support.waiting import until

TL, A, Y = 0x136, 0x130, 1


def packet(*told: tuple[int, int, int]) -> bytes:
    return b"".join(EVENT.pack(5, 0, *one) for one in (*told, (0, 0, 0)))


@pytest.fixture
def port(tmp_path):
    with Pty(tmp_path / "pad") as port:
        yield port


@pytest.fixture
def ctx(port):
    return DriverContext(KIND, KIND.parse('{"device": "pad"}'), port.path, "gamepad")


@pytest.fixture
def gamepad(ctx):
    gamepad = KIND.load()(ctx)
    gamepad.open()
    gamepad.step()
    yield gamepad
    gamepad.close()


def wait_for(gamepad, ctx, held):
    until(lambda: (gamepad.step(), held(ctx.state))[1])


def test_at_first_it_is_at_rest_and_has_said_nothing(gamepad, ctx):
    assert ctx.state.connected
    assert ctx.state.pressed == ()
    assert set(ctx.state.axes.values()) == {0.0}
    assert ctx.state.silent_s is None


def test_what_is_held_is_told_at_once_and_again_for_as_long_as_it_is(gamepad, ctx, port):
    os.write(port.master, packet((EV_KEY, TL, 1), (EV_ABS, Y, -32768)))
    wait_for(gamepad, ctx, lambda state: state.pressed == ("tl",))
    assert ctx.state.axes["left_y"] == 1.0
    before = len(ctx.published)
    wait_for(gamepad, ctx, lambda state: len(ctx.published) >= before + 3 and state.silent_s > 0.2)
    assert gamepad.rate_hz == 50.0
    os.write(port.master, packet((EV_KEY, TL, 0), (EV_ABS, Y, 0)))
    wait_for(gamepad, ctx, lambda state: state.pressed == ())
    assert gamepad.rate_hz == 20.0


def test_a_press_that_is_over_before_it_is_read_is_told(gamepad, ctx, port):
    os.write(port.master, packet((EV_KEY, A, 1)) + packet((EV_KEY, A, 0)))
    until(lambda: (gamepad.step(), any(state.pressed for _, state in ctx.published) and ctx.state.pressed == ())[1])
    assert [state.pressed for _, state in ctx.published if state.pressed] == [("a",)]


def test_of_damage_nothing_is_believed(gamepad, ctx, port):
    os.write(port.master, b"\xff" * 24 + packet((EV_KEY, TL, 1), (EV_ABS, Y, -32768)))
    wait_for(gamepad, ctx, lambda state: state.silent_s is not None)
    assert ctx.state.pressed == ()
    assert ctx.state.axes["left_y"] == 0.0


def test_unplugged_with_something_held_it_holds_nothing_and_comes_back_at_rest(tmp_path):
    with plugged("gamepad", tmp_path) as device:
        bench = DriverBench(KIND, '{"device": "device"}', device)
        bench.works()
        device.fault("left_y", 1.0)
        device.fault("pressed", "tl")
        bench.until(lambda: bench.ctx.said("state")[-1].pressed == ("tl",), "it is held")
        bench.errors.clear()
        device.fault("unplug", True)
        bench.until(lambda: bench.errors, "the loss is told")
        assert "check its cable" in str(bench.errors[0])
        device.fault("left_y", 0.0)
        device.fault("pressed", None)
        device.fault("unplug", False)
        bench.until(lambda: bench.ctx.said("state")[-1].pressed == (), "it is back, and at rest")
        assert bench.ctx.said("state")[-1].connected
        bench.close()


def test_a_lost_gamepad_holds_nothing(gamepad, ctx):
    gamepad.degraded("it went away")
    assert (ctx.state.connected, ctx.state.pressed, ctx.state.axes) == (False, (), {})
    assert ctx.state.reason == "it went away"


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        ("js0", "is neither a path"),
        ("/nowhere/event0", "is missing; plug it in"),
        ("input:No Such Pad", "is missing; plug it in"),
        ("/", "cannot be opened|went away"),
    ],
)
def test_an_address_that_is_no_gamepad_says_what_to_do(address, complaint):
    with pytest.raises(DeviceError, match=f"'pad' at {address} .*({complaint})"):
        Receiver(Device("pad", "gamepad", address, {})).poll()
