"""Speech on a sound card of the kernel that hears what it plays: recorded, and told when there is no card."""

import array
import subprocess
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.usb import robots, vhci
from tests.support.usb.rig import until

CARDS = Path("/proc/asound/cards")
EDITS = ("UPDATE device SET address = 'alsa:plughw:Loopback,0' WHERE robot = 'lbr' AND name = 'speaker'",)
RECORDS = ("arecord", "-q", "-D", "plughw:Loopback,1", "-f", "S16_LE", "-r", "16000", "-c", "1", "-t", "raw")
HEARD_S = 0.4
"""A sentence of four words is longer than this."""
LOUD = 1000
"""Of 32,767: what a sound card that is silent never gives."""


@pytest.fixture(scope="module")
def card():
    if why := vhci.why_no_module("snd-aloop"):
        pytest.skip(why)
    until(lambda: "Loopback" in CARDS.read_text(), "a sound card", 60.0)


@pytest.fixture(scope="module")
def robot(card, service, place):
    with robots.running(service, place / "sound", "speech", edits=EDITS) as found:
        yield found


def test_what_it_says_can_be_recorded(robot, tmp_path, record_property):
    robots.ready(robot, "speech")
    path = tmp_path / "heard"
    with path.open("wb") as file:
        recorder = programs.start([*RECORDS], stdout=file, stderr=subprocess.PIPE)
    try:
        assert robot.say("/s/Good morning to everybody")["code"] == 0

        def loud_s():
            data = path.read_bytes()
            samples = array.array("h", data[: len(data) // 2 * 2])
            return sum(abs(one) > LOUD for one in samples) / 16_000

        until(lambda: loud_s() > HEARD_S, "a sentence", 120.0, every_s=1.0)
    finally:
        recorder.kill()
        recorder.communicate()
    record_property("loud for s", round(loud_s(), 2))


def test_a_card_that_is_not_there_is_told(service, place, record_property):
    edit = "UPDATE device SET address = 'alsa:plughw:Nowhere,0' WHERE robot = 'lbr' AND name = 'speaker'"
    with robots.running(service, place / "silent", "speech", edits=(edit,)) as robot:
        robot.say("/s/Can you hear me")
        _, reason = robots.degraded(robot, "speech")
        record_property("told", reason[:120])
        assert "Nowhere" in reason
