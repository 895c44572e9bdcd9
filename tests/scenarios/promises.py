"""The figures, with their targets and hard limits."""

from msgspec import structs

from tests.support.figures import BASE, WHOLE, Promise

STOP_HARD_MS = 300.0
DEVICES = "base, no simulation"
SERVED = "uxa90-sim, its joints, motions and server"

STATED: dict[str, Promise] = {
    "S1": Promise(what="kill -9 motor driver, to motor zero", target=50, hard=STOP_HARD_MS),
    "S2": Promise(what="SIGSTOP motor driver, to motor zero", target=200, hard=STOP_HARD_MS),
    "S3": Promise(what="kill -9 drive, to motor zero", target=50, statistic="p99", hard=STOP_HARD_MS),
    "S4": Promise(what="SIGSTOP drive, to motor zero", target=220, hard=STOP_HARD_MS),
    "S5": Promise(what="every link of the router breaks, to motor zero", hard=STOP_HARD_MS),
    "S6": Promise(what="kill -9 executive, to motor zero", target=50, hard=STOP_HARD_MS),
    "S6 gone": Promise(what="kill -9 executive, to no process left", target=500, hard=2000),
    "S6 frozen": Promise(
        what="the same with anything frozen, to no process left", target=1500, hard=2000, robot="whole, any of three"
    ),
    "S6 frozen stop": Promise(
        what="kill -9 executive with anything frozen, to motor zero", hard=STOP_HARD_MS, robot="whole, any of three"
    ),
    "S7": Promise(what="SIGSTOP executive or client, to motor zero", hard=STOP_HARD_MS),
    "S11": Promise(what="SIGSTOP all processes, to motor zero", target=260, hard=STOP_HARD_MS),
    "S12": Promise(what="kill -9 motor driver and guard together, to motor zero", hard=STOP_HARD_MS),
    "S1 H": Promise(what="kill -9 motor driver, to motor zero", target=100, hard=STOP_HARD_MS),
    "S1 G": Promise(what="kill -9 motor driver, to motor zero", target=100, hard=STOP_HARD_MS),
    "S3 H": Promise(what="kill -9 drive, to motor zero", hard=STOP_HARD_MS),
    "S3 G": Promise(what="kill -9 drive, to motor zero", hard=STOP_HARD_MS),
    "S6 H": Promise(what="kill -9 executive, to motor zero", hard=STOP_HARD_MS),
    "S6 G": Promise(what="kill -9 executive, to motor zero", hard=STOP_HARD_MS),
    "S8 H": Promise(what="client killed, to motor zero", hard=STOP_HARD_MS),
    "S8 G": Promise(what="client killed, to motor zero", hard=STOP_HARD_MS),
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
    "S15": Promise(what="range board silent, unplugged, garbled or blind, to motor zero", target=400, hard=600),
    "S15 frozen": Promise(what="range board repeats one reading, to motor zero", target=400, hard=1000),
    "S16": Promise(what="motor cable pulled, to the fault told", target=200, hard=500),
    "S16 stop": Promise(what="motor cable pulled, to motor zero", hard=STOP_HARD_MS),
    "S17": Promise(what="controller that was deaf for 2 s, to motor zero after it hears again", hard=50),
    "S17 lines": Promise(what="old commands that it then obeys", unit="", target=3, hard=3),
    "S18 interval": Promise(what="end of a timed move, off by; never 20 ms early", target=40, hard=150),
    "S18 range": Promise(what="range crossed (frame at the driver), to motor zero", target=120, hard=150),
    "S19": Promise(
        what="turn that loses its client, inertial unit, attitude or drive, to motor zero",
        target=300,
        hard=500,
        robot="base, imu, attitude",
    ),
    "S21 full": Promise(what="operator's terminal takes no output, to motor zero", target=800, hard=2000),
    "S21 silent": Promise(what="operator's terminal answers no more, to motor zero", target=1500, hard=2500),
    "S21 s": Promise(what="`s` typed at a terminal that is not read, to motor zero", target=100, hard=STOP_HARD_MS),
    "S21 left": Promise(what="Ctrl-C or SIGTERM at such a terminal, to console gone", target=1000, hard=3000),
    "E1 console": Promise(what="estop as a console line, to motor zero", target=20, statistic="p99", hard=250),
    "E1 put": Promise(what="estop as a plain put, to motor zero", target=20, statistic="p99", hard=250),
    "E1 console H": Promise(
        what="estop as a console line under load, to motor zero", target=50, statistic="p99", hard=250
    ),
    "E1 put H": Promise(what="estop as a plain put under load, to motor zero", target=50, statistic="p99", hard=250),
    "E1 console G": Promise(what="estop as a console line (E4), to motor zero", target=50, statistic="p99", hard=250),
    "E1 put G": Promise(what="estop as a plain put (E4), to motor zero", target=50, statistic="p99", hard=250),
    "E2": Promise(what="the latch survives dead processes, restarts, an older database, lost links: nothing moves"),
    "E3": Promise(what="a 20 Hz stream through emergency stop and reset moves nothing until it pauses"),
    "E5": Promise(what="stop, emergency stop, reset and motion by role and by plain key, as the rows say"),
    "E6 dead": Promise(what="estop as the executive is killed, to motor zero", target=100, hard=STOP_HARD_MS),
    "E7": Promise(what="an emergency stop that the device does not acknowledge is never called done"),
    "E7 stop": Promise(what="emergency stop of a controller that says nothing, to motor zero", hard=250),
    "B1 I": Promise(what="interval of motor commands", target=22, statistic="p99"),
    "B1 H": Promise(what="interval of motor commands under 4 busy loops", target=35, statistic="p99"),
    "B2 I": Promise(what="stops that nobody asked for, in 10 s", unit="", target=0),
    "B2 H": Promise(what="stops that nobody asked for, in 10 s under 4 busy loops", unit="", target=0),
    "F2": Promise(
        what="commands and setpoints recorded and sent again, by the same and another connection: none counts"
    ),
    "F3": Promise(what="commands dated before, twice, overtaken, with impossible numbers: none that is not new counts"),
    "F4": Promise(what="wall clock of the robot jumps by up to an hour 30 times a second: no stop"),
    "S8 clock": Promise(what="client killed under that clock (F4), to motor zero", hard=STOP_HARD_MS),
    "E1 put clock": Promise(what="estop as a plain put under that clock (F4), to motor zero", hard=250),
    "B3": Promise(what="10 listeners to everything, 5 frozen and 5 slow: no process ends"),
    "B3 stop": Promise(
        what="estop as a console line before and under them, to motor zero", target=20, statistic="p99", hard=250
    ),
    "B3 ratio": Promise(
        what="median of that under them, as many times the median before", unit="", target=1.2, statistic="p50"
    ),
    "B3 memory": Promise(what="growth of any process under them", unit="MiB", target=20, hard=100),
    "F7": Promise(what="foreign, forged and replayed setpoints, second run, second opener"),
    "F7 second run": Promise(what="second run refused after", target=500, hard=1000),
    "P2": Promise(what="a program that ends at once: five starts more, each later, then given up with a reason"),
    "P2 CPU": Promise(what="CPU of that loop, of one core over 30 s", unit="%", target=5),
    "P2 period": Promise(
        what="p99 of motor commands' intervals meanwhile, as many times that before",
        unit="",
        target=1.1,
        statistic="p50",
    ),
    "P3": Promise(
        what="random signals while three people use the robot: no motion while latched, nothing lost or left"
    ),
    "P3 ready": Promise(what="last signal to all ready", target=5000, hard=10000),
    "P3 memory": Promise(what="growth of resident memory, of any process", unit="%", target=10),
    "P4 stop": Promise(what="shutdown (5 ways), to motor zero", target=100, hard=STOP_HARD_MS),
    "P4 gone": Promise(what="shutdown (5 ways), to all gone", target=1500, hard=3000),
    "P4 gone, one frozen": Promise(what="shutdown with one process frozen, to all gone", target=3000, hard=5000),
    "P4": Promise(what="shutdown: exit code 0, nothing left, in order"),
    "P6": Promise(
        what="cold start, database made, to ready, by the clock of a machine as fast as it should be",
        target=1500,
        hard=3000,
        robot=WHOLE,
    ),
    "P6 bytes": Promise(what="until ready the controller hears set-up, questions and zero only", robot=DEVICES),
    "P7": Promise(
        what="start with a device missing, busy or wrong, to ready; told, and driving refused", hard=5000, robot=DEVICES
    ),
    "P8": Promise(what="100 row edits a second: no needless restart, invalid ones change nothing, nothing locked"),
    "P8 edit": Promise(what="time of one such edit", target=50, statistic="p99"),
    "P9": Promise(
        what="stop, estop or status while 300 and 40 rows come at once, to its answer", target=100, hard=1000
    ),
    "P9 heard": Promise(what="each of them is done"),
    "P10": Promise(what="descriptors more after adding and removing a capability, again and again", unit="", target=0),
    "P10 threads": Promise(what="threads more after that", unit="", target=5),
    "P10 memory": Promise(what="memory of the executive more after that", unit="MiB", target=10),
    "P10 end": Promise(what="shutdown after that", target=3000, hard=5000),
    "B5": Promise(what="start under 4 and under 30 busy loops: no process ends, and it is ready"),
    "B5 H": Promise(what="start of lbr-sim under 4 busy loops, to ready"),
    "B5 30": Promise(what="start of lbr-sim under 30 busy loops, to ready"),
    "W1": Promise(what="stop by HTTP beside what one address holds open: answered", robot=SERVED),
    "W1 idle": Promise(what="stop by HTTP beside 40 idle connections, to its answer", target=300, robot=SERVED),
    "W1 heads": Promise(what="stop by HTTP beside 200 half heads, to its answer", target=300, robot=SERVED),
    "W1 bodies": Promise(
        what="stop by HTTP beside 200 bodies that do not come, to its answer", target=300, robot=SERVED
    ),
    "W1 stops": Promise(
        what="stop by HTTP beside 200 stops that are half said, to its answer", target=300, robot=SERVED
    ),
}
"""Without `robot` a figure is of the base of lbr, or of all of lbr with `--whole`: what runs anything else names it."""

AT_REST: dict[str, Promise] = {
    f"B4 {robot}{suffix}": Promise(what=what, unit=unit, target=target, robot=f"{robot}-sim, whole")
    for robot in ("lbr", "bioloid", "uxa90")
    for suffix, what, unit, target in (
        ("", "memory of all processes at rest (PSS, shared pages counted once)", "MiB", 300.0),
        (" private", "memory at rest that no other process shares", "MiB", None),
        (" RSS", "resident memory at rest, shared pages counted by each process", "MiB", None),
        (" real", "memory at rest without the simulation (PSS)", "MiB", None),
        (" CPU", "CPU at rest, of one core, without the simulation", "%", 15.0),
        (" CPU all", "CPU at rest, of one core, simulation and its pictures included", "%", None),
        (" processes", "processes at rest", "", None),
    )
}
"""What a robot costs that nobody drives, everything running that ships: its cameras, its servers, its speech."""

PROMISES: dict[str, Promise] = {
    name: promise if promise.robot else structs.replace(promise, robot=BASE) for name, promise in STATED.items()
} | AT_REST
