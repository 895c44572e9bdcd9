"""`lbr behaviour try`: a table tried in the simulated world before it moves anything, faster than real time."""

import time
from collections import Counter
from importlib.util import find_spec
from statistics import median
from typing import TYPE_CHECKING, Any

import click
from msgspec.structs import replace

from lbr import home
from lbr.commands.options import Number, database_option, json_option, print_json
from lbr.commands.rows import planned
from lbr.database.rows import RobotRows
from lbr.errors import InputError
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from lbr.messages.rows import row_set

if TYPE_CHECKING:
    from lbr.simulation.trials.trial import Begins, Outcome, Setup

LONGEST_S = 900.0
WITHOUT_END_S = 180.0
MOST_TOLD = 8

OPTIONS = (
    click.argument("source", metavar="FILE|TABLE"),
    click.option("--runs", type=click.IntRange(1, 100_000), default=20, show_default=True, help="How many trials."),
    click.option(
        "--faults", type=click.IntRange(0, 1000), default=0, help="So many more with each thing that may go wrong."
    ),
    click.option(
        "--seed", type=click.IntRange(0), default=1, show_default=True, help="The same trials for the same number."
    ),
    click.option("--for", "max_s", type=Number(1.0, 86400.0), metavar="SECONDS", help="The longest a trial may last."),
    click.option(
        "--jobs", type=click.IntRange(1, 256), metavar="N", help="Trials at a time; one for each core if left out."
    ),
    click.option("--only", type=click.IntRange(0), metavar="NUMBER", help="One trial alone, with all its events."),
    click.option("--fault", metavar="NAME", help="What is wrong in the trial of --only."),
    click.option(
        "--begins",
        type=click.Choice(["standing", "fallen"]),
        help="How a humanoid begins; if left out it has fallen where the table itself gets it up, else it stands.",
    ),
    click.option("--robot", metavar="NAME", help="Whose behaviours; the usual robot's if left out."),
    database_option,
    json_option,
)


