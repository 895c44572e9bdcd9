"""Histories of processes, replayed with a clock and a process factory that the test holds."""

import random
from collections import deque

import msgspec
import pytest

from lbr.capability.config import ProcessConfig, Report
from lbr.capability.program import ProgramSettings
from lbr.executive.planning.plan import Change
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes.process_host import TERM_S
from lbr.executive.processes.starvation import Look, Thread
from lbr.executive.processes.supervisor import (
    DEGRADED_PATIENCE_S,
    HANG_APP_S,
    HANG_MOVER_S,
    HANG_PROGRAM_S,
    HANG_S,
    HANG_STARTING_S,
    SETTLING_S,
    Supervisor,
)


class FakeProcess:
    def __init__(self, unit, log):
        self.unit, self.log = unit, log
        self.pid = self.thread = 4000 + len(log)
        self.patience_s = TERM_S
        self.said = deque()
        self.code = None
        self.obeys = True

    def reports(self):
        said = list(self.said)
        self.said.clear()
        return said

    def settle(self):
        pass

    def terminate(self):
        self.log.append(("term", self.unit.name))
        if self.obeys:
            self.code = 0

    def kill(self):
        self.log.append(("kill", self.unit.name))
        self.code = -9

    def returncode(self):
        return self.code

    def close(self):
        pass


class Stage:
    """A supervisor whose time and processes are ours."""

    def __init__(self, *units, at_once=1000):
        self.now = 100.0
        self.log = []
        self.told = []
        self.codes = {}
        self.processes = {}
        self.hidden = set()
        self.closed = set()
        self.busy = False
        self.seen = lambda now: Look(now, Thread(waited=now if self.busy else 0.0))
        self.units = {unit.name: unit for unit in units}
        self.supervisor = Supervisor(
            self.start,
            self.tell,
            lambda name: name not in self.hidden,
            clock=lambda: self.now,
            dice=random.Random(1),
            at_once=at_once,
            look=lambda _pid, now, **_how: self.seen(now),
        )
        self.adopt(Change(start=tuple(self.units)))

    def tell(self, kind, name, text, level, code):
        self.told.append((kind, name, text, level))
        self.codes[kind] = code

    def adopt(self, change):
        self.supervisor.adopt(self.units, change)
        self.supervisor.step()

    def start(self, unit):
        if unit.name in self.closed:
            return None
        process = FakeProcess(unit, self.log)
        self.log.append(("start", unit.name))
        self.processes[unit.name] = process
        return process

    def says(self, name, phase="ready", reason="", code=""):
        self.processes[name].said.append(Report(phase=phase, reason=reason, code=code))
        self.supervisor.step()

    def passes(self, seconds, beating=()):
        end = self.now + seconds
        while self.now < end:
            self.now = min(self.now + 0.1, end)
            for name in beating:
                self.processes[name].said.append(Report())
            self.supervisor.step()

    def dies(self, name, code=1):
        self.processes[name].code = code
        self.supervisor.step()

    def phase(self, name):
        return self.supervisor.parts[name].phase

    def starts(self, name):
        return self.log.count(("start", name))


def unit(name, *, needs=(), moves=False, family="app", restart="on-failure", mark="", program=None):
    config = ProcessConfig(
        robot="r", name=name, kind="k", settings=msgspec.Raw(b"{}"), endpoints=(), home="", device=mark
    )
    return ProcessSpec(
        name=name, kind="k", family=family, moves=moves, restart=restart, needs=needs, config=config, program=program
    )


def test_a_capability_waits_for_what_it_needs():
    stage = Stage(unit("motors"), unit("drive", needs=("motors",)))
    assert stage.starts("drive") == 0
    stage.says("motors")
    assert stage.starts("drive") == 1


def test_a_missing_device_does_not_hold_up_the_others():
    stage = Stage(unit("motors"), unit("drive", needs=("motors",)))
    stage.says("motors", "degraded", "device missing")
    assert stage.starts("drive") == 1
    stage.passes(SETTLING_S + 0.2, beating=["motors", "drive"])
    assert stage.told == [("degraded", "motors", "device missing", "warning")]


def test_what_is_still_missing_right_after_a_start_is_told_as_trouble_only_if_it_lasts():
    stage = Stage(unit("ranges"))
    stage.says("ranges")
    stage.says("ranges", "degraded", "no reading yet")
    assert stage.phase("ranges") == "degraded"
    stage.passes(SETTLING_S / 2, beating=["ranges"])
    stage.says("ranges")
    stage.passes(SETTLING_S, beating=["ranges"])
    assert stage.told == [("started", "ranges", "ready", "info")]
    stage.says("ranges", "degraded", "no reading yet")
    assert stage.told[1:] == [("degraded", "ranges", "no reading yet", "warning")]


