"""Measures each client's rate of reading servos, its cost, and the truth of every state; all on a simulated line.

`python -m benchmarks servo_bus [--rounds N] [--seconds S] [--json FILE]`. Eighteen emulated AX-12A at 1 Mbit/s on a
pty, with the servos' own delays and jitter and no USB. In turns, so that other load affects all equally: (a) a loop in
C, the floor; (b) lbr's block read; (c) the vendor's kit with three reads for each state; (d) the vendor's kit with a
block read; at return delays of 0, 250 and 500 us. Then the USB2AX's sync read against the limit of its line, and (b)
and the sync read beside every fault of a line. Every state has a counter: a wrong state differs from the servo's, a
stale one is an earlier one. Exit code 1 for any of these.

(c) and (d) need `pip install dynamixel-sdk`, (a) a C compiler as `cc`; without, they are left out. Rates depend on the
machine: trust ratios and CPU time.
"""

import argparse
import statistics
import time
from collections.abc import Iterator, Sequence
from typing import Any

import msgspec

from benchmarks import Measured
from tests.support.figures import Promise, Results
from tests.support.servo_bus.arithmetic import wire_hz
from tests.support.servo_bus.line import Line, line

SMOKE = "--rounds 1 --seconds 0.05 --no-faults"

PROMISES = {"servo bus": Promise(what="states that were read, each what the servo said, and not what it said before")}
DELAYS = {0: 0, 125: 250, 250: 500}
"""Values of the return delay register, with their microseconds."""

NAMES = {
    "floor": "(a) C: write, poll, read",
    "block": "(b) lbr, block read",
    "vendor_three": "(c) dynamixel-sdk, three reads",
    "vendor_block": "(d) dynamixel-sdk, block read",
    "together": "lbr, sync read of a USB2AX",
}
FAULTS: dict[str, dict[str, Any]] = {
    "lost answers": {"drop": 0.05},
    "wrong bits": {"bit_flip": 0.05},
    "noise before answers": {"garbage": 0.05},
    "stray packets": {"stray": 0.05},
    "answers cut short": {"half": 0.05},
    "answers in pieces": {"pieces": 0.2},
    "late answers": {"late": 0.02},
    "echo": {"echo": True},
    "a silent servo": {"silent": [7]},
    "two servos with one id": {"duplicate": [7]},
    "babble": {"babbling": True},
    "unplugged and back": {"unplug": True},
    "no supply, and back": {"brown_out": True},
}
PASSING = {"unplug", "brown_out"}
"""Faults that end halfway."""


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the duration."""
    parser.add_argument("--rounds", type=int, default=7, help="default: %(default)s")
    parser.add_argument("--seconds", type=float, default=0.6, help="how long each client reads in each round")
    parser.add_argument("--no-faults", action="store_true", help="leave the faults out")


def measure(given: argparse.Namespace) -> Measured:
    """Let all clients read in turns, then beside faults."""
    with line() as under_test:
        missing = {"floor", "vendor_three"} - set(under_test.kinds)
        text = [f"left out: {NAMES[kind]}; see --help" for kind in sorted(missing)]
        figures = [figure for delay in DELAYS for figure in compare(under_test, delay, given.rounds, given.seconds)]
        survived = [] if given.no_faults else list(survive(under_test, max(1.0, given.seconds)))
    text += ["", table(figures), "", *([fault_table(survived)] if survived else []), *verdicts(figures)]
    results = Results(PROMISES)
    result = results.of("servo bus")
    read: tuple[Figure | Survived, ...] = (*figures, *survived)
    for found in read:
        result.checks += found.states
        bad = found.wrong + found.stale
        result.violations += [f"{found.client}: {found.wrong} wrong, {found.stale} stale"] if bad else []
    kept = {"figures": figures, "faults": survived}
    load = f"{given.rounds} rounds of {given.seconds:g} s"
    return Measured(results=results.ordered(), load=load, text="\n".join(text), figures=kept)


class Figure(msgspec.Struct, kw_only=True):
    """A client at a return delay: medians over the rounds, sums of violations."""

    client: str
    delay_us: int
    rate_hz: float
    of_wire: float
    of_floor: float | None
    cpu_us: float
    states: int
    lost: int
    wrong: int
    stale: int


class Survived(msgspec.Struct, kw_only=True):
    """A client beside a fault, and its reads per second after the fault."""

    client: str
    fault: str
    states: int
    lost: int
    wrong: int
    stale: int
    longest_ms: float
    rate_hz: float
    after_hz: float


def compare(under_test: Line, delay: int, rounds: int, seconds: float) -> Iterator[Figure]:
    """Let all clients read in turns at a return delay."""
    runs: dict[str, list[dict[str, Any]]] = {kind: [] for kind in (*under_test.kinds, "together")}
    for _ in range(rounds):
        for kind, done in runs.items():
            under_test.set(delay=delay, usb2ax=5 if kind == "together" else None)
            done.append(under_test.run(kind, seconds))
    for kind, done in runs.items():
        rates = [run["states"] / run["wall_s"] for run in done]
        floor = [run["states"] / run["wall_s"] for run in runs.get("floor", [])]
        ratios = [own / least for own, least in zip(rates, floor, strict=False)]
        yield Figure(
            client=kind,
            delay_us=DELAYS[delay],
            rate_hz=statistics.median(rates),
            of_wire=statistics.median(rates) / wire_hz(kind, delay),
            of_floor=statistics.median(ratios) if ratios and kind != "together" else None,
            cpu_us=statistics.median(run["cpu_s"] / max(1, run["states"]) * 1e6 for run in done),
            **{name: sum(run[name] for run in done) for name in ("states", "lost", "wrong", "stale")},
        )


def survive(under_test: Line, seconds: float) -> Iterator[Survived]:
    """Let lbr's clients read beside each fault, and once more when it has gone."""
    for kind in ("block", "together"):
        for fault, faults in FAULTS.items():
            under_test.set(delay=0, usb2ax=5 if kind == "together" else None)
            under_test.run(kind, 0.05)
            passing = set(faults) & PASSING
            client = under_test.start(kind, seconds)
            time.sleep(seconds / 4)
            under_test.set(faults=faults)
            if passing:
                time.sleep(seconds / 4)
                under_test.set(faults={})
            run = client.answer()
            under_test.set(faults={})
            after = under_test.run(kind, seconds / 2)
            yield Survived(
                client=kind,
                fault=fault,
                **{name: run[name] + after[name] for name in ("lost", "wrong", "stale")},
                states=run["states"],
                longest_ms=run["longest_s"] * 1e3,
                rate_hz=run["states"] / run["wall_s"],
                after_hz=after["states"] / after["wall_s"],
            )


