"""The cloud's voices, Amazon Polly: with a time limit, and once for each text. Runs in the engine's process."""

import hashlib
import html
import os
import queue
import threading
import time
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lbr.apps.sound import wav
from lbr.apps.speech.request import Request
from lbr.capability.border import border
from lbr.errors import LbrError, told

INSTALL = "`pip install 'lbr[polly]'` brings what asks for them"
KEY, SECRET = "ROBOT_AWS_AK", "ROBOT_AWS_SK"
"""The environment variables of the key, named as in the first lbr; without them botocore uses its own sources."""
RATE_HZ = 16_000
MOST_CHARACTERS = 2500
"""The service accepts 3,000 characters at once, marks included."""
MOST_BYTES = RATE_HZ * 2 * 600
USUAL_WORDS_PER_MIN = 150
SLOWEST_PERCENT, FASTEST_PERCENT = 20, 200
KEPT = 500
RETRY_S = 30.0


class Polly:
    """Requests sound from the cloud. After a failure it makes no request for a while, so that no text waits in vain."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._again_at = 0.0
        self._why = ""
        self._client: object = None

    def write(self, request: Request) -> None:
        """Write the sound of a voice; raise LbrError if it does not come in time."""
        file = Path(request.cloud.cache) / f"{_digest(request)}.wav"
        if not file.is_file():
            self._fetch(request, file)
        try:
            file.touch()
            samples = array("h", wav.samples(file))
            if request.volume < 1.0:
                samples = array("h", (int(sample * request.volume) for sample in samples))
            wav.write(Path(request.path), samples.tobytes(), RATE_HZ, width=2)
        except (OSError, ValueError) as err:
            file.unlink(missing_ok=True)
            raise LbrError(f"an earlier answer of the cloud cannot be read ({err})") from err

    def _fetch(self, request: Request, file: Path) -> None:
        if len(request.text) > MOST_CHARACTERS:
            raise LbrError(f"the cloud takes {MOST_CHARACTERS} characters at once; this text has {len(request.text)}")
        if self._clock() < self._again_at:
            raise LbrError(self._why)
        ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=self._ask, args=(request, file, ended), name="cloud", daemon=True).start()
        try:
            why = ended.get(timeout=request.cloud.timeout_s)
        except queue.Empty:
            why = f"the cloud did not answer within {request.cloud.timeout_s:g} s"
        if why:
            self._why, self._again_at = why, self._clock() + RETRY_S
            raise LbrError(why)

    def _ask(self, request: Request, file: Path, ended: "queue.SimpleQueue[str]") -> None:
        """Store the cloud's sound, in a thread of its own: a late answer serves the next time."""

        def failed(err: Exception) -> None:
            lost = f"the cloud's voice '{request.name}' cannot be had ({told(err)})"
            lacking = f"the cloud's voices cannot be had; {INSTALL}"
            ended.put(str(err) if isinstance(err, LbrError) else lacking if isinstance(err, ImportError) else lost)

        with border(failed):  # then another voice speaks
            sound = self._synthesised(request)
            file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            wav.write(file, sound, RATE_HZ, width=2)
            _drop_oldest(file.parent)
            self._again_at = 0.0
            ended.put("")

    def _synthesised(self, request: Request) -> bytes:
        percent = round(100 * request.words_per_min / USUAL_WORDS_PER_MIN)
        rate = min(max(percent, SLOWEST_PERCENT), FASTEST_PERCENT)
        answer = self._connected(request).synthesize_speech(
            Engine="neural",
            VoiceId=request.name,
            OutputFormat="pcm",
            SampleRate=str(RATE_HZ),
            TextType="ssml",
            Text=f'<speak><prosody rate="{rate}%">{html.escape(request.text, quote=False)}</prosody></speak>',
        )
        sound: bytes = answer["AudioStream"].read(MOST_BYTES)
        if len(sound) < 2:
            raise LbrError("the cloud answered without sound")
        return sound[: len(sound) // 2 * 2]

    def _connected(self, request: Request) -> Any:
        if self._client is None:
            import botocore.session
            from botocore.config import Config

            limit_s = request.cloud.timeout_s
            self._client = botocore.session.get_session().create_client(
                "polly",
                region_name=request.cloud.region,
                endpoint_url=request.cloud.endpoint or None,
                aws_access_key_id=os.environ.get(KEY),
                aws_secret_access_key=os.environ.get(SECRET),
                config=Config(connect_timeout=limit_s, read_timeout=limit_s, retries={"total_max_attempts": 1}),
            )
        return self._client


def _digest(request: Request) -> str:
    said = (request.voice, str(request.words_per_min), request.text)
    return hashlib.sha256("\0".join(said).encode()).hexdigest()[:40]


def _drop_oldest(folder: Path) -> None:
    files = sorted(folder.glob("*.wav"), key=lambda path: path.stat().st_mtime)
    for path in files[:-KEPT]:
        path.unlink(missing_ok=True)
