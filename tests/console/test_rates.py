import threading

import pytest

from lbr.bus import probe, stamp, wire
from lbr.bus.probe import Arrival
from lbr.console.rates import measure
from lbr.messages.system import Stamp
from tests.support.waiting import until

MS = 1_000_000


def arrival(seq: int, sent_ms: float, *, late_ms: float = 1.0, source: str = "drive", boot: str = "b1") -> Arrival:
    sent_ns = int(sent_ms * MS)
    said = Stamp(source=source, seq=seq, mono_ns=sent_ns, wall_ns=0, boot=boot)
    return Arrival("rob/drive/state", wire.encode(said), 10, sent_ns + int(late_ms * MS))


def test_rate_loss_and_age_of_a_steady_stream():
    [rate] = measure([arrival(n, 20 * n) for n in range(1, 51)], 1.0, boot="b1")
    assert rate.publisher_hz == pytest.approx(50)
    assert (rate.received, rate.lost, rate.lost_percent) == (50, 0, 0)
    assert rate.period_p50_ms == pytest.approx(20)
    assert rate.age_p50_ms == pytest.approx(1)


def test_the_publishers_rate_is_true_when_the_reader_gets_every_tenth():
    [rate] = measure([arrival(n, 20 * n, late_ms=300) for n in range(1, 501, 10)], 10.0, boot="b1")
    assert rate.publisher_hz == pytest.approx(50)
    assert rate.received_hz == pytest.approx(5)
    assert rate.lost_percent == pytest.approx(90)
    assert rate.age_p99_ms == pytest.approx(300)


def test_a_restarted_publisher_is_measured_from_its_restart():
    before, after = [arrival(n, 20 * n) for n in range(90, 95)], [arrival(n, 5000 + 10 * n) for n in range(1, 9)]
    [rate] = measure([*before, *after], 1.0, boot="b1")
    assert rate.publisher_hz == pytest.approx(100)
    assert rate.lost == 0


def test_ages_from_another_machine_are_not_made_up():
    [rate] = measure([arrival(n, 20 * n, boot="other") for n in range(1, 5)], 1.0, boot="b1")
    assert rate.age_p50_ms is None
    assert rate.publisher_hz == pytest.approx(50)


def test_two_publishers_of_one_stream_are_told_apart_and_stampless_ones_counted():
    plain = Arrival("rob/drive/state", b"", 10, 0)
    rates = measure([arrival(1, 0), arrival(1, 5, source="motors"), plain], 1.0, boot="b1")
    assert [(rate.source, rate.received) for rate in rates] == [("drive", 1), ("motors", 1), ("unstamped", 1)]
    assert rates[2].publisher_hz is None


def test_a_reader_that_sleeps_on_the_job_still_tells_the_publishers_rate(robot, client):
    """The reader keeps 5 messages of many: what was published shows in the stamps, not in what was read."""
    heard = probe.Arrivals(client, "rob/drive/state", depth=5)
    publisher = wire.Publisher(robot.bus, "rob/drive/state", "drive")
    until(lambda: publisher.put({}) or heard.count)
    tick = threading.Event()
    while heard.count < 40:  # a busy machine loses some
        publisher.put({})
        tick.wait(0.01)
    arrivals = heard.take()
    assert len(arrivals) == 5
    first, last = stamp.read(arrivals[0].attachment), stamp.read(arrivals[-1].attachment)
    [rate] = measure(arrivals, 0.4)
    assert rate.publisher_hz == pytest.approx((last.seq - first.seq) / (last.mono_ns - first.mono_ns) * 1e9, rel=0.01)
    assert rate.publisher_hz < 100
    assert rate.age_p50_ms < 1000
