"""`lbr at`: answers as of a past moment."""

import time
from datetime import UTC, datetime
from pathlib import Path

import click
import msgspec

from lbr import home
from lbr.apps.recorder.box.past import snapshot
from lbr.apps.recorder.commands.box import Excerpt
from lbr.apps.recorder.recording import times
from lbr.apps.recorder.recording.moment import SILENT_S, Moment, moment
from lbr.apps.recorder.recording.recorded import RecordedRows
from lbr.commands.options import FileName, json_option, print_json
from lbr.commands.rows import opened
from lbr.database.reading import RawTables
from lbr.errors import InputError
from lbr.messages.plain import one_line
from lbr.why import rendering
from lbr.why.chain import explain

Tables = dict[str, list[dict[str, object]]]
SURE = "capability"
"""The table that decides whether two sets of rows are the same."""


@click.command("at")
@click.argument("when", metavar="TIME")
@click.argument("answer", metavar="{why|status|rows}", type=click.Choice(["why", "status", "rows"]))
@click.argument("part", required=False, default="")
@click.option("--robot", metavar="NAME", help="Whose; the only one with recordings if left out.")
@click.option("--in", "place", default="", metavar="WHAT", help="Out of this recording or file: see lbr box list.")
@click.option("--db", "database", type=FileName(), metavar="FILE", help="The rows whose past is looked at, for rows.")
@json_option
def command(
    when: str, answer: str, part: str, robot: str | None, place: str, database: Path | None, as_json: bool
) -> int:
    """Answer as then: why something stood still, how each process was, or what the rows were.

    TIME is 10m (ago), 14:02, 'yesterday 9:30'. PART is what `why` is asked about, or a table of the rows. The answers
    are from the black box. Rows are from the history of the rows themselves, or from the box if the database was
    replaced since.
    """
    now = time.time_ns()
    at_ns = times.moment_ns(when, now)
    if at_ns > now:
        raise InputError(f"{times.text(at_ns, now)} is still to come")
    if answer == "rows":
        return _rows(at_ns, part, robot, place, database, as_json=as_json)
    moment = _moment(at_ns, robot, place)
    if moment.late_s > SILENT_S:
        text = f"nothing was recorded for {times.length(moment.late_s)} until then; this is how it was before"
        click.echo(f"lbr: {text}", err=True)
    return _why(moment, part, as_json=as_json) if answer == "why" else _status(moment, as_json=as_json)


def _moment(at_ns: int, robot: str | None, place: str) -> Moment:
    return moment(Excerpt(place, robot).chosen().files, at_ns)


def _why(moment: Moment, part: str, *, as_json: bool) -> int:
    answer = explain(snapshot(moment), part)
    if as_json:
        print_json(answer)
        return 0
    for line in rendering.lines(answer):
        click.echo(one_line(line))
    return 0


def _status(moment: Moment, *, as_json: bool) -> int:
    from lbr.commands.status_table import show  # noqa: PLC0415 - rich, for people alone

    if moment.status is None:
        raise InputError("the status of then is not in the recording")
    if as_json:
        print_json(moment.status)
    else:
        show(moment.status)
    return 0


def _rows(at_ns: int, table: str, robot: str | None, place: str, database: Path | None, *, as_json: bool) -> int:
    revision, tables, source = _tables(at_ns, robot, place, database)
    if table and table not in tables:
        raise InputError(f"there was no table '{table}'; there was {', '.join(tables)}", "unknown_name")
    wanted = {name: rows for name, rows in tables.items() if not table or name == table}
    if as_json:
        print_json({"revision": revision, "source": source, "tables": wanted})
        return 0
    click.echo(f"revision {revision}, by {source}")
    for name, rows in wanted.items():
        click.echo(f"{name}: {len(rows)} rows")
        for row in rows:
            click.echo(one_line(f"  {msgspec.json.encode(row).decode()}"))
    return 0


def _tables(at_ns: int, robot: str | None, place: str, database: Path | None) -> tuple[int, Tables, str]:
    """Return the revision and rows of a moment, and their source: the database's own history, or a recording.

    The history has each edit at its moment; a recording has it once the executive has applied it. A recording wins if
    the database was replaced since.
    """
    path = database or home.default_database()
    recorded, name = (None, robot) if database else _recorded(at_ns, robot, place)
    if recorded is not None and (place or not _goes_back_to(path, recorded, name)):
        return recorded.revision, recorded.tables, "the black box" if not place else f"the recording {place}"
    if not path.exists():
        raise InputError(f"neither the black box nor {path} has the rows of then")
    return *_past(path, at_ns, name), f"the past of {path}"


def _recorded(at_ns: int, robot: str | None, place: str) -> tuple[RecordedRows | None, str | None]:
    """Return the recorded rows of a moment, or None, and their robot."""
    try:
        then = _moment(at_ns, robot, place)
    except InputError:
        if place:
            raise
        return None, robot
    name = then.status.robot if then.status is not None else robot
    return (then.rows if place or then.late_s <= SILENT_S else None), name


def _goes_back_to(path: Path, recorded: RecordedRows, robot: str | None) -> bool:
    """Return whether the database's history has these rows, so it was not replaced."""
    if not path.exists():
        return False
    with opened(path) as rows:
        try:
            then = rows.tables_at(recorded.revision)
        except InputError:
            return False
    return _of(then, robot).get(SURE, []) == recorded.tables.get(SURE)


def _past(path: Path, at_ns: int, robot: str | None) -> tuple[int, Tables]:
    with opened(path) as rows:
        until = [one.id for one in rows.touched(0) if _ns(one.changed_at) <= at_ns]
        revision = until[-1] if until else 0
        return revision, _of(rows.tables_at(revision), robot)


def _of(tables: RawTables, robot: str | None) -> Tables:
    """Return the rows of one robot, of all without a name; tokens are left out."""
    return {
        name: [dict(row) for row in found if robot is None or row.get("robot", row.get("name", robot)) == robot]
        for name, found in tables.items()
        if name != "user_token"
    }


def _ns(text: str) -> int:
    try:
        at = datetime.fromisoformat(text)
    except ValueError:
        return 0
    return int((at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp() * 1e9)
