import os
import struct
import time

import pytest
from msgspec.structs import replace

from lbr.capability.context import Device
from lbr.drivers.infrared import KIND, decoders
from lbr.drivers.infrared.capability import LOOKS_HZ, RESTING_HZ
from lbr.drivers.infrared.receiver import Receiver
from lbr.drivers.input_events import EVENT
from lbr.errors import DeviceError
from lbr.messages.dock import DockHeard
from lbr.operations.drive.kernel import drive_state, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.testing import FakeCall
from tests.drivers.peers import DriverContext, Pty
from tests.support.waiting import until

SETTINGS = '{"device": "dock_receiver", "ttl_s": %s, "protocols": [7]}'
TTL_S, LONG_S = 0.3, 10.0
LEFT, RIGHT = 0x400021, 0x400022


def record(code: int, *, protocol: int = 7, age_s: float = 0.0) -> bytes:
    return struct.pack("=QHHIQ", time.monotonic_ns() - int(age_s * 1e9), 0, protocol, 0, code)


@pytest.fixture
def receiver(tmp_path):
    with Pty(tmp_path / "lirc") as receiver:
        yield receiver


@pytest.fixture
def ttl_s():
    """So long that a busy machine holds up no test for as much."""
    return LONG_S


@pytest.fixture
def ctx(receiver, ttl_s):
    return DriverContext(KIND, KIND.parse(SETTINGS % ttl_s), receiver.path, "infrared")


@pytest.fixture
def infrared(ctx):
    infrared = KIND.load()(ctx)
    infrared.open()
    infrared.step()
    yield infrared
    infrared.close()


def shown(ctx) -> tuple[bool, bool, bool]:
    return (ctx.state.left, ctx.state.right, ctx.state.power)


def wait_for(infrared, ctx, expected):
    until(lambda: (infrared.step(), shown(ctx) == expected)[1])


def test_at_first_nothing_was_ever_seen(infrared, ctx):
    assert shown(ctx) == (False, False, False)
    assert ctx.state.left_age_s is None


@pytest.mark.parametrize("ttl_s", [TTL_S])
def test_a_beam_counts_and_expires_by_itself(infrared, ctx, receiver):
    until(lambda: os.write(receiver.master, record(LEFT)) and (infrared.step(), shown(ctx) == (True, False, False))[1])
    assert ctx.state.left_age_s < TTL_S
    wait_for(infrared, ctx, (False, False, False))
    assert ctx.state.left_age_s >= TTL_S


def test_what_the_kernel_kept_while_nobody_read_is_dated_as_it_came(infrared, ctx, receiver):
    os.write(receiver.master, record(LEFT, age_s=LONG_S + 5.0) + record(RIGHT))
    wait_for(infrared, ctx, (False, True, False))
    assert ctx.state.left_age_s > LONG_S + 4.9


def test_a_record_by_another_clock_counts_from_now(infrared, ctx, receiver):
    os.write(receiver.master, record(RIGHT, age_s=-5000.0))
    wait_for(infrared, ctx, (False, True, False))


def test_other_codes_and_other_protocols_are_nothing(infrared, ctx, receiver):
    os.write(receiver.master, record(0x40A7) + record(LEFT, protocol=9) + record(RIGHT))
    wait_for(infrared, ctx, (False, True, False))
    assert ctx.state.left_age_s is None


def test_it_goes_on_saying_what_it_sees(infrared, ctx):
    before = len(ctx.published)
    until(lambda: (infrared.step(), len(ctx.published) > before)[1])


def test_somebody_else_may_have_seen_a_beam(infrared, ctx):
    call = FakeCall("hear", DockHeard(right=True), ctx.clock())
    infrared.command(call)
    infrared.step()
    assert call.answer.accepted
    assert shown(ctx) == (False, True, False)


def test_unplugged_it_is_degraded_still_hears_others_and_comes_back(infrared, ctx, receiver, monkeypatch):
    monkeypatch.setattr("lbr.drivers.infrared.capability.RETRY_S", 0.0)
    receiver.unplug()
    until(lambda: (infrared.step(), "is missing" in ctx.health[-1])[1])
    infrared.command(FakeCall("hear", DockHeard(left=True), ctx.clock()))
    infrared.step()
    assert ctx.state.left
    receiver.plug()
    until(lambda: (infrared.step(), ctx.health[-1] == "ready")[1])
    os.write(receiver.master, record(RIGHT))
    until(lambda: (infrared.step(), ctx.state.right)[1])


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        ("rc0", "is not a path"),
        ("/nowhere/lirc0", "is missing; plug it in"),
        ("/", "cannot be opened|went away|set up"),
    ],
)
def test_an_address_that_is_no_receiver_says_what_to_do(address, complaint):
    with pytest.raises(DeviceError, match=f"'dock_receiver' at {address} .*({complaint})"):
        Receiver(Device("dock_receiver", "infrared", address, {}), KIND.parse(SETTINGS % TTL_S)).poll()


def test_a_receiver_that_decodes_nothing_is_degraded_although_it_opens(receiver, ctx, monkeypatch):
    monkeypatch.setattr(decoders, "of", lambda _path: decoders.Decoders(receiver="rc0", enabled=frozenset({"nec"})))
    infrared = KIND.load()(ctx)
    infrared.open()
    infrared.step()
    assert "decodes nec, not sony: sudo ir-keytable -s rc0 -p nec,sony" in ctx.health[-1]
    infrared.close()


def test_events_are_read_where_the_row_says_so(receiver):
    settings = KIND.parse('{"device": "dock_receiver", "records": "events"}')
    opened = Receiver(Device("dock_receiver", "infrared", str(receiver.path), {}), settings)
    os.write(receiver.master, EVENT.pack(5, 0, 4, 4, LEFT))
    found = []
    until(lambda: bool(found.extend(opened.poll()) or found))
    opened.close()
    assert [scancode.code for scancode in found] == [LEFT]


STANDS = drive_state(first_state(DriveSettings()), 0.0)


@pytest.mark.parametrize(
    ("drive", "rate_hz"),
    [(STANDS, RESTING_HZ), (replace(STANDS, holder="page"), LOOKS_HZ), (replace(STANDS, moving=True), LOOKS_HZ)],
)
def test_it_looks_seldom_before_a_base_that_stands_and_that_nobody_holds(infrared, ctx, drive, rate_hz):
    assert infrared.rate_hz == LOOKS_HZ
    ctx.arrive("drive", drive)
    infrared.step()
    assert infrared.rate_hz == rate_hz


def test_it_looks_often_once_the_drive_is_silent(infrared, ctx, monkeypatch):
    ctx.arrive("drive", STANDS)
    infrared.step()
    monkeypatch.setattr("lbr.drivers.infrared.capability.RESTS_S", 0.0)
    infrared.step()
    assert infrared.rate_hz == LOOKS_HZ
