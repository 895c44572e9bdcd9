"""`lbr replay`: what was recorded, as streams of a robot of another name; with pause, jumps and speed."""

import json
import os
import pty
import signal
import subprocess

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.recorder.recording import chunks, reader
from lbr.apps.recorder.recording.chunks import Channel, Channels
from lbr.apps.recorder.recording.player import Player
from lbr.apps.recorder.recording.segments import Segment
from lbr.messages.system import CapabilityStatus, EstopState, Status
from tests.support import programs
from tests.support.robot import LBR, environment, lbr
from tests.support.segments import finished
from tests.support.waiting import until

S = 10**9
DRIVE = Channel(
    "drive/state",
    "json",
    "DriveState",
    b'{"title":"DriveState","type":"object","properties":{"power":{"type":"number"}}}',
)
STATUS = Channel("@status", "json", "Status", b"{}")


@pytest.fixture
def home(tmp_path):
    place = tmp_path / "h"
    folder = place / "recordings" / "lbr"
    folder.mkdir(parents=True, mode=0o700)
    place.chmod(0o700)
    channels = Channels()
    with finished(Segment(folder / "walk.mcap", "a test", {"robot": "lbr"})) as segment:
        numbers = channels.number(DRIVE), channels.number(STATUS)
        drive = CapabilityStatus(
            name="drive",
            kind="drive",
            phase="ready",
            pid=1,
            restarts=0,
            uptime_s=1.0,
            reason="",
            rates_hz={"state": 10.0},
        )
        status = Status(
            robot="lbr",
            profile="lbr-sim",
            ready=True,
            pid=1,
            uptime_s=1.0,
            estop=EstopState(engaged=False, reason=""),
            capabilities=(drive,),
        )
        for second in range(1, 61):
            at = 1_700_000_000 * S + second * S
            parts = [channels.schemas, channels.of(numbers)]
            parts += [
                chunks.message(numbers[0], second * 10 + n, at + n * S // 10, at, b'{"power": %d}' % second)
                for n in range(10)
            ]
            parts.append(chunks.message(numbers[1], second, at, at, msgspec.json.encode(status)))
            segment.write(chunks.chunk(parts, at, at + S))
    return place


def power(home):
    done = lbr(home, "topic", "echo", "drive/state", "--robot", "replay", "--once", "--json")
    return json.loads(done.stdout)["power"] if done.returncode == 0 else None


def test_it_is_looked_at_as_another_robot_paused_and_moved_to_and_fro(home):
    ours, theirs = pty.openpty()
    popen = programs.start(
        [*LBR, "replay", "walk", "--robot", "lbr"],
        env=environment(home),
        stdin=theirs,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        until(lambda: power(home) is not None, what="a stream")
        os.write(ours, b" ")
        first = power(home)
        os.write(ours, b"\x1b[C")
        later = until(lambda: (now := power(home)) is not None and now >= first + 9 and now, what="a jump ahead")
        os.write(ours, b"\x1b[D")
        back = until(lambda: (now := power(home)) is not None and now < later - 5 and now, what="a jump back")
        assert power(home) == back, "it stands while it is paused"
        listed = lbr(home, "topic", "list", "--robot", "replay").stdout
        assert "drive/state" in listed
        assert "DriveState" in listed
        os.write(ours, b"q")
        assert popen.wait(10) == 0
    finally:
        popen.kill()
        popen.communicate()
        os.close(ours)
        os.close(theirs)


def test_what_was_cut_after_its_first_chunk_is_played_and_a_time_without_anything_is_refused(home, tmp_path):
    walk, cut = home / "recordings" / "lbr" / "walk.mcap", tmp_path / "cut.mcap"
    with reader.opened(walk) as found:
        cut.write_bytes(walk.read_bytes()[: found.spans[1].at + 40])
    played = lbr(home, "replay", str(cut), "--robot", "lbr")
    assert (played.returncode, played.stdout) == (0, "")
    assert "replays cut.mcap" in played.stderr
    refused = lbr(home, "replay", str(cut), "--robot", "lbr", "--from", "1m")
    assert refused.returncode == 2
    assert "in that time" in refused.stderr


def test_it_ends_at_its_end_or_when_it_is_told_and_leaves_nothing(home):
    done = lbr(home, "replay", "walk", "--robot", "lbr", "--speed", "100")
    assert done.returncode == 0, done.stderr
    popen = programs.start([*LBR, "replay", "walk", "--robot", "lbr"], env=environment(home), stdin=subprocess.DEVNULL)
    until(lambda: power(home) is not None, what="a stream")
    popen.send_signal(signal.SIGTERM)
    assert popen.wait(10) == 0
    assert lbr(home, "status").returncode == 1
    assert "not a robot's name" in lbr(home, "replay", "walk", "--robot", "lbr", "--as", "../x").stderr
    assert lbr(home, "replay", "walk", "--robot", "lbr", "--from", "1m").returncode == 2


@given(
    st.lists(
        st.tuples(
            st.floats(0, 100),
            st.sampled_from(["pause", "resume", "faster", "slower", "seek"]),
            st.integers(-(10**12), 10**12),
        ),
        max_size=30,
    )
)
def test_a_player_never_leaves_what_there_is_and_goes_on_with_the_clock(steps):
    now = 100.0
    player = Player(1000 * S, 2000 * S, 1.0, now)
    for seconds, what, ns in steps:
        before = player.at_ns(now)
        now += seconds
        at = player.at_ns(now)
        assert 1000 * S <= before <= at <= 2000 * S
        if player.paused:
            assert at == before
            assert player.wait_s(at + 1, now) == float("inf")
        elif at < 2000 * S:
            assert abs(player.wait_s(at + S, now) - 1 / player.speed) < 1e-3
        if what == "seek":
            player.seek(1500 * S + ns, now)
        elif what in {"faster", "slower"}:
            player.faster(now, 2.0 if what == "faster" else 0.5)
            assert abs(player.at_ns(now) - at) <= 1
        else:
            player.pause(now, paused=what == "pause")
