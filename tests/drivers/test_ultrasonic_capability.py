import os
import sys
import termios
from contextlib import contextmanager
from fcntl import ioctl

import pytest
from msgspec.structs import replace

from lbr.drivers.ultrasonic import KIND
from lbr.drivers.ultrasonic.controller import ASK_PERIOD_S
from lbr.errors import DeviceError
from lbr.operations.drive.kernel import drive_state, first_state
from lbr.operations.drive.settings import DriveSettings
from tests.drivers.peers import DriverContext
from tests.support.waiting import until

LINE = b'{ "Ranges": { "Forward": %d, "Left": 45, "Right": 60, "Back": 70, "Bottom": 0, "Deltat": 100}}\r\n'


@pytest.fixture
def ctx(board, monkeypatch):
    """A context on a clock of the test, `now`."""
    settings = KIND.parse('{"device": "ring", "timeout_s": 0.2, "start_timeout_s": 0.4}')
    ctx = DriverContext(KIND, settings, board.path, "ultrasonic_ring")
    ctx.now = 100.0
    monkeypatch.setattr(ctx, "clock", lambda: ctx.now)
    return ctx


@pytest.fixture
def ring(ctx):
    ring = KIND.load()(ctx)
    ring.open()
    yield ring
    ring.close()


@contextmanager
def listening(board):
    """A function that tells how many bytes of a board are there to be read."""
    line = os.open(board.path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    yield lambda: int.from_bytes(ioctl(line, termios.FIONREAD, b"\0\0\0\0"), sys.byteorder)
    os.close(line)


def hear(ring, ctx, count=1):
    until(lambda: (ring.step(), len(ctx.published) >= count)[1])


def test_opening_starts_the_board_and_closing_stops_it(ring, board):
    assert board.heard() == b"g\n"
    ring.close()
    assert board.heard() == b"s\n"


def test_every_good_frame_is_published_at_once(ring, ctx, board):
    board.say(b"received: g\nreceived: \n\n" + LINE % 120)
    hear(ring, ctx)
    output, ranges = ctx.published[0]
    assert output == "readings"
    assert ranges.forward_m == 1.2
    assert ranges.bottom_m is None
    assert ranges.status["bottom"] == "missing"
    board.say(LINE % 121 + LINE % 122)
    hear(ring, ctx, 3)
    assert [ranges.forward_m for _, ranges in ctx.published] == [1.2, 1.21, 1.22]
    assert ctx.kinds() == []


def test_it_is_ready_only_once_it_has_measured(ring, ctx, board, wording):
    ring.step()
    wording(*ctx.health)
    board.say(LINE % 120)
    hear(ring, ctx)
    assert ctx.health[-1] == "ready"


def test_a_board_that_was_silent_and_is_opened_again_says_no_more_before_it_measures(ring, ctx, board, wording):
    ring.step()
    ring.close()
    ring.open()
    ring.step()
    wording(*ctx.health)
    assert not ring.answers()
    board.say(LINE % 120)
    hear(ring, ctx)
    assert ring.answers()
    assert ctx.health[-1] == "ready"


def test_a_board_that_was_still_starting_is_asked_again(ring, ctx, board):
    assert board.heard() == b"g\n"
    ctx.now += ASK_PERIOD_S
    until(lambda: (ring.step(), board.waiting() == b"g\n")[1])


def test_no_frame_means_no_message_and_then_silence_is_an_error(ring, ctx, board):
    board.say(LINE % 120)
    hear(ring, ctx)
    ctx.now += 0.19
    ring.step()
    ctx.now += 0.02
    with pytest.raises(DeviceError, match=r"'ring' is silent"):
        ring.step()
    assert len(ctx.published) == 1


def test_a_board_that_never_speaks_is_an_error_after_its_start_up_time(ring, ctx):
    for _ in range(3):
        ctx.now += 0.13
        ring.step()
    ctx.now += 0.02
    with pytest.raises(DeviceError, match="silent"):
        ring.step()
    assert ctx.published == []


def test_noise_never_becomes_a_number_and_counts_as_silence(ring, ctx, board):
    def babble():
        board.say(b'{ "Ranges": { "Forward": 1\xff' + b"x" * 100 + b"\n")
        ring.step()
        ctx.now += 0.05

    with pytest.raises(DeviceError, match=r"but [0-9]+ malformed lines"):
        until(babble)
    assert ctx.published == []
    assert "bad_lines" in ctx.kinds()


def test_a_number_no_board_can_count_to_is_a_bad_line_and_the_next_frame_is_read(ring, ctx, board):
    board.say((LINE % 120).replace(b"100}", b"9" * 400 + b"}") + LINE % 121)
    hear(ring, ctx)
    assert [ranges.forward_m for _, ranges in ctx.published] == [1.21]


def test_what_came_in_during_a_long_pause_is_too_old_to_publish(ring, ctx, board):
    board.say(LINE % 120)
    hear(ring, ctx)
    with listening(board) as came:
        board.say(LINE % 500)
        until(lambda: came() == len(LINE % 500))
    ctx.now += 0.3
    ring.step()
    assert len(ctx.published) == 1
    board.say(LINE % 121)
    hear(ring, ctx, 2)
    assert ctx.published[1][1].forward_m == 1.21


def test_unplugging_is_an_error_and_replugging_goes_on(ring, ctx, board):
    board.say(LINE % 120)
    hear(ring, ctx)
    board.unplug()
    with pytest.raises(DeviceError, match="went away"):
        until(ring.step)
    ring.close()
    with pytest.raises(DeviceError, match="missing"):
        ring.open()
    ring.close()
    board.plug()
    ring.open()
    assert board.heard() == b"g\n"
    board.say(LINE % 130)
    hear(ring, ctx, 2)
    assert ctx.published[-1][1].forward_m == 1.3


def test_between_two_frames_it_hardly_looks_and_takes_the_next_one_as_soon_as_before(ring, ctx, board):
    """Time is stepped as the runtime's loop does, in hundredths of a second, a frame every tenth of it."""
    late_s, looks, due = [], 0, ctx.now
    with listening(board) as came:
        for tick in range(1000):
            ctx.now = 100.0 + tick / 100
            if tick % 10 == 0:
                said_s, frame = ctx.now, LINE % (120 + tick % 7)
                board.say(frame)
                until(lambda: came() == len(frame))  # noqa: B023  it is asked at once
            if ctx.now < due - 1e-6:
                continue
            heard, looks = len(ctx.published), looks + (tick >= 500)
            ring.step()
            due = ctx.now + 1 / ring.rate_hz
            if len(ctx.published) > heard and tick >= 500:
                late_s.append(ctx.now - said_s)
    assert len(late_s) == 50
    assert max(late_s) < 0.011
    assert looks <= 200


@pytest.fixture
def at_rest(ring, ctx, board):
    """A function that says a frame a tenth of a second later, the drive holding what it is told; what was published by it."""

    def say(forward_cm=120, *, drive=STANDS, count=1):
        came = len(ctx.published)
        for _ in range(count):
            ctx.now += 0.1
            if drive is not None:
                ctx.arrive("drive", drive)
            board.say(LINE % forward_cm)
            frames = ring._board.frames
            until(lambda: (ring.step(), ring._board.frames > frames)[1])  # noqa: B023  it is asked at once
        return [ranges for _, ranges in ctx.published[came:]]

    return say


STANDS = drive_state(first_state(DriveSettings()), 0.0)


def test_frames_that_repeat_themselves_are_published_twice_a_second(at_rest):
    assert [ranges.rests for ranges in at_rest(count=12)] == [False] * 11 + [True]
    assert len(at_rest(count=50)) == 10


@pytest.mark.parametrize(("forward_cm", "published"), [(125, 0), (115, 0), (126, 1), (114, 1), (760, 1), (0, 1)])
def test_a_flicker_is_no_change_and_a_change_is_published_at_once(at_rest, forward_cm, published):
    at_rest(count=12)
    assert [ranges.rests for ranges in at_rest(forward_cm)] == [False] * published
    assert len(at_rest(forward_cm, count=5)) == (5 if published else 1)


def test_a_distance_that_creeps_is_a_change_once_it_has_left_its_band(at_rest):
    at_rest(count=12)
    assert [len(at_rest(forward_cm)) for forward_cm in (118, 116, 114)] == [0, 0, 1]


@pytest.mark.parametrize("drive", [replace(STANDS, holder="page"), replace(STANDS, moving=True), None])
def test_every_frame_is_published_while_the_base_is_held_or_moves_or_its_drive_is_silent(at_rest, ctx, drive):
    at_rest(count=12)
    at_rest(drive=drive, count=20)
    assert [ranges.rests for ranges in at_rest(drive=drive, count=20)] == [False] * 20


def test_what_rested_is_missing_once_its_board_is_gone(at_rest, ring, ctx):
    at_rest(count=12)
    came = len(ctx.published)
    ring.close()
    (said,) = [ranges for _, ranges in ctx.published[came:]]
    assert set(said.status.values()) == {"missing"}
    assert said.forward_m is None
