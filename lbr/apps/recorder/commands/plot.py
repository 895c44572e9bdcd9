"""`lbr plot`: numbers over time in the terminal, live or from a recording."""

import shutil
import sys
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import click

from lbr.apps.recorder.commands.box import Excerpt
from lbr.apps.recorder.recording import export, times
from lbr.apps.recorder.recording.export import fields
from lbr.apps.recorder.recording.history import value_of
from lbr.apps.recorder.recording.selection import Chosen
from lbr.bus import wire
from lbr.bus.codec import decode
from lbr.bus.session import Session
from lbr.commands.completing import complete_field
from lbr.commands.options import Number, Whom, robot_options
from lbr.console import target, topics
from lbr.errors import BusError, InputError, MalformedError

FRAME_S = 0.2
WAIT_S = 5.0
MOST_POINTS = 4000
MOST_COLUMNS, MOST_LINES = 1000, 300
COLOURS = ("cyan", "yellow", "green", "magenta", "red", "blue", "white")
EDGE = 16
"""The columns and lines of axes and legend."""


class Series(NamedTuple):
    """A field of a topic, and its points: time in seconds, and value."""

    name: str
    topic: str
    path: tuple[str, ...]
    points: deque[tuple[float, float]]


@click.command("plot")
@click.argument("fields", nargs=-1, required=True, metavar="TOPIC.FIELD...", shell_complete=complete_field)
@robot_options
@click.option(
    "--seconds", type=Number(0.5, 86400), default=20.0, show_default=True, help="How much of the past is shown."
)
@click.option(
    "--once", is_flag=True, help="Watch for that long, print one plot and leave; so does what is no terminal."
)
@click.option("--from", "begin", metavar="TIME", help="Out of the black box: from 10m (ago), 14:02 ... on.")
@click.option("--to", "end", metavar="TIME", help="Until then; now if left out.")
@click.option(
    "--in", "recording", default="", metavar="WHAT", help="Out of this recording or file instead: see lbr box list."
)
def command(
    fields: tuple[str, ...],
    whom: Whom,
    seconds: float,
    once: bool,
    begin: str | None,
    end: str | None,
    recording: str,
) -> int:
    """Plot numbers of streams, such as drive/state.power motors/state.left; live until Ctrl-C, or out of the black box.

    Fields within others and places of lists stand behind a dot: drive/state.loop.rate_hz. True is 1, false 0.
    """
    series = [_series(text) for text in fields]
    if begin is not None or end is not None or recording:
        return _recorded(series, Excerpt(recording, whom.robot, begin, end).chosen())
    robot = target.find(*whom)
    with target.connected(robot) as bus:
        take = _taker(bus, robot.robot, series)
        _wait(take, series)
        if once or not sys.stdout.isatty():
            until = time.monotonic() + seconds
            while time.monotonic() < until:
                time.sleep(FRAME_S)
                take()
            click.echo(_drawn(series, time.monotonic(), seconds, *size(), colours=sys.stdout.isatty()))
            return 0
        return _live(take, series, seconds)


def _series(text: str) -> Series:
    topic, _, path = text.partition(".")
    if "/" not in topic or not path or "*" in topic:
        raise InputError(f"'{text[:60]}' is no field of a stream; say it as drive/state.power")
    return Series(text, topic, tuple(path.split(".")), deque(maxlen=100_000))


def _taker(bus: Session, robot: str, series: list[Series]) -> Callable[[], dict[str, object]]:
    """Subscribe to the topics; return a function that reads new points and returns the newest message of each topic."""
    feeds = {each.topic: wire.Subscription(bus, topics.key_of(robot, each.topic), depth=2000) for each in series}
    newest: dict[str, object] = {}

    def take() -> dict[str, object]:
        for topic, feed in feeds.items():
            for raw in feed.take():
                try:
                    newest[topic] = message = decode(raw.payload)
                except MalformedError:
                    continue
                for each in series:
                    if each.topic == topic and (value := value_of(message, each.path)) is not None:
                        each.points.append((raw.arrived, value))
        return newest

    return take


