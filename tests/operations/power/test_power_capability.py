"""The power operation with a real logind thread: on a D-Bus of the test's own, or on none where nothing is to be asked."""

import select
import threading

import pytest
from msgspec.structs import replace

from lbr.capability.context import Device
from lbr.drivers.i2c import open_bus
from lbr.drivers.pico import KIND as PICO
from lbr.drivers.pico.supply import Supply
from lbr.messages.joints import PlayCommand, TorqueCommand
from lbr.operations.power.logind import meaning
from lbr.simulation.devices.pico.twin import PicoTwin
from lbr.simulation.twins.base import Surroundings
from tests.operations.power.power_bench import GOOD, LOW, TICK_S, Running
from tests.operations.power.private_bus import Logind, needs_dbus
from tests.support.waiting import HANG_S

EMULATED_LOW = replace(LOW, emulated=True)
EMULATED_GOOD = replace(GOOD, emulated=True)


def asking():
    return [thread for thread in threading.enumerate() if thread.name == "logind"]


@pytest.fixture(scope="module")
def bus(tmp_path_factory):
    logind = Logind(tmp_path_factory.mktemp("bus"))
    yield logind
    logind.finish()


@pytest.fixture
def logind(bus):
    bus.can, bus.power_off_error, bus.silent = "yes", "", False
    bus.calls.clear()
    return bus


@pytest.fixture
def make():
    made = []

    def make(**options):
        made.append(Running(**options))
        return made[-1]

    yield make
    for one in made:
        one.power.close()
    for thread in asking():
        thread.join(HANG_S)


# -- with logind ------------------------------------------------------------------------------------------------------


@needs_dbus
def test_a_falling_voltage_parks_the_robot_and_powers_off_exactly_once(make, logind):
    running = make(bus=logind.address)
    said = running.arm()
    running.go(1.0, GOOD)
    running.wait_for(lambda: said and running.state.can_power_off == "yes")
    assert said == ["armed: warns below 10.5 V, shuts down below 9.9 V"]
    volts = 11.0
    while volts > 9.3:
        running.go(1.0, replace(GOOD, external_v=volts))
        volts -= 0.2
    running.go(12.0, LOW)
    body = running.ctx.body
    assert running.state.phase in {"parking", "powering_off", "off"}
    running.go(3.0, LOW)
    running.wait_for(lambda: running.state.phase == "off")
    first, *renewals = body.asked("park")
    assert first == PlayCommand(motion="sit", take_over=True)
    assert len(renewals) >= 8
    assert all(one.lease == "lease-1" for one in renewals)
    assert body.asked("let_go") == [TorqueCommand(on=False, confirmed=True)]
    running.go(60.0, LOW)
    assert [call for call in logind.calls if call[0] == "PowerOff"] == [("PowerOff", [False])]
    assert running.state.phase == "off"
    assert [kind for kind in running.kinds() if kind.startswith("shut")] == [
        "shutdown_countdown", "shutdown_parking", "shutdown_now", "shutdown_agreed",
    ]  # fmt: skip


@needs_dbus
@pytest.mark.parametrize("said", ["no", "challenge", "na"])
def test_who_arms_is_told_when_the_computer_may_not_be_powered_off(make, logind, said):
    logind.can = said
    running = make(bus=logind.address)
    answers = running.arm()
    running.go(0.1, GOOD)
    running.wait_for(lambda: answers)
    assert meaning(said) in answers[0]
    assert ("power_off_denied", "warning") in [(kind, level) for kind, _, level in running.events]
    assert running.state.can_power_off == f"{said}: {meaning(said)}"
    assert running.ctx.health[-1] == meaning(said)
    if said != "na":
        assert "service install" in answers[0]


