"""Capabilities that share a process: what they are to the robot alone, what one of them does to the others, and how it is told."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.support import databases, needs
from tests.support.commands import here
from tests.support.robot import Robot
from tests.support.waiting import STOPS_S, until

KIND = """
import ctypes, sys, threading
from pathlib import Path
from msgspec import Struct
from lbr.capability import Capability, Kind, NoSettings
from lbr.messages.leases import CommandReply

class Count(Struct, frozen=True):
    n: int

class Do(Struct, frozen=True):
    what: str = ""

START = threading.Thread.start

def refused(thread):
    raise RuntimeError("can't start new thread")

class Mate(Capability[NoSettings]):
    rate_hz = 50.0

    def open(self):
        self.n = 0
        self.heard = 0
        self.cannot_close = False

    def close(self):
        if self.cannot_close:
            raise OSError("and the line is dead")
        Path(self.ctx.home, f"{self.ctx.name} closed").touch()

    def step(self):
        for received in self.ctx.take("others"):
            self.heard = received.message.n
        if self.ctx.on_tick:
            self.n += 1
            self.ctx.publish("count", Count(self.n))

    def command(self, call):
        what = call.message.what
        if what.startswith("threads"):
            threading.Thread.start = refused if what == "threads: none" else START
        call.reply(CommandReply(accepted=True, reason=f"{self.heard}"))
        if what.startswith("raise"):
            self.cannot_close = what == "raise twice"
            raise ValueError("out of cheese")
        if what == "circle":
            while True:
                pass
        if what == "hold the interpreter":
            ctypes.PyDLL(None).sleep(60)
        if what == "exit":
            sys.exit(0)

KIND = Kind(name="mate", summary="counts", family="operation", entry=Mate, inputs={"others": Count}, optional=("others",),
            outputs={"count": Count}, commands={"do": Do})
"""
TOUCHER = """
from msgspec import Struct
from lbr.capability import Capability, Kind, OnDevice
from lbr.errors import DeviceError

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    device: str

class Toucher(Capability[Settings]):
    def open(self):
        try:
            open(self.ctx.device.address).close()
        except OSError as err:
            raise DeviceError(str(err)) from err

KIND = Kind(name="toucher", summary="opens a file", family="driver", entry=Toucher, settings=Settings,
    device=OnDevice("thing"))
"""
STILLBORN = """
from lbr.capability import Capability, Kind, NoSettings

class Stillborn(Capability[NoSettings]):
    def __init__(self, ctx):
        raise ValueError("no cheese at all")

