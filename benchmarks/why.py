"""Measures whether `why` names the cause: running robots get causes one at a time, and each is asked for.

`python -m benchmarks why --robots lbr,bioloid,uxa90 --json FILE`. A cause counts as named if an answer within 4 s has
it as the first link. It counts as blamed on hardware if an answer holds a line, a fault or a motor wrongly. Each is
healed before the next one.
"""

import argparse
import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

from msgspec import Struct

from benchmarks import Measured, listed
from lbr.messages.why import HARDWARE
from lbr.testing.robot import NoAnswerError
from tests.support.bench import Bench, let_go, temporary_home
from tests.support.figures import Promise, Results
from tests.support.robot import lbr, start

SMOKE = "--robots lbr --n 2"
NAMED_S, HEALED_S, AGAIN_S = 4.0, 12.0, 0.15
PROMISES = {
    "Y1": Promise(what="causes that are not named first, of all", unit="", target=2.0),
    "Y2": Promise(what="causes wrongly blamed on hardware"),
    "Y3": Promise(what="the answer to `why` of a robot that is up", target=200.0, statistic="p99"),
    "Y5": Promise(what="the answer to `why` while something is being broken"),
    "Y4": Promise(what="from a cause to its name"),
}
Act = Callable[[Bench], None]


class Cause(Struct, frozen=True, kw_only=True):
    """The action on a robot, its reversal, and the expected link: its name, its subject, and one of these codes."""

    name: str
    robot: str
    part: str
    break_it: Act
    heal: Act
    link: str
    about: str
    codes: tuple[str, ...]
    role: str = "admin"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the robots, and the number of causes."""
    parser.add_argument("--robots", type=listed, default=["lbr", "bioloid", "uxa90"], help="which (default all three)")
    parser.add_argument("--n", type=int, default=100, help="causes of each robot at most (default %(default)s)")
    parser.add_argument("--only", default="", help="causes whose name has this in it")


def measure(given: argparse.Namespace) -> Measured:
    """Break the robots, one cause after the other."""
    results = Results(PROMISES)
    told: list[dict[str, Any]] = []
    for robot in given.robots:
        causes = [one for one in CAUSES if one.robot == robot and given.only in one.name][: given.n]
        waiting = iter(causes)
        for rest in _runs(robot, waiting, results, told):
            print(f"{robot}: started again before '{rest}'", file=sys.stderr, flush=True)
    if "lbr" in given.robots and given.only in "executive":
        told += _without_executive(results)
    results.sample("Y1", sum(not one["named"] for one in told))
    missed = [f"{one['cause']}: {one['told']}" for one in told if not one["named"]]
    text = "\n".join(f"{'named' if one['named'] else 'MISSED'}  {one['cause']}: {one['told']}" for one in told)
    figures = {"causes": len(told), "named": len(told) - len(missed), "missed": missed, "each": told}
    return Measured(results=results.ordered(), figures=figures, text=text)


def _runs(robot: str, causes: Iterator[Cause], results: Results, told: list[dict[str, Any]]) -> Iterator[str]:
    """Run a robot, and another one after a cause that could not be healed; yield that cause's name."""
    while True:
        with _running(robot, results) as under:
            for cause in causes:
                told.append(_one(under, cause, results))
                if not _healed(under, cause):
                    yield cause.name
                    break
            else:
                return


@contextmanager
def _running(robot: str, results: Results) -> Iterator[Bench]:
    with temporary_home(whole=True) as home:
        under = Bench(start(home, profile=f"{robot}-sim", limit_s=60.0), results)
        try:
            if robot == "bioloid":
                under.robot.line("/torque/on")
            under.pass_time(3.0)
            _well(under, results)
            yield under
        finally:
            let_go(under.robot)


def _well(under: Bench, results: Results) -> None:
    """Ask a healthy robot about each of its capabilities."""
    for name in [unit["name"] for unit in under.units()] * 3:
        since = time.monotonic()
        under.robot.line(f"/why/{name}")
        results.sample("Y3", (time.monotonic() - since) * 1e3)