def options(command: Any) -> Any:
    """Give a command all options of trials."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


def tries(
    source: str,
    rows: RobotRows,
    table: BehaviourTable,
    of_table: tuple[BehaviourRow, ...],
    *,
    as_json: bool,
    **given: Any,
) -> int:
    """Try a table, and print the outcome; return the exit code."""
    setup, seed = _setup(rows, table, of_table, given["max_s"], given["begins"]), given["seed"]
    if given["only"] is not None:
        return _try_once(setup, given["only"], given["fault"] or "", seed, as_json=as_json)
    if given["fault"]:
        raise InputError("--fault goes with --only: --faults 1 tries each fault once")
    from rich.console import Console
    from rich.progress import Progress

    from lbr.simulation.trials.faults import ANY, BODY, DOCKING  # noqa: PLC0415
    from lbr.simulation.trials.trying import tried  # noqa: PLC0415

    wrong = BODY if setup.humanoid is not None else DOCKING if _docks(setup) else ANY
    trials = [(number, "") for number in range(given["runs"])]
    trials += [(number, name) for name in wrong for number in range(given["faults"])]
    began = time.monotonic()
    outcomes: list[Outcome] = []
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(f"trying '{setup.table}'", total=len(trials))
        for outcome in tried(setup, trials, seed=seed, jobs=given["jobs"] or 0):
            outcomes.append(outcome)
            bar.advance(task)
    outcomes.sort(key=lambda outcome: (outcome.fault, outcome.number))
    took_s = time.monotonic() - began
    if as_json:
        print_json({"table": setup.table, "seed": seed, "took_s": round(took_s, 1), "trials": outcomes})
    else:
        click.echo(report(source, setup.table, outcomes, took_s, seed))
    return int(any(outcome.unsafe or not (outcome.good or outcome.fault) for outcome in outcomes))


def report(source: str, table: str, outcomes: "list[Outcome]", took_s: float, seed: int) -> str:
    """Return the outcomes of trials, for people."""
    plain, faulty = [each for each in outcomes if not each.fault], [each for each in outcomes if each.fault]
    robot_s = sum(each.took_s for each in outcomes)
    fast = f"{robot_s / max(took_s, 0.001):.0f} times as fast"
    lines = [f"'{table}', {len(outcomes)} trials: {_span(robot_s)} of the robot's time in {_span(took_s)}, {fast}"]
    lines += _endings(plain)
    good = sorted(each.took_s for each in plain if each.good)
    if good:
        late = good[min(len(good) - 1, int(0.95 * len(good)))]
        lines.append(
            f"  good ones took {median(good):.1f} s, 95 % of them at most {late:.1f}, all at most {good[-1]:.1f}"
        )
    fastest = max((each.contact_mps for each in outcomes), default=0.0)
    if any(each.began for each in outcomes):
        lines.append(_stances(plain))
    else:
        lines.append(f"  came against nothing at more than {fastest:.2f} m/s" if fastest else "  touched nothing")
    for name in dict.fromkeys(each.fault for each in faulty):
        of_fault = [each for each in faulty if each.fault == name]
        how = Counter(("good: " if each.good else "") + each.text for each in of_fault).most_common(3)
        lines.append(f"  {name}: " + "; ".join(f"{text} ({count})" if count > 1 else text for text, count in how))
    for each in outcomes:
        lines += [f"  NOT SAFE: {_called(each)}: {text}" for text in each.unsafe]
    bad = next((each for each in plain if not each.good), None)
    if bad is not None:
        again = f"lbr behaviour try {source} --seed {seed} --only {bad.number}"
        lines.append(f"look at one that failed: {again}")
    return "\n".join(lines)


def _endings(outcomes: "list[Outcome]") -> list[str]:
    """Return a line for each way in which trials ended, the most frequent first."""
    by_how: Counter[tuple[bool, str, str, int, str]] = Counter()
    texts: dict[tuple[bool, str, str, int, str], Outcome] = {}
    for each in outcomes:
        how = (each.good, each.table, each.state, 0 if each.good else each.row, each.code)
        by_how[how] += 1
        texts.setdefault(how, each)
    lines = []
    for how, count in by_how.most_common(MOST_TOLD):
        each = texts[how]
        where = f"'{each.state}'" + ("" if each.good else f", row {each.row} of '{each.table}'")
        example = f"(such as trial {each.number}, from {each.place})"
        said = each.text if each.good else f"FAILED in {where}: {each.text} {example}"
        lines.append(f"  {count:5} {100 * count / len(outcomes):4.0f} %  {said}")
    if len(by_how) > MOST_TOLD:
        lines.append(f"         and {len(by_how) - MOST_TOLD} other ways; --json has them all")
    return lines


def _stances(outcomes: "list[Outcome]") -> str:
    """Return how often a humanoid stood at the end, by how it began, and how often it fell."""
    begun: dict[str, list[Outcome]] = {}
    for each in outcomes:
        begun.setdefault(each.began, []).append(each)
    stood = (f"{began}: {sum(each.stands for each in of)} of {len(of)}" for began, of in sorted(begun.items()))
    return f"  stood at the end, having begun {'; '.join(stood)}; fell in {sum(each.falls > 0 for each in outcomes)}"


def _called(one: "Outcome") -> str:
    return f"trial {one.number}" + (f" with {one.fault}" if one.fault else "") + f" from {one.place}"


def _span(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{seconds:.1f} s"


def _try_once(setup: "Setup", number: int, fault: str, seed: int, *, as_json: bool) -> int:
    """Run one trial, and print its events."""
    from lbr.simulation.trials.faults import EVERY  # noqa: PLC0415 - kept out of its `--help`
    from lbr.simulation.trials.trying import made  # noqa: PLC0415

    if fault and fault not in EVERY:
        raise InputError(f"there is no fault '{fault}': there is {', '.join(EVERY)}", "unknown_name")
    trial = made(setup, number, fault, seed)
    outcome = trial.run()
    if as_json:
        print_json({"trial": outcome, "told": [event._asdict() for event in trial.events]})
        return int(not outcome.good)
    began_s = min((event.at_s for event in trial.events if event.kind == "behaviour_began"), default=0.0)
    click.echo(f"{_called(outcome)}:")
    for event in trial.events:
        if event.at_s >= began_s:
            click.echo(f"  {event.at_s - began_s:7.2f} s  {event.subject}: {event.text}")
    where = f" in '{outcome.state}', row {outcome.row} of '{outcome.table}'" if not outcome.good else ""
    said = f"{'good' if outcome.good else 'FAILED'}{where} after {outcome.took_s:.1f} s and {outcome.moved_m:.1f} m"
    click.echo(f"{said}: {outcome.text}")
    return int(not outcome.good or bool(outcome.unsafe))


def _docks(setup: "Setup") -> bool:
    return any(b'"beacon"' in bytes(rows.rows) for unit in setup.units.values() if unit.kind == "behaviour"
               for table, rows in unit.rows.items() if table == "behaviour_row")  # fmt: skip


def _setup(
    rows: RobotRows,
    table: BehaviourTable,
    of_table: tuple[BehaviourRow, ...],
    max_s: float | None,
    begins: "Begins | None",
) -> "Setup":
    """Return the setup of trials; raise InputError without the extra 'sim'."""
    if find_spec("mujoco") is None:
        raise InputError("trials need the extra 'sim': pip install 'lbr[sim]'", "not_possible")
    longest_s = max_s or (table.max_s if 0.0 < table.max_s <= LONGEST_S else WITHOUT_END_S)
    return setup_of(rows, table, of_table, longest_s, str(home.home()), begins)


def setup_of(
    rows: RobotRows,
    table: BehaviourTable,
    of_table: tuple[BehaviourRow, ...],
    max_s: float,
    home: str,
    begins: "Begins | None" = None,
) -> "Setup":
    """Return the setup of trials: these rows' processes with the table; raise InputError if it cannot be tried."""
    from lbr.simulation.trials.trial import HUMANOID, RUNS, WORLD, Setup  # noqa: PLC0415

    plan, problems = planned(rows)
    if plan is None:
        raise InputError(
            f"the rows of {rows.robot.name} make no robot: {problems[0]}; 'lbr db check' lists all problems",
            "bad_value",
        )
    units = {name: unit.config for name, unit in plan.units.items() if unit.program is None}
    by_kind = {unit.kind: name for name, unit in plan.units.items()}
    walks = HUMANOID in by_kind and {"joints", "motions"} <= by_kind.keys()
    if not walks and (WORLD not in by_kind or "drive" not in by_kind):
        raise InputError(
            f"{rows.robot.name} cannot be tried: trials are of robots on wheels, with a row of kind 'world' and one of "
            f"'drive', and of humanoids, with rows of the kinds '{HUMANOID}', 'joints' and 'motions'",
            "not_possible",
        )
    if RUNS not in by_kind:
        raise InputError(f"{rows.robot.name} runs no tables: it has no capability of kind '{RUNS}'", "not_possible")
    tables = {each.name: each for each in rows.of(BehaviourTable)} | {table.name: table}
    lines = [row for row in rows.of(BehaviourRow) if row.behaviour != table.name]
    sets = {
        BehaviourTable.TABLE: row_set(BehaviourTable, tables.values()),
        BehaviourRow.TABLE: row_set(BehaviourRow, (*lines, *of_table)),
    }
    runs = units[by_kind[RUNS]]
    units[by_kind[RUNS]] = replace(runs, rows={**runs.rows, **sets})
    named = by_kind[HUMANOID if walks else WORLD]
    units = {(WORLD if name == named else name): unit for name, unit in units.items()}
    world = plan.kinds[named].parse(units[WORLD].settings)
    setup = Setup(robot=rows.robot.name, table=table.name, units=units, home=home, max_s=max_s)
    if not walks:
        return replace(setup, world=world)
    from lbr.operations.motions.fall import GETS_UP  # noqa: PLC0415 - for those who try tables

    gets_up = any(str(row.outputs.get("motion", "")).startswith(GETS_UP) for row in of_table)
    return replace(setup, humanoid=world, begins=begins or ("fallen" if gets_up else "standing"))
