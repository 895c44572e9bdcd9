"""`lbr box`: the contents of the black box, whether a robot runs or not."""

import time
from collections.abc import Iterator
from contextlib import suppress
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import click
from click.shell_completion import CompletionItem
from msgspec import Struct
from msgspec.structs import asdict, replace

from lbr import disk, home, plugins
from lbr.apps.recorder.recording import export as exports
from lbr.apps.recorder.recording import selection, shelf, times
from lbr.apps.recorder.recording.chunks import Message
from lbr.apps.recorder.recording.selection import Chosen, Damage
from lbr.apps.recorder.recording.shelf import Shelf
from lbr.commands.completing import items
from lbr.commands.options import FileName, json_option, print_json, together
from lbr.errors import InputError, LbrError
from lbr.messages.plain import one_line

AROUND_S = 10.0
SHOWN_EVENTS = 20
MB = 1_000_000


def complete_recording(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the kept incidents and the recordings."""
    with suppress(LbrError, OSError):
        shelves = [Shelf(home.home(), robot) for robot in shelf.robots(home.home())]
        kept = [(one.path.name, one.why.text if one.why else "") for here in shelves for one in here.incidents()]
        made = [(path.stem, "a recording") for here in shelves for path in here.recordings()]
        return items(begun, kept + made)
    return []


which_robot = click.option("--robot", metavar="NAME", help="Whose; the only one with recordings if left out.")


class Excerpt(NamedTuple):
    """The messages that a command means: a recording, by default the box of a robot, and a span of time."""

    recording: str = ""
    robot: str | None = None
    begin: str | None = None
    end: str | None = None
    around: str | None = None

    def chosen(self) -> Chosen:
        """Return the files and the span; raise InputError with the choices."""
        start_ns, end_ns = self._span()
        is_file = self.recording and Path(self.recording).is_file()
        place = Shelf(home.home(), "none") if is_file else of_robot(self.robot)[1]
        return replace(selection.choose(place, self.recording), start_ns=start_ns, end_ns=end_ns)

    def _span(self) -> tuple[int, int]:
        """Parse the times; raise InputError for a bad one, or an end before the beginning."""
        now = time.time_ns()
        if self.around is not None:
            if self.begin is not None or self.end is not None:
                raise InputError("--at is a moment: leave out --from and --to")
            at = times.moment_ns(self.around, now)
            return at - int(AROUND_S * 1e9), at + int(AROUND_S * 1e9)
        start_ns = times.moment_ns(self.begin, now) if self.begin is not None else 0
        end_ns = times.moment_ns(self.end, now) if self.end is not None else selection.LAST_NS
        if end_ns <= start_ns:
            raise InputError("--to is before --from: a time of day is the last one that is past")
        return start_ns, end_ns


excerpt_options = together(
    "excerpt",
    Excerpt,
    click.argument("recording", metavar="[WHAT]", required=False, default="", shell_complete=complete_recording),
    which_robot,
    click.option("--from", "begin", metavar="TIME", help="From then on: 10m (ago), 14:02, 'yesterday 9:30'."),
    click.option("--to", "end", metavar="TIME", help="Until then; now if left out."),
    click.option("--at", "around", metavar="TIME", help=f"{AROUND_S:g} s before and after."),
)


@click.group("box")
def command() -> None:
    """Look at what the black box holds, take it along, and delete it. WHAT is box, what it kept, a recording or a
    file."""


@command.command("list")
@which_robot
@json_option
def list_box(robot: str | None, as_json: bool) -> int:
    """List what there is: the box itself, what it kept and why, and what was recorded on purpose."""
    name, place = of_robot(robot)
    files, now = place.files(), time.time_ns()
    begin_ns, end_ns = selection.span_ns([*files[:1], *files[-1:]])
    incidents, made = place.incidents(), place.recordings()
    if as_json:
        print_json(
            {
                "robot": name,
                "box": {"files": len(files), "bytes": shelf.size_of(files), "from_ns": begin_ns, "to_ns": end_ns},
                "kept": [{"name": each.path.name, "bytes": each.bytes, "why": each.why} for each in incidents],
                "recordings": [{"name": path.name, "path": str(path), "bytes": shelf.size_of([path])} for path in made],
            }
        )
        return 0
    if files:
        span = f"{times.text(begin_ns, now)} to {times.text(end_ns, now)} ({times.length((end_ns - begin_ns) / 1e9)})"
        click.echo(f"box of {name}: {span}, {shelf.size_of(files) / MB:.1f} MB in {len(files)} files")
    else:
        click.echo(f"box of {name}: empty")
    for incident in incidents:
        why = "why is not readable" if incident.why is None else str(incident.why)
        again = f" (and {incident.why.again} more)" if incident.why is not None and incident.why.again else ""
        click.echo(one_line(f"kept       {incident.path.name}  {incident.bytes / MB:.1f} MB  {why}{again}"))
    for path in made:
        click.echo(one_line(f"recording  {path.name}  {shelf.size_of([path]) / MB:.1f} MB"))
    return 0


@command.command("show")
@excerpt_options
@json_option
def show(excerpt: Excerpt, as_json: bool) -> int:
    """Show what is in WHAT: topics with how many messages, and what happened. Without WHAT it is the box."""
    chosen = excerpt.chosen()
    counted = _counted(chosen)
    if as_json:
        print_json({"name": chosen.name, "why": chosen.why, **asdict(counted)})
        return 0
    now = time.time_ns()
    if chosen.why is not None:
        click.echo(one_line(str(chosen.why)))
    if not counted.topics:
        click.echo("nothing was recorded in that time")
        _print_damage(counted.damage)
        return 1
    seconds = max(1e-9, (counted.to_ns - counted.from_ns) / 1e9)
    span = f"{times.text(counted.from_ns, now)} to {times.text(counted.to_ns, now)}"
    click.echo(f"{chosen.name}: {span} ({times.length(seconds)})")
    width = max(map(len, counted.topics))
    for topic, one in sorted(counted.topics.items()):
        click.echo(one_line(f"{topic:<{width}}  {one.messages:>8}  {one.messages / seconds:7.1f} Hz  {one.message}"))
    for event in counted.events[-SHOWN_EVENTS:]:
        click.echo(one_line(f"{times.text(event.wall_ns, now)} {event.subject}: {event.text}"))
    _print_damage(counted.damage)
    return 0


@command.command("export")
@excerpt_options
@click.option(
    "--topic", "topics", multiple=True, metavar="PATTERN", help="Only these: drive/state, motors/*. Repeatable."
)
@click.option("--mcap", type=FileName(), metavar="FILE", help="Into one MCAP file, for Foxglove and others.")
@click.option("--csv", "folder", type=FileName(), metavar="FOLDER", help="Into a table for each topic, and pictures.")
@click.option("--force", is_flag=True, help="Take the place of what is there.")
def export(*, excerpt: Excerpt, topics: tuple[str, ...], mcap: Path | None, folder: Path | None, force: bool) -> int:
    """Write WHAT into files for other programs. Without WHAT it is the box; times select a part of it."""
    if (mcap is None) == (folder is None):
        raise InputError("say where to: --mcap FILE, or --csv FOLDER")
    target = mcap or folder
    assert target is not None
    if folder is not None and target.exists() and not target.is_dir():
        raise InputError(f"{target} is no folder: --csv writes a table for each topic into one")
    if mcap is not None and target.is_dir():
        raise InputError(f"{target} is a folder: --mcap writes one file")
    if target.exists() and not force and (mcap is not None or any(target.iterdir())):
        raise InputError(f"{target} is there already; --force takes its place")
    chosen, damage = excerpt.chosen(), Damage()

    def wanted(*, count: bool = False) -> Iterator[Message]:
        there = chosen.messages(damage if count else None)
        return (one for one in there if not topics or any(fnmatchcase(one.topic, pattern) for pattern in topics))

    if mcap is not None:
        count = exports.to_mcap(mcap, wanted(count=True), f"lbr {plugins.version()}")
    else:
        count = sum(exports.to_csv(target, wanted).values())
    if not count:
        _print_damage(damage)
        raise InputError("nothing was recorded in that time, or of these topics")
    click.echo(f"{count} messages into {target}")
    _print_damage(damage)
    return 0


@command.command("delete")
@click.argument("names", metavar="WHAT...", nargs=-1, required=True, shell_complete=complete_recording)
@which_robot
def delete(names: tuple[str, ...], robot: str | None) -> int:
    """Delete WHAT: what the box kept or a recording, by name; box for all of its own files but the one it writes."""
    _name, place = of_robot(robot)
    if "" in names:  # an unset shell variable, which would mean the whole box
        raise InputError("nothing is named that is to be deleted; 'lbr box list' shows what there is")
    chosen = [(recording, selection.choose(place, recording)) for recording in names]
    folders = {recording.path.name: recording.path for recording in place.incidents()}
    code = 0
    for name, recording in chosen:
        own = [folders[name]] if name in folders else list(recording.files)
        if any(place.box not in path.parents and place.recordings_folder not in path.parents for path in own):
            raise InputError(f"'{name}' is a file of another; delete it yourself")
        undeleted = [path for path in own if not place.delete(path)]
        written = [path for path in undeleted if path.is_file() and disk.is_locked(path)]
        for path in undeleted:
            why = "is being written, and stays" if path in written else "cannot be deleted: check disk and rights"
            click.echo(f"{path.name} {why}", err=True)
        code = code or (1 if undeleted and (recording.name != selection.BOX or undeleted != written) else 0)
        if len(undeleted) < len(own) or not own:
            click.echo(f"deleted {recording.name}")
        elif undeleted == written:
            click.echo(f"{recording.name}: nothing to delete")
    return code


def of_robot(robot: str | None) -> tuple[str, Shelf]:
    """Return the chosen robot and its recordings; raise InputError with the choices."""
    place = home.home()
    known = shelf.robots(place)
    if robot is None:
        running = [one.robot for one in home.running()]
        usual = running if len(running) == 1 else known
        if len(usual) != 1:
            names = ", ".join(known)
            raise InputError(
                f"there are recordings of {names}; say whose with --robot NAME"
                if known
                else f"nothing was recorded in {place}"
            )
        robot = usual[0]
    if robot not in known:
        raise InputError(f"there are no recordings of '{robot}' in {place}", "unknown_name")
    return robot, Shelf(place, robot)


class _Topic(Struct):
    """The messages of a topic: their number, total size and type."""

    messages: int
    bytes: int
    message: str


class _Event(Struct):
    """An event of a recording."""

    wall_ns: int
    subject: str = ""
    text: str = ""


class _Counted(Struct):
    """The contents of a recording."""

    from_ns: int
    to_ns: int
    topics: dict[str, _Topic]
    events: list[_Event]
    damage: Damage


def _counted(chosen: Chosen) -> _Counted:
    counted = _Counted(0, 0, {}, [], Damage())
    for message in chosen.messages(counted.damage):
        at_ns = message.log_ns
        counted.from_ns, counted.to_ns = min(counted.from_ns or at_ns, at_ns), max(counted.to_ns, at_ns)
        topic = counted.topics.setdefault(message.topic, _Topic(0, 0, message.channel.schema_name))
        topic.messages += 1
        topic.bytes += len(message.data)
        if message.topic == "@event" and isinstance(event := exports.decoded(message), dict):
            texts = {key: str(event.get(key, "")) for key in ("subject", "text")}
            counted.events.append(_Event(at_ns, **texts))
    return counted


def _print_damage(damage: Damage) -> None:
    for text in damage.files:
        click.echo(one_line(text), err=True)
    if damage.places:
        what = "1 damaged place was" if damage.places == 1 else f"{damage.places} damaged places were"
        click.echo(f"{what} passed over ({damage.bytes} bytes)", err=True)
