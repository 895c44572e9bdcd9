from typing import Any

import pytest

from lbr.capability.context import Received
from lbr.messages.motors import MotorsState
from lbr.messages.speech import SayCommand
from lbr.operations.battery import KIND

AT_ONCE = '{"internal_ohm": 0, "idle_a": 0, "filter_s": 0, "repeat_s": 60}'


class FakeContext:
    """The bus as lists; time goes on by steps."""

    def __init__(self) -> None:
        self.settings = KIND.parse(AT_ONCE)
        self.now = 1000.0
        self.voltage_v: float | None = None
        self.published: list[Any] = []
        self.events: list[tuple[str, str]] = []
        self.said: list[SayCommand] = []
        self.phase = ""

    def clock(self) -> float:
        return self.now

    def take(self, port: str) -> list[Received]:
        assert port == "motors"
        if self.voltage_v is None:
            return []
        state = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False, voltage_v=self.voltage_v)
        return [Received(state, None, self.now, "motors")]

    def publish(self, output: str, message: Any) -> None:
        self.published.append((output, message))

    def event(self, kind: str, text: str, *, level: str = "info") -> None:
        self.events.append((kind, level))

    def ask(self, request: str, message: SayCommand, timeout_s: float) -> None:
        assert request == "say"
        self.said.append(message)

    def ready(self) -> None:
        self.phase = "ready"

    def warn(self, reason: str) -> None:
        self.phase = reason


class Running:
    def __init__(self) -> None:
        self.ctx = FakeContext()
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


def test_it_tells_twice_a_second_and_only_what_it_knows(running):
    assert running.at(None, 2.0).valid is False
    assert "no voltage" in running.ctx.phase
    assert running.at(12.5, 4.0).charge == pytest.approx(0.8)
    assert running.ctx.phase == "ready"
    assert 9 <= len(running.ctx.published) <= 15


def test_a_low_battery_is_told_at_once_and_again_every_minute(running):
    running.at(12.5, 3.0)
    running.at(11.4, 30.0)
    assert running.ctx.events == [("battery_low", "warning")]
    running.at(11.4, 40.0)
    assert running.ctx.events == [("battery_low", "warning")] * 2
    assert [said.phrase for said in running.ctx.said] == ["battery_low", "battery_low"]


def test_an_empty_battery_has_words_of_its_own(running):
    running.at(10.4, 3.0)
    assert [said.phrase for said in running.ctx.said] == ["battery_critical"]


def test_a_charger_is_welcomed_once_a_minute_at_most(running):
    running.at(12.5, 10.0)
    for _ in range(2):
        running.at(13.5, 10.0)
        running.at(12.5, 10.0)
    assert running.ctx.events == [("charging", "info")]
    running.at(12.5, 60.0)
    running.at(13.5, 10.0)
    assert len(running.ctx.events) == 2
