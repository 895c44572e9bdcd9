import pytest

from lbr.apps.sound import wav
from lbr.apps.speech.kind import KIND
from lbr.apps.speech.worker import Worker
from lbr.errors import DeviceError
from lbr.messages.speech import HushCommand, SongCommand
from tests.apps.speech.speech_bench import Bench, SpeechContext, engine, wav_file
from tests.support import needs


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Return a function that opens speech; what it makes is closed after the test."""
    opened = []

    def make(*options, address="", wait=True, **settings):
        program = engine(tmp_path, *options)
        monkeypatch.setattr("lbr.apps.speech.capability.Worker", lambda clock: Worker(clock, program))
        found = Bench(SpeechContext(tmp_path / "home", address or str(tmp_path / "speaker"), **settings))
        found.speech.open()
        opened.append(found)
        if wait:
            found.until(lambda: found.ctx.health[-1] == "ready")
        return found

    yield make
    for found in opened:
        found.speech.close()


def scratch(found):
    return sorted(path.name for path in (found.home / "run" / "lbr-speech").glob("*.wav"))


def test_a_text_is_written_heard_and_counted_and_leaves_no_file(bench):
    found = bench()
    assert found.say("Hello/there").accepted
    found.until(lambda: found.state.spoken == 1)
    assert len(found.heard) == 1
    assert found.state.failed == 0
    assert not found.state.speaking
    assert scratch(found) == []


def test_texts_wait_for_one_another_in_their_order(bench):
    found = bench()
    assert found.say("one").reason == "says 'one'"
    assert found.say("two").reason == "says 'two' after 1 other"
    found.until(lambda: found.state.spoken == 2)
    texts = [state.text for state in found.ctx.said("state") if state.speaking]
    assert [text for index, text in enumerate(texts) if text not in texts[:index]] == ["one", "two"]


def test_the_queue_is_bounded_and_says_so(bench, wording):
    found = bench(queue=2)
    answers = [found.say("long") for _ in range(4)]
    assert [answer.accepted for answer in answers] == [True, True, False, False]
    wording(answers[2])


def test_an_interrupting_text_ends_what_is_said_and_what_waits(bench):
    found = bench()
    found.say("long one")
    found.until(lambda: found.state.speaking)
    found.say("never heard")
    assert found.say("now", interrupt=True).reason == "says 'now'; ended 'long one' and 1 more"
    found.until(lambda: found.state.spoken == 1)
    assert len(found.heard) == 2


def test_hush_ends_what_is_said_and_what_waits_and_leaves_nothing(bench):
    found = bench()
    found.say("long one")
    found.say("long two")
    found.until(lambda: found.state.speaking)
    assert found.ask(HushCommand()).accepted
    assert not found.state.speaking
    assert found.state.queued == 0
    found.until(lambda: found.speech._worker.idle)
    assert scratch(found) == []
    assert found.ask(HushCommand()).reason == "nothing was being spoken"


def test_what_is_still_being_saved_is_said_when_it_is_asked_for(bench):
    found = bench()
    assert found.say("Hello", save="note").accepted
    assert found.say("<note").accepted
    found.until(lambda: found.state.spoken == 1)
    assert [line for line in found.ctx.events if line[0] == "saved"]


def test_a_text_is_saved_and_played_by_its_name(bench):
    found = bench()
    assert found.say("Hello", save="Greeting-1").reason == "will be sounds/greeting-1.wav"
    found.until(lambda: ("saved", "'Hello' is sounds/greeting-1.wav") in found.ctx.events)
    assert found.heard == []
    assert found.say("<greeting-1").accepted
    found.until(lambda: found.state.spoken == 1)
    assert (found.home / "sounds" / "greeting-1.wav").exists()
    assert "did you mean greeting-1?" in found.say("<greting").reason


@pytest.mark.parametrize("name", ["../x", "a/b", ".x", "a b", "x" * 65])
def test_a_recording_has_no_other_place_than_its_folder(bench, name):
    found = bench()
    assert "letters, digits" in found.say("Hello", save=name).reason
    assert not found.say(f"<{name}").accepted


@pytest.mark.parametrize(
    "message",
    [
        {"text": "\U0001f600"},
        {"text": ""},
        {"text": "a" * 5001},
        {"phrase": "left"},
    ],
)
def test_what_cannot_be_said_is_refused_with_the_reason(bench, message, wording):
    answer = bench().say(**message)
    wording(answer)


@pytest.mark.parametrize(("text", "why"), [("lie", "cannot be read"), ("die", "died"), ("refuse", "no voice")])
def test_what_the_engine_fails_at_is_told_and_the_next_text_is_heard(bench, text, why):
    found = bench()
    found.say(text)
    found.say("and then")
    found.until(lambda: found.state.spoken == 1)
    assert found.state.failed == 1
    (kind, told), *_ = found.ctx.events
    assert kind == "speech_failed"
    assert why in told


def test_without_an_engine_it_is_degraded_and_refuses_but_recordings_are_heard(bench, wording):
    found = bench("none", wait=False)
    found.until(lambda: "no speech engine" in found.ctx.health[-1])
    wav_file(found.home / "sounds" / "ping.wav", 0.02)
    wording(found.say("Hello"), found.state.reason)
    assert found.say("<ping").accepted
    found.until(lambda: found.state.spoken == 1)


def test_without_a_sound_card_it_is_degraded_and_refuses_but_saves(bench, tmp_path, monkeypatch):
    (tmp_path / "bin").mkdir()
    player = tmp_path / "bin" / "aplay"
    player.write_text("#!/bin/sh\necho 'audio open error: No such file or directory' >&2\nexit 1\n")
    player.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}:/usr/bin:/bin")
    found = bench(address="alsa:default", wait=False)
    found.say("said before it was known")
    found.until(lambda: "audio open error" in found.ctx.health[-1] and "starting" not in found.ctx.health[-1])
    assert "no sound at alsa:default" in found.say("Hello").reason
    assert found.state.failed == 1
    assert found.say("Hello", save="kept").accepted
    found.until((found.home / "sounds" / "kept.wav").exists)
    player.write_text("#!/bin/sh\nexit 0\n")
    found.until(lambda: found.ctx.health[-1] == "ready")
    assert found.say("Hello").accepted
    found.until(lambda: found.state.spoken == 1)


def test_it_greets_once_when_it_can_be_heard_and_bids_farewell_at_its_end(bench):
    found = bench(greets=True, language="de")
    found.until(lambda: found.state.spoken == 1)
    assert next(state.text for state in found.ctx.said("state") if state.speaking) == "Guten Tag."
    found.until(lambda: found.speech._farewell is not None)
    found.speech.close()
    assert len(found.heard) == 2
    assert not (found.home / "run" / "lbr-speech").exists()


def test_a_song_is_played_at_once_and_says_when_it_began_and_the_rest_waits(bench):
    found = bench()
    wav_file(found.home / "music" / "tune.wav", 30.0)
    found.say("long")
    found.until(lambda: found.state.speaking)
    found.say("after it")
    before = found.ctx.clock()
    answer = found.ask(SongCommand(song="tune"))
    assert answer.accepted
    assert before <= answer.began_s <= found.ctx.clock()
    assert answer.duration_s == 30.0
    assert found.state.playing == "tune"
    assert not found.state.speaking
    assert "was not being played" in found.ask(HushCommand(song="other")).reason
    assert found.state.playing == "tune"
    found.ask(HushCommand(song="tune"))
    found.until(lambda: found.state.spoken == 1)


def test_a_song_that_is_not_there_or_no_song_is_refused(bench):
    found = bench()
    wav_file(found.home / "music" / "tune.wav", 1.0)
    (found.home / "music" / "text.wav").write_text("la la la")
    assert "did you mean tune?" in found.ask(SongCommand(song="tunes")).reason
    assert "is not a PCM WAV file" in found.ask(SongCommand(song="text")).reason
    assert "letters, digits" in found.ask(SongCommand(song="../music/tune")).reason


def test_an_address_that_is_no_speaker_and_a_missing_row_are_device_errors(tmp_path):
    speech = KIND.load()(SpeechContext(tmp_path, "nowhere"))
    with pytest.raises(DeviceError, match="no place for sound"):
        speech.open()
    speech.close()
    ctx = SpeechContext(tmp_path, "/nowhere")
    ctx.device = None
    with pytest.raises(DeviceError, match="no device row 'speaker'"):
        KIND.load()(ctx).open()


@needs.program("espeak-ng", "espeak-ng")
def test_the_real_engine_is_heard_in_the_simulated_speaker(tmp_path):
    found = Bench(SpeechContext(tmp_path / "home", str(tmp_path / "speaker")))
    found.speech.open()
    try:
        found.until(lambda: found.ctx.health[-1] == "ready")
        found.say("Well.")
        found.until(lambda: found.state.spoken)
        assert wav.peak(found.heard[0]) > wav.SILENT_PEAK
    finally:
        found.speech.close()


def test_another_voice_than_the_rows_is_told_until_it_is_the_rows_again(bench):
    found = bench()
    found.say("from elsewhere")
    found.until(lambda: found.ctx.health[-1] == "the cloud is away" and found.state.spoken == 1)
    assert found.say("Hello").accepted
    found.until(lambda: found.ctx.health[-1] == "ready")
    assert found.state.failed == 0