def test_a_crash_is_restarted_after_a_delay_and_its_dependants_are_told():
    stage = Stage(unit("motors"), unit("drive", needs=("motors",)))
    stage.says("motors")
    stage.says("drive")
    stage.dies("motors", -11)
    assert stage.starts("motors") == 1
    stage.passes(0.2, beating=["drive"])
    assert stage.starts("motors") == 2
    assert stage.starts("drive") == 1
    kinds = [(kind, subject) for kind, subject, _text, _level in stage.told]
    assert ("crashed", "motors") in kinds
    assert ("need_lost", "drive") in kinds


@pytest.mark.parametrize(
    ("of", "patience_s"),
    [({"family": "driver"}, HANG_S), ({"moves": True}, HANG_MOVER_S), ({"family": "app"}, HANG_APP_S)],
    ids=["a driver", "what moves something", "an app, to which others leave little time"],
)
def test_a_hang_is_killed_after_its_patience_and_told_apart_from_a_crash(of, patience_s):
    stage = Stage(unit("one", **of))
    stage.says("one")
    stage.passes(patience_s - 0.1)
    assert ("kill", "one") not in stage.log
    stage.passes(0.3)
    assert ("kill", "one") in stage.log
    assert [kind for kind, *_ in stage.told][-1] == "hung"


def test_a_silence_counts_from_the_date_of_the_last_beat_however_late_that_is_read():
    stage = Stage(unit("motors", moves=True))
    stage.says("motors")
    stage.now += 0.7
    stage.processes["motors"].said.append(Report(at=stage.now - 0.65))
    stage.supervisor.step()
    assert ("kill", "motors") not in stage.log
    stage.passes(0.4)
    assert ("kill", "motors") in stage.log


def test_a_hang_is_not_excused_by_threads_that_are_woken_now_and_then():
    stage = Stage(unit("motors", moves=True))
    stage.says("motors")
    stage.seen = lambda now: Look(now, Thread(), {2: Thread(runnable=True, slices=round(now * 100))})
    stage.passes(HANG_MOVER_S + 0.15)
    assert ("kill", "motors") in stage.log


def test_who_is_woken_often_is_not_told_as_waiting_for_the_processor():
    stage = Stage(unit("motors", family="driver"))
    stage.says("motors")
    stage.seen = lambda now: Look(now, Thread(runnable=True, slices=round(now * 100)))
    stage.passes(10.0, beating=["motors"])
    assert [kind for kind, *_ in stage.told] == ["started"]


def test_a_capability_that_somebody_else_told_to_end_starts_again(wording):
    stage = Stage(unit("motors"))
    stage.says("motors")
    stage.dies("motors", 0)
    assert stage.told[-1][:3] == ("crashed", "motors", stage.told[-1][2])
    wording(stage.told[-1][2])
    stage.passes(0.2)
    assert stage.starts("motors") == 2


def test_a_program_that_ends_by_itself_stays_down():
    stage = Stage(unit("once", program=ProgramSettings(argv=("x",))))
    stage.dies("once", 0)
    assert stage.phase("once") == "stopped"


def test_a_program_whose_token_vanishes_is_a_hang_and_one_without_a_token_is_never():
    token = unit("token", program=ProgramSettings(argv=("x",), ready="token"))
    stage = Stage(token, unit("plain", program=ProgramSettings(argv=("x",))))
    stage.passes(30.0)
    assert stage.phase("token") == "ready"
    stage.hidden = {"token", "plain"}
    stage.passes(HANG_PROGRAM_S - 0.2)
    assert ("kill", "token") not in stage.log
    stage.passes(0.5)
    assert ("kill", "token") in stage.log
    assert ("kill", "plain") not in stage.log
    assert "hung: its liveliness token is missing" in stage.supervisor.parts["token"].last_end


def test_the_last_end_is_told_in_the_words_of_its_event_also_after_the_restart():
    stage = Stage(unit("motors"))
    stage.says("motors")
    stage.processes["motors"].said.append(Report(phase="failed", reason="ValueError: out of cheese"))
    stage.dies("motors", 70)
    text = stage.told[-1][2]
    stage.passes(0.2)
    stage.says("motors")
    motors = stage.supervisor.parts["motors"]
    assert motors.reason == ""
    assert motors.last_end.startswith("crashed: ValueError: out of cheese")
    assert text.startswith(motors.last_end)


def test_heartbeats_keep_a_process_alive():
    stage = Stage(unit("motors"))
    stage.says("motors")
    stage.passes(10 * HANG_S, beating=["motors"])
    assert stage.phase("motors") == "ready"
    assert ("kill", "motors") not in stage.log


def test_a_slow_start_is_no_hang_but_an_endless_one_is():
    stage = Stage(unit("world"))
    stage.passes(HANG_STARTING_S - 1)
    assert ("kill", "world") not in stage.log
    stage.passes(1.5)
    assert ("kill", "world") in stage.log


