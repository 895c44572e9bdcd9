from itertools import pairwise
from types import SimpleNamespace

import pytest

from lbr.apps.dance.capability import TAKING_POWER
from lbr.apps.dance.kind import KIND
from lbr.apps.dance.messages import DanceCommand, DanceStep
from lbr.capability.context import Received
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.speech import PlayReply, SpeechState
from lbr.testing import FakeCall, FakeContext
from tests.apps.speech.speech_bench import wav_file
from tests.support.replies import dead

STEPS = (
    DanceStep(dance="to_and_fro", step=1, power=0.3, angle_deg=0.0, beats=1),
    DanceStep(dance="to_and_fro", step=2, power=0.3, angle_deg=180.0, beats=1),
    DanceStep(dance="to_and_fro", step=3, power=0.0, angle_deg=0.0, beats=1),
)
BEATS = "[0.5, 1.0, 1.5, 2.0, 2.5]"


class World(FakeContext):
    """The context of a dance: drive and speech on the other side of the bus, and time."""

    def __init__(self, home, **settings):
        super().__init__(KIND, KIND.settings(**settings), robot="lbr", name="dance", home=str(home), given=STEPS)
        self.refusal = ""
        self.wired = {"motion": ("drive",), "sound": ("speech",)}
        self.silent: set[str] = set()
        self.lease, self.dead = "", ""
        self.driven: list[tuple[float, float, float]] = []
        self.song = ""
        self.no_sound = ""

    def answer(self, request, message):
        if request in self.silent:
            return None
        if request in self.wired and not self.wired[request]:
            return {}
        return {"other": getattr(self, f"_{request}")(message)}

    def latest(self, port):
        state = SpeechState(speaking=False, text="", queued=0, spoken=0, failed=0, sink="", playing=self.song)
        return Received(state, None, self.now, "speech")

    def sources(self, port):
        return ("speech",)

    def _motion(self, message):
        if message.lease and message.lease != self.lease:
            return dead(self.dead, "stopped")
        if self.refusal:
            return CommandReply(accepted=False, reason=self.refusal, code="obstacle")
        self.lease = self.lease or "lease-1"
        self.driven.append((round(self.now - 100.0, 2), message.power, message.angle_deg))
        return CommandReply(accepted=True, lease=self.lease, ttl_s=0.3)

    def _halt(self, message):
        self.stop("dance")
        return CommandReply(accepted=True)

    def _sound(self, message):
        if self.no_sound:
            return PlayReply(accepted=False, reason=self.no_sound)
        self.song = message.song
        return PlayReply(accepted=True, began_s=self.now, duration_s=3.0)

    def _hush(self, message):
        if message.song == self.song:
            self.song = ""
        return CommandReply(accepted=True)

    def stop(self, who):
        self.lease, self.dead = "", f"stopped by {who}"

    @property
    def requests(self):
        return [asked.request for asked in self.asked]


@pytest.fixture
def world(tmp_path):
    wav_file(tmp_path / "music" / "tune.wav", 3.0)
    (tmp_path / "music" / "tune.json").write_text(f'{{"BEATS": {BEATS}}}')
    return World(tmp_path)


@pytest.fixture
def dance(world):
    dance = KIND.load()(world)
    dance.open()
    return dance


def play(capability, **command):
    call = FakeCall("dance", DanceCommand(**{"song": "tune", **command}))
    capability.command(call)
    return call


def run(dance, world, seconds):
    for _ in range(round(seconds / 0.02)):
        dance.step()
        world.now += 0.02


def changes(world):
    """What was driven, without repetitions: (since, power, angle)."""
    found = []
    for at, power, angle in world.driven:
        if not found or found[-1][1:] != (power, angle):
            found.append((at, power, angle))
    return found


def test_it_moves_at_each_beat_under_one_lease_and_stops_at_the_last(dance, world):
    call = play(dance)
    run(dance, world, 3.0)
    assert call.answer == CommandReply(accepted=True, reason="dances to_and_fro to tune")
    taken, rest, *moves = changes(world)
    assert (taken[1], rest[1]) == (TAKING_POWER, 0.0)
    expected = [(0.5, 0.3, 0.0), (1.0, 0.3, 180.0), (1.5, 0.0, 0.0), (2.0, 0.3, 0.0)]
    assert [move[1:] for move in moves] == [move[1:] for move in expected]
    assert [move[0] for move in moves] == pytest.approx([move[0] for move in expected], abs=0.05)
    assert [one.message.lease for one in world.asked if one.request == "motion"][1:] == ["lease-1"] * (
        len(world.driven) - 1
    )
    assert world.requests[-1] == "halt"
    assert world.said("state")[-1].phase == "ended"
    assert (world.said("state")[-1].beat, world.said("state")[-1].beats, world.said("state")[-1].moves) == (4, 5, 4)
    assert [kind for kind, _ in world.events] == ["dance_began", "dance_ended"]
    assert world.song == "tune"


