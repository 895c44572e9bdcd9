from typing import Any

import pytest

from lbr.capability.context import Received
from lbr.messages.motors import MotorsState
from lbr.operations.battery import KIND
from lbr.testing import FakeContext

AT_ONCE = '{"internal_ohm": 0, "idle_a": 0, "filter_s": 0, "repeat_s": 60}'


class GaugeContext(FakeContext):
    """The context of a battery whose motors say a voltage whenever they are asked."""

    def __init__(self) -> None:
        super().__init__(KIND, KIND.parse(AT_ONCE))
        self.voltage_v: float | None = None

    def take(self, port: str) -> list[Received]:
        assert port == "motors"
        if self.voltage_v is not None:
            state = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False, voltage_v=self.voltage_v)
            self.arrive(port, state)
        return super().take(port)


def told(ctx: FakeContext) -> list[tuple[str, str]]:
    """Return each event's kind and level."""
    return [(kind, level) for (kind, _), level in zip(ctx.events, ctx.levels, strict=True)]


class Running:
    def __init__(self) -> None:
        self.ctx = GaugeContext()
        self.battery = KIND.load()(self.ctx)
        self.battery.open()

    def at(self, voltage_v: float | None, for_s: float) -> Any:
        self.ctx.voltage_v = voltage_v
        for _ in range(round(for_s * 5)):
            self.ctx.now += 0.2
            self.battery.step()
        return self.ctx.published[-1][1]


@pytest.fixture
def running() -> Running:
    return Running()


def test_it_tells_at_least_once_a_second_and_only_what_it_knows(running):
    assert running.at(None, 2.0).valid is False
    assert "no voltage" in running.ctx.health[-1]
    assert running.at(12.5, 4.0).charge == pytest.approx(0.8)
    assert running.ctx.health[-1] == "ready"
    assert 6 <= len(running.ctx.published) <= 10


def test_a_low_battery_is_told_at_once_and_again_every_minute(running):
    running.at(12.5, 3.0)
    running.at(11.4, 30.0)
    assert told(running.ctx) == [("battery_low", "warning")]
    running.at(11.4, 40.0)
    assert told(running.ctx) == [("battery_low", "warning")] * 2
    assert [asked.message.phrase for asked in running.ctx.asked] == ["battery_low", "battery_low"]


def test_an_empty_battery_has_words_of_its_own(running):
    running.at(10.4, 3.0)
    assert [asked.message.phrase for asked in running.ctx.asked] == ["battery_critical"]


def test_a_charger_is_welcomed_once_a_minute_at_most(running):
    running.at(12.5, 10.0)
    for _ in range(2):
        running.at(13.5, 10.0)
        running.at(12.5, 10.0)
    assert told(running.ctx) == [("charging", "info")]
    running.at(12.5, 60.0)
    running.at(13.5, 10.0)
    assert len(running.ctx.events) == 2
