"""The figures, with their targets and hard limits."""

from benchmarks.figures import Promise

STOP_HARD_MS = 300.0

PROMISES: dict[str, Promise] = {
    "S1": Promise(what="kill -9 motor driver, to motor zero", target=50, hard=STOP_HARD_MS),
    "S3": Promise(what="kill -9 drive, to motor zero", target=50, statistic="p99", hard=STOP_HARD_MS),
    "S6": Promise(what="kill -9 executive, to motor zero", target=50, hard=STOP_HARD_MS),
    "S6 gone": Promise(what="kill -9 executive, to no process left", target=500, hard=2000),
    "S14": Promise(what="nothing turns after a stop until a new command; a new driver begins with zero"),
    "F6": Promise(what="outputs within the configured maximum and slew, in every scenario"),
    "P1 motors": Promise(what="kill -9 motor driver, to ready", target=500, statistic="p95", hard=2000),
    "P1 drive": Promise(what="kill -9 drive, to ready", target=1000, statistic="p95", hard=2000),
}
