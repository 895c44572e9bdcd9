"""A leaf process's sessions under questions: real processes on a real router."""

import subprocess
import sys
from pathlib import Path

import zenoh

from lbr.bus import session
from tests.robot import until

QUESTIONS = 500
LEAF = """
import sys, time
from lbr.bus import session, wire
bus = session.open_client(sys.argv[1:])
stream = wire.Publisher(bus, "robot/drive/state", "drive")
worst_s, last = 0.0, time.monotonic()
stream.put({"text": "x" * 500})
print("ready", flush=True)
while True:
    stream.put({"text": "x" * 500, "worst_s": worst_s})
    time.sleep(0.02)
    worst_s, last = max(worst_s, time.monotonic() - last), time.monotonic()
"""


def test_many_questions_at_once_are_all_answered_and_do_not_hold_up_who_answers(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path / 'bus.sock'}"
    answers: list[bytes] = []

    def answered(reply: zenoh.Reply) -> None:
        answers.append(reply.ok.payload.to_bytes() if reply.ok is not None else b"")

    with session.open_router(session.Router(listen=(endpoint,))), session.open_client([endpoint]) as bus:
        leaf = subprocess.Popen(
            [sys.executable, "-c", LEAF, endpoint], stdout=subprocess.PIPE, env=session.leaf_environment()
        )
        try:
            assert leaf.stdout is not None
            assert leaf.stdout.readline() == b"ready\n"
            for _ in range(QUESTIONS):
                bus.get("robot/drive/state", zenoh.handlers.Callback(answered, indirect=False), timeout=4.0)
            until(lambda: len(answers) == QUESTIONS, what="every question is answered")
        finally:
            leaf.kill()
            leaf.communicate()
    assert all(b"text" in answer for answer in answers)
