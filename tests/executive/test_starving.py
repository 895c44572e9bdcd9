"""What is silent hangs, unless the machine did not give it the processor."""

import os
import signal
import sys
import time

from hypothesis import given
from hypothesis import strategies as st

from lbr.executive.processes.starvation import (
    OTHERS_STRETCH,
    SUSPICIOUS_S,
    Look,
    Thread,
    following,
    look,
    verdict,
    waited_s,
)
from tests.support import programs
from tests.support.waiting import until

PATIENCE_S = 1.0
seconds = st.floats(0.0, 100.0)


def judged(silent_s: float, main_s: float = 0.0, others_s: float = 0.0, ran_s: float = 0.0, runs: bool = False) -> str:
    """Judge a silence that was looked at as soon as it was suspicious."""
    seen = max(0.0, silent_s - SUSPICIOUS_S)
    now = Look(seen, Thread(ran_s, main_s, runs), {2: Thread(0.0, others_s)})
    return verdict(silent_s, PATIENCE_S, Look(0.0, Thread(), {2: Thread()}), now)


@given(st.floats(PATIENCE_S, 100.0, exclude_min=True), st.floats(0.0, 100.0))
def test_who_starts_may_work_for_a_while_and_neither_sleep_nor_turn_in_circles_for_ever(
    silent_s: float, work_s: float
) -> None:
    seen = silent_s - SUSPICIOUS_S
    works = verdict(silent_s, PATIENCE_S, Look(0.0), Look(seen, Thread(seen, 0.0, runnable=True)), work_s=work_s)
    if abs(silent_s - min(seen, work_s) - PATIENCE_S) > 1e-6:
        assert (works == "hung") == (silent_s - min(seen, work_s) > PATIENCE_S)
    assert verdict(silent_s, PATIENCE_S, Look(0.0), Look(seen, Thread()), work_s=work_s) == "hung"


@given(seconds, seconds, seconds)
def test_nothing_hangs_while_there_is_patience(silent_s: float, main_s: float, others_s: float) -> None:
    assert (judged(silent_s, main_s, others_s) == "fine") == (silent_s <= PATIENCE_S)


@given(st.floats(PATIENCE_S, 100.0, exclude_min=True))
def test_who_did_not_wait_for_the_processor_hangs_at_once(silent_s: float) -> None:
    assert judged(silent_s) == "hung"  # stopped, or waiting for a lock
    assert judged(silent_s, ran_s=silent_s - SUSPICIOUS_S, runs=True) == "hung"  # turning in circles


@given(st.floats(PATIENCE_S, 100.0, exclude_min=True), st.floats(0.0, 1.0))
def test_who_turns_in_circles_is_judged_by_the_time_it_was_given(silent_s: float, share: float) -> None:
    seen = silent_s - SUSPICIOUS_S
    says = judged(silent_s, seen * (1.0 - share), ran_s=seen * share, runs=True)
    own_s = SUSPICIOUS_S + seen * share
    if abs(own_s - PATIENCE_S) > 1e-6:
        assert (says == "hung") == (own_s > PATIENCE_S)


@given(st.floats(0.0, 100.0), st.floats(0.0, 10.0), st.floats(0.0, 10.0))
def test_who_ran_for_longer_than_a_round_takes_hangs_however_long_it_waited(
    silent_s: float, ran_s: float, may_run_s: float
) -> None:
    now = Look(silent_s, Thread(ran_s, silent_s))
    says = verdict(silent_s, PATIENCE_S, Look(0.0), now, may_run_s=may_run_s)
    assert (says == "hung") == (silent_s > PATIENCE_S and ran_s > may_run_s)


@given(st.floats(PATIENCE_S, 1000.0, exclude_min=True))
def test_who_gets_nothing_at_all_is_never_killed(silent_s: float) -> None:
    assert judged(silent_s, silent_s) == "starved"
    assert judged(silent_s, runs=True) == "starved"  # a wait that is not over is not counted yet


