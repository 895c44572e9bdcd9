import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.sound import wav
from lbr.apps.sound.sinks import FILES_KEPT, sink_at
from lbr.errors import DeviceError, InputError
from tests.apps.speech.speech_bench import wav_file
from tests.support import needs
from tests.support.waiting import until

PLAYER = "#!/bin/sh\n{}\n"


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_a_wav_file_says_how_long_and_how_loud_it_is(tmp_path, width):
    loud = wav.read(wav_file(tmp_path / "loud.wav", 0.5, width=width, value=0x40))
    assert loud.duration_s == pytest.approx(0.5)
    assert wav.peak(loud.path) == pytest.approx(0.5, abs=0.01)
    silence = wav_file(tmp_path / "silent.wav", 0.1, width=width, value=128 if width == 1 else 0)
    assert wav.peak(silence) < wav.SILENT_PEAK


def test_a_header_that_promises_more_than_the_file_holds_is_not_believed(tmp_path):
    path = wav_file(tmp_path / "cut.wav", 1.0)
    path.write_bytes(path.read_bytes()[:844])
    assert wav.read(path).duration_s < 0.12


def test_what_is_no_wav_file_is_refused_by_name(tmp_path):
    for name, make in {"none.wav": None, "text.wav": b"hello", "empty.wav": b""}.items():
        if make is not None:
            (tmp_path / name).write_bytes(make)
        with pytest.raises(InputError, match=name):
            wav.read(tmp_path / name)
    with pytest.raises(InputError, match="is not a file"):
        wav.read(Path("/dev/zero"))
    with pytest.raises(InputError, match="holds no sound"):
        wav.read(wav_file(tmp_path / "short.wav", 0.0))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return wav_file(tmp_path_factory.mktemp("wav") / "whole.wav", 0.01, width=2)


@given(st.data())
def test_damaged_files_are_refused_or_read_and_nothing_else(whole, data):
    content = bytearray(whole.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, 60))] = data.draw(st.integers(0, 255))
    path = whole.with_name("damaged.wav")
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        sound = wav.read(path)
        wav.peak(path)
    except InputError:
        return
    assert 0.0 < sound.duration_s <= wav.LONGEST_S


def test_a_folder_gets_numbered_files_takes_the_time_of_playing_and_keeps_the_newest(tmp_path):
    sound = wav.read(wav_file(tmp_path / "a.wav", 0.05))
    now = [10.0]
    sink = sink_at(str(tmp_path / "speaker"), lambda: now[0])
    playback = sink.start(sound)
    assert playback.poll() is None
    now[0] += 0.06
    assert playback.poll() == ""
    for _ in range(FILES_KEPT + 5):
        sink.start(sound)
    files = sorted(path.name for path in (tmp_path / "speaker").iterdir())
    assert len(files) == FILES_KEPT
    assert files[-1] == f"{FILES_KEPT + 6:06}.wav"


def test_a_folder_that_cannot_be_is_an_error_with_its_name(tmp_path):
    (tmp_path / "file").write_text("")
    sound = wav.read(wav_file(tmp_path / "a.wav", 0.05))
    with pytest.raises(DeviceError, match=r"/file/speaker takes no sound"):
        sink_at(str(tmp_path / "file" / "speaker"), time.monotonic).start(sound)


@pytest.mark.parametrize("address", ["", "alsa:", "speaker", "/dev/snd:x"[5:]])
def test_an_address_that_is_no_place_for_sound_is_refused(address):
    with pytest.raises(DeviceError, match="no place for sound"):
        sink_at(address, time.monotonic)


@pytest.fixture
def aplay(tmp_path, monkeypatch):
    """A player of the test's own in the place of aplay; returns a function that says what it does."""
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")

    def write(script):
        (tmp_path / "aplay").write_text(PLAYER.format(script))
        (tmp_path / "aplay").chmod(0o755)
        return sink_at("alsa:plughw:1", time.monotonic)

    return write


def test_the_players_exit_code_and_words_decide_whether_it_was_heard(aplay, tmp_path):
    sound = wav.read(wav_file(tmp_path / "a.wav", 0.05))
    good = aplay('test "$*" = "-q -D plughw:1 ' + str(sound.path) + '"').start(sound)
    assert until(lambda: good.poll() is not None)
    assert good.poll() == ""
    bad = aplay("echo 'Unknown PCM plughw' >&2; exit 1").start(sound)
    assert until(lambda: bad.poll() is not None)
    assert "no sound at alsa:plughw:1 (Unknown PCM plughw)" in bad.poll()


def test_a_player_that_does_not_end_is_ended(aplay, tmp_path):
    sound = wav.read(wav_file(tmp_path / "a.wav", 0.05))
    now = [10.0]
    aplay("exec sleep 60")
    playback = sink_at("alsa:x", lambda: now[0]).start(sound)
    assert playback.poll() is None
    now[0] += 6.0
    assert "did not come to its end" in playback.poll()


def test_a_robot_without_a_player_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    sound = wav.read(wav_file(tmp_path / "a.wav", 0.05))
    with pytest.raises(DeviceError, match="apt install alsa-utils"):
        sink_at("alsa:default", time.monotonic).start(sound)


@needs.program("aplay", "alsa-utils")
def test_the_machines_own_aplay_is_believed(tmp_path):
    sound = wav.read(wav_file(tmp_path / "a.wav", 0.02))
    for device, heard in (("null", True), ("no_such_card", False)):
        playback = sink_at(f"alsa:{device}", time.monotonic).start(sound)
        result = until(lambda playing=playback: None if (found := playing.poll()) is None else (found,))
        assert (result[0] == "") is heard
