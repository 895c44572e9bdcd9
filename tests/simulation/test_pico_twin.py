"""The emulated UPS PIco by its registers, and what its relay does to the servos of a body."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.simulation.devices.dynamixel.bus import DynamixelBus
from lbr.simulation.devices.dynamixel.servo import AxServo
from lbr.simulation.devices.pico import PicoFaults
from lbr.simulation.devices.pico.twin import ADDRESS, Pico, PicoTwin
from lbr.simulation.faults import changed
from lbr.simulation.i2c import Message, transfer
from lbr.simulation.measured import Sensed
from lbr.simulation.twins import PowerSwitch
from lbr.simulation.twins.base import Surroundings

COMMANDS = 0x6B


def read(pico, register, length=1, address=ADDRESS, now=1.0):
    messages = (Message(address, write=bytes((register,))), Message(address, read=length))
    answer = transfer(pico.on_bus(ADDRESS), messages, now)
    return answer[1:] if answer[0] == 0 else None


def write(pico, register, value, now=1.0):
    transfer(pico.on_bus(ADDRESS), (Message(COMMANDS, write=bytes((register, value))),), now)


def test_voltages_are_decimals_low_byte_first():
    pico = Pico(battery_v=4.05)
    pico.external_v = 10.7
    assert read(pico, 0x0C, 2) == b"\x70\x10"
    assert read(pico, 0x08, 2) == b"\x05\x04"
    assert read(pico, 0x1C) == b"\x33"


@pytest.mark.parametrize(("volts", "modes"), [((12.0, 6.9, 7.2, 7.6), (1, 2, 2, 1)), ((7.2, 0.0), (1, 2))])
def test_it_goes_over_to_its_battery_and_back(volts, modes):
    pico, seen = Pico(), []
    for one in volts:
        pico.external_v = one
        seen.append(read(pico, 0x00)[0])
    assert tuple(seen) == modes


def test_its_counter_counts_milliseconds_and_wraps():
    pico = Pico()
    assert read(pico, 0x22, 2, now=1.0) == (1000).to_bytes(2, "little")
    assert read(pico, 0x22, 2, now=65.537) == (1).to_bytes(2, "little")


def test_status_cannot_be_written_and_a_bus_without_supply_answers_nothing():
    pico = Pico()
    transfer(pico.on_bus(ADDRESS), (Message(ADDRESS, write=b"\x0c\x99\x99"),), 1.0)
    assert read(pico, 0x0C, 2) == b"\x00\x12"
    pico.faults = PicoFaults(brown_out=True)
    assert read(pico, 0x0C, 2) is None


def test_the_relay_outlasts_a_brown_out_and_the_timer_does_not():
    pico = Pico()
    write(pico, 0x0C, 1)
    write(pico, 0x05, 30)
    pico.faults = PicoFaults(brown_out=True)
    pico.faults = PicoFaults()
    assert read(pico, 0x0C, address=COMMANDS) == b"\x01"
    assert read(pico, 0x05, address=COMMANDS) == b"\xff"


def test_the_still_alive_timer_resets_the_computer_once_and_zero_at_once():
    pico = Pico()
    write(pico, 0x05, 30, now=1.0)
    pico.run(30.9)
    assert pico.resets == 0
    pico.run(31.0)
    pico.run(99.0)
    assert pico.resets == 1
    write(pico, 0x05, 0, now=100.0)
    assert pico.resets == 2


@given(st.binary(min_size=1, max_size=6), st.sampled_from([ADDRESS, COMMANDS]), st.integers(0, 40))
def test_whatever_is_written_and_read_it_answers(data, address, length):
    answer = transfer(
        Pico().on_bus(ADDRESS), (Message(address, write=data), Message(address, read=length)), Random(1).random()
    )
    assert len(answer) == length + 1


def test_what_feeds_it_can_be_set_while_it_runs():
    faults = changed(PicoFaults(), "external_v", "9.5")
    assert changed(faults, "source", "battery").external_v == 9.5
    assert changed(faults, "external_v", None).external_v is None
    with pytest.raises(InputError, match="source"):
        changed(faults, "source", "sun")


# -- in the world -----------------------------------------------------------------------------------------------------


def twin(tmp_path, **settings):
    device = Device("ups", "pico", f"unix:{tmp_path / 'ups'}", settings)
    return PicoTwin(device, Surroundings(seed=1, now=0.0, trace=None, cameras=None))


def test_it_tells_the_worlds_battery(tmp_path):
    ups = twin(tmp_path)
    ups.sense(Sensed(battery_v=11.3))
    ups.take_over()
    assert transfer(ups.devices(), (Message(ADDRESS, write=b"\x0c"), Message(ADDRESS, read=2)), 1.0) == b"\0\x30\x11"


@pytest.mark.parametrize("on", [0, 1])
def test_motors_have_power_at_first_and_by_the_relay(tmp_path, on):
    ups = twin(tmp_path, relay_on=on)
    assert isinstance(ups, PowerSwitch)
    assert ups.motors_on
    transfer(ups.devices(), (Message(COMMANDS, write=bytes((0x0C, 1 - on))),), 1.0)
    assert not ups.motors_on


def test_servos_without_power_are_limp_silent_and_begin_anew():
    bus = DynamixelBus([AxServo(1)])
    ping, torque_on = b"\xff\xff\x01\x02\x01\xfb", b"\xff\xff\x01\x04\x03\x18\x01\xde"

    def said(data, now):
        return bus.feed(data, now) + bus.poll(now + 0.02)

    assert said(torque_on, 1.0)
    assert bus.servos[0].drive().torque > 0.0
    bus.supplied = False
    assert not said(ping, 2.0)
    assert bus.servos[0].drive().torque == 0.0
    bus.supplied = True
    assert said(ping, 3.0)
    assert bus.servos[0].drive().torque == 0.0
