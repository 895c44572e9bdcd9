from typing import Any

import msgspec
import pytest

from lbr.apps.telemetry.kind import KIND
from lbr.apps.telemetry.package import is_complete, package
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.camera import CamerasState, CameraState
from lbr.messages.dock import DockSignal
from lbr.messages.imu import ImuSample
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges
from lbr.messages.telemetry import Telemetry
from lbr.testing import FakeContext

SIDES = {"forward_m": 0.67, "left_m": 0.18, "right_m": 0.55, "back_m": None, "bottom_m": None}
SAID: dict[str, Any] = {
    "ranges": Ranges(**SIDES, status={}, cycle_s=0.15, others_m={"bow": 0.4}),
    "imu": ImuSample(valid=True, time_s=99.0, gyro_rps=(0.0, 0.0, 0.1), accel_mps2=(0.0, 0.0, 9.8), temperature_c=28.4),
    "attitude": AttitudeState(valid=True, epoch="a", measured_s=98.0, heading_deg=315.0, orientation=(1.0, 0.0, 0.0, 0.0)),
    "motors": MotorsState(
        left=0.0, right=0.0, armed=True, reason="", estop=False, voltage_v=12.6, internal_v=13.5, output_v=4.73,
        amps_left_a=-5.1, amps_right_a=1.2, counts_left=130, counts_right=-260,
    ),
    "odometry": OdometryState(valid=True, epoch="a", distance_m=1.5),
    "battery": BatteryState(valid=True, voltage_v=12.6, charge=0.9, charging=False, source="battery", level="ok"),
    "dock": DockSignal(left=True, right=False, power=False),
    "cameras": CamerasState(
        selected="front", cameras={"front": CameraState(on=True, phase="streaming", device="/dev/video0")}
    ),
}  # fmt: skip


class Listener(FakeContext):
    """The context of telemetry: `hear` has ports say what they say."""

    def __init__(self) -> None:
        super().__init__(KIND, KIND.parse('{"rate_hz": 4}'))

    def hear(self, *ports: str) -> None:
        for port in ports:
            self.arrive(port, SAID[port])


@pytest.fixture
def ctx() -> Listener:
    return Listener()


def test_nothing_is_told_of_what_was_never_heard(ctx):
    made = package(ctx.latest, ctx.now, 1.7e9)
    assert made == Telemetry(time_s=1.7e9)


def test_every_source_has_its_part(ctx):
    ctx.hear(*KIND.inputs)
    made = msgspec.to_builtins(package(ctx.latest, ctx.now, 1.7e9))
    assert None not in made.values()
    assert made["ranges"] == SIDES | {"age_s": 0.0, "cycle_s": 0.15, "others_m": {"bow": 0.4}}
    assert (made["imu"]["heading_deg"], made["imu"]["gyro_rps"]) == (315.0, (0.0, 0.0, 0.1))
    assert made["amperages"] == {"age_s": 0.0, "left_a": -5.1, "right_a": 1.2}
    assert made["counts"] == {"age_s": 0.0, "left": 130, "right": -260, "distance_m": 1.5}
    assert made["voltages"] == {"age_s": 0.0, "battery_v": 12.6, "internal_v": 13.5, "output_v": 4.73}
    assert (made["battery"]["charge"], made["battery"]["source"]) == (0.9, "battery")
    assert made["dock_signal"] == {"age_s": 0.0, "left": True, "right": False, "power": False}
    assert made["cameras"]["cameras"]["front"] == {
        "device": "/dev/video0", "on": True, "phase": "streaming", "reason": "",
    }  # fmt: skip


@pytest.mark.parametrize("port", KIND.inputs)
def test_each_source_is_enough_for_its_own_part_or_none(ctx, port):
    ctx.hear(port)
    made = msgspec.to_builtins(package(ctx.latest, ctx.now, 1.7e9))
    heard = {name for name, part in made.items() if part is not None} - {"time_s", "complete"}
    parts = {
        "attitude": {"imu"},
        "motors": {"amperages", "counts", "voltages"},
        "dock": {"dock_signal"},
        "odometry": set(),
    }
    assert heard == parts.get(port, {port})


def test_a_part_ages_while_its_source_is_silent(ctx):
    ctx.hear("ranges", "imu")
    ctx.now += 2.0
    ctx.hear("ranges", "attitude")
    made = package(ctx.latest, ctx.now + 0.5, 1.7e9)
    assert made.ranges is not None
    assert made.imu is not None
    assert (made.ranges.age_s, made.imu.age_s) == (0.5, 2.5)
    assert made.ranges.forward_m == 0.67


def test_it_is_told_at_its_own_rate_whatever_arrives(ctx):
    telemetry = KIND.load()(ctx)
    assert (telemetry.rate_hz, telemetry.woken_by_streams) == (4.0, False)
    telemetry.open()
    for on_tick in (True, False, False, True):
        ctx.on_tick = on_tick
        telemetry.step()
    assert len(ctx.published) == 2


def test_a_package_is_complete_once_what_is_wired_has_told_what_clients_ask_for(ctx):
    ctx.hear(*KIND.inputs)
    wired = [*KIND.inputs]
    assert is_complete(ctx.latest, wired)
    for port, unknown in (
        ("attitude", msgspec.structs.replace(SAID["attitude"], heading_deg=None)),
        ("battery", BatteryState(valid=False)),
        ("motors", msgspec.structs.replace(SAID["motors"], amps_left_a=None)),
    ):
        ctx.arrive(port, unknown)
        assert not is_complete(ctx.latest, wired)
        assert is_complete(ctx.latest, [one for one in wired if one != port])
        ctx.hear(port)


def test_the_package_reads_as_the_message_it_is(ctx):
    ctx.hear(*KIND.inputs)
    made = package(ctx.latest, ctx.now, 1.7e9)
    assert msgspec.json.decode(msgspec.json.encode(made), type=Telemetry) == made


def test_the_compass_is_told_between_its_measurements_too_but_not_for_long(ctx):
    telemetry = KIND.load()(ctx)
    sample = SAID["imu"]
    seen = []
    for mag_ut, later_s in (((1.0, 2.0, 3.0), 0.0), (None, 0.2), (None, 0.2), (None, 0.2)):
        ctx.now += later_s
        ctx.arrive("imu", msgspec.structs.replace(sample, mag_ut=mag_ut))
        telemetry.step()
        assert ctx.said("package")[-1].imu is not None
        seen.append(ctx.said("package")[-1].imu.mag_ut)
    assert seen == [(1.0, 2.0, 3.0)] * 3 + [None]