def test_a_crash_loop_ends_in_failed_and_a_restart_by_hand_begins_anew():
    stage = Stage(unit("bad"))
    for _ in range(6):
        stage.passes(4.0)
        stage.dies("bad")
    assert stage.phase("bad") == "failed"
    started = stage.starts("bad")
    stage.passes(60.0)
    assert stage.starts("bad") == started
    stage.supervisor.restart("bad")
    stage.passes(0.2)
    assert stage.starts("bad") == started + 1


def test_an_edit_touches_only_what_it_names():
    stage = Stage(unit("a"), unit("b"), unit("c"))
    for name in "abc":
        stage.says(name)
    stage.units = {"a": stage.units["a"], "b": unit("b", mark="new"), "d": unit("d")}
    stage.adopt(Change(start=("d",), stop=("c",), restart=("b",)))
    stage.passes(0.3, beating=["a"])
    assert (stage.starts("a"), stage.starts("b"), stage.starts("d")) == (1, 2, 1)
    assert ("term", "a") not in stage.log
    assert set(stage.supervisor.parts) == {"a", "b", "d"}


def test_who_was_taken_along_by_a_neighbour_comes_back_whatever_its_row_says_of_its_own_ends():
    stage = Stage(unit("ann", restart="never"))
    for _ in range(9):
        stage.processes["ann"].said.append(Report(phase="taken_along", reason="its process ended with 'bob'"))
        stage.dies("ann", 70)
        stage.passes(0.2)
        stage.says("ann")
    assert (stage.phase("ann"), stage.starts("ann")) == ("ready", 10)


def test_the_new_process_waits_until_the_old_one_has_let_go_of_its_device():
    stage = Stage(unit("motors"))
    stage.says("motors")
    old = stage.processes["motors"]
    old.obeys = False
    stage.adopt(Change(restart=("motors",)))
    stage.passes(TERM_S / 2)
    assert stage.starts("motors") == 1
    stage.passes(TERM_S)
    assert ("kill", "motors") in stage.log
    assert stage.starts("motors") == 2


def test_shutdown_stops_motion_first_and_simulation_last():
    stage = Stage(
        unit("world", family="simulation"),
        unit("motors", family="driver", moves=True),
        unit("camera", family="driver"),
        unit("drive", family="operation", moves=True),
        unit("web"),
    )
    for name in stage.units:
        stage.says(name)
    stage.log.clear()

    def tick(seconds):
        stage.now += seconds

    stage.supervisor.shut_down(tick)
    assert [name for what, name in stage.log if what == "term"] == ["drive", "motors", "web", "camera", "world"]


def test_shutdown_kills_what_does_not_end():
    stage = Stage(unit("motors", family="driver", moves=True))
    stage.says("motors")
    stage.processes["motors"].obeys = False

    def tick(seconds):
        stage.now += seconds

    stage.supervisor.shut_down(tick)
    assert ("kill", "motors") in stage.log


@pytest.mark.parametrize("family", ["app", "driver"])
def test_a_program_that_cannot_start_is_reported_and_not_retried_for_ever(family):
    stage = Stage()
    stage.units = {"x": unit("x", family=family)}
    stage.start = None

    def refuse(_unit):
        raise OSError(2, "No such file")

    stage.supervisor = Supervisor(refuse, lambda *about: stage.told.append(about), clock=lambda: stage.now)
    stage.adopt(Change(start=("x",)))
    assert "could not be started" in stage.told[-1][2]
    stage.passes(30.0)
    assert stage.phase("x") == "failed"


def test_what_waits_for_a_failed_need_says_so_and_does_not_hold_up_readiness():
    stage = Stage(unit("motors", restart="never"), unit("drive", needs=("motors",)))
    stage.dies("motors")
    assert stage.phase("motors") == "failed"
    assert stage.supervisor.settled()
    drive = stage.supervisor.parts["drive"]
    assert (drive.code, drive.reason) == ("unreachable", "waits for 'motors', which is failed")


def test_ready_means_visible_on_the_bus():
    stage = Stage(unit("motors"), unit("drive", needs=("motors",)))
    stage.hidden = {"motors"}
    stage.says("motors")
    assert stage.phase("motors") == "starting"
    stage.hidden = set()
    stage.supervisor.step()
    assert stage.phase("motors") == "ready"
    assert stage.starts("drive") == 1


def test_a_degraded_capability_gets_a_moment_before_the_robot_counts_as_ready():
    stage = Stage(unit("ranges"))
    stage.says("ranges", "degraded", "no reading yet")
    assert not stage.supervisor.settled()
    stage.passes(DEGRADED_PATIENCE_S + 0.2, beating=["ranges"])
    assert stage.supervisor.settled()


