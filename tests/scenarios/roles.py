"""E5: everybody may stop, and only those who may operate can release; lines by role and plain keys, at the local door."""

import json
import time
from collections.abc import Callable
from typing import Any

from lbr.bus import keys, wire
from lbr.bus.session import Session
from tests.support.bench import ANGLES, Bench

STOP_LIMIT_S = 0.5
ARMED_S = 0.3
"""After a reset the driver waits for a zero, and a sender that went on has to pause."""
ROLES = ("view", "operate", "admin")
STOPS = ("s", "S", "stop", "estop", "/estop/matrix")


def matrix(under_test: Bench) -> None:
    """Every role's lines: the stops while the robot drives, then `reset`, then a motion."""
    with under_test.robot.as_owner() as bus:
        for role in ROLES:
            for line in STOPS:
                _stops(
                    under_test, f"{role} says {line!r}", lambda line=line, role=role: _say(bus, under_test, role, line)
                )
                if "estop" in line:
                    _resets(under_test, bus, role)
            _drives(under_test, bus, role)


def plain_keys(under_test: Bench) -> None:
    """What anybody at the local socket may do without a word of the console."""
    robot = under_test.robot
    ways: dict[str, Callable[[], Any]] = {
        "a query on drive/stop": lambda: robot.ask("drive/stop", {}),
        "a put on drive/stop": lambda: robot.bus.put(f"{robot.name}/drive/stop", b"{}"),
        "a put on drive/stop that is not JSON": lambda: robot.bus.put(f"{robot.name}/drive/stop", b"\xff"),
        "power 0": lambda: robot.put("drive/command", {"power": 0.0}, source="anybody"),
        "a put on @estop": lambda: robot.bus.put(keys.estop(robot.name), json.dumps({"engaged": True})),
        "a put on @estop that is not JSON": lambda: robot.bus.put(keys.estop(robot.name), b"\x00"),
    }
    for what, how in ways.items():
        _stops(under_test, what, how)
        if "@estop" in what:
            _release(under_test)
    forbidden_keys(under_test)


def forbidden_keys(under_test: Bench) -> None:
    """Keys that nobody at the local socket may use: the administrator's lines, releases, acknowledgements."""
    robot = under_test.robot
    said = robot.line("estop")
    assert said["code"] == 0, said
    _acknowledged(under_test)
    for key in ("@console/admin", "@estop/release/motors", "@estop/release/drive", "@alive/motors"):
        answer = robot.ask(key, "reset" if "console" in key else {}, timeout_s=0.3)
        accepted = answer is not None and (answer.get("accepted") or answer.get("code") == 0)
        under_test.results.check("E5", [f"{key} at the local socket: {answer}"] if accepted else [])
    for key, payload in ((keys.estop(robot.name), {"engaged": False}), (f"{robot.name}/@estop/reset", {})):
        robot.bus.put(key, json.dumps(payload))
    under_test.pass_time(0.1)
    latched = under_test.answer("@estop")["engaged"]
    under_test.results.check("E5", [] if latched else ["a put released the emergency stop"])
    _release(under_test)


def _stops(under_test: Bench, what: str, how: Callable[[], Any]) -> None:
    mover = under_test.drive()
    at_ns = time.monotonic_ns()
    how()
    zero = under_test.trace.first_zero(at_ns, STOP_LIMIT_S)
    before = under_test.trace.at(at_ns)  # now that all until then is read
    mover.cease()
    if before.zero:
        under_test.results.disturbed.append(f"E5: {what}: the motors stood already")
    else:
        under_test.results.check("E5", [] if zero is not None else [f"{what}: the robot went on"])
    under_test.until(lambda: under_test.trace.now().zero, 2.0, "rest")
    under_test.pass_time(ARMED_S)


def _resets(under_test: Bench, bus: Session, role: str) -> None:
    """Let a role say `reset`; release the latch some other way if it may not."""
    _acknowledged(under_test)
    said = _say(bus, under_test, role, "reset")
    latched = under_test.answer("@estop")["engaged"]
    may = role != "view"
    wrong = (
        [f"{role} says 'reset': {said}, latched {latched}"]
        if (latched is may) or (said["code"] == 0) is not may
        else []
    )
    under_test.results.check("E5", wrong)
    if latched:
        _release(under_test)
    under_test.pass_time(ARMED_S)


def _drives(under_test: Bench, bus: Session, role: str) -> None:
    said = _say(bus, under_test, role, f"/r/0.4/{ANGLES[0]:g}")
    may = role != "view"
    under_test.results.check("E5", [] if (said["code"] == 0) is may else [f"{role} drives: {said}"])
    under_test.robot.ask("drive/stop", {})
    under_test.until(lambda: under_test.trace.now().zero, 2.0, "rest")


def _release(under_test: Bench) -> None:
    _acknowledged(under_test)
    under_test.release()
    under_test.pass_time(ARMED_S)


def _acknowledged(under_test: Bench) -> None:
    def all_said() -> bool:
        state = under_test.answer("@estop")
        return bool(state["engaged"] and not state["waiting"])

    under_test.until(all_said, 3.0, "the emergency stop acknowledged")


def _say(bus: Session, under_test: Bench, role: str, line: str) -> Any:
    answers = wire.ask(bus, keys.console(under_test.robot.name, role), line, source=f"{role} of the matrix")
    return json.loads(answers[0].payload) if answers else {"code": -1, "text": "no answer"}
