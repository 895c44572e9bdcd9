import random
import sys
import time
from contextlib import suppress

import pytest

from lbr.apps.sound import formats, wav
from lbr.apps.sound.decode import decode
from lbr.apps.speech import decoder
from lbr.apps.speech.decoder import Decoder
from lbr.apps.speech.jobs import Job, Jobs
from lbr.apps.speech.worker import Worker
from lbr.errors import InputError
from lbr.messages.speech import HushCommand
from tests.apps.speech.speech_bench import Bench, SpeechContext, engine, wav_file
from tests.support import needs
from tests.support.waiting import until

needs.modules("av")
import av  # noqa: E402
import numpy as np  # noqa: E402

CODERS = {
    "mp3": ("libmp3lame", 44100), "flac": ("flac", 44100), "ogg": ("libopus", 48000), "opus": ("libopus", 48000),
    "m4a": ("aac", 44100), "mp4": ("aac", 44100), "webm": ("libopus", 48000), "aiff": ("pcm_s16be", 22050),
    "wav": ("adpcm_ima_wav", 22050),
}  # fmt: skip
CONTAINERS = {"m4a": "mp4"}
SECONDS = 0.5


def recorded(folder, suffix, name="jingle"):
    """Write half a second of a tone in a format."""
    coder, rate = CODERS[suffix]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.{suffix}"
    with av.open(str(path), "w", format=CONTAINERS.get(suffix, suffix)) as out:
        try:
            stream = out.add_stream(coder, rate=rate)
        except (av.error.FFmpegError, ValueError) as err:
            pytest.skip(f"this PyAV writes no {suffix}: {err}")
        stream.layout = "mono"
        tone = np.int16(8000 * np.sin(np.arange(int(rate * SECONDS)) * 2 * np.pi * 440 / rate))
        frame = av.AudioFrame.from_ndarray(tone.reshape(1, -1), format="s16", layout="mono")
        frame.rate = rate
        fitting = av.AudioResampler(
            format=stream.format.name, layout="mono", rate=rate, frame_size=stream.codec_context.frame_size or None
        )
        for piece in (*fitting.resample(frame), *fitting.resample(None)):
            out.mux(stream.encode(piece))
        out.mux(stream.encode(None))
    return path


@pytest.mark.parametrize("suffix", CODERS)
def test_a_recording_of_any_format_becomes_a_wav_file_as_long_and_loud(tmp_path, suffix):
    decode(recorded(tmp_path, suffix), tmp_path / "out.wav")
    assert wav.read(tmp_path / "out.wav").duration_s == pytest.approx(SECONDS, abs=0.15)
    assert wav.peak(tmp_path / "out.wav") == pytest.approx(8000 / 32768, rel=0.3)


def test_what_cannot_be_decoded_is_told_by_its_name(tmp_path):
    (tmp_path / "text.mp3").write_text("la la la " * 1000)
    (tmp_path / "empty.ogg").write_bytes(b"")
    for name in ("text.mp3", "empty.ogg", "none.flac"):
        with pytest.raises(InputError, match=name):
            decode(tmp_path / name, tmp_path / "out.wav")


def test_a_list_that_names_other_files_opens_none_of_them(tmp_path):
    other = recorded(tmp_path, "mp3", "other")
    (tmp_path / "list.mp3").write_text(
        f"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile://{other}\n#EXT-X-ENDLIST\n"
    )
    (tmp_path / "list.ogg").write_text(f"ffconcat version 1.0\nfile {other}\n")
    for name in ("list.mp3", "list.ogg"):
        with pytest.raises(InputError, match=name):
            decode(tmp_path / name, tmp_path / "out.wav")


@pytest.mark.parametrize("suffix", ["mp3", "ogg", "m4a"])
def test_damaged_recordings_are_decoded_as_far_as_they_go_or_refused_and_nothing_else(tmp_path, suffix):
    whole, chance = recorded(tmp_path, suffix).read_bytes(), random.Random(suffix)
    damaged = tmp_path / f"damaged.{suffix}"
    for _ in range(15):
        content = bytearray(whole)
        for _ in range(chance.randint(1, 8)):
            content[chance.randrange(len(content))] = chance.randrange(256)
        damaged.write_bytes(content[: chance.randint(0, len(content))])
        with suppress(InputError):  # anything else is a failure
            decode(damaged, tmp_path / "out.wav")


def test_without_the_library_the_sentence_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(formats, "LIBRARY", "av_that_is_not_there")
    with pytest.raises(InputError, match=r"jingle.mp3 .*pip install 'lbr\[recordings\]'"):
        decode(tmp_path / "jingle.mp3", tmp_path / "out.wav")


@pytest.fixture
def bench(tmp_path, monkeypatch):
    program = engine(tmp_path, "none")  # a robot without a voice plays recordings all the same
    monkeypatch.setattr("lbr.apps.speech.capability.Worker", lambda clock: Worker(clock, program))
    found = Bench(SpeechContext(tmp_path / "home", str(tmp_path / "speaker")))
    found.speech.open()
    yield found
    found.speech.close()


def test_speech_plays_recordings_by_name_whatever_their_format(bench):
    recorded(bench.home / "sounds", "mp3")
    wav_file(bench.home / "sounds" / "ping.wav", 0.02)
    assert bench.say("<jingle").accepted
    assert bench.say("<Ping").accepted
    bench.until(lambda: bench.state.spoken == 2)
    assert wav.read(bench.heard[0]).duration_s == pytest.approx(SECONDS, abs=0.15)  # in the order they were asked for
    assert "did you mean jingle" in bench.say("<jingl").reason
    assert list((bench.home / "run" / "lbr-speech").glob("decoded*")) == []


def test_speech_says_which_recording_cannot_be_decoded_and_goes_on(bench):
    (bench.home / "sounds").mkdir()
    (bench.home / "sounds" / "broken.mp3").write_text("la la la")
    wav_file(bench.home / "sounds" / "ping.wav", 0.02)
    bench.say("<broken")
    bench.say("<ping")
    bench.until(lambda: bench.state.spoken == 1)
    assert bench.state.failed == 1
    assert any("broken.mp3 cannot be decoded" in text for kind, text in bench.ctx.events if kind == "speech_failed")


def test_a_recording_that_is_hushed_is_decoded_no_further(bench):
    recorded(bench.home / "sounds", "mp3")
    bench.say("<jingle")
    bench.speech.step()
    assert bench.ask(HushCommand()).reason == "ended '<jingle'"
    bench.speech.step()
    assert bench.speech._decoder._popen is None
    assert bench.heard == []


def test_a_decoder_that_hangs_or_dies_costs_one_recording(tmp_path):
    now = [time.monotonic()]
    hang = (sys.executable, "-I", "-S", "-c", "import time; time.sleep(60)")
    die = (sys.executable, "-I", "-S", "-c", "import os; os.kill(os.getpid(), 9)")
    for program, why in ((hang, "was not decoded within 30 s"), (die, "the decoder died")):
        jobs = Jobs(4)
        jobs.add(Job(text="<a", source=tmp_path / "a.mp3"))
        found = Decoder(jobs, tmp_path, lambda: now[0], program)
        assert found.go_on() == []
        assert found.poll() == [] or program is die
        now[0] += decoder.LIMIT_S if program is hang else 0.0
        (_, said), *_ = until(found.poll) if jobs.to_decode() else [(None, why)]
        assert why in said
        assert jobs.to_decode() is None
        found.close()