@needs_dbus
@pytest.mark.parametrize("error", ["InteractiveAuthorizationRequired", "AccessDenied"])
def test_a_denied_shutdown_is_told_with_what_to_install_and_tried_again(make, logind, error):
    logind.power_off_error = error
    running = make(bus=logind.address, calibration={"armed": 1.0})
    running.go(1.0, GOOD)
    running.go(18.0, LOW)
    running.wait_for(lambda: running.state.phase == "failed")
    assert "--power-off" in running.state.reason
    assert running.ctx.health[-1] == running.state.reason
    assert ("shutdown_failed", running.state.reason, "error") in running.events
    logind.power_off_error = ""
    running.go(32.0, LOW)
    running.wait_for(lambda: running.state.phase == "off")
    assert len([call for call in logind.calls if call[0] == "PowerOff"]) == 2


@needs_dbus
def test_a_logind_that_says_nothing_is_given_up_on(make, logind):
    logind.silent = True
    running = make(bus=logind.address, calibration={"armed": 1.0}, answer_s=0.2)
    running.go(0.1, GOOD)
    running.wait_for(lambda: "does not answer within" in running.state.can_power_off)
    running.go(18.0, LOW)
    running.wait_for(lambda: running.state.phase == "failed")


def test_no_d_bus_at_all_is_told(make, tmp_path):
    running = make(bus=f"unix:path={tmp_path / 'nothing'}", calibration={"armed": 1.0})
    running.go(0.1, GOOD)
    running.wait_for(lambda: "cannot be asked" in running.state.can_power_off)
    assert "power_off_denied" in running.kinds()


@pytest.fixture
def twin(tmp_path):
    """The emulated supply on its socket, served as the world does."""
    device = Device("ups", "pico", f"unix:{tmp_path / 'ups'}", {})
    twin = PicoTwin(device, Surroundings(seed=1, now=0.0, trace=None, cameras=None))
    ended = threading.Event()
    twin.clock = lambda: 0.0
    twin.service(0.0)

    def serve():
        while not ended.is_set():
            select.select([twin.watched()], [], [], 0.05)
            twin.service(twin.clock())

    thread = threading.Thread(target=serve)
    thread.start()
    yield twin, device
    ended.set()
    thread.join()
    twin.close()


@needs_dbus
def test_the_supplys_own_twin_brings_it_down_through_its_driver(make, logind, twin):
    """Twin, bytes, driver, decision, D-Bus: all but the two processes."""
    world, device = twin
    running = make(bus=logind.address, calibration={"armed": 1.0})
    world.clock = running.ctx.clock
    supply = Supply(*open_bus(device, 0x69), device, PICO.settings(device="ups"), running.ctx.clock)
    try:
        for volts, exchanges in ((12.0, 30), (11.0, 30), (9.7, 200)):
            world.fault("external_v", volts)
            for _ in range(exchanges):
                state = supply.exchange()
                if state is not None:
                    running.ctx.arrive("ups", state)
                running.step()
                running.step()
        running.wait_for(lambda: running.state.phase == "off")
    finally:
        supply.close()
    assert logind.calls.count(("PowerOff", [False])) == 1
    assert running.state.ups.external_v == 9.7


# -- without ----------------------------------------------------------------------------------------------------------


def test_an_emulated_supply_never_asks_the_computer_that_it_runs_on(make):
    running = make(calibration={"armed": 1.0})
    running.go(1.0, EMULATED_GOOD)
    assert running.state.can_power_off.startswith("not asked")
    running.go(18.0, EMULATED_LOW)
    assert running.state.phase == "off"
    assert "stays on" in running.state.reason
    assert len(running.ctx.body.asked("let_go")) == 1
    assert not asking()
    running.go(4.0, EMULATED_GOOD)
    assert running.state.phase == "watching"


def test_what_was_armed_is_kept_with_its_thresholds_over_a_restart(make):
    running = make()
    running.arm(warn_v=11.2, shutdown_v=10.8)
    assert running.ctx.calibration == {"armed": 1.0, "warn_v": 11.2, "shutdown_v": 10.8}
    running.go(6.0, replace(EMULATED_LOW, external_v=10.7))
    assert running.state.phase == "countdown"
    again = make(calibration=running.ctx.calibration)
    again.go(0.2, EMULATED_GOOD)
    assert (again.state.armed, again.state.warn_v, again.state.shutdown_v) == (True, 11.2, 10.8)
    again.go(18.0, replace(EMULATED_LOW, external_v=10.7))
    assert again.state.phase == "off"
    third = make(calibration=running.ctx.calibration)
    for one in (again, third):
        one.disarm()
        assert one.ctx.calibration["armed"] == 0.0


