"""S15, S16, S17 and E7: devices that are unplugged, deaf, dumb, frozen or lying, on the path to the motors."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from lbr.bus import stamp, wire
from tests.scenarios.bounds import held
from tests.scenarios.estop import PAUSE_S
from tests.support.bench import ALMOST, Bench, NoMotionError
from tests.support.trace import Output
from tests.support.waiting import HANG_S

MOTORS, RANGES = "motor_controller", "range_board"
DEAF_S = 2.0
STALE_LINES, STALE_MS = 3, 50.0
WORTH_GOING_BACK_M = 0.2
AFTERMATH_S = 0.3
TRUTH_S = 0.8
RANGE_FAULTS: dict[str, Any] = {
    "silent": True,
    "unplug": True,
    "garbage": 1.0,
    "missing": "forward",
    "error": "forward",
    "frozen": True,
}


def motors_unplugged(under_test: Bench) -> None:
    """S16: the cable is pulled and comes back as another tty of the same name; a stubborn sender goes on."""
    mover = under_test.drive()
    states = wire.Subscription(under_test.robot.bus, f"{under_test.robot.name}/motors/state", depth=256)
    fault_ns = time.monotonic_ns()
    with fault(under_test, MOTORS, "unplug"):
        seen_ns = _first(under_test, states, lambda state: "went away" in state["reason"])
        zero = under_test.stopped_after("S16 stop", fault_ns)
        under_test.results.sample("S16", (seen_ns - fault_ns) * 1e-6)
        under_test.pass_time(AFTERMATH_S)
    back_ns = time.monotonic_ns()
    states.close()
    under_test.all_ready()
    under_test.pass_time(AFTERMATH_S)
    mover.cease()
    under_test.stays_at_rest(zero)
    under_test.begins_with_zero(back_ns, last_bytes_s=0.0)


def motors_deaf(under_test: Bench) -> None:
    """S17: the controller reads nothing for two seconds, then all that waited."""
    mover = under_test.drive()
    with fault(under_test, MOTORS, "stop_reading"):
        under_test.pass_time(DEAF_S)
        under_test.trace.read()
        resumed_ns = time.monotonic_ns()
    under_test.all_ready()
    under_test.pass_time(AFTERMATH_S)
    mover.cease()
    under_test.trace.read()
    heard = under_test.trace.lines(resumed_ns)
    stale = [line.text for line in heard if line.moves]
    if heard:
        # What waited jumps to a power that had been reached bit by bit; on a busy machine that is later than it was asked for.
        under_test.excused.append((resumed_ns, heard[0].at_ns + int(STALE_MS * 1e6)))
    turned_ms = _turned_ms(under_test.trace.outputs(resumed_ns))
    under_test.results.sample("S17 lines", len(stale))
    under_test.results.sample("S17", turned_ms)
    wrong = [f"{len(stale)} old commands were obeyed"] if len(stale) > STALE_LINES else []
    wrong += [f"the motors turned for {turned_ms:.0f} ms"] if turned_ms > STALE_MS else []
    under_test.results.check("S17", wrong)


def motors_dumb(under_test: Bench) -> None:
    """E7: the controller obeys but does not say so; the emergency stop's answer must not claim what nobody said."""
    robot = under_test.robot
    mover = under_test.drive()
    with fault(under_test, MOTORS, "silent"):
        if not under_test.trace.now().least >= ALMOST:
            mover.cease()
            raise NoMotionError("the motors stood before the emergency stop")
        at_ns = time.monotonic_ns()
        said = robot.line("estop")
        zero = under_test.stopped_after("E7 stop", at_ns)
        lies = [f"estop was answered {said}"] if said["code"] == 0 or "motors" not in said["text"] else []
        end = time.monotonic() + TRUTH_S
        while time.monotonic() < end:
            state = under_test.answer("@estop")
            lies += [f"@estop says {state}"] if "motors" in state["acknowledged"] else []
    under_test.results.check("E7", lies[:1])
    under_test.release()
    under_test.all_ready()
    under_test.pass_time(AFTERMATH_S)
    mover.cease()
    under_test.stays_at_rest(zero)
    under_test.pass_time(PAUSE_S)


def ranges_fail(under_test: Bench, name: str) -> None:
    """S15: the range board fails in one way while the robot drives ahead."""
    ahead_m = _ahead_m(under_test)
    mover = under_test.drive(0.0)
    fault_ns = time.monotonic_ns()
    with fault(under_test, RANGES, name, RANGE_FAULTS[name]):
        zero = under_test.stopped_after("S15 frozen" if name == "frozen" else "S15", fault_ns)
        under_test.pass_time(AFTERMATH_S)
        mover.cease()
    under_test.stays_at_rest(zero)
    under_test.all_ready()
    _back(under_test, ahead_m)


@contextmanager
def fault(under_test: Bench, device: str, name: str, value: Any = True) -> Iterator[None]:
    """Make a fault of an emulated device for the time of a block."""
    _set(under_test, device, name, value)
    try:
        yield
    finally:
        _set(under_test, device, name, None)


def _set(under_test: Bench, device: str, name: str, value: Any) -> None:
    reply = under_test.answer("world/fault", {"device": device, "name": name, "value": value})
    assert reply["accepted"], reply


def _first(under_test: Bench, feed: wire.Subscription, wanted: Callable[[Any], bool]) -> int:
    """Return when the first message like that was published."""
    end = time.monotonic() + HANG_S
    while time.monotonic() < end:
        for raw in feed.take():
            found = stamp.read(raw.attachment)
            if found is not None and wanted(json.loads(raw.payload)):
                return found.mono_ns
        under_test.pass_time(0.002)
    raise AssertionError("it was never told")


def _turned_ms(outputs: list[Output]) -> float:
    ends = [*(entry.at_ns for entry in outputs[1:]), outputs[-1].at_ns] if outputs else []
    return sum((end - entry.at_ns) * 1e-6 for entry, end in zip(outputs, ends, strict=True) if not entry.zero)


def _ahead_m(under_test: Bench) -> float:
    """Return how far the robot sees ahead."""
    return float(under_test.robot.ask("ranges/readings")["forward_m"])


def _back(under_test: Bench, ahead_m: float) -> None:
    """Drive back to where so much is seen ahead, unless that is next to nothing, or it looks past what it saw before."""
    if _ahead_m(under_test) > ahead_m - WORTH_GOING_BACK_M:
        return
    with held(under_test, {"angle_deg": 180.0, "range_cm": round(ahead_m * 100), "sensor": "forward"}):
        under_test.until(lambda: under_test.answer("drive/state")["goal"] is None, HANG_S, "the end of the way back")
        under_test.until(lambda: under_test.trace.now().zero, HANG_S, "standing where it began")
