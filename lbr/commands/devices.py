"""`lbr devices`: the plugged-in devices, and the rows with which a robot would use them."""

import sys
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any

import click
from msgspec import Struct
from msgspec.structs import asdict, replace

from lbr import home
from lbr.commands import attached, recognised
from lbr.commands.attached import End
from lbr.commands.options import Number, complete_robot, database_option, json_option, print_json
from lbr.commands.proposing import Proposal, propose
from lbr.commands.recognised import Attached
from lbr.commands.row_touched import Touching, change_rows
from lbr.commands.rows import opened, robot_meant
from lbr.database import changes, forms
from lbr.database.proposals import Proposed
from lbr.database.rows import CORE
from lbr.database.store import Database
from lbr.drivers import recognising
from lbr.errors import InputError, LbrError
from lbr.executive.planning import profile
from lbr.messages.manage import RowChange
from lbr.messages.plain import one_line

LOOK_S = 0.5
"""Time between two looks, with --watch."""
SETTLE_S = 0.5
"""udev sets rights and names just after a device is plugged in."""


class Looked(Struct, frozen=True, kw_only=True):
    """The result of one look; `robot` is empty without a database."""

    robot: str
    devices: list[Attached]
    proposals: list[Proposal]
    hints: list[str] = []


def run(
    robot: str | None, called: str | None, *, listen: bool, wait_s: float, database: Path | None, **how: Any
) -> int:
    """Look once, or with --watch until Ctrl-C; write the accepted rows, and return the exit code."""
    ports: tuple[str, ...] = how["ports"]
    if called is not None and (not called or len(ports) != 1):
        raise InputError("--as names the row of one device: say which with one --port")
    if how["watch"] and how["write"]:
        raise InputError("--watch writes nothing: leave --write out")
    looking = Looking(robot, database, called or "", wait_s=wait_s, ask=not listen)
    if how["watch"]:
        return _watch(looking, ports, as_json=how["as_json"])
    looked = looking.look([attached.named(port) for port in ports] if ports else attached.ends())
    good = [one for one in looked.proposals if one.changes and not one.problems]
    proposed = _agreed(looking, looked, good, write=how["write"], as_json=how["as_json"])
    bad = any(one.problems for one in looked.proposals) or (proposed is not None and bool(proposed.problems))
    return 2 if bad else 0


def _agreed(looking: "Looking", looked: Looked, good: list[Proposal], *, write: bool, as_json: bool) -> Proposed | None:
    """Print the result of a look, and write the rows that a person accepts."""
    if as_json:
        proposed = looking.write(looked.robot, good) if write and good else None
        written = proposed is not None and not proposed.problems
        problems = proposed.problems if proposed is not None else ()
        print_json({**asdict(looked), "written": written, "problems": [str(one) for one in problems]})
        return proposed
    _tell(looked)
    if not good:
        return None
    if not write and sys.stdin.isatty() and sys.stdout.isatty():
        write = click.confirm(f"write these rows of '{looked.robot}'?", default=False)
    if not write:
        click.echo("nothing is written yet: 'lbr devices --write' does it")
        return None
    proposed = looking.write(looked.robot, good)
    for problem in proposed.problems:
        click.echo(f"problem: {one_line(str(problem))}", err=True)
    if proposed.problems:
        click.echo("nothing was written", err=True)
    else:
        click.echo(f"the rows are written: revision {proposed.revision}; 'lbr db undo' takes them back")
    return proposed


class Looking:
    """Looks at ends for one robot's rows; without a database, for no rows."""

    def __init__(self, robot: str | None, database: Path | None, called: str, *, wait_s: float, ask: bool) -> None:
        self._robot = robot
        self._given = database is not None
        self._database = database or home.default_database()
        self._called = called
        self._wait_s = wait_s
        self._ask = ask
        self.kinds, self._known, self._hints = recognised.known_kinds(home.home())

    def look(self, ends: Collection[End]) -> Looked:
        """Return the devices at these ends, and the proposed rows."""
        devices = recognised.ask_all(ends, self._known, _held(), wait_s=self._wait_s, ask=self._ask)
        hints = [*self._hints, *recognising.hung()]
        if not self._database.exists():
            if self._robot is not None or self._given:
                raise InputError(f"there is no database {self._database}; 'lbr db init' makes one", "unknown_name")
            hint = f"there is no database {self._database}, so no rows are proposed: 'lbr db init' makes one"
            return Looked(robot="", devices=devices, proposals=[], hints=[*hints, hint])
        with opened(self._database) as rows:
            robot = robot_meant(rows, self._robot)
            nodes = {end.path for end in (*attached.ends(), *ends)} | {device.address for device in devices}
            known, proposals = propose(rows.load(robot), self.kinds, devices, nodes, self._called)
            offers = [self._previewed(rows, robot, one) for one in proposals]
        return Looked(robot=robot, devices=known, proposals=offers, hints=hints)

    def write(self, robot: str, offers: Collection[Proposal]) -> Proposed:
        """Write the rows of some proposals, all or none; a row in several proposals is written once."""
        changes: list[RowChange] = []
        for one in offers:
            changes += (each for each in one.changes if each not in changes)
        with opened(self._database) as rows:
            return self._change_rows(rows, robot, changes, dry_run=False)

    def _previewed(self, rows: Database, robot: str, proposal: Proposal) -> Proposal:
        if not proposal.changes:
            return proposal
        try:
            proposed = self._change_rows(rows, robot, proposal.changes, dry_run=True)
        except InputError as err:
            return replace(proposal, changes=[], problems=(str(err),))
        differences = tuple(map(str, changes.differences(proposed.changes)))
        return replace(proposal, differences=differences, problems=tuple(map(str, proposed.problems)))

    def _change_rows(self, rows: Database, robot: str, changes: list[RowChange], *, dry_run: bool) -> Proposed:
        read = (each.row for kind in self.kinds.values() for each in kind.reads)
        classes = {row.TABLE: row for row in (*CORE, *read)}
        wanted = forms.wanted(robot, changes, classes)
        return change_rows(rows, wanted, "took what is plugged in", Touching(rows), dry_run=dry_run)


