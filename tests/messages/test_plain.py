"""What senders say of themselves and of their reasons is one line of text, whatever they put there."""

import json

import pytest

from lbr.bus import stamp
from lbr.bus.codec import Decoder
from lbr.messages.leases import StopCommand
from lbr.messages.power import CancelCommand
from lbr.messages.system import EstopRequest

FORGED = "a ladder\r\nlbr: all is well\x1b[2J\u2028\u202eX\x00"


@pytest.mark.parametrize("message", [EstopRequest(engaged=True), StopCommand(), CancelCommand()])
def test_a_reason_cannot_forge_a_line_at_a_console(message):
    given = json.dumps({"engaged": True, "reason": FORGED}).encode()
    said = Decoder(type(message)).decode(given).reason
    assert said.startswith("a ladder  lbr: all is well")
    assert said.isprintable()


def test_nor_can_a_name():
    made = stamp.make("console", 1).replace(b'"console"', json.dumps(FORGED).encode())
    found = stamp.read(made)
    assert found is not None
    assert found.source.isprintable()
    assert stamp.read(stamp.passed_on(made, "lan")).source == found.source
