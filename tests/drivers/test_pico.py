"""The UPS PIco's driver against its emulated supply, which was written from the same manual by other means."""

import errno
from functools import partial
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.drivers.i2c_socket import SocketBus
from lbr.drivers.pico import KIND, capability, registers, relay
from lbr.errors import DeviceError, MalformedError
from lbr.messages.power import RelayCommand
from lbr.simulation.devices.pico.twin import Pico as Chip
from lbr.simulation.i2c import Message, refusal, transfer
from lbr.testing import FakeCall
from tests.drivers.i2c_peer import MemoryBus, Server
from tests.drivers.peers import DriverContext

PACE_S = 0.1


# -- the numbers ----------------------------------------------------------------------------------------------------


def test_the_manuals_voltage_is_ten_volts_seventy():
    assert registers.volts(0x1070) == 10.70


def test_a_temperature_of_0x33_is_33_degrees_and_not_51():
    assert registers.celsius(0x33) == 33.0


@given(st.integers(0, 9999))
def test_decimals_come_out_as_they_went_in(number):
    assert registers.decimal(int(str(number), 16)) == number


@given(st.integers(0, 0xFFFF))
def test_a_nibble_above_nine_is_no_number(word):
    if any(word >> shift & 0xF > 9 for shift in (0, 4, 8, 12)):
        with pytest.raises(MalformedError, match="no decimal"):
            registers.volts(word)
    else:
        assert 0.0 <= registers.volts(word) <= 99.99


@pytest.mark.parametrize(("mode", "said"), [(1, "external"), (2, "battery"), (0x81, "external"), (0x82, "battery")])
def test_the_highest_bit_of_the_mode_says_nothing_of_the_source(mode, said):
    assert registers.source(mode) == said


@pytest.mark.parametrize("mode", [0, 3, 0x7F, 0xFF])
def test_any_other_mode_is_none(mode):
    with pytest.raises(MalformedError):
        registers.source(mode)


@pytest.mark.parametrize(
    ("volts", "letter", "charge"),
    [
        (3.4, "P", 0.0),
        (3.775, "S", 0.5),
        (4.15, "P", 1.0),
        (4.3, "P", 1.0),
        (3.0, "P", 0.0),
        (3.525, "Q", 0.5),
        (2.9, "F", 0.0),
    ],
)
def test_charge_is_by_chemistry_and_within_bounds(volts, letter, charge):
    assert registers.charge(volts, registers.chemistry(ord(letter))) == pytest.approx(charge)


# -- the driver and the emulated supply -----------------------------------------------------------------------------


class Bench(DriverContext):
    def __init__(self, settings, address):
        super().__init__(KIND, settings, address, "pico")

    def clock(self):
        return self.now


class Running:
    """The driver on a bus in memory to a chip whose time goes on with the test's."""

    def __init__(self, patch, path, **settings):
        self.chip, self.skip = Chip(), 0
        self.ctx = Bench(KIND.settings(device="ups", pace_s=PACE_S, **settings), f"unix:{path}")
        bus = MemoryBus(self.answer)
        patch.setattr(capability, "open_bus", lambda _device, address: (bus, address))
        self.log = bus.log
        self.ups = KIND.load()(self.ctx)
        self.ups.open()

    def faults(self, **faults):
        self.chip.faults = replace(self.chip.faults, **faults)

    def answer(self, messages):
        if self.skip:
            self.skip -= 1
            return refusal()
        told = [Message(a, read=part) if isinstance(part, int) else Message(a, write=part) for a, part in messages]
        return transfer(self.chip.on_bus(0x69), told, self.ctx.now)

    def step(self):
        self.ctx.now += PACE_S
        self.ups.step()

    def sweep(self):
        """Go on until it tells something new."""
        before = len(self.ctx.published)
        for _ in range(80):
            self.step()
            if len(self.ctx.published) > before:
                return self.ctx.state
        raise AssertionError("nothing was published")

    def sweep_often(self, steps):
        for _ in range(steps):
            self.step()

    def written(self, register):
        return [
            part[1]
            for log in self.log
            for a, part in log
            if a == 0x6B and part != 1 and part[:1] == bytes((register,)) and len(part) == 2
        ]


@pytest.fixture
def make(tmp_path, monkeypatch):
    return partial(Running, monkeypatch, tmp_path / "ups")