def _held() -> dict[str, str]:
    """Return the devices that running robots use, by their rows. Simulated robots use no devices."""
    held: dict[str, str] = {}
    for running in home.running():
        try:
            if profile.load(running.profile).simulate:
                continue
            with opened(Path(running.database)) as rows:
                held |= recognised.held_by(running.robot, rows.load(running.robot).devices)
        except (LbrError, OSError):
            continue  # its devices are locked, too: see `serial_line.holder`
    return held


def _watch(looking: Looking, ports: tuple[str, ...], *, as_json: bool) -> int:
    def now() -> dict[str, End]:
        ends = [attached.named(port) for port in ports] if ports else attached.ends()
        return {
            f"{one.address} {one.path}": one
            for one in ends
            if one.path.startswith(("i2c:", "unix:")) or Path(one.path).exists()
        }

    known = now()  # before the first look: a device plugged in meanwhile is reported twice rather than never
    first = looking.look([attached.named(port) for port in ports] if ports else attached.ends())
    if as_json:
        print_json(first)
    else:
        _tell(first)
        click.echo("watching; Ctrl-C ends it")
    while True:
        time.sleep(LOOK_S)
        attached_now = now()
        for key in known.keys() - attached_now.keys():
            _say(known[key], "gone", as_json=as_json)
        if new := [attached_now[key] for key in attached_now.keys() - known.keys()]:
            time.sleep(SETTLE_S)
            looked = looking.look(new)
            if as_json:
                print_json({"came": looked})
            else:
                _tell(looked)
        known = attached_now


def _say(end: End, change: str, *, as_json: bool) -> None:
    if as_json:
        print_json({change: end})
    else:
        click.echo(one_line(f"{end.address}: {change}"))


def _tell(looked: Looked) -> None:
    for hint in looked.hints:
        click.echo(f"note: {one_line(hint)}", err=True)
    proposals = {proposal.address: proposal for proposal in looked.proposals}
    for device in looked.devices:
        name = f"{device.what} ({device.type})" if device.type else device.name or device.place
        row = f", device '{device.row}' of '{looked.robot}'" if device.row else ""
        serial = f", serial number {device.serial}" if device.serial else ""
        note = f"; {device.text}" if device.text else ""
        click.echo(one_line(f"{device.address}: {name}{serial}{row}{note}"))
        if (proposal := proposals.get(device.address)) is not None:
            click.echo(one_line(f"    proposed: {proposal.text}"))
            for line in proposal.differences:
                click.echo(one_line(f"      {line}"))
            for line in proposal.problems:
                click.echo(one_line(f"      problem: {line}"), err=True)
    if not looked.devices:
        click.echo("nothing is plugged in that could be a device: no USB line, i2c bus, camera or receiver")


WAIT_S, LONGEST_WAIT_S = 2.0, 30.0


@click.command("devices")
@click.option(
    "--robot", metavar="NAME", shell_complete=complete_robot, help="Whose rows; the one that runs, if one does."
)
@click.option(
    "--port",
    "ports",
    metavar="PATH",
    multiple=True,
    help="Look here alone: a tty, i2c:BUS, or unix:PATH of a bus. May be repeated.",
)
@click.option("--as", "called", metavar="DEVICE", help="The device row to make or to change; with one --port.")
@click.option("--listen", is_flag=True, help="Ask nothing: no byte is written, and only what talks by itself is known.")
@click.option(
    "--wait",
    "wait_s",
    type=Number(0.1, LONGEST_WAIT_S),
    default=WAIT_S,
    show_default=True,
    metavar="SECONDS",
    help="How long one line is asked, at most.",
)
@click.option("--write", is_flag=True, help="Write the rows that are proposed; 'lbr db undo' takes them back.")
@click.option("--watch", is_flag=True, help="Go on, and report what is plugged in and pulled out.")
@database_option
@json_option
def command(
    robot: str | None, called: str | None, *, listen: bool, wait_s: float, database: Path | None, **how: Any
) -> int:
    """Find the plugged-in devices, identify each, and propose the rows with which a robot uses it.

    Each is identified by its driver's own question, which moves and changes nothing. Devices in use by a running robot
    or another program are not opened. Nothing is written without --write, or a yes at a terminal. Exit code 2 if a
    proposal is bad.
    """
    return run(robot, called, listen=listen, wait_s=wait_s, database=database, **how)
