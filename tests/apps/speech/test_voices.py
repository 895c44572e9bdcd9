import json
import shutil
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import msgspec
import pytest

from lbr.apps.sound import wav
from lbr.apps.speech import worker
from lbr.apps.speech.kind import KIND
from lbr.apps.speech.piper import Piper
from lbr.apps.speech.polly import Polly
from lbr.apps.speech.request import Cloud, Request
from lbr.apps.speech.text import voice_of
from lbr.apps.speech.worker import Worker
from lbr.errors import LbrError
from tests.support import needs
from tests.support.waiting import HANG_S, until

needs.modules("botocore")
SOUND = b"\x00\x20\x00\xe0" * 4000


@pytest.fixture
def cloud(monkeypatch):
    """A service at the wire, as Amazon's Polly answers; `mood` says how, `asked` what it was asked for."""
    for name, value in {
        "ROBOT_AWS_AK": "AKIDEXAMPLE",
        "ROBOT_AWS_SK": "secret",
        "AWS_EC2_METADATA_DISABLED": "true",
        "AWS_CONFIG_FILE": "/nowhere",
        "NO_PROXY": "127.0.0.1",
    }.items():
        monkeypatch.setenv(name, value)
    released = threading.Event()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            asked = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            server.asked.append((self.path, asked, self.headers["Authorization"]))
            if server.mood == "hang":
                released.wait(8.0)
            refused = server.mood == "refuse"
            body = b'{"message": "no such voice"}' if refused else b"" if server.mood == "mute" else SOUND
            self.send_response(400 if refused else 200)
            self.send_header("Content-Type", "application/json" if refused else "audio/pcm")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *args):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.mood, server.asked = "answer", []
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    yield server
    released.set()
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture
def wanted(tmp_path, cloud):
    """Return a function that makes a request to the service."""

    def make(text="Hello & good day", *, timeout_s=HANG_S, **more):
        where = Cloud(
            region="us-west-2",
            endpoint=f"http://127.0.0.1:{cloud.server_port}",
            timeout_s=timeout_s,
            cache=str(tmp_path / "cloud"),
        )
        usual = {"language": "en", "words_per_min": 150, "volume": 1.0, "voice": "polly/Kevin", "cloud": where}
        return Request(text=text, path=str(tmp_path / "out.wav"), models=str(tmp_path), **{**usual, **more})

    return make


def test_the_cloud_says_a_text_once_and_then_it_is_known(cloud, wanted, tmp_path):
    polly = Polly()
    polly.write(wanted())
    (path, asked, signed), *_ = cloud.asked
    assert path == "/v1/speech"
    assert asked["VoiceId"] == "Kevin"
    assert asked["Text"] == '<speak><prosody rate="100%">Hello &amp; good day</prosody></speak>'
    assert "AKIDEXAMPLE" in signed
    assert wav.read(tmp_path / "out.wav").duration_s == pytest.approx(0.5)
    loud = wav.peak(tmp_path / "out.wav")
    Polly().write(wanted(volume=0.5))
    assert wav.peak(tmp_path / "out.wav") == pytest.approx(loud / 2, rel=0.01)
    assert len(cloud.asked) == 1
    polly.write(wanted("Something else", words_per_min=75))
    assert 'rate="50%"' in cloud.asked[1][1]["Text"]


@pytest.mark.parametrize(
    ("mood", "why"), [("refuse", "no such voice"), ("mute", "without sound"), ("hang", "within 0.3 s")]
)
def test_a_cloud_that_does_not_say_it_is_left_alone_for_a_while(cloud, wanted, mood, why):
    now = [100.0]
    polly = Polly(lambda: now[0])
    polly.write(wanted("First, so that all is loaded"))
    cloud.mood = mood
    for _ in range(3):
        with pytest.raises(LbrError, match=why):
            polly.write(wanted(timeout_s=0.3 if mood == "hang" else HANG_S))
    asked = until(lambda: len(cloud.asked) == 2 and len(cloud.asked))
    assert asked == 2
    polly.write(wanted("First, so that all is loaded"))  # what is known is said all the same
    cloud.mood, now[0] = "answer", now[0] + 31.0
    polly.write(wanted())


def test_a_text_that_is_too_long_for_the_cloud_is_not_sent(cloud, wanted):
    with pytest.raises(LbrError, match="2500 characters at once"):
        Polly().write(wanted("a" * 2501))
    assert cloud.asked == []


def test_without_piper_or_its_voice_the_sentence_says_what_to_do(wanted):
    with pytest.raises(LbrError, match=r"pip install piper-tts|download it"):
        Piper().write(wanted(voice="piper/en_US-lessac-medium"))


@pytest.mark.parametrize(
    ("language", "voice"), [("en", "polly/Kevin"), ("en-gb", "polly/Kevin"), ("de-at", "espeak/de+f2"), ("fr", "")]
)
def test_a_language_has_the_voice_of_its_row_or_of_what_it_is_a_kind_of(language, voice):
    assert voice_of(language, {"en": "polly/Kevin", "de-at": "espeak/de+f2"}) == voice


@pytest.mark.parametrize(
    "wrong",
    [
        {"voices": {"en": "espeak/en; rm x"}},
        {"voices": {"en": "espeak/../../x"}},
        {"voices": {"en": "sh/-c"}},
        {"voices": {"$(x)": "espeak/en"}},
        {"pitch": 100},
        {"cloud_endpoint": "http://elsewhere.example"},
        {"cloud_endpoint": "file:///etc"},
    ],
)
def test_rows_name_voices_and_nothing_else(wrong):
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert({"device": "speaker", **wrong}, KIND.settings)


@pytest.fixture
def real(cloud):
    if not (shutil.which("espeak-ng") or needs.IN_CI):
        pytest.skip("espeak-ng is not installed here: sudo apt install espeak-ng")
    found = Worker(time.monotonic)
    until(lambda: (found.poll(), found.idle or found.trouble)[1])
    yield found
    found.close()


def said(found, request):
    found.write(request, HANG_S)
    return until(found.poll)


def test_the_engine_speaks_by_the_rows_voice_and_by_its_own_when_that_is_away(real, cloud, wanted, tmp_path):
    out, sounds = tmp_path / "out.wav", []
    for more in ({}, {"pitch": 90}, {"voice": "espeak/en-us+f3"}, {"voice": "espeak/de"}):
        answer = said(real, wanted("$(touch x); `id`", **{"voice": "", **more}))
        assert (answer.reason, answer.note) == ("", "")
        sounds.append(out.read_bytes())
    assert len(set(sounds)) == 4
    answer = said(real, wanted())
    assert (answer.reason, answer.note) == ("", "")
    assert wav.read(out).duration_s == pytest.approx(0.5)
    cloud.mood = "refuse"
    answer = said(real, wanted("But this it does not say"))
    assert answer.reason == ""
    assert "no such voice" in answer.note
    assert "espeak-ng speaks instead of polly/Kevin" in answer.note
    assert wav.peak(out) > wav.SILENT_PEAK
    assert "espeak-ng speaks instead of piper/x" in said(real, wanted(voice="piper/x")).note


def test_the_program_of_the_engine_is_not_named_by_any_row():
    assert worker.ENGINE[1:] == ("-P", "-m", "lbr.apps.speech.engine")