@pytest.mark.parametrize("kept", [{"shutdown_v": -3.0}, {"shutdown_v": 12.0}, {"warn_v": 101.0}])
def test_thresholds_that_somebody_spoilt_are_told_and_those_of_the_settings_hold(make, kept):
    running = make(calibration={"armed": 1.0, **kept})
    running.go(0.2, EMULATED_GOOD)
    assert (running.state.warn_v, running.state.shutdown_v) == (10.5, 9.9)
    assert running.kinds() == ["thresholds_unusable"]


def test_the_countdown_is_seen_said_and_can_be_cancelled(make):
    running = make(calibration={"armed": 1.0})
    running.go(1.0, EMULATED_GOOD)
    running.go(3.5, EMULATED_LOW)
    assert running.state.phase == "countdown"
    first = running.state.remaining_s
    assert running.go(2.0, EMULATED_LOW).remaining_s < first <= 10.0
    assert [message.text for message in running.ctx.body.asked("say")][-1].startswith("external supply 9.50 V")
    assert "cancelled" in running.cancel("I am charging it")[0]
    assert running.go(60.0, EMULATED_LOW).phase == "warning"
    assert running.ctx.body.asked("park") == []


def test_a_cancel_while_it_parks_halts_the_motion(make):
    running = make(calibration={"armed": 1.0})
    running.ctx.body.takes_s = 10.0
    running.go(18.0, EMULATED_LOW)
    assert running.state.phase == "parking"
    running.cancel()
    running.go(10.0, EMULATED_LOW)
    assert len(running.ctx.body.asked("halt")) == 1
    assert running.ctx.body.asked("let_go") == []
    assert running.state.phase == "warning"


def test_a_motion_that_takes_too_long_is_halted_and_the_joints_let_go(make):
    running = make(calibration={"armed": 1.0}, park_s=2.0)
    running.ctx.body.takes_s = 1e6
    running.go(22.0, EMULATED_LOW)
    assert running.state.phase == "off"
    assert len(running.ctx.body.asked("halt")) == 1
    assert len(running.ctx.body.asked("let_go")) == 1
    assert "not over within 2 s" in running.told("shutdown_now")


def test_a_refused_motion_does_not_keep_the_computer_on(make):
    running = make(calibration={"armed": 1.0})
    running.ctx.body.refuses = "torque on first"
    running.go(18.0, EMULATED_LOW)
    assert running.state.phase == "off"
    assert "torque on first" in running.told("shutdown_now")


def test_joints_held_a_moment_longer_are_let_go_at_the_next_try(make):
    running = make(calibration={"armed": 1.0})
    running.ctx.body.holds_joints = 3
    running.go(20.0, EMULATED_LOW)
    assert running.state.phase == "off"
    assert len(running.ctx.body.asked("let_go")) == 4


def test_a_robot_without_motions_powers_off_at_once(make):
    running = make(calibration={"armed": 1.0})
    running.ctx.wired = {}
    running.go(14.0, EMULATED_LOW)
    assert running.state.phase == "off"


def test_a_supply_that_is_gone_is_degraded_and_told_once(make):
    running = make(calibration={"armed": 1.0})
    running.go(2.0, EMULATED_GOOD)
    running.go(30.0, None)
    assert running.state.phase == "warning"
    assert "last read" in running.ctx.health[-1]
    assert running.kinds() == ["supply_unknown"]
    running.go(2.0, EMULATED_GOOD)
    assert running.ctx.health[-1] == "ready"


def test_the_state_is_told_every_second_and_at_every_change(make):
    running = make()
    running.go(10.0, EMULATED_GOOD)
    assert 10 <= len(running.ctx.published) <= 22
    before = len(running.ctx.published)
    running.arm()
    running.power.step()
    assert len(running.ctx.published) > before
    assert TICK_S <= 0.1
