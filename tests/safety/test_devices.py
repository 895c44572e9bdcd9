"""Devices that are unplugged, deaf, dumb or frozen: what moves stops, what is said is true, nothing goes on by itself."""

from collections.abc import Callable

from tests.scenarios import devices
from tests.support.bench import Bench
from tests.support.figures import Results

Held = Callable[[Callable[[Bench], None]], Results]


def test_a_pulled_motor_cable_is_told_and_its_return_moves_nothing(held: Held):
    assert held(devices.motors_unplugged).of("S16").n == 1


def test_an_emergency_stop_is_called_done_only_once_the_device_has_said_so(held: Held):
    assert held(lambda under_test: under_test.once_it_moves(devices.motors_dumb)).of("E7").n == 1


def test_a_range_board_that_falls_silent_stops_the_way_ahead(held: Held):
    assert held(lambda under_test: devices.ranges_fail(under_test, "silent")).by_figure
