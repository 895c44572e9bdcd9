"""`lbr why`."""

import time
from pathlib import Path

import click
import msgspec
from click.shell_completion import CompletionItem

from lbr import home
from lbr.commands.options import DEFAULT_PROFILE, FileName, Whom, json_option, print_json, robot_options
from lbr.commands.rows import opened, planned
from lbr.commands.speaking import speaking
from lbr.console import target
from lbr.console.target import Target
from lbr.errors import BusError, InputError
from lbr.executive.planning import facts, profile
from lbr.executive.planning.watch import loaded
from lbr.messages.plain import one_line
from lbr.messages.rows import short
from lbr.messages.system import Event
from lbr.messages.why import Chain
from lbr.why import chain, rendering
from lbr.why.chain import explain
from lbr.why.snapshot import Facts, Snapshot

ANSWER_S = 1.5
"""A running robot answers within a fifth of a second; after this time, its rows are used instead."""
EVENTS = 200


def complete_part(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the parts in the rows here, for completion."""
    path = home.default_database()
    found = {name for facts in _of_rows(path, None) for name in chain.names(facts)} if path.exists() else set()
    return [CompletionItem(name) for name in sorted(found) if name.startswith(begun)]


@click.command("why")
@click.argument("part", required=False, default="", shell_complete=complete_part)
@robot_options
@click.option("--db", "database", type=FileName(), help="The rows to read of a robot that does not run.")
@click.option("-v", "--verbose", is_flag=True, help="Show the whole chain also if nothing is wrong.")
@json_option
def command(part: str, whom: Whom, database: Path | None, verbose: bool, as_json: bool) -> int:
    """Explain why PART stands still: the first broken link from the command to the motor, and its cure. PART is a
    capability, a joint, a camera or another device, or a word of the console; without one it is everything that moves.
    A robot that does not run or does not answer is explained by its rows. Exit code 0: it was explained, 1: there are
    no rows, 2: bad input."""
    answer = ask(part, whom, database)
    if as_json:
        print_json(answer)
    else:
        for line in rendering.lines(answer, verbose=verbose):
            click.echo(one_line(line))
    return 0


def ask(part: str, whom: Whom, database: Path | None) -> Chain:
    """Return why a part stands still: by the robot's own answer, or by its rows without one."""
    began = time.monotonic()
    runs = [run for run in home.running() if whom.robot in {None, run.robot}]
    if not runs and not whom.connect:
        return explain(_dead(part, whom.robot, database or home.default_database()), part)
    try:
        return _answer(target.find(*whom), part)
    except BusError:
        if whom.connect or len(runs) != 1:
            raise
    return explain(_silent(runs[0], time.monotonic() - began), part)


def _answer(robot: Target, part: str) -> Chain:
    """Return the robot's own answer; BusError if it does not answer in time."""
    with speaking(robot, "lbr why", answers_within_s=ANSWER_S) as speaker:
        result = speaker.submit(f"why {part}")
    if result.code != 0:
        raise InputError(result.text, result.reason_code or "refused")  # type: ignore[arg-type]
    return msgspec.convert(result.data, Chain)


def _dead(part: str, robot: str | None, path: Path) -> Snapshot:
    """Return the facts of the rows about a robot that does not run: the named one, else one that has such a part."""
    if not path.exists():
        raise BusError(f"no robot runs here, and there are no rows in {path}; 'lbr run' makes them and starts one")
    found, usual = _of_rows(path, robot), profile.load(DEFAULT_PROFILE).robot
    if not found:
        raise InputError(f"there is no robot {short(robot or '')!r} in {path}", "unknown_name")
    known = [one for one in found if not part or part in chain.names(one)] or found
    return _snapshot(next((one for one in known if one.robot == usual), known[0]), "down", path)


def _silent(running: home.Running, waited_s: float) -> Snapshot:
    """Return the known facts about a robot that holds its lock and does not answer."""
    path = Path(running.database)
    found = _of_rows(path, running.robot, running.profile) if path.exists() else []
    facts = found[0] if found else Facts(robot=running.robot, profile=running.profile)
    return _snapshot(facts, "silent", path, waited_s)


def _snapshot(facts: Facts, executive: str, path: Path, waited_s: float = 0.0) -> Snapshot:
    events: tuple[Event, ...] = ()
    if path.exists():
        with opened(path) as rows:
            events = rows.events(EVENTS)
    return Snapshot(
        facts=facts,
        executive=executive,  # type: ignore[arg-type]
        waited_s=waited_s,
        events=events,
        wall_ns=time.time_ns(),
    )


def _of_rows(path: Path, robot: str | None, profile: str = "") -> list[Facts]:
    """Return a database's facts about its robots, or about one of them."""
    with opened(path) as database:
        names = [name for name in database.robots() if robot in {None, name}]
        all_rows = loaded(database, names)
    known = []
    for name in names:
        made, problems = planned(all_rows[name])
        of_bad = facts.of_bad_rows(all_rows[name], tuple(str(one) for one in problems), profile)
        known.append(facts.facts(made, profile) if made is not None else of_bad)
    return known