def verdicts(figures: Sequence[Figure]) -> Iterator[str]:
    """Yield the verdict on each target."""
    by = {(figure.client, figure.delay_us): figure for figure in figures}
    for delay_us in DELAYS.values():
        own, three, vendor = (by.get((kind, delay_us)) for kind in ("block", "vendor_three", "vendor_block"))
        assert own is not None
        said = [f"CPU {own.cpu_us:.0f} us per state ({_met(own.cpu_us < 80.0)}: < 80)"]
        if own.of_floor is not None:
            said.insert(0, f"{own.of_floor:.2f} of the floor ({_met(own.of_floor >= 0.85)}: >= 0.85)")
        if three is not None and vendor is not None:
            faster = own.rate_hz / three.rate_hz
            said.append(f"{faster:.2f} x (c) ({_met(faster >= 2.5)}: >= 2.5)")
            said.append(f"{own.cpu_us / vendor.cpu_us:.2f} of the CPU of (d)")
        yield f"return delay {delay_us} us: lbr's block read is at " + ", ".join(said)


def table(figures: Sequence[Figure]) -> str:
    """Return a Markdown table of the clients."""
    rows = [
        "| return delay us | client | states/s | of the wire | of (a) | CPU us/state | lost | wrong | stale |",
        "|--:|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for figure in figures:
        floor = "" if figure.of_floor is None else f"{figure.of_floor:.2f}"
        rows.append(
            f"| {figure.delay_us} | {NAMES[figure.client]} | {figure.rate_hz:.0f} | {figure.of_wire:.2f} | {floor} "
            f"| {figure.cpu_us:.0f} | {figure.lost} | {figure.wrong} | {figure.stale} |"
        )
    return "\n".join(rows)


def fault_table(survived: Sequence[Survived]) -> str:
    """Return a Markdown table of the faults."""
    rows = [
        "| client | fault | states/s | lost | wrong | stale | longest ms | states/s after |",
        "|---|---|--:|--:|--:|--:|--:|--:|",
    ]
    rows += [
        f"| {NAMES[found.client]} | {found.fault} | {found.rate_hz:.0f} | {found.lost} | {found.wrong} | {found.stale} "
        f"| {found.longest_ms:.0f} | {found.after_hz:.0f} |"
        for found in survived
    ]
    return "\n".join(rows) + "\n"


def _met(met: bool) -> str:
    return "met" if met else "missed"