def command(running, *, on):
    said = []
    call = FakeCall("relay", RelayCommand(on=on))
    call.reply = lambda answer, **_: said.append("refused: " * (not answer.accepted) + answer.reason)
    running.ups.command(call)
    return said


def test_about_once_a_second_all_is_told_that_it_measures(make):
    running = make()
    running.chip.external_v, running.chip.battery_v = 10.7, 4.0
    began = running.ctx.now
    state = running.sweep()
    state = running.sweep()
    assert 1.5 < running.ctx.now - began < 2.5
    assert (state.valid, state.reason, state.source, state.emulated) == (True, "", "external", True)
    assert (state.external_v, state.battery_v, state.output_v) == (10.7, 4.0, 5.12)
    assert (state.charge, state.temperature_c, state.charging, state.relay) == (0.8, 33.0, True, False)
    assert state.firmware == "40, board 33, loader P"


def test_one_register_is_read_at_each_tick_so_that_the_supply_keeps_up(make):
    running = make()
    running.sweep()
    assert all(len([part for _, part in log if isinstance(part, int)]) <= 1 for log in running.log)
    steps = len(running.log)
    running.step()
    assert len(running.log) == steps + 1


def test_no_acknowledge_now_and_then_is_tried_again(make):
    running = make()
    for _ in range(6):
        running.skip = 3
        assert running.sweep().valid


def test_a_register_that_never_comes_is_no_number_and_named(make):
    running = make()
    running.faults(bad_bcd=True)
    state = running.sweep()
    assert not state.valid
    assert (state.external_v, state.battery_v, state.source) == (None, None, None)
    assert "external_v (register 0x0c) cannot be read" in state.reason
    assert "no decimal number" in state.reason
    assert state.code == "unreachable"
    assert running.ctx.health[-1] != "ready"
    running.faults(bad_bcd=False)
    assert running.sweep().valid
    assert running.ctx.health[-1] == "ready"


def test_a_temperature_that_is_no_number_leaves_the_voltages(make):
    running = make()
    running.chip.registers = lambda now, real=running.chip.registers: real(now) | {0x1C: 0xFF}
    state = running.sweep()
    assert state.valid
    assert state.external_v == 12.0
    assert state.temperature_c is None
    assert "temperature_c" in state.reason
    assert state.code == "stale_sensor"


def test_a_counter_that_stands_still_is_a_supply_that_hangs(make):
    running = make()
    running.sweep()
    running.faults(hung=True)
    running.sweep()
    state = running.sweep()
    assert not state.valid
    assert "hangs" in state.reason
    assert state.code == "stale_sensor"
    assert state.external_v is None


@pytest.mark.parametrize("start", [65.3, 130.6, 0.2])
def test_a_counter_that_wraps_hangs_not(make, start):
    running = make()
    running.ctx.now = start
    assert all(running.sweep().valid for _ in range(3))


def test_the_highest_bit_of_the_mode_does_not_hide_the_battery(make):
    running = make()
    running.faults(mode_bit_7=True, external_v=0.0)
    state = running.sweep()
    assert (state.valid, state.source, state.external_v) == (True, "battery", 0.0)


def test_a_supply_that_is_gone_is_a_device_error_and_comes_back(make):
    running = make()
    running.sweep()
    running.faults(brown_out=True)
    with pytest.raises(DeviceError, match=r"does not answer at 0x69"):
        running.sweep_often(20)
    running.ups.close()
    running.ups.degraded("gone")
    assert running.ctx.state.valid is False
    assert running.ctx.state.emulated
    running.faults(brown_out=False)
    running.ups.open()
    assert running.sweep().valid


def test_the_relay_is_switched_and_read_back(make):
    running = make()
    said = command(running, on=True)
    running.step()
    assert said == []
    running.step()
    assert said == ["the motors' power is on"]
    assert running.chip.relay == 1
    assert running.sweep().relay is True


def test_a_relay_wired_the_other_way(make):
    running = make(relay_on=0)
    command(running, on=True)
    running.step()
    running.step()
    assert running.chip.relay == 0
    assert running.sweep().relay is True
    command(running, on=False)
    running.step()
    running.step()
    assert running.chip.relay == 1


