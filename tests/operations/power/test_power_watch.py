"""The decision about the shutdown: traces of voltages in, what is done out. Time is a number here."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.power import UpsState
from lbr.operations.power import PowerSettings
from lbr.operations.power.state import Answered, Arm, Cancel, News, Parked, Reading, Tick
from lbr.operations.power.watch import begin, code, decide, refusal

SETTINGS = PowerSettings(device="ups")
WARN, SHUT = SETTINGS.warn_v, SETTINGS.shutdown_v
GOOD, LOW = 11.5, 9.5


def ups(volts, battery=4.1, **more):
    return UpsState(valid=True, source="external", external_v=volts, battery_v=battery, **more)


INVALID = UpsState(valid=False, reason="the supply hangs")


class Bench:
    """One decision going on: a reading each second and ticks between, notes what was done and when."""

    def __init__(self, config=SETTINGS, *, armed=True):
        self.config = config
        self.now = 1000.0
        self.watch = begin(armed=armed, warn_v=config.warn_v, shutdown_v=config.shutdown_v, now=self.now)
        self.done = []
        self.news = []

    def happen(self, event):
        self.watch, tasks = decide(self.watch, event, self.now, self.config)
        self.news += [task for task in tasks if isinstance(task, News)]
        self.done += [task for task in tasks if not isinstance(task, News)]
        return self.watch.phase

    def read(self, *states):
        for state in states:
            self.happen(Reading(state if isinstance(state, UpsState) else ups(state)))
            for _ in range(4):
                self.now += 0.25
                self.happen(Tick())
        return self.watch.phase

    def silence(self, for_s):
        for _ in range(round(for_s * 4)):
            self.now += 0.25
            self.happen(Tick())
        return self.watch.phase

    def kinds(self):
        return [told.kind for told in self.news]


def bench_in(phase, config=SETTINGS):
    bench = Bench(config)
    bench.read(GOOD, GOOD)
    if phase in {"countdown", "parking", "powering_off", "off", "failed"}:
        bench.read(*[LOW] * 3)
    if phase in {"parking", "powering_off", "off", "failed"}:
        bench.read(*[LOW] * 11)
    if phase in {"powering_off", "off", "failed"}:
        bench.happen(Parked())
    if phase in {"off", "failed"}:
        bench.happen(Answered("" if phase == "off" else "polkit says no"))
    assert bench.watch.phase == phase, bench.watch
    return bench


def test_each_phase_of_the_watch_has_the_code_of_its_sentence():
    assert [code(bench_in(phase).watch) for phase in ("countdown", "parking", "powering_off", "off", "failed")] == [
        *["shutting_down"] * 4, "failed",
    ]  # fmt: skip
    bench = Bench()
    assert [bench.read(GOOD, GOOD), code(bench.watch)] == ["watching", ""]
    assert [bench.read(10.2, 10.2, 10.2), code(bench.watch)] == ["warning", "limit"]


# -- the way down -----------------------------------------------------------------------------------------------------


def test_a_low_voltage_is_warned_of_counted_down_parked_and_powered_off_once():
    bench = Bench()
    assert bench.read(GOOD, GOOD) == "watching"
    assert bench.read(10.2, 10.2) == "watching"
    assert bench.read(10.2) == "warning"
    assert bench.read(LOW, LOW) != "countdown"
    assert bench.read(LOW) == "countdown"
    assert bench.done == ["ask_can"]
    assert bench.read(*[LOW] * 12) == "parking"
    assert bench.done == ["ask_can", "park"]
    assert bench.happen(Parked()) == "powering_off"
    assert bench.happen(Answered()) == "off"
    bench.read(*[LOW] * 60)
    assert bench.done.count("power_off") == 1
    assert [kind for kind in bench.kinds() if kind.startswith("shutdown")] == [
        "shutdown_countdown", "shutdown_parking", "shutdown_now", "shutdown_agreed",
    ]  # fmt: skip


def test_parking_that_never_ends_ends_all_the_same():
    bench = bench_in("parking")
    bench.read(*[LOW] * 21)
    assert bench.watch.phase in {"powering_off", "failed"}
    assert bench.done[-2:] == ["stop_parking", "power_off"]
    assert "took too long" in " ".join(told.text for told in bench.news)


def test_a_refused_shutdown_is_told_and_tried_again_as_long_as_it_is_low():
    bench = bench_in("failed")
    assert bench.news[-1].level == "error"
    assert "polkit says no" in bench.watch.reason
    bench.read(*[LOW] * 28)
    assert bench.done.count("power_off") == 1
    bench.read(*[LOW] * 4)
    assert bench.done.count("power_off") == 2


def test_logind_that_does_not_answer_is_a_failure():
    bench = bench_in("powering_off")
    bench.read(*[LOW] * 13)
    assert bench.watch.phase == "failed"
    assert "did not answer" in bench.watch.reason


def test_a_computer_that_stays_on_though_logind_agreed_is_told():
    bench = bench_in("off")
    bench.silence(SETTINGS.off_s + 1)
    assert bench.watch.phase == "failed"
    assert "still runs" in bench.watch.reason


def test_an_emulated_supply_powers_nothing_off_and_a_good_voltage_ends_it():
    bench = bench_in("powering_off")
    assert bench.happen(Answered(pretended=True)) == "off"
    assert "emulated" in bench.watch.reason
    assert code(bench.watch) == "not_possible"
    bench.read(*[LOW] * 200)
    assert bench.watch.phase == "off"
    assert bench.read(GOOD, GOOD, GOOD) == "watching"


def test_what_an_emulated_supply_has_brought_down_can_be_disarmed():
    bench = bench_in("powering_off")
    bench.happen(Answered(pretended=True))
    assert "no shutdown to cancel" in refusal(bench.watch, Cancel("console"))
    assert refusal(bench.watch, Arm(armed=True, warn_v=11.0)) == ""
    assert bench.happen(Arm(armed=True, warn_v=11.0)) == "off"
    assert refusal(bench.watch, Arm(armed=False)) == ""
    assert bench.happen(Arm(armed=False)) == "disarmed"
    bench.read(*[LOW] * 60)
    assert (bench.watch.phase, bench.done.count("power_off")) == ("disarmed", 1)


# -- what must not lead there ---------------------------------------------------------------------------------------


def test_one_noisy_sample_is_none():
    bench = Bench()
    for _ in range(20):
        bench.read(GOOD, 3.0, 8.0, GOOD)
    assert bench.watch.phase == "watching"
    assert bench.done == []


def test_many_readings_within_a_moment_are_not_enough():
    bench = Bench()
    for _ in range(20):
        bench.now += 0.09
        bench.happen(Reading(ups(LOW)))
    assert bench.watch.phase == "warning"
    bench.now += 0.3
    assert bench.happen(Reading(ups(LOW))) == "countdown"


def test_two_readings_far_apart_are_not_enough():
    bench = Bench()
    for _ in range(2):
        bench.now += 4.0
        bench.happen(Reading(ups(LOW)))
    assert bench.watch.phase == "watching"


def test_what_was_low_before_a_silence_counts_no_more():
    bench = Bench()
    bench.read(LOW, LOW)
    bench.silence(SETTINGS.stale_s + 1)
    assert bench.read(LOW, LOW) != "countdown"
    assert bench.read(LOW) == "countdown"


def test_what_was_low_of_one_source_says_nothing_of_the_other():
    bench = Bench()
    bench.read(LOW, LOW)
    low_battery = ups(0.0, battery=3.5)
    assert bench.read(low_battery, low_battery) != "countdown"
    assert bench.read(LOW, LOW) != "countdown"
    assert bench.read(LOW) == "countdown"


@pytest.mark.parametrize("volts", [None, nan, inf, -inf, -1.0])
def test_a_voltage_that_was_not_measured_is_no_low_one(volts):
    bench = Bench()
    bench.read(*[volts] * 60)
    assert bench.done == []
    assert bench.kinds() == ["supply_unknown"]
    assert bench.watch.phase == "warning"


def test_a_supply_that_dies_is_a_warning_and_comes_back_as_news():
    bench = bench_in("watching")
    bench.read(*[INVALID] * 60)
    assert bench.watch.phase == "warning"
    assert (bench.watch.reason, code(bench.watch)) == ("the supply hangs", "stale_sensor")
    assert bench.read(GOOD) == "watching"
    assert bench.kinds() == ["supply_unknown", "supply_known"]


def test_a_supply_that_falls_silent_is_a_warning():
    bench = bench_in("watching")
    assert bench.silence(SETTINGS.stale_s + 1) == "warning"
    assert "last read" in bench.watch.reason
    assert bench.done == []


def test_a_silent_supply_ends_a_countdown():
    bench = bench_in("countdown")
    assert bench.silence(SETTINGS.stale_s + 1) == "warning"
    bench.silence(60)
    assert "park" not in bench.done


def test_single_failed_readings_do_not_hold_up_a_shutdown():
    bench = Bench()
    bench.read(GOOD, *[LOW, LOW, INVALID] * 6)
    assert bench.watch.phase == "parking"


def test_a_countdown_does_not_end_on_a_failed_reading():
    bench = bench_in("countdown")
    bench.read(*[LOW] * 8)
    bench.read(INVALID, INVALID, INVALID)
    assert bench.watch.phase == "countdown"
    assert bench.read(LOW) == "parking"


def test_a_disconnected_external_supply_is_told_apart_when_the_battery_backs_it():
    bench = bench_in("watching")
    bench.read(*[0.0] * 60)
    assert bench.watch.phase == "warning"
    assert bench.done == []
    assert "disconnected; battery 4.10 V" in bench.watch.reason
    assert bench.kinds() == ["supply_low"]
    assert bench.read(GOOD) == "watching"


def test_the_battery_behind_a_disconnected_supply_is_watched_too():
    bench = bench_in("watching")
    bench.read(*[ups(0.0, battery=3.5)] * 3)
    assert bench.watch.phase == "countdown"


def test_without_a_battery_behind_it_nothing_is_low_too():
    bench = Bench(PowerSettings(device="ups", battery_backs=False))
    bench.read(*[0.0] * 3)
    assert bench.watch.phase == "countdown"


def test_a_disarmed_watch_warns_but_does_nothing():
    bench = Bench(armed=False)
    bench.read(GOOD, *[LOW] * 60, *[INVALID] * 20)
    assert bench.watch.phase == "disarmed"
    assert bench.done == []
    assert bench.kinds() == ["supply_low", "supply_unknown"]
    assert "not armed" in bench.news[0].text


def test_a_voltage_that_recovers_ends_the_countdown_with_hysteresis():
    bench = bench_in("countdown")
    assert bench.read(*[SHUT + 0.1] * 5) == "countdown"
    assert bench.read(*[SHUT + SETTINGS.hysteresis_v] * 3) == "warning"
    assert bench.kinds()[-1] == "shutdown_off"
    assert "park" not in bench.done


def test_a_voltage_between_the_thresholds_warns_once():
    bench = bench_in("watching")
    for _ in range(30):
        bench.read(WARN - 0.05, WARN + 0.05, WARN - 0.05, WARN - 0.05, WARN - 0.05)
    assert bench.kinds() == ["supply_low"]


# -- people -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", ["watching", "countdown", "parking", "failed"])
def test_disarming_ends_it_at_any_moment_for_certain(phase):
    bench = bench_in(phase)
    before = bench.done.count("power_off")
    bench.happen(Arm(armed=False, sender="console"))
    bench.read(*[LOW] * 60)
    bench.happen(Parked())
    assert bench.watch.phase == "disarmed"
    assert bench.done.count("power_off") == before
    assert "keep" in bench.done
    if phase == "parking":
        assert "stop_parking" in bench.done


@pytest.mark.parametrize("phase", ["countdown", "parking", "failed"])
def test_a_cancel_ends_it_until_the_voltage_was_good_again(phase):
    bench = bench_in(phase)
    before = bench.done.count("power_off")
    bench.happen(Cancel("console"))
    bench.read(*[LOW] * 60)
    assert bench.watch.phase == "warning"
    assert "cancelled" in bench.watch.reason
    assert code(bench.watch) == "cancelled"
    assert bench.done.count("power_off") == before
    bench.read(*[GOOD] * 3)
    bench.read(*[LOW] * 3)
    assert bench.watch.phase == "countdown"


def test_disarming_and_arming_within_a_moment_leaves_one_countdown():
    bench = bench_in("countdown")
    bench.happen(Arm(armed=False))
    bench.happen(Arm(armed=True))
    bench.read(*[LOW] * 60)
    bench.happen(Parked())
    assert bench.done.count("park") == 1
    assert bench.done.count("power_off") == 1


@pytest.mark.parametrize("phase", ["powering_off", "off"])
def test_once_the_computer_goes_down_it_is_too_late(phase):
    bench = bench_in(phase)
    for event in (Arm(armed=False), Cancel("console")):
        assert "too late" in refusal(bench.watch, event)
        bench.happen(event)
        assert bench.watch.phase == phase


def test_there_is_nothing_to_cancel_while_nothing_is_low():
    assert "no shutdown to cancel" in refusal(bench_in("watching").watch, Cancel("console"))


def test_thresholds_in_the_wrong_order_are_refused():
    watch = bench_in("watching").watch
    assert "must not be above" in refusal(watch, Arm(armed=True, shutdown_v=10.8))
    assert refusal(watch, Arm(armed=True, warn_v=11.2, shutdown_v=10.8)) == ""


def test_a_new_threshold_counts_from_now_on():
    bench = bench_in("countdown")
    bench.happen(Arm(armed=True, shutdown_v=9.0))
    assert bench.happen(Tick()) == "watching"
    bench.read(*[LOW] * 60)
    assert bench.watch.phase == "warning"
    assert "park" not in bench.done


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"shutdown_v": 11.0}, "shutdown_v"),
        ({"battery_shutdown_v": 4.0}, "battery_shutdown_v"),
        ({"absent_v": 9.9}, "absent_v"),
    ],
)
def test_settings_that_contradict_themselves_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        PowerSettings(device="ups", **wrong)


# -- any trace --------------------------------------------------------------------------------------------------------

VOLTS = st.one_of(
    st.floats(8.0, 13.0), st.sampled_from([0.0, SHUT, SHUT - 0.01, WARN, GOOD, LOW, nan, inf, None]), st.just("invalid")
)
PEOPLE = st.sampled_from(["arm", "disarm", "cancel", "parked", "agreed", "refused"])


def reading(volts):
    return INVALID if volts == "invalid" else ups(volts)


@given(st.lists(st.tuples(VOLTS, st.integers(1, 8)), max_size=25))
def test_it_never_parks_unless_readings_were_below_for_the_hold_and_the_last_one_is(trace):
    bench, history = Bench(), []
    for volts, times in trace:
        for _ in range(times):
            history.append(volts)
            bench.read(reading(volts))
            if "park" in bench.done:
                low = [one for one in history[-20:] if isinstance(one, float) and one < SHUT]
                assert isinstance(history[-1], float)
                assert history[-1] < SHUT
                assert len(low) >= SETTINGS.hold_samples
                return


@given(st.lists(VOLTS, max_size=12), st.lists(st.floats(2.0, SHUT - 0.01), min_size=20, max_size=40))
def test_whatever_came_before_it_always_powers_off_below_for_the_set_time(before, low):
    bench = Bench()
    bench.read(*map(reading, before), *low)
    if bench.watch.phase == "parking":
        bench.happen(Parked())
    assert bench.done.count("power_off") >= 1


@given(st.lists(st.one_of(VOLTS.map(lambda volts: ("read", volts)), PEOPLE.map(lambda who: (who, None))), max_size=80))
def test_nothing_powers_off_while_disarmed_and_each_shutdown_once(events):
    bench, asked = Bench(), 0
    deeds = {
        "arm": Arm(armed=True), "disarm": Arm(armed=False), "cancel": Cancel("x"), "parked": Parked(),
        "agreed": Answered(), "refused": Answered("no"),
    }  # fmt: skip
    for what, volts in events:
        before = bench.watch
        if what == "read":
            bench.read(reading(volts))
        else:
            bench.happen(deeds[what])
        new = bench.done.count("power_off") - asked
        asked += new
        assert new <= 1
        assert not (new and not before.armed)
        assert bench.watch.phase != "disarmed" or not bench.watch.armed
        if bench.watch.phase in {"countdown", "parking"}:
            assert bench.watch.armed
            assert not bench.watch.cancelled


@given(st.integers(0, 14))
def test_a_restart_in_mid_countdown_counts_anew_and_powers_off(seconds):
    first = Bench()
    first.read(GOOD, *[LOW] * seconds)
    second = Bench()
    second.now = first.now
    second.read(*[LOW] * 2)
    assert "park" not in second.done
    second.read(*[LOW] * 12)
    second.happen(Parked())
    assert second.done.count("power_off") == 1
