"""`lbr motion`: motions in files, to share them and to import those of a robot's maker."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click
from msgspec.structs import replace

from lbr import home
from lbr.apps.motions.commands import motion_files
from lbr.apps.motions.commands.motion_files import Summary
from lbr.commands.completing import complete_motion
from lbr.commands.new_file import write_new
from lbr.commands.options import FileName, database_option, json_option, print_json
from lbr.commands.rows import opened, problems_of
from lbr.database import edits, given_files
from lbr.database.rows import RobotRows
from lbr.errors import InputError
from lbr.messages.joints import Joint, Motion, MotionRow, MotionStep, motions_of
from lbr.messages.plain import one_line
from lbr.messages.units import NAME_PATTERN
from lbr.robot.motion_file import LARGEST_BYTES
from lbr.robot.old_data import Note, merged

if TYPE_CHECKING:
    from lbr.database.store import Database

robot_option = click.option("--robot", metavar="NAME", help="Whose motions; found out if left out.")


@click.group("motion")
def command() -> None:
    """Take motions from files, and write them to files. A running robot follows."""


@command.command("list")
@robot_option
@database_option
@json_option
def list_(robot: str | None, database: Path | None, as_json: bool) -> int:
    """List the motions: how long they are, how many joints they move, and the part that keeps them."""
    with opened(database) as rows:
        motions = [(name, motion) for name in rows.robots(robot) for motion in _motions(rows.load(name))]
    if as_json:
        keys = ("robot", "name", "help", "slot", "builtin", "duration_s", "frames", "joints")
        print_json([dict(zip(keys, (name, *_figures(motion)), strict=True)) for name, motion in motions])
        return 0
    for name, motion in motions:
        _, text, slot, _, seconds, frames, joints = _figures(motion)
        kept = f"in slot {slot}" if slot is not None else f"{frames} key frames, {joints} joints"
        click.echo(one_line(f"{name} {motion.name}: {seconds:g} s, {kept}" + (f". {text}" if text else "")))
    if not motions:
        click.echo("there are no motions")
    return 0


@command.command("export")
@click.argument("name", shell_complete=complete_motion)
@robot_option
@click.option(
    "--to", "path", type=FileName(), metavar="FILE", help="Else it is printed. By its end, .mtn is RoboPlus's form."
)
@database_option
def export(name: str, robot: str | None, path: Path | None, database: Path | None) -> int:
    """Write the motion NAME to a file, for others: as JSON, or in a maker's form; 'lbr motion import' takes it."""
    with opened(database) as rows:
        motions = [
            (whose, motion, of_robot)
            for whose in rows.robots(robot)
            for of_robot in (rows.load(whose),)
            for motion in _motions(of_robot)
            if motion.name == name
        ]
    if not motions:
        raise InputError(f"there is no motion '{name}'; 'lbr motion list' shows them", "unknown_name")
    if len(motions) > 1:
        raise InputError(
            f"{' and '.join(whose for whose, *_ in motions)} have a motion '{name}'; say which with --robot NAME"
        )
    content, notes = motion_files.exported(*motions[0], suffix=path.suffix if path is not None else "")
    for note in notes:
        click.echo(one_line(f"note: {note}"), err=True)
    if path is None:
        click.echo(content.decode(), nl=False)
        return 0
    write_new(path, content)
    return 0


@command.command("import")
@click.argument("file", type=FileName(dir_okay=False))
@robot_option
@click.option("--name", metavar="NAME", help="What it is to be called; as in the file if left out.")
@click.option("--clip", is_flag=True, help="Bring angles beyond a joint's limits within them, instead of refusing.")
@click.option("--replace", "replacing", is_flag=True, help="Put it in the place of the motion that has this name.")
@click.option("--dry-run", is_flag=True, help="Show the effects, and write nothing.")
@database_option
@json_option
def import_(
    file: Path,
    robot: str | None,
    name: str | None,
    clip: bool,
    replacing: bool,
    dry_run: bool,
    database: Path | None,
    as_json: bool,
) -> int:
    """Take the motion in FILE: one that 'lbr motion export' wrote, or one of a robot's maker, which its package reads.

    A robot that runs takes it over at once; a motion that is being played is stopped for it. An angle beyond a joint's
    limits is refused, and named.
    """
    if name is not None and not re.fullmatch(NAME_PATTERN, name):
        raise InputError(f"'{name}' is not a name: those are of lower-case letters, digits and _, a letter first")
    with opened(database) as db:
        whose, motion, rows, notes = _understood(db, file, robot, name)
        if not replacing and any(one.name == motion.name for one in rows.of(MotionRow)):
            how = "--replace puts this one in its place, --name gives it another name"
            raise InputError(f"motion '{motion.name}' is there already: {how}")
        motion, cut = motion_files.within_limits(motion, rows.of(Joint), clip=clip)
        about = motion_files.summary(motion, rows.of(Joint), cut)
        if not dry_run:
            edits.write_rows(db, whose, motion.rows, problems_of, create=not replacing).good()
    if as_json:
        print_json(
            {
                "robot": whose,
                "name": motion.name,
                "written": not dry_run,
                **about._asdict(),
                "notes": [str(note) for note in notes],
            }
        )
        return 0
    for note in merged(notes):
        click.echo(one_line(f"note: {note}"), err=True)
    click.echo(_summary(whose, motion, about, written=not dry_run))
    return 0


