"""Every scenario: how often is the full amount, how often the gate's, and whether it wants the machine for itself."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from tests.scenarios import (
    bounds,
    clients,
    clocks,
    connections,
    crashes,
    devices,
    edits,
    estop,
    freezes,
    kills,
    latch,
    load,
    loops,
    many_rows,
    orphans,
    replays,
    resets,
    roles,
    shutdown,
    slow,
    starts,
    storms,
    turns,
    unread,
    writers,
)
from tests.scenarios.freezes import repeated
from tests.support.bench import Bench, bench
from tests.support.figures import Results

Way = Callable[[Bench], None]
Run = Callable[[Results, int], None]


def all_of(*ways: Way) -> Run:
    """Return a scenario that goes all ways `n` times on one robot."""
    return lambda results, n: in_turn(*ways)(results, n * len(ways))


def in_turn(*ways: Way) -> Run:
    """Return a scenario that goes `n` times one of the ways on one robot."""

    def run(results: Results, n: int) -> None:
        with bench(results) as under_test:
            for turn in range(n):
                ways[turn % len(ways)](under_test)

    return run


@dataclass(frozen=True, slots=True)
class Scenario:
    """`run(results, n)`. One `n` may be several tries: all ways there are, some seconds, some messages.

    `tries` is how many of its first figure one `n` makes, at least.
    """

    run: Run
    full: int
    gate: int
    alone: bool = False
    tries: int = 1

    def amount(self, n: int) -> int:
        """Return the amount if 300 were the full one."""
        return max(1, round(self.full * n / 300))

    def for_tries(self, tries: int) -> int:
        """Return the amount that makes this many tries."""
        return -(-tries // self.tries)


SCENARIOS: dict[str, Scenario] = {
    "S13": Scenario(crashes.crashes, 30, 1),
    "P3": Scenario(storms.storm, 500, 15),
    "E1": Scenario(all_of(estop.by_console, estop.by_put), 1000, 20),
    "S8": Scenario(all_of(*clients.WAYS), 100, 4, tries=5),
    "S1": Scenario(kills.kill_motor_driver, 300, 20),
    "S3": Scenario(kills.kill_drive, 300, 20),
    "S18": Scenario(bounds.bounds, 200, 6),
    "E7": Scenario(repeated(devices.motors_dumb), 300, 6),
    "E3": Scenario(in_turn(*(partial(resets.reset_under_stream, how=how) for how in resets.STREAMS)), 300, 9),
    "E2": Scenario(in_turn(*latch.WAYS), 300, 8),
    "P5": Scenario(crashes.hangs, 10, 1),
    "S6": Scenario(kills.kill_executive, 100, 6),
    "S6 frozen": Scenario(orphans.anything_frozen, 100, 4),
    "S2": Scenario(repeated(freezes.motor_driver_frozen), 100, 10),
    "S4": Scenario(repeated(freezes.drive_frozen), 100, 6),
    "S5": Scenario(repeated(freezes.links_broken), 100, 10),
    "S7": Scenario(repeated(freezes.executive_frozen, freezes.client_frozen), 50, 3, tries=2),
    "S11": Scenario(repeated(freezes.everything_frozen), 30, 3),
    "S12": Scenario(repeated(freezes.driver_and_guard_killed), 50, 5),
    "S15": Scenario(all_of(*(partial(devices.ranges_fail, name=name) for name in devices.RANGE_FAULTS)), 10, 1),
    "S16": Scenario(repeated(devices.motors_unplugged), 50, 5),
    "S17": Scenario(repeated(devices.motors_deaf), 30, 3),
    "S19": Scenario(turns.turns_lost, 20, 1),
    "S21": Scenario(unread.unread, 100, 1),
    "E5": Scenario(all_of(roles.matrix, roles.plain_keys), 5, 1),
    "E6": Scenario(latch.last_stops, 60, 4),
    "F2": Scenario(replays.replays, 10_000, 1_000),
    "F3": Scenario(all_of(replays.numbered), 1_000, 10),
    "F4": Scenario(clocks.wall_clock_jumps, 30, 2),
    "F7": Scenario(all_of(writers.foreign_setpoints, writers.second_run, writers.second_opener), 30, 1),
    "P1": Scenario(kills.kill_others, 60, 3),
    "P2": Scenario(loops.crash_loops, 5, 1),
    "P4": Scenario(shutdown.shutdowns, 50, 1),
    "P6": Scenario(starts.starts, 60, 1),
    "P7": Scenario(starts.hardware, 20, 1),
    "P9": Scenario(many_rows.rows_at_once, 10, 1),
    "P10": Scenario(many_rows.edits_without_end, 200, 3),
    "P8": Scenario(edits.edits, 60, 5),
    "W1": Scenario(connections.stops_beside, 100, 5),
    "H": Scenario(load.stops_under("H"), 100, 2, alone=True),
    "G": Scenario(load.stops_under("G"), 100, 2, alone=True),
    "B1": Scenario(load.steady, 90, 1, alone=True),
    "B5": Scenario(many_rows.busy_start, 5, 1, alone=True),
    "B3": Scenario(slow.slow_listeners, 10, 1, alone=True),
    "B4": Scenario(slow.at_rest, 60, 5),
}
"""The longest first, so that several at a time end together. P8 and B4 count seconds, B1 ten of them, F2 messages."""

FIGURE_OF = {"H": "E1 console H", "G": "E1 console G", "S6 frozen": "S6 frozen"}
"""What a scenario that cannot go on breaks, if it is not the first figure of its own name."""