@given(st.floats(PATIENCE_S, 100.0, exclude_min=True))
def test_other_threads_excuse_for_a_while_and_no_longer(silent_s: float) -> None:
    assert judged(silent_s, others_s=silent_s) == ("starved" if silent_s <= OTHERS_STRETCH * PATIENCE_S else "hung")


@given(seconds, seconds, seconds, seconds)
def test_more_waiting_never_makes_it_worse(silent_s: float, main_s: float, others_s: float, more_s: float) -> None:
    order = ("fine", "starved", "hung")
    before, after = judged(silent_s, main_s, others_s), judged(silent_s, main_s + more_s, others_s + more_s)
    assert order.index(after) <= order.index(before)


@given(st.floats(PATIENCE_S, 100.0, exclude_min=True), st.floats(0.0, 100.0))
def test_what_was_not_looked_at_counts_no_more_than_a_look_should_take(silent_s: float, unseen_s: float) -> None:
    first = Look(unseen_s)
    assert verdict(unseen_s + silent_s, PATIENCE_S, first, first) == "fine"
    late = Look(unseen_s + PATIENCE_S)
    assert verdict(unseen_s + silent_s + PATIENCE_S, PATIENCE_S, first, late) == "hung"


def test_a_kernel_that_counts_nothing_excuses_nothing() -> None:
    nobody = look(2**22 + 1, 5.0)
    assert verdict(2.0, PATIENCE_S, Look(0.0), nobody) == "hung"


def test_real_processes_are_told_apart() -> None:
    """A stopped one and a sleeping one have no excuse, and one that has the processor has hardly any."""
    scripts = ("import time; time.sleep(60)", "import time; time.sleep(60)", "while True: pass")
    sleeps, stopped, turns = (programs.start([sys.executable, "-c", script]) for script in scripts)
    try:
        until(lambda: look(turns.pid, 0.0).main.ran > 0.1)
        os.kill(stopped.pid, signal.SIGSTOP)
        until(lambda: not look(stopped.pid, 0.0).main.runnable)
        until(lambda: not look(sleeps.pid, 0.0).main.runnable)
        first = {one.pid: look(one.pid, time.monotonic()) for one in (sleeps, stopped, turns)}
        until(lambda: look(turns.pid, 0.0).main.ran - first[turns.pid].main.ran > 0.3)
        for one in (sleeps, stopped, turns):
            begun = first[one.pid]
            now = look(one.pid, time.monotonic())
            own = now.main.ran - begun.main.ran if one is turns else now.at - begun.at
            assert verdict(now.at - begun.at, 0.8 * own, begun, now) == "hung"
    finally:
        for one in (sleeps, stopped, turns):
            one.kill()
            one.wait()


@given(st.floats(PATIENCE_S + SUSPICIOUS_S, 100.0), st.floats(0.05, 0.5))
def test_who_is_woken_just_now_has_not_waited_ever_since(silent_s: float, every_s: float) -> None:
    """A thread that wakes and sleeps is seen able to run now and then; it was given the processor each time."""
    first = newest = Look(0.0, Thread(slices=1), {2: Thread(slices=1)})
    for n in range(1, int(silent_s / every_s) + 1):
        threads = {2: Thread(ran=n * 1e-5, runnable=True, slices=n + 1)}
        newest = following(newest, Look(n * every_s, Thread(slices=1), threads))
    assert verdict(newest.at + SUSPICIOUS_S, PATIENCE_S, first, newest) != "starved"
    main = following(Look(0.0, Thread(slices=1)), Look(3.0, Thread(runnable=True, slices=300)))
    assert waited_s(Look(0.0, Thread(slices=1)), main) == 0.0


@given(st.floats(0.1, 100.0), st.floats(0.0, 1.0))
def test_who_gets_no_slice_from_a_look_on_waits_from_then_on(silent_s: float, before_s: float) -> None:
    first = Look(0.0, Thread(slices=1))
    begun = following(first, Look(before_s, Thread(ran=0.01, runnable=True, slices=2)))
    now = following(begun, Look(before_s + silent_s, Thread(ran=0.01, runnable=True, slices=2)))
    assert abs(waited_s(first, now) - min(silent_s, before_s + silent_s - 0.01)) < 1e-6
