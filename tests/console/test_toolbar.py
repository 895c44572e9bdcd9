import msgspec
import pytest

from lbr.console.operator import Telemetry
from lbr.console.toolbar import toolbar
from lbr.messages.drive import DriveState
from lbr.messages.motors import MotorsState
from lbr.messages.sensing import Ranges
from lbr.messages.system import CapabilityStatus, EstopState, Status

STANDING = {
    "moving": False, "power": 0.0, "angle_deg": 0.0, "left": 0.0, "right": 0.0, "holder": None, "goal": None,
    "limited_by": "", "reason": "", "estop": False, "loop": None,
}  # fmt: skip


def status(*, estop: bool = False, phase: str = "ready", ready: bool = True) -> Status:
    unit = CapabilityStatus(
        name="motors", kind="roboteq", phase=phase, pid=1, restarts=0, uptime_s=1.0, reason="", rates_hz={}
    )
    return Status(
        robot="rob", profile="t", ready=ready, pid=1, uptime_s=1.0, capabilities=(unit,),
        estop=EstopState(engaged=estop, reason="a hand in the way" if estop else ""),
        degraded={"motors": phase} if phase in {"degraded", "stopped"} else {},
    )  # fmt: skip


def text(telemetry: Telemetry, columns: int = 1000) -> str:
    return "".join(piece for _, piece in toolbar("rob", telemetry, None, {}, columns))


@pytest.mark.parametrize(
    ("telemetry", "said"),
    [
        (Telemetry(status=status()), "ready"),
        (Telemetry(status=status(estop=True)), "E-STOP: a hand in the way"),
        (Telemetry(status=status(phase="degraded")), "degraded: motors"),
        (Telemetry(status=status(phase="stopped")), "degraded: motors"),
        (Telemetry(status=status(phase="failed")), "failed: motors"),
        (Telemetry(status=status(ready=False)), "starting"),
        (Telemetry(), "listening"),
        (Telemetry(status=status(), status_age_s=7.0), "NO CONTACT for 7 s"),
        (Telemetry(status=status(), status_age_s=float("nan")), "NO CONTACT"),
    ],
)
def test_the_state_is_said_in_words(telemetry, said):
    assert text(telemetry).split(" | ")[1].startswith(said)


def test_power_volts_and_the_nearest_range_are_shown_and_unknown_ones_left_out():
    motors = MotorsState(left=0.2, right=-0.2, armed=True, reason="", estop=False, voltage_v=12.34)
    ranges = Ranges(forward_m=1.0, back_m=None, left_m=0.45, right_m=2.0, bottom_m=None, status={})
    bar = text(Telemetry(status=status(), motors=motors, ranges=ranges))
    assert bar == " rob | ready | L +0.20 R -0.20 | 12.3 V | 0.45 m left"


@pytest.mark.parametrize(
    ("others", "sees", "said"),
    [
        ({"bow": 0.3}, {}, "0.30 m bow"),
        ({"bow": 0.3}, {"bow forward": 0.2}, "0.20 m ahead (bow)"),
        ({}, {"lidar left": 0.4, "lidar forward": None}, "0.40 m left (lidar)"),
        ({}, {"lidar left": 0.6}, "0.45 m left"),
        ({"bow": None}, {"lidar left": None}, "0.45 m left"),
    ],
)
def test_the_nearest_is_that_of_sensors_of_any_name(others, sees, said):
    ranges = Ranges(forward_m=1.0, back_m=None, left_m=0.45, right_m=2.0, bottom_m=None, status={}, others_m=others)
    drive = msgspec.convert(STANDING | {"sees": sees}, DriveState)
    assert text(Telemetry(status=status(), drive=drive, ranges=ranges)).endswith(f"| {said}")


def test_a_robot_without_a_ring_shows_what_its_lidar_sees():
    drive = msgspec.convert(STANDING | {"sees": {"lidar back": 0.7}}, DriveState)
    assert text(Telemetry(status=status(), drive=drive)).endswith("| 0.70 m behind (lidar)")


def test_a_line_under_way_shows_its_age():
    assert "clock (3 s)" in "".join(piece for _, piece in toolbar("rob", Telemetry(), None, {"clock": 3.2}))


@pytest.mark.parametrize("columns", [12, 20, 30, 40, 60, 80])
def test_a_narrow_bar_keeps_the_state_and_leaves_out_the_least_important(columns):
    motors = MotorsState(left=0.2, right=-0.2, armed=True, reason="", estop=False, voltage_v=12.34)
    ranges = Ranges(forward_m=1.0, back_m=None, left_m=0.45, right_m=2.0, bottom_m=None, status={})
    bar = text(Telemetry(status=status(), motors=motors, ranges=ranges), columns)
    assert len(bar) <= columns
    assert bar.startswith(" rob | re")
    assert ("12.3 V" in bar) <= ("L +0.20" in bar)


def test_a_long_reason_is_shortened_to_fit():
    bar = text(Telemetry(status=status(estop=True)), 24)
    assert bar == " rob | E-STOP: a hand …"
