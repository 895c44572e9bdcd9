import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.dance import metronome, songs
from lbr.apps.dance.choreography import Move, beat_at, choose
from lbr.apps.dance.messages import DanceStep
from lbr.apps.sound import wav
from lbr.errors import InputError
from tests.apps.speech.speech_bench import wav_file


@pytest.fixture
def music(tmp_path):
    wav_file(tmp_path / "tune.wav", 3.0)
    (tmp_path / "tune.json").write_text('{"BEATS": [0, 0.5, 1.25]}')
    return tmp_path


def test_a_song_is_its_sound_and_its_beats(music):
    song = songs.load(music, "tune")
    assert song.beats == (0.0, 0.5, 1.25)
    assert song.duration_s == pytest.approx(3.0)


@pytest.mark.parametrize(
    "text",
    [
        '{"BEATS": [0.5,\n 1.0,, 2]}',
        '{"beats": [1, 2]}',
        "[1, 2]",
        '{"BEATS": [1]}',
        '{"BEATS": [1, "2"]}',
        '{"BEATS": [1, true]}',
        '{"BEATS": [-1, 2]}',
        '{"BEATS": [1, NaN]}',
        '{"BEATS": [1, 1e999]}',
        '{"BEATS": [1, 2, 2]}',
        '{"BEATS": [1, 5]}',
        "\ufeff{}",
        "[" * 100_000,
        " " * 1_000_001,
    ],
)
def test_beats_that_are_wrong_are_refused_with_file_and_beat(music, text, wording):
    (music / "tune.json").write_text(text)
    with wording.of(InputError):
        songs.load(music, "tune")


def test_what_is_missing_is_named(music):
    with pytest.raises(InputError, match="did you mean tune"):
        songs.load(music, "tunes")
    (music / "tune.json").write_bytes(b'{"BEATS": [\xff]}')
    with pytest.raises(InputError, match=r"tune\.json: "):
        songs.load(music, "tune")
    (music / "tune.json").unlink()
    with pytest.raises(InputError, match=r"tune\.json is missing"):
        songs.load(music, "tune")
    (music / "tune.wav").write_text("la")
    (music / "tune.json").write_text("{}")
    with pytest.raises(InputError, match=r"tune\.wav is not a PCM WAV"):
        songs.load(music, "tune")
    with pytest.raises(InputError, match="letters, digits"):
        songs.load(music, "../tune")


NUMBERS = st.one_of(st.floats(), st.integers(), st.booleans(), st.none(), st.text(max_size=3))


@given(st.one_of(st.text(max_size=60), st.lists(NUMBERS, max_size=6).map(lambda beats: json.dumps({"BEATS": beats}))))
def test_whatever_stands_in_the_file_is_refused_or_beats_in_order(text):
    try:
        beats = songs.parse(text.encode("utf-8", "surrogatepass"), "x.json")
    except InputError as err:
        assert "x.json" in str(err)  # noqa: PT017 - both ends are right
        return
    assert len(beats) >= 2
    assert all(early < late for early, late in zip((-1.0, *beats), beats, strict=False))


def test_the_metronome_is_a_song_of_a_few_seconds_made_once(tmp_path):
    metronome.ensure(tmp_path)
    song = songs.load(tmp_path, metronome.NAME)
    assert len(song.beats) == metronome.BEATS
    assert wav.peak(tmp_path / "metronome.wav") > 0.5
    assert (tmp_path / "metronome.wav").stat().st_size < 150_000
    (tmp_path / "metronome.json").write_text('{"BEATS": [1, 2]}')
    metronome.ensure(tmp_path)
    assert songs.load(tmp_path, metronome.NAME).beats == (1.0, 2.0)


def rows(dance, *steps):
    return [DanceStep(dance=dance, step=n, power=p, angle_deg=a, beats=b) for n, p, a, b in steps]


def test_a_choreography_repeats_and_holds_moves_for_their_beats():
    steps = [*rows("waltz", (2, 0.3, 90.0, 2), (1, 0.2, 0.0, 1)), *rows("jive", (1, 0.5, 180.0, 1))]
    waltz = choose(steps, "waltz")
    assert [waltz.at(beat).angle_deg for beat in range(5)] == [0.0, 90.0, 90.0, 0.0, 90.0]
    assert choose(steps, "jive").at(7) == Move(0.5, 180.0)
    with pytest.raises(InputError, match=r"no rows of a dance 'walz'.*did you mean waltz"):
        choose(steps, "walz")


@pytest.mark.parametrize(("seconds", "beat"), [(-1, -1), (0.49, -1), (0.5, 0), (0.99, 0), (1.0, 1), (9.0, 1)])
def test_a_beat_lasts_until_the_next(seconds, beat):
    assert beat_at((0.5, 1.0), seconds) == beat