@pytest.mark.parametrize("code", ["not_ready", "not_armed", "no_setpoint"])
def test_who_says_that_it_has_just_begun_gets_as_long_as_its_first_troubles_are_not_told(code):
    stage = Stage(unit("attitude"))
    stage.says("attitude", "degraded", "its zero is not known", code)
    stage.passes(SETTLING_S - 0.2, beating=["attitude"])
    assert not stage.supervisor.settled()
    stage.passes(0.4, beating=["attitude"])
    assert stage.supervisor.settled()


def test_few_start_at_a_time_and_what_moves_or_has_a_device_waits_for_none_of_them():
    many = [unit(f"app{n}") for n in range(6)]
    stage = Stage(*many, unit("motors", family="driver"), unit("drive", moves=True, family="operation"), at_once=2)
    assert [name for _, name in stage.log] == ["app0", "app1", "motors", "drive"]
    stage.says("app0")
    assert stage.starts("app2") == 0  # the drivers are among those that start
    stage.says("motors")
    stage.says("drive")
    assert stage.starts("app2") == 1
    for n in range(1, 5):
        stage.says(f"app{n}")
    assert all(stage.starts(f"app{n}") == 1 for n in range(6))


def test_who_has_no_way_onto_the_bus_yet_waits_without_counting_as_an_end():
    stage = Stage(unit("camera"))
    stage.dies("camera")
    stage.closed = {"camera"}
    stage.passes(3.0)
    assert (stage.phase("camera"), stage.starts("camera")) == ("waiting", 1)
    stage.closed = set()
    stage.passes(0.1)
    assert (stage.phase("camera"), stage.supervisor.parts["camera"].restarts) == ("starting", 1)


def test_who_is_not_given_the_processor_is_not_killed_and_the_machine_is_said_to_be_busy_once():
    stage = Stage(unit("motors", moves=True), unit("camera"))
    stage.says("motors")
    stage.says("camera")
    stage.busy = True
    stage.passes(60.0)
    assert not [what for what, _ in stage.log if what == "kill"]
    told = [text for kind, _, text, _ in stage.told if kind == "too_busy"]
    assert len(told) == 1
    assert "'motors' has waited " in told[0]
    stage.busy = False
    stage.passes(14.0, beating=("motors", "camera"))
    assert [kind for kind, *_ in stage.told][-1] == "busy_over"


def test_who_hangs_once_the_machine_has_time_is_killed_as_fast_as_ever():
    stage = Stage(unit("motors", moves=True))
    stage.says("motors")
    stage.busy = True
    stage.passes(10.0)
    stage.processes["motors"].said.append(Report())
    stage.busy = False
    stage.passes(HANG_MOVER_S + 0.11)
    assert ("kill", "motors") in stage.log


def test_what_is_degraded_while_the_machine_is_busy_is_told_if_it_lasts_beyond_that():
    stage = Stage(unit("camera"), unit("ranges", family="driver"))
    stage.says("camera")
    stage.says("ranges")
    stage.busy = True
    stage.passes(4.0, beating=("ranges",))
    stage.says("ranges", "degraded", "no answer: cable and power?")
    stage.says("camera", "degraded", "no picture")
    stage.passes(1.0, beating=("ranges",))
    assert "degraded" not in [kind for kind, *_ in stage.told]
    assert stage.supervisor.parts["ranges"].reason == "no answer: cable and power?"
    stage.says("camera")
    stage.busy = False
    stage.passes(14.0, beating=("ranges", "camera"))
    assert [(kind, name) for kind, name, *_ in stage.told][-2:] == [("busy_over", "machine"), ("degraded", "ranges")]


def test_each_phase_and_each_event_of_a_process_says_why_by_a_code():
    stage = Stage(unit("motors"), unit("drive", needs=("motors",)), unit("camera", needs=("drive",)))
    parts = stage.supervisor.parts
    stage.says("motors", "degraded", "no such device", "unreachable")
    stage.says("drive")
    stage.passes(SETTLING_S + 0.2, beating=["motors", "drive"])
    assert (parts["motors"].code, stage.codes["degraded"]) == ("unreachable", "unreachable")
    stage.says("motors")
    assert parts["motors"].code == ""
    stage.dies("motors", -9)
    assert (parts["motors"].code, parts["motors"].end_code, stage.codes["crashed"]) == ("failed",) * 3
    assert stage.codes["need_lost"] == "unreachable"
    stage.passes(0.2)
    stage.says("motors")
    assert (parts["motors"].code, parts["motors"].end_code) == ("", "failed")
    for _ in range(100):
        if "hung" not in stage.codes:
            stage.passes(0.1, beating=["drive"])
    assert stage.codes["hung"] == parts["motors"].end_code == "timeout"
