"""The running world of a humanoid as a driver and a bus client meet it: real ttys and sockets, real time."""

from math import radians

import pytest
import serial
from PIL import Image

from lbr.capability.context import Device
from lbr.simulation.humanoid import KIND
from lbr.simulation.humanoid.capability import HumanoidWorld
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.requests import PickUpRequest, PictureRequest, PlugRequest
from tests.simulation.humanoid_bench import rows
from tests.simulation.world_bench import Bench as WorldBench
from tests.simulation.world_bench import WorldContext
from tests.support.waiting import HANG_S

STEP_RAD = radians(300.0 / 1023.0)
LEFT_ARM = 4


class Bench(WorldBench):
    """The world of a Bioloid."""

    def __init__(self, folder, **settings):
        self.bus_path = folder / "servo_bus"
        devices = (
            Device("servo_bus", "dynamixel", str(self.bus_path), {}),
            Device("imu", "phidget_spatial", f"unix:{folder}/imu", {}),
            Device("ups", "pico", f"unix:{folder}/ups", {}),
        )
        ctx = WorldContext(HumanoidWorldSettings(**{"model": "bioloid", "hand_s": 0.2, **settings}), devices, kind=KIND)
        ctx.robot, ctx.home, ctx.given = "bioloid", str(folder), rows()[0]
        self._run(HumanoidWorld, ctx)

    @property
    def pose(self):
        return self.ctx.said("pose")[-1]


class Client:
    """A host of the bus, packet by packet as the manual has them."""

    def __init__(self, path):
        self.tty = serial.Serial(str(path), 1_000_000, timeout=HANG_S, exclusive=True)

    def write_all(self, address, values):
        """A sync write of two bytes to each servo; no answer."""
        data = bytes(byte for number, value in values.items() for byte in (number, value & 255, value >> 8))
        self._send(0xFE, 0x83, bytes([address, 2]) + data)

    def read(self, number, address):
        """Two bytes of a servo."""
        self._send(number, 0x02, bytes([address, 2]))
        header, _, length, _ = self.tty.read(2), self.tty.read(1), self.tty.read(1)[0], self.tty.read(1)
        assert header == b"\xff\xff"
        return int.from_bytes(self.tty.read(length - 1)[:2], "little")

    def _send(self, number, instruction, parameters):
        body = bytes([number, len(parameters) + 2, instruction]) + parameters
        self.tty.write(b"\xff\xff" + body + bytes([~sum(body) & 255]))


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path)
    made.world.open()
    yield made
    made.world.close()


@pytest.fixture
def servos(bench):
    client = Client(bench.bus_path)
    yield client
    client.tty.close()


def stand(bench, servos):
    goals = {joint.device_id: round(joint.zero_rad / STEP_RAD) + 512 for joint in rows()[0]}
    servos.write_all(30, goals)
    servos.write_all(24, dict.fromkeys(goals, 1))
    assert bench.until(lambda: not bench.pose.held)


def test_servos_with_torque_stand_it_up_and_positions_on_the_bus_follow_the_world(bench, servos):
    assert bench.until(lambda: bench.ctx.said("pose"))
    assert bench.pose.held
    stand(bench, servos)
    assert "let_go" in dict(bench.ctx.events)
    servos.write_all(30, {LEFT_ARM: 663})
    assert bench.until(lambda: bench.pose.joints["left_shoulder_roll"] > 0.7), "it counts the other way round"

    def world_raw():
        return 512 + (1.5708 - bench.pose.joints["left_shoulder_roll"]) / STEP_RAD

    assert bench.until(lambda: abs(servos.read(LEFT_ARM, 36) - world_raw()) < 2 and abs(world_raw() - 663) < 12)
    assert servos.read(LEFT_ARM, 42) & 255 == pytest.approx(bench.pose.supply_v * 10, abs=1.5)
    assert bench.pose.upright


def test_who_loses_all_torque_in_a_knees_bend_falls_is_told_of_and_picked_up(bench, servos):
    stand(bench, servos)
    bent = {"hip_pitch": 60, "knee": -160, "ankle_pitch": 20}
    goals = {
        joint.device_id: 512 + joint.sign * steps
        for joint in rows()[0]
        for name, steps in bent.items()
        if joint.name.endswith(name)
    }
    servos.write_all(30, goals)
    assert bench.until(lambda: any(kind == "fallen" for kind, _ in bench.ctx.events))
    servos.write_all(24, dict.fromkeys(range(1, 19), 0))
    call = bench.ask("pick_up", PickUpRequest())
    assert call.answer.accepted
    assert bench.until(lambda: bench.pose.held and bench.pose.upright)


def test_a_picture_shows_it_from_two_sides(bench, tmp_path):
    assert bench.until(lambda: bench.ctx.said("pose"))
    path = tmp_path / "it.png"
    call = bench.ask("picture", PictureRequest(path=str(path), width_px=600, height_px=400))
    assert bench.until(lambda: call.answer is not None)
    with Image.open(path) as picture:
        assert picture.size == (600, 400)
        paper = picture.getpixel((5, 40))
        halves = (picture.crop((0, 60, 300, 350)), picture.crop((300, 60, 600, 350)))
        for half in halves:
            drawn = sum(count for count, colour in half.getcolors(100_000) if colour != paper)
            assert 0.03 < drawn / (300 * 290) < 0.5


def test_no_second_servo_bus_is_plugged_in_while_it_stands(bench, tmp_path):
    bench.ctx.home = str(tmp_path)
    place = tmp_path / "run" / "bioloid-devices" / "arm"
    call = bench.ask("plug", PlugRequest(device="arm", type="dynamixel", address=str(place)))
    assert "'arm' moves what is in the world" in call.refused
    assert not place.exists()
