"""The driver against the emulated controller on a pty."""

import time

import msgspec
import pytest
from lbr_roboclaw.kind import KIND, RoboclawSettings

from lbr.testing import driver, wheels
from lbr.testing.device import plugged
from lbr.testing.driver import DriverBench

SETTINGS = '{"device": "motors", "guard_silence_ms": 250, "setpoint_valid_s": 0.25, "reply_timeout_s": 0.03}'
"""As patient as a row may be: the machine of this test may be busy."""


@pytest.fixture
def bench(tmp_path):
    with plugged("roboclaw", tmp_path, name="motors") as device:
        bench = DriverBench(KIND, SETTINGS, device, wired={"setpoint": ("drive",)}, name="motors", home=str(tmp_path))
        yield bench
        bench.close()


def state(bench):
    return bench.ctx.said("state")[-1]


@pytest.mark.parametrize("check", [*driver.CHECKS, *wheels.CHECKS])
def test_it_does_what_every_driver_has_to(check, bench):
    check(bench)


def test_what_it_measures_is_told_in_si_units(bench):
    bench.works()
    bench.until(lambda: state(bench).voltage_v == 12.6, "the battery")
    bench.until(lambda: state(bench).temperature_c == 28.1, "the temperature")
    bench.until(lambda: state(bench).counts_left == 0 and state(bench).amps_right_a == 0.0, "motors at rest")


@pytest.mark.parametrize(("fault", "name"), [("overheat", "overheat"), ("pressed", "emergency_stop")])
def test_with_a_fault_nothing_moves_and_it_is_named(bench, fault, name):
    bench.drives()
    bench.device.fault(fault)
    bench.until(lambda: name in state(bench).faults and not state(bench).armed, "it is told")
    assert bench.device.twin.wheels(time.monotonic()) == (0.0, 0.0)
    bench.device.fault(fault, value=False)
    bench.until(lambda: not state(bench).faults, "it is over")
    bench.drives()


def test_a_controller_that_restarts_gets_its_serial_timeout_again(bench):
    bench.drives()
    bench.device.twin._timeout_s = 0.0
    bench.until(lambda: any("lost its serial timeout" in str(error) for error in bench.errors), "it is noticed")
    bench.works()
    bench.until(lambda: bench.device.twin._timeout_s == 0.2, "it is set again")


def test_another_address_is_no_answer(tmp_path):
    with plugged("roboclaw", tmp_path, name="motors", settings={"address": 0x81}) as device:
        bench = DriverBench(KIND, SETTINGS, device, wired={"setpoint": ("drive",)}, name="motors")
        bench.until(lambda: bench.errors, "it is missed")
        assert "device 'motors'" in str(bench.errors[0])
        assert "address" in str(bench.errors[0])


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ('{"device": "m", "left": {"channel": 2}}', "left and right both use channel 2"),
        ('{"device": "m", "tolerated_faults": ["emergency_stop"]}', "emergency_stop"),
        ('{"device": "m", "watchdog_ms": 250}', "watchdog_ms"),
        ('{"device": "m", "address": 12}', "address"),
    ],
)
def test_a_row_that_cannot_be_is_refused_in_words(row, said):
    with pytest.raises(msgspec.ValidationError, match=said):
        msgspec.json.decode(row, type=RoboclawSettings)
