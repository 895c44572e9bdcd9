"""The figures, with their targets and hard limits."""

from benchmarks.figures import Promise

STOP_HARD_MS = 300.0

PROMISES: dict[str, Promise] = {
    "S1": Promise(what="kill -9 motor driver, to motor zero", target=50, hard=STOP_HARD_MS),
    "S2": Promise(what="SIGSTOP motor driver, to motor zero", target=200, hard=STOP_HARD_MS),
    "S3": Promise(what="kill -9 drive, to motor zero", target=50, statistic="p99", hard=STOP_HARD_MS),
    "S4": Promise(what="SIGSTOP drive, to motor zero", target=220, hard=STOP_HARD_MS),
    "S5": Promise(what="every link of the router breaks, to motor zero", hard=STOP_HARD_MS),
    "S6": Promise(what="kill -9 executive, to motor zero", target=50, hard=STOP_HARD_MS),
    "S6 gone": Promise(what="kill -9 executive, to no process left", target=500, hard=2000),
    "S7": Promise(what="SIGSTOP executive or client, to motor zero", hard=STOP_HARD_MS),
    "S11": Promise(what="SIGSTOP all processes, to motor zero", target=260, hard=STOP_HARD_MS),
    "S12": Promise(what="kill -9 motor driver and guard together, to motor zero", hard=STOP_HARD_MS),
    "S14": Promise(what="nothing turns after a stop until a new command; a new driver begins with zero"),
    "F6": Promise(what="outputs within the configured maximum and slew, in every scenario"),
    "P1 motors": Promise(what="kill -9 motor driver, to ready", target=500, statistic="p95", hard=2000),
    "P1 drive": Promise(what="kill -9 drive, to ready", target=1000, statistic="p95", hard=2000),
    "P1 ranges": Promise(what="kill -9 range driver, to ready", target=500, statistic="p95", hard=2000),
    "P1 world": Promise(what="kill -9 simulated world, to ready", target=1000, statistic="p95", hard=2000),
    "S8": Promise(what="client killed, hung up or gone, to motor zero", hard=STOP_HARD_MS),
    "S8 clean": Promise(what="client leaves, to motor zero", target=50, statistic="p50", hard=STOP_HARD_MS),
    "S13": Promise(what="crash from within (11 ways, driver and app), to motor zero", hard=STOP_HARD_MS),
    "S13 gone": Promise(what="crash from within, to process gone", target=500, hard=1000),
    "S13 ready": Promise(what="crash from within, to ready", target=1000, hard=2000),
    "P5 stop": Promise(what="hang (4 ways, driver and app), to motor zero", hard=STOP_HARD_MS),
    "P5 gone": Promise(what="hang, to process killed", target=1500, hard=3000),
    "P5 ready": Promise(what="hang, to ready", target=3000, hard=5000),
    "S18 interval": Promise(what="end of a timed move, off by; never 20 ms early", target=40, hard=150),
    "S18 range": Promise(what="range crossed (frame at the driver), to motor zero", target=120, hard=150),
    "E1 console": Promise(what="estop as a console line, to motor zero", target=20, statistic="p99", hard=250),
    "E1 put": Promise(what="estop as a plain put, to motor zero", target=20, statistic="p99", hard=250),
    "E1 H": Promise(
        what="estop as a console line under 4 busy loops, to motor zero", target=50, statistic="p99", hard=250
    ),
    "B1 I": Promise(what="interval of motor commands", target=22, statistic="p99"),
    "B1 H": Promise(what="interval of motor commands under 4 busy loops", target=35, statistic="p99"),
    "B2 I": Promise(what="stops that nobody asked for, in 10 s", unit="", target=0),
    "B2 H": Promise(what="stops that nobody asked for, in 10 s under 4 busy loops", unit="", target=0),
    "F7": Promise(what="foreign, forged and replayed setpoints, second run, second opener"),
    "F7 second run": Promise(what="second run refused after", target=500, hard=1000),
    "P4 stop": Promise(what="shutdown (5 ways), to motor zero", target=100, hard=STOP_HARD_MS),
    "P4 gone": Promise(what="shutdown (5 ways), to all gone", target=1500, hard=3000),
    "P4 gone, one frozen": Promise(what="shutdown with one process frozen, to all gone", target=3000, hard=5000),
    "P4": Promise(what="shutdown: exit code 0, nothing left, in order"),
    "P6": Promise(what="cold start, database made, to ready", target=1500, hard=3000),
    "P6 bytes": Promise(what="until ready the controller hears set-up, questions and zero only"),
    "P7": Promise(what="start with a device missing, busy or wrong, to ready; told, and driving refused", hard=5000),
    "P8": Promise(what="100 row edits a second: no needless restart, invalid ones change nothing, nothing locked"),
    "P8 edit": Promise(what="time of one such edit", target=50, statistic="p99"),
}
