"""Loops that move something do nothing that takes long once they are ready, and nothing they do is without bound."""

import textwrap
import time
from contextlib import suppress
from pathlib import Path

import pytest

from tests.scenarios import devices, estop, load
from tests.scenarios.promises import PROMISES
from tests.support.bench import Bench, bench
from tests.support.figures import Results
from tests.support.mover import accepted
from tests.support.waiting import until

pytestmark = pytest.mark.timeout(30)

WATCHED = """
    import gc
    import sys
    from dataclasses import replace
    from {module} import KIND as BASE


    class Watched(BASE.load()):
        known = frozenset()

        def open(self):
            super().open()
            self.known = self.known or frozenset(sys.modules)

        def step(self):
            super().step()
            fresh = sys.modules.keys() - self.known
            if fresh or gc.isenabled():
                self.known |= fresh
                self.ctx.event("held_up", ", ".join(sorted(fresh)) or "the collector runs by itself")


    KIND = replace(BASE, name="{name}", entry=Watched)
"""
CHATTERBOX = """
    from msgspec import Struct
    from lbr.capability import Capability, Kind


    class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
        pass


    class Chatterbox(Capability):
        rate_hz = 100.0

        def step(self):
            self.ctx.event("chatter", "again")


    KIND = Kind(name="chatterbox", summary="", family="app", entry=Chatterbox, settings=Settings)
"""


def edits(*names: str) -> tuple[str, ...]:
    return tuple(f"UPDATE capability SET kind = 'watched_{name}' WHERE name = '{name}'" for name in names)


def give_kinds(home: Path) -> None:
    for name, module in (("motors", "lbr.drivers.roboteq"), ("drive", "lbr.operations.drive")):
        path = home / "capabilities" / f"watched_{name}.py"
        path.write_text(textwrap.dedent(WATCHED.format(module=module, name=f"watched_{name}")))
        path.chmod(0o600)


def test_nothing_is_imported_and_no_garbage_collected_by_chance_after_ready():
    with bench(Results(PROMISES)) as under_test:
        give_kinds(under_test.robot.home)
        for edit in edits("motors", "drive"):
            under_test.robot.edit(edit)
        under_test.until(lambda: under_test.unit("motors")["kind"] == "watched_motors", 5.0, "the watched kinds")
        under_test.all_ready()
        begun_ns = time.time_ns()  # one that shares a process may begin after another is ready
        under_test.drive().cease()
        estop.by_console(under_test)
        devices.motors_unplugged(under_test)
        robot = under_test.robot
        for key in ("drive/command", "drive/turn", "drive/stop", "motors/enable"):
            robot.bus.put(f"{robot.name}/{key}", b"{")
            with suppress(StopIteration):
                next(iter(robot.bus.get(f"{robot.name}/@schema/{key}")))
        assert robot.ask("drive/command", {"power": 0.2, "angle_deg": 0.0, "interval_s": 0.1})["accepted"]
        under_test.pass_time(0.5)
        held_up = [one for one in robot.events() if one["kind"] == "held_up" and one["wall_ns"] > begun_ns]
        assert not held_up, held_up


def test_a_chatterbox_floods_neither_the_events_nor_the_disk(running: Bench):
    robot = running.robot
    path = robot.home / "capabilities" / "chatterbox.py"
    path.write_text(textwrap.dedent(CHATTERBOX))
    path.chmod(0o600)
    robot.edit("INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'chatterbox', 'chatterbox', '{}')")
    said = until(lambda: [event for event in robot.events() if event["kind"] == "repeated"])
    assert "more events 'chatter' within a second" in said[0]["text"]
    assert sum(event["kind"] == "chatter" for event in robot.events()) <= 30


def test_a_flood_of_commands_takes_the_base_from_nobody_and_holds_up_no_stop(running: Bench):
    robot, command = running.robot, {"power": 0.2, "angle_deg": 90, "ttl_s": 1.0}
    command["lease"] = accepted(robot, command)
    answers = []
    with load.floods(robot, ("drive/command",), '{"power": 0.9, "angle_deg": 0}', each=1000):
        for _ in range(30):
            answers.append(robot.ask("drive/command", command, source="bench"))
            running.pass_time(0.05)
        stopped = robot.ask("drive/stop", {}, source="bench")
    assert [answer for answer in answers if not (answer and answer["accepted"])] == []
    assert stopped
    assert stopped["accepted"]
