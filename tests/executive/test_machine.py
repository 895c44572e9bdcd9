"""What a machine has no room for is refused in words, before anything starts."""

import resource
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.kind import Kind, NoSettings
from lbr.database.rows import CapabilityRow, RobotRow, RobotRows
from lbr.database.store import Database
from lbr.executive.planning import machine
from lbr.executive.planning.draft import Draft
from lbr.executive.planning.machine import ANY, MOST_CAPABILITIES, Machine, this_machine
from lbr.executive.planning.profile import Profile, load
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.planning.watch import RowWatch
from tests.support import databases

KIND = Kind(name="k", summary="s", family="app", entry="nowhere:Nothing", settings=NoSettings)
HERE = Profile(robot="r")


def found(count: int, on: Machine = ANY, profile: Profile = HERE) -> list[str]:
    chosen = tuple(CapabilityRow(name=f"c{n}", kind="k") for n in range(count))
    kinds = {row.name: KIND for row in chosen}
    draft = Draft(rows=RobotRows(robot=RobotRow(name="r")), profile=profile, kinds=kinds, settings={}, chosen=chosen)
    return [str(one) for one in machine.problems(draft, on)]


@given(st.integers(0, 300), st.integers(0, 300))
def test_no_more_run_than_there_is_room_for(count: int, most: int) -> None:
    assert bool(found(count, Machine(most=most, bound="so it is"))) == (count > most)


def test_the_refusal_says_how_many_and_what_the_bound_is(wording) -> None:
    wording(*found(300))


def test_what_other_machines_run_counts_there(wording) -> None:
    names = tuple(f"c{n}" for n in range(150))
    wording(*found(200, profile=Profile(robot="r", hosts={"two": names[:90]})))
    assert "also the host 'two'" in found(200, profile=Profile(robot="r", hosts={"two": names}))[-1]


def test_few_files_or_little_memory_make_less_room_and_say_so(monkeypatch: pytest.MonkeyPatch, wording) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(resource, "getrlimit", lambda _what: (256, 256))
        few = this_machine(0)
    assert few.most == 13
    wording(few.bound)
    with monkeypatch.context() as patch:
        patch.setattr(machine.Path, "read_text", lambda _path, **_how: "MemAvailable: 65536 kB\nSwapFree: 0 kB\n")
        assert this_machine(20).most == 24
        wording(this_machine(20).bound)


def test_what_runs_already_has_room_however_little_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine.Path, "read_text", lambda _path, **_how: "MemAvailable: 0 kB\n")
    assert found(20, this_machine(20)) == []


def test_limits_are_raised_to_what_a_full_robot_needs_and_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr(resource, "setrlimit", lambda _what, limits: asked.append(limits))
    for soft, hard in ((256, 512), (1024, 1_000_000), (4096, 4096), (1024, resource.RLIM_INFINITY)):
        monkeypatch.setattr(resource, "getrlimit", lambda _what, limits=(soft, hard): limits)
        machine.raise_limits()
    wanted = machine.FILES_WANTED
    assert asked == [(512, 512), (wanted, 1_000_000), (wanted, resource.RLIM_INFINITY)]
    assert wanted >= machine.FILES_BESIDE + machine.FILES_EACH * MOST_CAPABILITIES


def test_an_edit_has_the_room_of_the_processes_that_run_however_many_capabilities_share_them(tmp_path: Path) -> None:
    databases.fresh(tmp_path / "robot.db")
    running: list[int] = []

    def room(processes: int) -> Machine:
        running.append(processes)
        return ANY

    site = RunIdentity(home=str(tmp_path), endpoints=("tcp/h:1",), secret=b"secret", token_key=b"key")
    with Database.open(tmp_path / "robot.db") as database:
        watch = RowWatch(database, load("lbr-sim"), site, room)
        plan = watch.first()
        watch.look_again()
        watch.look(plan)
    names = {unit.config.process or name for name, unit in plan.local_units.items()}
    assert len(names) < len(plan.local_units)
    assert running == [0, len(names)]