@command.command("stable")
@click.argument("names", nargs=-1, shell_complete=complete_motion)
@robot_option
@click.option("--dry-run", is_flag=True, help="Show the result, and write nothing.")
@database_option
@json_option
def stable(names: tuple[str, ...], robot: str | None, dry_run: bool, database: Path | None, as_json: bool) -> int:
    """Find in which key frames of the motions NAMES, or of all, the simulated body stands, and write that down.

    A robot that is stopped on its way goes on to the nearest of them. A motion stored
    in the controller has no frames here. For it a person sets, in its last row of motion_step, whether the robot may
    go straight to its end.
    """
    from lbr.apps.motions.commands import standing as motion_standing  # noqa: PLC0415

    results = []
    with opened(database) as db:
        whose, rows = _robot_for(db, robot, lambda rows: bool(rows.of(Joint)))
        known = {motion.name: motion for motion in _motions(rows)}
        if unknown := sorted(set(names) - set(known)):
            raise InputError(f"there is no motion '{unknown[0]}'; 'lbr motion list' shows them", "unknown_name")
        for motion in (known[name] for name in (names or known)):
            if motion.slot is not None or not motion.frames:
                continue
            lead_in = known[motion.lead_in].frames if motion.lead_in in known else ()
            world = motion_standing.world(rows, whose)
            stability = tuple(motion_standing.stable_frames(world, rows.of(Joint), _home(), lead_in, motion.frames))
            frames = tuple(replace(one, stable=stands) for one, stands in zip(motion.frames, stability, strict=True))
            results.append(
                {
                    "name": motion.name,
                    "frames": len(stability),
                    "stable": [at for at, stands in enumerate(stability, 1) if stands],
                }
            )
            if not dry_run and frames != motion.frames:
                edits.write_rows(db, whose, replace(motion, frames=frames).rows, problems_of).good()
            if not as_json:
                click.echo(one_line(f"{motion.name}: stands in {sum(stability)} of {len(stability)} key frames"))
    if as_json:
        print_json(results)
    return 0


def _home() -> str:
    return str(home.home())


def _understood(
    opened: "Database", file: Path, robot: str | None, name: str | None
) -> tuple[str, Motion, RobotRows, list[Note]]:
    """Return the robot of a file, its motion, that robot's rows, and notes for people."""

    content = given_files.read(file, LARGEST_BYTES)
    notes: list[Note] = []
    try:
        read = motion_files.read(content, file.suffix)
        if isinstance(read, motion_files.MotionFile):
            meant = robot or (read.robot if read.robot in opened.robots() else None)
            whose, rows = _robot_for(opened, meant, lambda rows: bool(rows.of(Joint)))
            motion = replace(read.motion, builtin=False)
        else:
            whose, rows = _robot_for(opened, robot, read.fits)
            motions, notes = read.motions(rows)
            motion = _only(motions)
    except InputError as err:
        raise InputError(f"{file}: {err}") from err
    return whose, replace(motion, name=name or motion.name), rows, notes


def _only(motions: tuple[Motion, ...]) -> Motion:
    if len(motions) > 1:
        names = ", ".join(one.name for one in motions[:10])
        raise InputError(f"it has {len(motions)} motions ({names}): 'lbr import' takes them all")
    return motions[0]


def _summary(robot: str, motion: Motion, about: Summary, *, written: bool) -> str:
    took = "took" if written else "would take"
    lines = [
        f"{took} '{motion.name}' for {robot}: {about.frames} key frames, {about.duration_s:g} s, {about.joints} joints",
        f"fastest: {about.fastest}, {about.speed_rps:.2f} rad/s of the {about.limit_rps:g} it may",
    ]
    if about.speed_rps > about.limit_rps:
        lines.append("where a joint would be too fast, it takes longer than that")
    if about.clipped:
        lines.append(f"{about.clipped} {'angle' if about.clipped == 1 else 'angles'} brought within the joints' limits")
    return "\n".join(lines)


def _figures(motion: Motion) -> tuple[str, str, int | None, bool, float, int, int]:
    seconds = motion.slot_s if motion.slot_s is not None else sum(frame.duration_s for frame in motion.frames)
    joints = {name for frame in motion.frames for name in frame.positions}
    return motion.name, motion.help, motion.slot, motion.builtin, round(seconds, 2), len(motion.frames), len(joints)


def _motions(rows: RobotRows) -> tuple[Motion, ...]:
    return motions_of(rows.of(MotionRow), rows.of(MotionStep))


def _robot_for(opened: "Database", robot: str | None, fits: Callable[[RobotRows], bool]) -> tuple[str, RobotRows]:
    """Return the chosen robot, or the only one that a file fits, with its rows."""
    robots = [(name, opened.load(name)) for name in opened.robots(robot)]
    fitting = robots if robot is not None else [(name, rows) for name, rows in robots if fits(rows)]
    if len(fitting) != 1:
        names = ", ".join(name for name, _ in fitting) or "none"
        raise InputError(f"{len(fitting)} robots could play it ({names}); say which with --robot NAME")
    return fitting[0]