def _one(under: Bench, cause: Cause, results: Results) -> dict[str, Any]:
    """Make a cause, and ask until it is named or the time is over."""
    began, last, blamed = time.monotonic(), "no answer", ""
    with ExitStack() as undo:
        undo.callback(lambda: _try(under, cause.heal))
        named = False
        try:
            cause.break_it(under)
        except (AssertionError, OSError) as err:
            results.disturbed.append(f"{cause.name} could not be put in: {err}")
            began, last = -NAMED_S, f"could not be put in: {err}"
        while not named and time.monotonic() < began + NAMED_S:
            since = time.monotonic()
            with suppress(NoAnswerError):
                answer = under.robot.line(f"/why/{cause.part}", role=cause.role)
                results.sample("Y5", (time.monotonic() - since) * 1e3)
                link = _first(answer["data"])
                last = (
                    f"{link['name']} {link['about']} {link['code']}: {link['text']}"
                    if link
                    else answer["text"].splitlines()[0]
                )
                named = (
                    bool(link)
                    and link["name"] == cause.link
                    and cause.about in {"", link["about"]}
                    and link["code"] in cause.codes
                )
                if link and link["state"] == "held" and link["name"] in HARDWARE and cause.link not in HARDWARE:
                    blamed = last
            under.pass_time(AGAIN_S)
    _judge(results, cause.name, named=named, last=last, blamed=blamed)
    if named:
        results.sample("Y4", (time.monotonic() - began) * 1e3)
    return {"cause": f"{cause.robot}: {cause.name}", "named": named, "told": last}


def _judge(results: Results, name: str, *, named: bool, last: str, blamed: str) -> None:
    results.check("Y2", [f"{name}: {blamed}"] if blamed else [])
    print(f"{'named ' if named else 'MISSED'} {name}: {last}", file=sys.stderr, flush=True)


def _first(chain: dict[str, Any] | None) -> dict[str, Any]:
    if not chain or chain.get("first") is None:
        return {}
    return {"code": "", **chain["links"][chain["first"]]}


def _healed(under: Bench, cause: Cause) -> bool:
    """Wait until nothing holds the part any more."""
    end = time.monotonic() + HEALED_S
    while time.monotonic() < end:
        with suppress(NoAnswerError):
            if cause.robot != "lbr":
                under.robot.line("/torque/on")
            link = _first(under.robot.line(f"/why/{cause.part}")["data"])
            same = (link.get("name"), link.get("about")) == (cause.link, cause.about)
            if link.get("state") != "held" and not (same and link["state"] == "doubt"):
                return True
        under.pass_time(AGAIN_S)
    return False


def _try(under: Bench, heal: Act) -> None:
    with suppress(AssertionError, NoAnswerError, OSError):
        heal(under)


def _without_executive(results: Results) -> list[dict[str, Any]]:
    """Ask about a robot whose executive is frozen, and one that was killed: by the command, from its rows."""
    told = []
    with temporary_home() as home:
        under = Bench(start(home), results)
        try:
            for name, number, state in (
                ("executive frozen", signal.SIGSTOP, "unreachable"),
                ("executive killed", signal.SIGKILL, "unreachable"),
            ):
                os.kill(under.robot.popen.pid, number)
                if number == signal.SIGKILL:
                    under.robot.popen.wait()
                said = lbr(home, "why", "drive", "--json", limit_s=20.0)
                link = _first(json.loads(said.stdout)) if said.stdout else {}
                last = f"{link.get('name')} {link.get('code')}: {link.get('text')} {said.stderr}"
                named = (link.get("name"), link.get("code")) == ("executive", state)
                _judge(results, name, named=named, last=last, blamed="")
                told.append({"cause": f"lbr: {name}", "named": named, "told": last})
        finally:
            let_go(under.robot)
    return told


def _line(text: str) -> Act:
    def act(under: Bench) -> None:
        said = under.robot.line(text)
        assert said["code"] == 0, f"{text}: {said['text']}"

    return act


def _press(under: Bench) -> None:
    """Press the emergency stop, even while a driver cannot acknowledge it."""
    under.robot.line("estop")


def _nothing(_under: Bench) -> None:
    pass


def _signal(name: str, number: int = signal.SIGKILL) -> Act:
    return lambda under: os.kill(under.pid(name), number)


def _kill_for_good(name: str) -> Act:
    """Kill it at each start, until it is given up."""

    def act(under: Bench) -> None:
        end = time.monotonic() + 25.0
        while (unit := under.unit(name))["phase"] != "failed" and time.monotonic() < end:
            if unit["pid"]:
                with suppress(ProcessLookupError):
                    os.kill(unit["pid"], signal.SIGKILL)
            under.pass_time(0.05)

    return act


def _restart(name: str) -> Act:
    return _line(f"/restart/{name}")


def _sql(text: str) -> Act:
    return lambda under: under.robot.edit(text)


def _fault(device: str, name: str, value: Any) -> Act:
    def act(under: Bench) -> None:
        answer = under.answer("world/fault", {"device": device, "name": name, "value": value})
        assert answer.get("accepted", True), answer

    return act


def _row(table: str, where: str, on: int) -> Act:
    return _sql(f"UPDATE {table} SET enabled = {on} WHERE {where}")


def _off(robot: str, name: str, part: str) -> Cause:
    where = f"robot = '{robot}' AND name = '{name}'"
    return Cause(
        name=f"row {name} off", robot=robot, part=part, break_it=_row("capability", where, 0), heal=_row("capability", where, 1),
        link="row", about=name, codes=("off",),
    )  # fmt: skip