def test_it_renews_at_ten_times_a_second(dance, world):
    play(dance)
    run(dance, world, 2.4)
    times = [at for at, _, _ in world.driven]
    assert max(late - early for early, late in pairwise(times)) < 0.13


def test_a_stop_of_the_base_ends_dance_and_song_also_before_the_first_beat(dance, world):
    play(dance)
    run(dance, world, 0.3)
    world.stop("console")
    world.driven.clear()
    run(dance, world, 2.0)
    assert world.driven == []
    assert world.said("state")[-1].reason == "stopped by console"
    assert world.song == ""
    assert "halt" not in world.requests  # whoever has the base now keeps it


def test_a_refused_move_ends_the_dance_and_stops_what_went_before(dance, world):
    play(dance)
    run(dance, world, 0.7)
    world.refusal = "back is 20 cm"
    run(dance, world, 0.5)
    assert (world.said("state")[-1].reason, world.said("state")[-1].code) == ("back is 20 cm", "obstacle")
    assert world.requests[-2:] == ["halt", "hush"]


def test_a_drive_that_falls_silent_ends_the_dance(dance, world):
    play(dance)
    run(dance, world, 0.7)
    world.silent.add("motion")
    run(dance, world, 1.0)
    assert "does not answer" in world.said("state")[-1].reason


@pytest.mark.parametrize(
    ("refusal", "wired", "why"),
    [("held by console", ("drive",), "held by console"), ("", (), "must be wired to one drive")],
)
def test_without_the_base_there_is_no_dance_and_no_song(dance, world, refusal, wired, why):
    world.refusal, world.wired["motion"] = refusal, wired
    call = play(dance)
    run(dance, world, 0.1)
    assert not call.answer.accepted
    assert why in call.answer.reason
    assert world.song == ""


def test_without_sound_it_dances_silently_and_says_so(dance, world):
    world.no_sound = "no sound card"
    call = play(dance)
    run(dance, world, 3.0)
    assert call.answer.reason == "dances to_and_fro to tune, without sound: no sound card"
    assert any(state.reason == "no sound card" for state in world.said("state") if state.phase == "dancing")
    assert world.said("state")[-1].reason == "danced to the end"


def test_speech_that_answers_too_late_is_hushed_with_the_dance(dance, world):
    world.ask_now = world.ask

    def ask(request, message, timeout_s, **_):
        asked = world.ask_now(request, message, timeout_s)
        return SimpleNamespace(answers=lambda: {"speech": None}) if request == "sound" else asked

    world.ask = ask
    play(dance)
    run(dance, world, 0.7)
    assert world.said("state")[-1].reason == "speech does not answer"
    assert world.song == "tune"
    world.stop("console")
    run(dance, world, 0.2)
    assert world.song == ""


def test_a_song_that_is_hushed_ends_the_dance(dance, world):
    play(dance)
    run(dance, world, 0.7)
    world.song = ""
    run(dance, world, 0.1)
    assert world.said("state")[-1].reason == "the song was ended"
    assert world.lease == ""


def test_speech_that_dies_ends_the_dance(dance, world):
    play(dance)
    run(dance, world, 0.7)
    world.gone.add("speech")
    run(dance, world, 0.1)
    assert "speech is gone" in world.said("state")[-1].reason
    assert world.lease == ""


def test_the_longest_dance_is_bounded(dance, world):
    world.settings = KIND.settings(max_s=1.0)
    play(dance)
    run(dance, world, 1.1)
    assert "max_s" in world.said("state")[-1].reason
    assert world.lease == ""


def test_its_own_stop_and_its_end_stop_the_base_and_the_song(dance, world):
    play(dance)
    run(dance, world, 0.7)
    call = FakeCall("stop", StopCommand(reason="enough"), source="tester")
    dance.command(call)
    assert call.answer.accepted
    assert world.said("state")[-1].reason == "stopped by tester: enough"
    assert world.requests[-2:] == ["halt", "hush"]
    play(dance)
    run(dance, world, 0.7)
    dance.close()
    assert world.lease == ""
    assert world.song == ""


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ({"song": "tunes"}, "did you mean tune?"),
        ({"song": "../tune"}, "letters, digits"),
        ({"song": "tune", "dance": "waltz"}, "no rows of a dance 'waltz'"),
    ],
)
def test_what_cannot_be_danced_is_refused_and_nothing_moves(dance, world, command, why):
    call = play(dance, **command)
    assert why in call.answer.reason
    run(dance, world, 0.2)
    assert world.asked == []


def test_one_dance_at_a_time(dance, world):
    play(dance)
    run(dance, world, 0.2)
    assert "'tune' is being danced to" in play(dance).answer.reason
    run(dance, world, 3.0)
    assert play(dance).answer is None


def test_the_metronome_is_there_for_whoever_has_no_music(dance, world):
    call = play(dance, song="metronome")
    run(dance, world, 0.2)
    assert call.answer.accepted