def test_a_relay_that_stays_is_told(make, wording):
    running = make()
    said = command(running, on=True)
    running.step()
    running.chip.relay = 0
    running.step()
    wording(*said)


def test_a_relay_that_nobody_answers_for_is_refused(make):
    running = make()
    said = command(running, on=True)
    running.skip = 4
    for _ in range(5):
        running.step()
    assert said[0].startswith("refused: the supply does not take it")


def test_closing_refuses_who_waits(make):
    running = make()
    said = command(running, on=True)
    running.ups.close()
    assert "closing" in said[0]


def test_the_still_alive_timer_is_left_alone_unless_asked_for(make):
    running = make()
    for _ in range(40):
        running.step()
    running.ups.close()
    assert running.written(0x05) == []


def test_the_still_alive_timer_is_fed_and_ends_with_the_driver(make):
    running = make(still_alive_s=20)
    for _ in range(700):
        running.step()
    assert running.chip.resets == 0
    assert len(running.written(0x05)) == 14
    running.ups.close()
    assert running.written(0x05)[-1] == 0xFF
    assert 0x00 not in running.written(0x05)


def test_a_computer_that_hangs_is_reset(make):
    running = make(still_alive_s=20)
    running.step()
    running.ctx.now += 21.0
    running.chip.run(running.ctx.now)
    assert running.chip.resets == 1


def test_a_still_alive_time_too_short_is_refused():
    with pytest.raises(ValueError, match="at least 20"):
        KIND.settings(device="ups", still_alive_s=5)


@given(st.lists(st.one_of(st.binary(min_size=2, max_size=2), st.none()), max_size=30))
def test_whatever_the_bus_gives_is_told_or_a_device_error(answers):
    """In process: a bus of arbitrary bytes and errors."""
    from lbr.capability.context import Device
    from lbr.drivers.pico.supply import Supply

    left = list(answers)

    def read(_address, _register):
        part = left.pop() if left else None
        if part is None:
            raise OSError(errno.EREMOTEIO, "no")
        return int.from_bytes(part, "little")

    bus = SimpleNamespace(read_word_data=read, read_byte_data=lambda a, r: read(a, r) & 0xFF, close=lambda: None)
    supply = Supply(bus, 0x69, Device("ups", "pico", "unix:/x", {}), KIND.settings(device="ups"), lambda: 0.0)
    try:
        for _ in range(40):
            state = supply.exchange()
            assert state is None or state.valid or state.reason
    except DeviceError:
        pass


# -- the program for systemd ----------------------------------------------------------------------------------------


@pytest.fixture
def wired(make, tmp_path, monkeypatch):
    """A supply on a wire, at whose other end a thread may be held up."""
    monkeypatch.setattr(SocketBus.__init__, "__defaults__", (None, 5.0))
    running = make()
    server = Server(tmp_path / "ups", running.answer)
    yield running
    server.finish()


def arguments(running, *words):
    return [*words, "--address", running.ctx.device.address, "--within-s", "0", "--settle-s", "0"]


def test_the_program_switches_and_shows(wired, capsys):
    assert relay.main(arguments(wired, "on")) == 0
    assert wired.chip.relay == 1
    assert relay.main(arguments(wired, "show")) == 0
    assert relay.main(arguments(wired, "off")) == 0
    assert wired.chip.relay == 0
    assert capsys.readouterr().out.splitlines() == [f"the motors' power is {word}" for word in ("on", "on", "off")]


def test_the_program_knows_the_other_wiring(wired):
    assert relay.main([*arguments(wired, "on"), "--on-is", "0"]) == 0
    assert wired.chip.relay == 0


def test_the_program_tries_again_for_a_while(wired):
    wired.skip = 2
    assert relay.main([*arguments(wired, "on"), "--within-s", "5"]) == 0


def test_the_program_fails_loudly(wired, capsys):
    wired.skip = 9
    assert relay.main(arguments(wired, "on")) == 1
    assert "could not be switched" in capsys.readouterr().err
    assert relay.main(["on", "--address", "nonsense"]) == 1
    assert "correct the device row" in capsys.readouterr().err


def test_the_bus_gives_words_low_byte_first(wired):
    bus = SocketBus(wired.ctx.device.address.removeprefix("unix:"))
    wired.chip.external_v = 10.7
    assert bus.read_word_data(0x69, registers.EXTERNAL) == 0x1070
    bus.close()