def _cut(robot: str, source: str, target: str, part: str, about: str) -> Cause:
    where = f"robot = '{robot}' AND source = '{source}' AND target = '{target}'"
    return Cause(
        name=f"channel {source} to {target} off", robot=robot, part=part, break_it=_row("channel", where, 0),
        heal=_row("channel", where, 1), link="wire", about=about, codes=("wiring",),
    )  # fmt: skip


def _killed(robot: str, name: str, part: str) -> Cause:
    return Cause(
        name=f"{name} killed", robot=robot, part=part, break_it=_signal(name), heal=_nothing, link="process", about=name,
        codes=("failed",),
    )  # fmt: skip


def _frozen(robot: str, name: str, part: str) -> Cause:
    return Cause(
        name=f"{name} frozen", robot=robot, part=part, break_it=_signal(name, signal.SIGSTOP), heal=_nothing, link="process",
        about=name, codes=("timeout",),
    )  # fmt: skip


def _given_up(robot: str, name: str, part: str) -> Cause:
    return Cause(
        name=f"{name} given up", robot=robot, part=part, break_it=_kill_for_good(name), heal=_restart(name), link="process",
        about=name, codes=("failed",),
    )  # fmt: skip


def _device(
    robot: str, device: str, fault: str, part: str, *, link: str = "line", codes: tuple[str, ...] = ("unreachable",)
) -> Cause:
    undo = False
    return Cause(
        name=f"{device} {fault}", robot=robot, part=part, break_it=_fault(device, fault, True), heal=_fault(device, fault, undo),
        link=link, about=device, codes=codes,
    )  # fmt: skip


def _servo(fault: str, link: str, codes: tuple[str, ...], joint: str = "left_elbow", servo: int = 6) -> Cause:
    def heal(under: Bench) -> None:
        _fault("servo_bus", fault, None)(under)
        under.pass_time(2.0)
        under.robot.line("/recover")
        under.pass_time(0.5)
        under.robot.line("/torque/on")

    return Cause(
        name=f"servo of {joint} {fault}", robot="bioloid", part=joint, break_it=_fault("servo_bus", fault, servo), heal=heal,
        link=link, about=joint, codes=codes,
    )  # fmt: skip


def _said(name: str, robot: str, part: str, do: str, undo: str, link: str, about: str, *codes: str) -> Cause:
    heal = _line(undo) if undo else _nothing
    return Cause(
        name=name,
        robot=robot,
        part=part,
        break_it=_press if do == "estop" else _line(do),
        heal=heal,
        link=link,
        about=about,
        codes=codes,
    )


def _lapse(under: Bench) -> None:
    """Drive, and stop renewing."""
    mover = under.drive()
    mover.cease()
    under.pass_time(0.5)


MOVERS: list[Any] = []


def _other_drives(under: Bench) -> None:
    MOVERS[:] = [under.drive()]


def _other_ceases(under: Bench) -> None:
    for mover in MOVERS:
        mover.cease()
    under.robot.line("stop")


def _play(under: Bench) -> None:
    """Play on until it is healed: no console renews its lease, so the joints hold soon."""
    under.robot.line("/play/wave")


BAD_SETTING = (
    "UPDATE capability SET settings = json_set(settings, '$.no_such', 1) WHERE robot = 'lbr' AND name = 'drive'"
)
GOOD_SETTING = (
    "UPDATE capability SET settings = json_remove(settings, '$.no_such') WHERE robot = 'lbr' AND name = 'drive'"
)
FAR = json.dumps([{"direction": way, "sensor": way, "stop_m": 7.9} for way in ("forward",)])
FAR_STOP = f"UPDATE capability SET settings = json_set(settings, '$.rules', json('{FAR}')) WHERE robot = 'lbr' AND name = 'drive'"
NEAR_STOP = "UPDATE capability SET settings = json_remove(settings, '$.rules') WHERE robot = 'lbr' AND name = 'drive'"

