import os
import shutil
import signal
import time

import pytest
import pyttsx3
from pyttsx3.drivers import _espeak

from lbr.apps.sound import wav
from lbr.apps.speech import worker
from lbr.apps.speech.engine import Engine
from lbr.apps.speech.request import Request
from lbr.apps.speech.worker import Worker
from tests.apps.speech.speech_bench import engine
from tests.support import needs
from tests.support.waiting import HANG_S, until


def request(path, text="Hello, I am well.", language="en"):
    return Request(text=text, language=language, words_per_min=150, volume=1.0, path=str(path))


@pytest.fixture
def started(tmp_path):
    workers = []

    def start(*options, program=None):
        workers.append(Worker(time.monotonic, program or engine(tmp_path, *options)))
        return workers[-1]

    yield start
    for each in workers:
        each.close()


def ready(found):
    until(lambda: (found.poll(), found.idle or found.trouble)[1])
    return found


def outcome(found, asked, limit_s=HANG_S):
    found.write(asked, limit_s)
    return until(found.poll).reason


@pytest.fixture(scope="module")
def real():
    if not (shutil.which("espeak-ng") or needs.IN_CI):
        pytest.skip("espeak-ng is not installed here: sudo apt install espeak-ng")
    found = ready(Worker(time.monotonic))
    yield found
    found.close()


def test_the_engine_writes_sound_again_and_again_each_text_to_its_own_file(real, tmp_path):
    assert real.trouble == ""
    sizes = []
    for index, text in enumerate(("Hello, I am well.", "Yes", "[[not]] a <tag/> $(touch x)")):
        path = tmp_path / f"{index}.wav"
        assert outcome(real, request(path, text)) == ""
        assert wav.peak(path) > wav.SILENT_PEAK
        sizes.append(wav.read(path).duration_s)
    assert sizes[0] > sizes[1]


def test_the_engine_says_what_it_has_no_voice_for(real, tmp_path):
    assert outcome(real, request(tmp_path / "a.wav", language="en-gb-nowhere")) == ""  # English at least
    assert "no voice for 'xq'" in outcome(real, request(tmp_path / "b.wav", language="xq"))
    assert outcome(real, request(tmp_path / "c.wav")) == ""


def test_silence_is_a_failure(real, tmp_path):
    assert "no sound for this text" in outcome(real, request(tmp_path / "a.wav", "..."))


def test_a_text_that_came_out_silent_once_is_written_again(monkeypatch, tmp_path, real):
    assert real.idle
    made = pyttsx3.init()
    texts = ["..."]
    monkeypatch.setattr(pyttsx3, "init", lambda: made)
    write = made.save_to_file
    monkeypatch.setattr(made, "save_to_file", lambda text, path: write(texts.pop() if texts else text, path))
    Engine().write(request(tmp_path / "a.wav"))
    assert wav.peak(tmp_path / "a.wav") > wav.SILENT_PEAK


def test_a_text_that_begins_while_the_last_one_is_not_quite_over_is_written_all_the_same(monkeypatch, tmp_path, real):
    assert real.idle
    made = pyttsx3.init()
    monkeypatch.setattr(pyttsx3, "init", lambda: made)
    playing = [True]
    monkeypatch.setattr(_espeak, "IsPlaying", lambda: bool(playing) and playing.pop())
    Engine().write(request(tmp_path / "a.wav", "Hello, I am well. " * 99))
    assert playing == []
    assert wav.peak(tmp_path / "a.wav") > wav.SILENT_PEAK


def test_a_file_that_cannot_be_written_ends_in_time_and_the_next_text_is_written(started, tmp_path, real):
    found = ready(started(program=worker.ENGINE))
    assert outcome(found, request(tmp_path / "no" / "folder.wav"), 0.5)
    assert outcome(ready(found), request(tmp_path / "a.wav")) == ""


def test_a_robot_without_an_engine_says_so_and_tries_again_later(started, wording):
    found = ready(started("none"))
    wording(found.trouble)
    assert not found.idle


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("die", "died (signal 9)"),
        ("hang", "did not come to an end"),
        ("babble", "an unreadable answer"),
        ("refuse", "voice"),
    ],
)
def test_a_text_that_breaks_the_engine_fails_and_the_next_one_does_not(started, tmp_path, text, why):
    found = ready(started())
    assert why in outcome(found, request(tmp_path / "a.wav", text), 0.3 if text == "hang" else HANG_S)
    assert found.trouble == ""
    assert outcome(ready(found), request(tmp_path / "b.wav")) == ""


def test_an_engine_killed_while_it_waits_is_started_again(started, tmp_path):
    found = ready(started())
    os.kill(found._popen.pid, signal.SIGKILL)
    until(lambda: (found.poll(), found.trouble)[1])
    found._retry_at = 0.0
    until(lambda: (found.poll(), found.idle)[1])
    assert outcome(found, request(tmp_path / "a.wav")) == ""
    assert found.trouble == ""


def test_an_engine_without_a_text_for_ten_seconds_is_ended_and_the_next_text_starts_another(tmp_path):
    now = [100.0]
    found = Worker(lambda: now[0], engine(tmp_path))
    ready(found)
    assert outcome(found, request(tmp_path / "a.wav")) == ""
    now[0] += 9.0
    found.poll()
    assert found._popen is not None
    now[0] += 2.0
    found.poll()
    assert (found._popen, found.idle, found.started, found.trouble) == (None, True, True, "")
    assert outcome(found, request(tmp_path / "b.wav")) == ""
    assert wav.read(tmp_path / "b.wav").duration_s > 0.0
    now[0] += 11.0
    found.poll()
    assert "died (signal 9)" in outcome(found, request(tmp_path / "c.wav", "die"))
    assert outcome(ready(found), request(tmp_path / "d.wav")) == ""
    found.close()


def test_an_engine_that_never_answers_at_its_start_is_trouble(started, monkeypatch):
    monkeypatch.setattr(worker, "START_S", 0.2)
    found = ready(started("mute"))
    assert "its start" in found.trouble