def _wait(take: Callable[[], dict[str, object]], series: list[Series]) -> None:
    """Wait for the first message of each topic; raise InputError for a field that is not a number."""
    until = time.monotonic() + WAIT_S
    while missing := sorted({each.topic for each in series} - (newest := take()).keys()):
        if time.monotonic() > until:
            raise BusError(f"nothing comes on {', '.join(missing)} ('lbr topic list' shows what there is)")
        time.sleep(FRAME_S / 4)
    for each in series:
        if not each.points:
            _refuse(each, newest[each.topic])


def _refuse(series: Series, message: object) -> None:
    """Raise InputError for a missing field or a text; a null may become a number."""
    known = dict(fields(message))
    path = ".".join(series.path)
    if path in known and known[path] is None:
        return
    numbers = [name for name, value in known.items() if isinstance(value, bool | int | float)]
    what = "is text" if path in known else "is not there"
    raise InputError(
        f"'{path}' {what} in {series.topic}; numbers are {', '.join(numbers[:20]) or 'none'}", "unknown_name"
    )


def _live(take: Callable[[], object], series: list[Series], seconds: float) -> int:
    from lbr.commands.screen import redraw  # noqa: PLC0415 - rich, for people alone

    def frame() -> str:
        take()
        return _drawn(series, time.monotonic(), seconds, *size(), colours=True)

    redraw(frame, FRAME_S)


def _recorded(series: list[Series], chosen: Chosen) -> int:
    last: dict[str, object] = {}
    for message in chosen.messages():
        of_topic = [each for each in series if each.topic == message.topic]
        if of_topic:
            last[message.topic] = value = export.decoded(message)
            for each in of_topic:
                if (number := value_of(value, each.path)) is not None:
                    each.points.append((message.log_ns / 1e9, number))
    for each in series:
        if each.topic not in last:
            raise InputError(f"nothing of {each.topic} was recorded in that time ('lbr box show' shows what was)")
        if not each.points:
            _refuse(each, last[each.topic])
    points = [at for each in series for at, _value in each.points]
    if not points:
        raise InputError("there was no number in that time")
    now = time.time_ns()
    click.echo(f"{times.text(int(min(points) * 1e9), now)} to {times.text(int(max(points) * 1e9), now)}")
    length = max(0.001, max(points) - min(points))
    click.echo(_drawn(series, max(points), length, *size(), colours=sys.stdout.isatty()))
    return 0


def size() -> tuple[int, int]:
    """Return the width and height to draw, as a terminal may report any size."""
    found = shutil.get_terminal_size()
    return min(found.columns, MOST_COLUMNS), min(found.lines, MOST_LINES)


def _drawn(series: list[Series], now: float, seconds: float, width: int, height: int, *, colours: bool) -> str:
    """Return a plot of the last `seconds` before `now`, the newest at the right."""
    import plotille

    figure = plotille.Figure()
    figure.width = max(20, width - EDGE)
    figure.height = max(5, height - 8 - len(series))
    figure.color_mode = "names"
    figure.with_colors = colours
    figure.x_label, figure.y_label = "s", "value"
    figure.register_label_formatter(float, _label)
    figure.set_x_limits(-seconds, 0)
    curves = 0
    for index, each in enumerate(series):
        points = [(at - now, value) for at, value in each.points if now - at <= seconds]
        points = points[:: 1 + len(points) // MOST_POINTS]
        if points:
            curves += 1
            times, values = [at for at, _ in points], [value for _, value in points]
            label = f"{each.name}  {values[-1]:.6g}"
            figure.plot(times, values, lc=COLOURS[index % len(COLOURS)] if colours else None, label=label)
    if not curves:
        return "no number yet: the fields are null"
    return str(figure.show(legend=True))


def _label(val: float, chars: int, delta: object, left: bool = False) -> str:  # noqa: ARG001 - as plotille calls it
    text = f"{float(val):.4g}"
    return text.ljust(chars) if left else text.rjust(chars)
