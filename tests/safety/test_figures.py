"""The arithmetic of what is measured."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.scenarios.promises import PROMISES
from tests.scenarios.schedule import FIGURE_OF, SCENARIOS
from tests.support.figures import Promise, Report, Result, Results, percentile, slope, table
from tests.support.ledger import BEGIN, END, Ledger
from tests.support.trace import Line, Output, Trace, limit_violations

powers = st.floats(-1, 1).map(lambda value: round(value, 3))
outputs = st.builds(Output, st.integers(0, 10**15), powers, powers, st.sampled_from(["command", "watchdog", "close"]))


def ramp(*values: float, every_s: float = 0.02) -> list[Output]:
    return [Output(round((n + 1) * every_s * 1e9), value, value, "command") for n, value in enumerate(values)]


@given(st.lists(outputs, max_size=20))
def test_a_trace_is_read_back_however_it_is_cut(tmp_path_factory: pytest.TempPathFactory, entries: list[Output]):
    path = tmp_path_factory.mktemp("trace") / "trace.txt"
    text = "".join(f"{e.at_ns} {e.left:g} {e.right:g} {e.cause}\n{e.at_ns} line !M 1 2\n" for e in entries)
    trace = Trace(path)
    half = len(text) // 2
    for part in (text[:half], text[half:]):
        with path.open("a") as file:
            file.write(part)
        trace.read()
    assert [e for e in trace.entries if isinstance(e, Output)] == entries
    assert [e for e in trace.entries if isinstance(e, Line)] == [Line(e.at_ns, "!M 1 2") for e in entries]


def test_the_end_of_the_emulation_is_no_stop(tmp_path: Path):
    path = tmp_path / "trace.txt"
    path.write_text("100 0.4 0.4 command\n200 0 0 close\n")
    assert Trace(path).first_zero(150, 0.0) is None
    path.write_text("100 0.4 0.4 command\n200 0 0 watchdog\n")
    assert Trace(path).first_zero(150, 0.0) == Output(200, 0.0, 0.0, "watchdog")


def test_a_steady_ramp_is_within_the_slew():
    assert not limit_violations(ramp(*(n * 0.04 for n in range(20)), 0.0, 0.04), max_power=1.0, accel_per_s=2.0)


def test_a_jump_is_above_the_slew():
    assert limit_violations(ramp(0.1, 0.0, 0.4), max_power=1.0, accel_per_s=2.0)


def test_small_jumps_one_after_the_other_are_above_the_slew():
    assert limit_violations(ramp(0.1, 0.2, 0.3, 0.4, 0.5, 0.6), max_power=1.0, accel_per_s=2.0)


def test_turning_round_begins_at_zero():
    assert limit_violations(
        [*ramp(*(n * 0.04 for n in range(11))), *ramp(-0.4, every_s=0.3)], max_power=1.0, accel_per_s=2.0
    )


def test_an_output_above_the_maximum_is_told():
    assert limit_violations(ramp(0.04, 0.08), max_power=0.05, accel_per_s=2.0)


def test_percentiles_are_values_that_were_measured():
    samples = [float(n) for n in range(1, 201)]
    assert (percentile(samples, "p50"), percentile(samples, "p99"), percentile(samples, "max")) == (100, 198, 200)


@pytest.mark.parametrize(
    ("samples", "violations", "verdict"),
    [
        ([10.0], [], "met"),
        ([10.0, 60.0], [], "missed"),
        ([301.0], [], "broken"),
        ([1.0], ["x"], "broken"),
        ([], [], "broken"),
    ],
)
def test_a_verdict_follows_the_worst(samples, violations, verdict):
    promise = Promise(what="stop", target=50, hard=300)
    result = Result(figure="S1", promise=promise, samples=samples, violations=violations)
    assert result.verdict == verdict
    told = table([result]).split("|")[-2].partition(":")[0]
    assert told == ("" if verdict == "met" else verdict), "what is met goes without saying"


def report(*results: Result, load: str = "") -> Report:
    return Report(machine="this one", load=load, started="today", took_s=1.0, results=list(results))


def test_a_newer_result_replaces_the_older_one_of_its_figure_alone(tmp_path: Path):
    ledger = Ledger()
    stop = Promise(what="stop", hard=300)
    ledger.merge(report(*(Result(figure=name, promise=stop, samples=[200.0]) for name in ("S10", "S2")), load="old"))
    ledger.merge(report(Result(figure="S2", promise=stop, samples=[100.0, 301.0]), load="new"))
    ledger.write(tmp_path / "results.json")
    kept = Ledger.read(tmp_path / "results.json").figures
    assert [(found.figure, found.max, found.verdict) for found in kept] == [("S2", 301, "broken"), ("S10", 200, "met")]
    assert [found.measured.endswith("new") for found in kept] == [True, False]
    assert kept[0].failures == 1


def test_the_table_takes_the_place_of_the_old_one(tmp_path: Path):
    docs = tmp_path / "safety.md"
    docs.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    ledger = Ledger()
    ledger.merge(report(Result(figure="S2", promise=Promise(what="stop", hard=300), samples=[1.0] * 30)))
    ledger.write_docs(docs)
    text = docs.read_text()
    assert text.startswith("before\n")
    assert text.endswith(f"{END}\nafter\n")
    assert "old" not in text
    assert "|S2|stop||30|1.0|1.0|1.0||300||" in text


def test_under_a_load_a_figure_counts_as_its_own_and_other_times_are_let_go():
    results = Results(PROMISES)
    loaded = results.under("H")
    for figure in ("S1", "S8 clean"):
        loaded.sample(figure, 5.0)
    loaded.check("S14", ["it moved"])
    assert set(results.by_figure) == {"S1 H", "S14"}


def test_every_scenario_has_a_figure():
    firsts = {figure.split()[0] for figure in PROMISES} | set(FIGURE_OF)
    assert set(SCENARIOS) <= firsts


@given(st.floats(-100, 100), st.floats(-10, 10))
def test_the_slope_of_a_line_is_found(start: float, per_hour: float):
    assert slope([(hour, start + per_hour * hour) for hour in range(5)]) == pytest.approx(per_hour, abs=1e-6)


def test_so_many_tries_are_made_at_least():
    assert SCENARIOS["S8"].for_tries(100) == 20
    assert SCENARIOS["S1"].for_tries(100) == 100


def test_figures_of_the_base_become_those_of_the_whole_robot_and_others_stay():
    whole = Results(PROMISES, whole=True)
    assert [whole.of(figure).promise.robot for figure in ("S1", "S19", "B4 lbr")] == [
        "whole",
        "base, imu, attitude",
        "lbr-sim, whole",
    ]
    assert Results(PROMISES).of("S1").promise.robot == "base"


def test_what_was_tried_again_is_kept_with_the_result(tmp_path: Path):
    ledger = Ledger()
    found = report(Result(figure="S2", promise=Promise(what="stop", hard=300), samples=[1.0]))
    found.repeated.append("S2, by itself: beside 3 others S2 312 ms, at most 300")
    ledger.merge(found)
    assert ledger.figures[0].measured.endswith("; 1 measured again")
