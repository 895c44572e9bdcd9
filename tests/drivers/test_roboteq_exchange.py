from itertools import count

import pytest

from lbr.drivers.echoed_lines import query
from lbr.drivers.roboteq.exchange import Exchange
from lbr.drivers.roboteq.protocol import STOP

READS_AT_MOST = 200
NOISE = {
    "no line ends": b"\xff" * 64,
    "only line ends": b"\r" * 64,
    "junk lines": b"junk\r" * 12,
    "other answers": b"A=1:2\r" * 8,
    "signs": b"-\r+\r" * 16,
    "other echoes": b"!M 7 7\r+\r" * 6,
}


class BabblingLine:
    """Has always something to read; every read takes a millisecond."""

    def __init__(self, noise):
        self.now = 50.0
        self.noise = noise
        self.written = []
        self._reads = count()

    def clock(self):
        return self.now

    def read(self, wait_s=0.0):
        assert next(self._reads) < READS_AT_MOST, "reads without end"
        self.now += 0.001
        return self.noise

    def write(self, data):
        self.written.append(data)
        return len(data)


@pytest.fixture(params=NOISE.values(), ids=NOISE)
def line(request):
    return BabblingLine(request.param)


@pytest.fixture
def exchange(line):
    """With an echo, so that no sign counts without it."""
    exchange = Exchange(line, line.clock)
    noise, line.noise = line.noise, b"?V\rV=1:2:3\r"
    exchange.send(query("V"), 0.03)
    assert exchange.wait(0.03).result == "value"
    line.noise, line.now = noise, 100.0
    return exchange


def test_on_a_babbling_line_the_answer_is_lost_in_time(exchange, line):
    exchange.send(STOP, 0.03)
    assert exchange.wait(0.06).result == "lost"
    assert line.now - 100.0 < 0.035
    assert not exchange.busy


def test_on_a_babbling_line_a_wait_ends_with_its_budget(exchange, line):
    exchange.send(STOP, 0.03)
    assert exchange.wait(0.005) is None
    assert line.now - 100.0 < 0.01
    assert exchange.wait(0.0) is None
    assert exchange.busy


def test_finishing_gives_up_at_the_end_of_the_budget(exchange, line):
    exchange.send(STOP, 0.1)
    assert exchange.finish(0.03).result == "lost"
    assert line.now - 100.0 < 0.035
    exchange.send(STOP, 0.1)


def test_what_answers_nothing_is_counted_until_something_is_answered(exchange, line):
    exchange.send(STOP, 0.03)
    exchange.wait(0.06)
    assert exchange.babble_bytes >= 30 * len(line.noise)
    line.noise = STOP + b"+\r"
    exchange.send(STOP, 0.03)
    assert exchange.wait(0.03).result == "acknowledged"
    assert exchange.babble_bytes == 0
