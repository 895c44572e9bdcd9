"""A computer that sleeps: the monotonic clock stands still, the other goes on; who reads both may be held up in between."""

from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability import suspended
from lbr.capability.loop import Loop
from lbr.capability.suspended import LEAST_S, Suspended

held_up = st.floats(0.0, 30.0)


class Clocks:
    """Both clocks: `held_up` is for how long each reading takes, `slept` what the monotonic one does not count."""

    def __init__(self) -> None:
        self.now, self.slept, self.held_up = 1000.0, 0.0, iter(())

    def monotonic(self) -> float:
        self.now += next(self.held_up, 0.0)
        return self.now

    def clock_gettime(self, which: int) -> float:
        assert which == suspended.time.CLOCK_BOOTTIME
        self.now += next(self.held_up, 0.0)
        return self.now + self.slept

    CLOCK_BOOTTIME = suspended.time.CLOCK_BOOTTIME


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> Clocks:
    found = Clocks()
    monkeypatch.setattr(suspended, "time", found)
    return found


def test_a_sleep_is_told_once_with_its_length(clocks: Clocks) -> None:
    under_test = Suspended()
    assert under_test.for_s() == 0.0
    clocks.slept += 3600.0
    assert under_test.for_s() == pytest.approx(3600.0)
    assert under_test.for_s() == 0.0


@given(st.lists(st.lists(held_up, max_size=3), max_size=6), st.floats(LEAST_S + 0.01, 1e6))
def test_who_is_held_up_between_two_readings_has_not_slept_and_who_slept_is_found_out(
    rounds: list[list[float]], slept_s: float
) -> None:
    clocks = Clocks()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(suspended, "time", clocks)
        under_test = Suspended()
        for one in rounds:
            clocks.held_up = iter(one)
            assert under_test.for_s() == 0.0
        clocks.held_up, clocks.slept = iter(()), slept_s
        assert under_test.for_s() == pytest.approx(slept_s)


def test_the_clocks_of_this_computer_agree_while_it_is_awake() -> None:
    under_test = Suspended()
    assert all(under_test.for_s() == 0.0 for _ in range(1000))


def test_a_capability_hears_of_it_before_it_steps(clocks: Clocks) -> None:
    heard: list[Any] = []

    class Mover:
        def woke(self, slept_s: float) -> None:
            heard.append(round(slept_s))

        def step(self) -> None:
            heard.append("step")

    class Context:
        on_tick = False

        def calls(self) -> tuple[()]:
            return ()

        def counts(self) -> dict[str, int]:
            return {}

    class Reporter:
        def beat(self, _counts: dict[str, int]) -> None:
            pass

    process: Any = Loop(cast("Any", None), cast("Any", Reporter()))
    process._round(Context(), Mover())
    clocks.slept += 60.0
    process._round(Context(), Mover())
    assert heard == ["step", 60, "step"]