CAUSES: tuple[Cause, ...] = (
    *(_killed("lbr", name, part) for name, part in (("drive", "drive"), ("motors", "drive"), ("ranges", "drive"), ("camera_front", "camera_front"))),
    _killed("lbr", "dock", "dock"),
    _killed("lbr", "imu", "attitude"),
    _killed("lbr", "world", "drive"),
    *(_frozen("lbr", name, part) for name, part in (("drive", "drive"), ("motors", "drive"), ("ranges", "drive"), ("camera_front", "camera_front"))),
    _given_up("lbr", "drive", "drive"),
    _given_up("lbr", "motors", "drive"),
    *(_off("lbr", name, part) for name, part in (("drive", "drive"), ("motors", "drive"), ("ranges", "drive"), ("camera_front", "camera_front"), ("dock", "dock"))),
    _cut("lbr", "drive.setpoint", "motors.setpoint", "drive", "motors"),
    _cut("lbr", "ranges.readings", "drive.ranges", "drive", "drive"),
    _cut("lbr", "motors.state", "drive.motors", "drive", "drive"),
    _device("lbr", "motor_controller", "unplug", "drive"),
    _device("lbr", "motor_controller", "silent", "drive"),
    _device("lbr", "motor_controller", "brown_out", "drive"),
    _device("lbr", "motor_controller", "unplug", "motors"),
    _device("lbr", "range_board", "unplug", "drive"),
    _device("lbr", "range_board", "silent", "drive"),
    _device("lbr", "imu", "unplug", "attitude"),
    _device("lbr", "front_camera", "unplug", "camera_front"),
    _device("lbr", "dock_receiver", "unplug", "dock"),
    _said("emergency stop", "lbr", "drive", "estop", "reset", "estop", "estop", "estop"),
    _said("motors disabled", "lbr", "drive", "disable", "enable", "arming", "motors", "not_armed"),
    _said("cameras off", "lbr", "camera_front", "/camera/off", "/camera/front", "switch", "camera_front", "off"),
    _said("other camera on", "lbr", "front", "/camera/rear", "/camera/front", "switch", "camera_front", "off"),
    Cause(name="another drives", robot="lbr", part="drive", break_it=_other_drives, heal=_other_ceases, link="holder", about="drive", codes=("held",)),
    Cause(name="a lease lapsed", robot="lbr", part="drive", break_it=_lapse, heal=_line("stop"), link="last", about="drive", codes=("lapsed",)),
    Cause(name="a wall by the rules", robot="lbr", part="drive", break_it=_sql(FAR_STOP), heal=_sql(NEAR_STOP), link="reading", about="forward", codes=("obstacle",)),
    Cause(name="an edit refused", robot="lbr", part="drive", break_it=_sql(BAD_SETTING), heal=_sql(GOOD_SETTING), link="rows", about="rows", codes=("bad_value",)),
    Cause(name="only a looker", robot="lbr", part="drive", break_it=_nothing, heal=_nothing, link="asker", about="", codes=("role",), role="view"),
    *(_killed("bioloid", name, part) for name, part in (("servos", "left_knee"), ("joints", "left_knee"), ("motions", "motions"))),
    _frozen("bioloid", "servos", "left_knee"),
    _given_up("bioloid", "joints", "left_knee"),
    *(_off("bioloid", name, part) for name, part in (("joints", "left_knee"), ("servos", "left_knee"), ("ups", "ups"))),
    _cut("bioloid", "joints.setpoint", "servos.setpoint", "left_knee", "servos"),
    _device("bioloid", "servo_bus", "unplug", "left_knee"),
    _device("bioloid", "servo_bus", "brown_out", "left_knee"),
    _device("bioloid", "imu", "unplug", "attitude"),
    _device("bioloid", "ups", "unplug", "ups"),
    _said("emergency stop", "bioloid", "left_knee", "estop", "reset", "estop", "estop", "estop"),
    _said("a joint released", "bioloid", "left_elbow", "/torque/off/left_elbow", "/torque/on", "torque", "left_elbow", "no_torque"),
    _said("all released", "bioloid", "joints", "/torque/off/all", "/torque/on", "torque", "joints", "no_torque"),
    _said("relay off", "bioloid", "left_knee", "/relay/off", "/relay/on", "power", "ups", "off"),
    _servo("overload", "fault", ("latched", "failed")),
    _servo("hot", "fault", ("latched", "failed")),
    _servo("silent", "line", ("unreachable",)),
    _servo("unpowered", "line", ("unreachable",)),
    Cause(name="the mover was lost", robot="bioloid", part="joints", break_it=_play, heal=_line("/torque/on"), link="last", about="joints", codes=("lapsed", "holder_gone")),
    *(_killed("uxa90", name, part) for name, part in (("servos", "left_knee"), ("joints", "left_knee"), ("tracking", "tracking"), ("camera_head", "tracking"))),
    *(_off("uxa90", name, part) for name, part in (("camera_head", "camera_head"), ("joints", "left_knee"), ("servos", "left_knee"))),
    _device("uxa90", "main_board", "unplug", "left_knee"),
    _device("uxa90", "head_camera", "unplug", "camera_head"),
    _cut("uxa90", "joints.setpoint", "servos.setpoint", "left_knee", "servos"),
    _said("emergency stop", "uxa90", "left_knee", "estop", "reset", "estop", "estop", "estop"),
)  # fmt: skip