KIND = Kind(name="stillborn", summary="does not begin", family="app", entry=Stillborn)
"""
MATES = ("ann", "bob", "cyd")
ROWS = "INSERT INTO capability (robot, name, kind, process) VALUES ('lbr', 'ann', 'mate', 'crew'), ('lbr', 'bob', 'mate', 'crew'), ('lbr', 'cyd', 'mate', 'crew')"


@pytest.fixture(autouse=True, scope="module")
def crew(robot: Robot) -> None:
    for name, source in (("mate", KIND), ("stillborn", STILLBORN), ("toucher", TOUCHER)):
        (robot.home / "capabilities" / f"{name}.py").write_text(source)
    robot.edit(ROWS)
    robot.edit("INSERT INTO channel (robot, source, target) VALUES ('lbr', 'ann.count', 'bob.others')")


@pytest.fixture(autouse=True)
def all_well(robot: Robot) -> None:
    """Each test begins with three that are ready by the rows of now, and no past: who has ended too often is given up."""
    until(lambda: robot.status()["revision"] == databases.newest(robot.home) and len(mates(robot)) == 3)
    for name in [one["name"] for one in mates(robot) if one["last_end"]]:
        until(lambda: all(one["phase"] in {"ready", "failed"} for one in mates(robot)), what="an end of the last start")
        robot.line(f"/restart/{name}")
    until(lambda: all(one["phase"] == "ready" and not one["last_end"] for one in mates(robot)))


def mates(robot: Robot) -> list[dict[str, Any]]:
    return [one for one in units(robot) if one["kind"] == "mate"]


def units(robot: Robot) -> list[dict[str, Any]]:
    """Every capability at this moment; what is told on the bus is up to a second old."""
    return list(robot.line("/report/health")["data"]["capabilities"])


def pids(robot: Robot) -> dict[str, int]:
    return {one["name"]: one["pid"] for one in mates(robot)}


def do(robot: Robot, name: str, what: str = "") -> dict[str, Any]:
    return dict(robot.ask(f"{name}/do", {"what": what}) or {})


def closed(robot: Robot) -> set[str]:
    """Return what those that were closed have left."""
    return {path.name for path in robot.home.glob("* closed")}


def forget_closed(robot: Robot) -> None:
    for name in closed(robot):
        (robot.home / name).unlink()


def in_a_new_process(robot: Robot, before: int) -> Callable[[], bool]:
    """Return a look, at one moment, at whether all are ready in another process than before."""
    return lambda: all(one["phase"] == "ready" and one["pid"] != before for one in mates(robot))


def test_they_are_one_process_and_three_capabilities(robot: Robot) -> None:
    assert len(set(pids(robot).values())) == 1
    assert {one["process"] for one in mates(robot)} == {"crew"}
    assert all(do(robot, name)["accepted"] for name in MATES)
    until(lambda: all(one["rates_hz"].get("count", 0) > 20 for one in mates(robot)), what="each counts for itself")


def test_what_one_says_another_hears_and_so_does_everybody_else(robot: Robot) -> None:
    first = int(do(robot, "bob")["reason"])
    until(lambda: int(do(robot, "bob")["reason"]) > first + 5)
    assert int(do(robot, "cyd")["reason"]) == 0, "nothing is wired to it"
    assert robot.ask("ann/count")["n"] > 0


def test_one_that_is_switched_off_leaves_the_others_alone_and_comes_back_to_them(robot: Robot) -> None:
    before = pids(robot)
    robot.edit("UPDATE capability SET enabled = 0 WHERE name = 'bob'")
    until(lambda: robot.capability("bob")["phase"] == "absent")
    until(lambda: robot.ask("bob/count", timeout_s=0.3) is None, what="nothing answers in its name")
    assert pids(robot) == {name: pid for name, pid in before.items() if name != "bob"}
    robot.edit("UPDATE capability SET enabled = 1 WHERE name = 'bob'")
    until(lambda: robot.capability("bob")["phase"] == "ready")
    first = int(do(robot, "bob")["reason"])
    until(lambda: int(do(robot, "bob")["reason"]) > first, what="it hears again")
    assert pids(robot) == before
    assert all(one["restarts"] == 0 for one in mates(robot) if one["name"] != "bob")


def test_a_new_row_joins_them_with_its_own_rights(robot: Robot) -> None:
    before = pids(robot)
    robot.edit("INSERT INTO capability (robot, name, kind, process) VALUES ('lbr', 'dan', 'mate', 'crew')")
    until(lambda: robot.capability("dan")["phase"] == "ready")
    assert pids(robot) == {**before, "dan": before["ann"]}
    until(lambda: robot.ask("dan/count", timeout_s=0.3), what="what it says is heard")
    robot.edit("DELETE FROM capability WHERE name = 'dan'")
    until(lambda: pids(robot) == before)


def test_a_restart_of_one_is_a_restart_of_one(robot: Robot) -> None:
    before = pids(robot)
    forget_closed(robot)
    assert robot.line("/restart/ann")["code"] == 0
    until(lambda: closed(robot) and pids(robot) == before, what="it is there again, in the same process")
    until(lambda: robot.ask("ann/count", timeout_s=0.3), what="it counts again")
    assert closed(robot) == {"ann closed"}


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("raise", "out of cheese"),
        ("exit", "SystemExit"),
        ("circle", "no heartbeat"),
        ("hold the interpreter", "no heartbeat"),
    ],
)
def test_who_fails_takes_the_others_along_and_is_named(robot: Robot, what: str, told: str) -> None:
    before = pids(robot)["bob"]
    base = {name: robot.capability(name)["pid"] for name in ("drive", "motors")}
    do(robot, "bob", what)
    until(in_a_new_process(robot, before))
    assert {name: robot.capability(name)["pid"] for name in base} == base
    ends = {one["name"]: one["last_end"] for one in mates(robot)}
    if what != "hold the interpreter":  # then none of them is heard, and whichever is looked at first is told
        assert told in ends["bob"]
        assert all("its process 'crew' ended with 'bob', which shares it" in ends[name] for name in ("ann", "cyd"))
    assert "logs/lbr-crew.log" in ends["bob"]


def test_who_cannot_even_close_keeps_nobody_from_ending_in_order(robot: Robot) -> None:
    before = pids(robot)["bob"]
    forget_closed(robot)
    do(robot, "bob", "raise twice")
    until(in_a_new_process(robot, before))
    assert closed(robot) == {"ann closed", "cyd closed"}


def test_who_does_not_even_begin_fails_alone(robot: Robot) -> None:
    before = pids(robot)
    robot.edit("INSERT INTO capability (robot, name, kind, process) VALUES ('lbr', 'eve', 'stillborn', 'crew')")
    eve = until(
        lambda: next((one for one in units(robot) if one["name"] == "eve" and one["phase"] == "failed"), None),
    )
    assert "no cheese at all" in eve["last_end"]
    assert pids(robot) == before
    robot.edit("DELETE FROM capability WHERE name = 'eve'")
    until(lambda: all(one["name"] != "eve" for one in units(robot)))


def test_who_gets_no_thread_to_begin_in_fails_alone_and_begins_once_there_is_one(robot: Robot) -> None:
    before = pids(robot)
    do(robot, "ann", "threads: none")
    robot.edit("INSERT INTO capability (robot, name, kind, process) VALUES ('lbr', 'dan', 'mate', 'crew')")
    told = "crashed: RuntimeError: can't start new thread"
    until(lambda: any(one["name"] == "dan" and told in one["last_end"] for one in units(robot)))
    do(robot, "ann", "threads: as ever")
    until(lambda: any(one["name"] == "dan" and one["phase"] == "ready" for one in units(robot)))
    assert pids(robot) == {**before, "dan": before["ann"]}
    robot.edit("DELETE FROM capability WHERE name = 'dan'")
    until(lambda: pids(robot) == before)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGSTOP])
def test_their_process_is_started_again_however_it_ends(robot: Robot, number: signal.Signals) -> None:
    before = pids(robot)["ann"]
    os.kill(before, number)
    until(in_a_new_process(robot, before))
    assert len(set(pids(robot).values())) == 1


def test_a_frozen_process_that_more_are_to_join_holds_up_nobody_and_goes_on(robot: Robot) -> None:
    before = pids(robot)["ann"]
    os.kill(before, signal.SIGSTOP)
    rows = ", ".join(f"('lbr', 'more{n}', 'mate', 'crew')" for n in range(6))
    robot.edit(f"INSERT INTO capability (robot, name, kind, process) VALUES {rows}")

    def all_there() -> bool:
        begun = time.monotonic()
        assert robot.line("s")["code"] == 0
        assert time.monotonic() - begun < STOPS_S
        return [one["phase"] for one in mates(robot)] == ["ready"] * 9

    until(all_there)
    robot.edit("DELETE FROM capability WHERE name LIKE 'more%'")
    until(lambda: set(pids(robot)) == set(MATES))


def test_the_table_of_what_runs_and_the_logs_name_the_process(robot: Robot) -> None:
    until(lambda: f"{pids(robot)['ann']} crew" in here(robot.home, "status").stdout)
    of_before = robot.home / "logs" / "lbr-bob.log"
    of_before.write_text("alone then\n")
    before = pids(robot)["ann"]
    do(robot, "ann", "raise")
    until(in_a_new_process(robot, before))
    until(lambda: "out of cheese" in here(robot.home, "logs", "bob").stdout)
    assert here(robot.home, "logs", "lbr/bob").stdout == "alone then\n"
    of_before.unlink()


@needs.root("opens the files of others")
def test_a_device_of_another_users_that_comes_later_is_reached_in_a_new_process(robot: Robot, tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    for path in (ours, theirs):
        path.touch(0o600)
    os.chown(theirs, 65534, 65534)
    robot.edit(
        "INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'one', 'thing', ?), ('lbr', 'two', 'thing', ?)",
        *map(str, (ours, ours)),
    )
    robot.edit(
        "INSERT INTO capability (robot, name, kind, process, settings) VALUES"
        """ ('lbr', 'fay', 'toucher', 'hands', '{"device": "one"}'), ('lbr', 'gus', 'toucher', 'hands', '{"device": "two"}')"""
    )
    until(lambda: {robot.capability(name)["phase"] for name in ("fay", "gus")} == {"ready"})
    before = robot.capability("fay")["pid"]
    assert robot.capability("gus")["pid"] == before
    robot.edit("UPDATE device SET address = ? WHERE name = 'two'", str(theirs))
    until(lambda: robot.capability("gus")["pid"] not in {None, before}, what="it begins elsewhere")
    until(lambda: robot.capability("gus")["phase"] == "ready", what="it reaches its device")
    assert robot.capability("fay")["pid"] == before
    robot.edit("DELETE FROM capability WHERE kind = 'toucher'")
    robot.edit("DELETE FROM device WHERE type = 'thing'")
    until(lambda: all(one["kind"] != "toucher" for one in units(robot)))
