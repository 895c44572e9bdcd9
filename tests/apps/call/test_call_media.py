"""Picture and sound both ways over real connections, without a browser."""

import threading
from pathlib import Path

import pytest

from tests.support import needs
from tests.support.waiting import until

needs.modules("aiortc", "PIL")

from lbr.apps.call.media import Media  # noqa: E402
from lbr.apps.call.sound import BYTES, TONE_EVERY, Source, tone  # noqa: E402
from tests.apps.call.call_bench import GREY, WHITE, Caller, Camera, news  # noqa: E402


@pytest.fixture
def media():
    found = Media(lambda: None, "tone", simulated=True)
    yield found
    found.stop()
    assert not [one.name for one in threading.enumerate() if one.name.startswith(("media", "video-dec", "audio-dec"))]


@pytest.fixture
def camera(media):
    found = Camera(media.show)
    yield found
    found.close()


@pytest.fixture
def caller():
    made = []

    def make():
        made.append(Caller())
        return made[-1]

    yield make
    for one in made:
        one.close()


def connected(media, one, name, purpose="talk"):
    media.connect(name, purpose, one.offer(purpose))
    answer = until(lambda: news(media, "answer", name))
    one.take(answer)
    assert until(lambda: news(media, "connected", name) is not None)
    return answer


def near(level, wanted):
    return abs(level - wanted) < 12


def test_a_caller_sees_and_hears_the_robot_and_a_display_the_caller(media, camera, caller):
    ann, screen = caller(), caller()
    answer = connected(media, ann, "ann")
    assert "VP8/90000" in ann.codecs
    assert "H264/90000" not in answer
    streams = [line.split(" ")[0] for line in answer.splitlines() if line.startswith("a=msid:")]
    assert len(set(streams)) == 2, "the picture would wait for the sound"
    until(lambda: any(near(level, GREY) for level in ann.levels), what="the camera's picture")
    assert ann.sizes >= {(64, 48)}
    until(lambda: any(level > 300 for level in ann.sound), what="the test tone")
    connected(media, screen, "screen", "display")
    until(lambda: len(screen.levels) > 3 and len(screen.sound) > 3, what="the caller on the display")
    camera.level = WHITE
    until(lambda: near(ann.levels[-1], WHITE), what="the next picture")
    media.close("ann")
    until(lambda: not media._peers or set(media._peers) == {"screen"})


def test_a_camera_that_is_unplugged_leaves_no_old_picture_and_comes_back(media, camera, caller):
    ann = caller()
    connected(media, ann, "ann", "watch")
    until(lambda: ann.levels and near(ann.levels[-1], GREY))
    assert ann.sound == []
    camera.level = None
    until(lambda: ann.levels[-1] < 30, what="a dark picture")
    camera.raw = b"\xff\xd8 no picture"
    until(lambda: "cannot be read" in media.broken)
    camera.raw, camera.level = b"", WHITE
    until(lambda: near(ann.levels[-1], WHITE), what="the picture again")
    assert media.broken == ""


def test_a_connection_that_is_closing_when_the_robot_ends_is_closed_whole(media, caller):
    connected(media, caller(), "ann")
    media.close("ann")
    media.stop()
    assert not media._peers
    assert not media._working


def test_an_offer_that_cannot_be_answered_ends_no_other_call(media, camera, caller):
    ann = caller()
    connected(media, ann, "ann")
    good = caller().offer()
    for n, bad in enumerate(("v=0\r\n", good.replace("a=ice-ufrag", "a=x"), good[: len(good) // 4], "\0" * 9000)):
        media.connect(f"bad{n}", "talk", bad)
        assert "cannot be answered" in until(lambda n=n: news(media, "refused", f"bad{n}"))
    until(lambda: set(media._peers) == {"ann"})
    seen = len(ann.levels)
    until(lambda: len(ann.levels) > seen + 3)


def test_a_simulated_robot_has_a_tone_and_one_without_a_row_is_silent(wording):
    assert len(tone()) == TONE_EVERY
    assert {len(packet) for packet in tone()} == {BYTES}
    assert Source("default", simulated=True).hears == "tone"
    assert Source("tone", simulated=False).hears == "tone"
    none = Source("", simulated=True)
    assert none.hears == "silence"
    wording(none.text)


@pytest.mark.parametrize(
    ("program", "hears", "told"),
    [
        ("#!/bin/sh\necho 'arecord: main:831: audio open error: No such file' >&2\nexit 1\n", "silence", "audio open error"),
        ("#!/bin/sh\nwhile head -c 1920 /dev/zero; do sleep 0.02; done\n", "microphone", "the microphone 'plughw:1'"),
        (None, "silence", "install alsa-utils"),
    ],
)  # fmt: skip
def test_a_microphone_is_told_as_it_is(tmp_path, monkeypatch, caller, program, hears, told):
    if program is not None:
        path = tmp_path / "arecord"
        path.write_text(program)
        path.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin" if program is not None else str(tmp_path))
    found = Media(lambda: None, "plughw:1", simulated=False)
    try:
        assert "has not begun" in found.sound
        ann = caller()
        connected(found, ann, "ann")
        until(lambda: told in found.sound and found.hears == hears)
        until(lambda: ann.sound, what="packets of sound, silent as they are")
    finally:
        found.stop()


def test_a_page_that_leaves_while_it_is_let_in_leaves_no_socket_open(media, caller):
    offer = caller().offer()
    before = descriptors()
    for n in range(8):
        media.connect(f"guest{n}", "talk", offer)
        media.close(f"guest{n}")
    until(lambda: not media._peers and not media._working and len(media.news) >= 8)
    until(lambda: descriptors() <= before, what="sockets closed")


def descriptors():
    return len(list(Path("/proc/self/fd").iterdir()))
