"""`lbr replay`: the streams of a recording, published under another robot's name."""

import contextlib
import os
import re
import secrets
import select
import sys
import termios
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import click
import msgspec
from msgspec import Raw

from lbr import home
from lbr.apps.recorder.commands.box import Excerpt, excerpt_options
from lbr.apps.recorder.recording import lines, selection, times
from lbr.apps.recorder.recording.chunks import PICTURES, Channel, Message
from lbr.apps.recorder.recording.export import picture_in
from lbr.apps.recorder.recording.player import Player
from lbr.bus import access, keys, session, wire
from lbr.bus.session import Session
from lbr.commands.options import Number, json_option
from lbr.errors import InputError
from lbr.messages.camera import JpegFrame
from lbr.messages.unreadable import UNREADABLE

NOT_ON_A_BUS = frozenset({"@rows", "@log"})
SHOWN_S = 0.5
JUMP_NS = 10_000_000_000
KEYS = "space pauses, left and right jump 10 s, up and down change the speed, q ends"
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_ARROWS = {b"\x1b[A": "faster", b"\x1b[B": "slower", b"\x1b[C": "on", b"\x1b[D": "back"}
_LETTERS = {b" ": "pause", b"q": "end", b"+": "faster", b"-": "slower", b"\x04": "end"}


@click.command("replay")
@excerpt_options
@click.option(
    "--as", "name", default="replay", show_default=True, metavar="NAME", help="The robot that it is looked at as."
)
@click.option("--speed", type=Number(0.05, 100.0), default=1.0, show_default=True, help="So many times as fast.")
@click.option("--loop", is_flag=True, help="Begin again at the end.")
@click.option(
    "--check",
    is_flag=True,
    help="Run the robot's own processes on the recorded bytes and commands, and compare; exit 1 if it does otherwise.",
)
@click.option(
    "--tries",
    type=click.IntRange(1, 20),
    default=3,
    show_default=True,
    help="With --check: so many runs at most, until one is as recorded.",
)
@json_option
def command(
    *,
    excerpt: Excerpt,
    name: str,
    speed: float,
    loop: bool,
    check: bool,
    tries: int,
    as_json: bool,
) -> int:
    """Publish what was recorded under another robot's name, with its schemas, at the pace of then. Nothing moves by it.

    With --check a recording by 'lbr record --lines' goes through the real drivers and operations instead, in a home of
    its own. A difference by chance varies from try to try, that of a change does not: so it is tried again.

    WHAT is the box (if left out), what it kept, a recording or a file. Meanwhile `lbr topic`, `lbr plot` and `lbr
    status` with --robot replay look at it. In a terminal space pauses, the arrows jump and change the speed, q ends.
    """
    if not _NAME.fullmatch(name):
        raise InputError(f"'{name[:60]}' is not a robot's name: small letters, digits and _")
    chosen = excerpt.chosen()
    if check:
        from lbr.apps.recorder.commands import replay_check  # noqa: PLC0415

        return replay_check.check(chosen, tries, as_json=as_json)
    if as_json:
        raise InputError("--json goes with --check")
    first, last = selection.span_ns(chosen.files)
    start_ns, end_ns = max(chosen.start_ns, first), min(chosen.end_ns, last)
    if not last or end_ns < start_ns:
        raise InputError("nothing was recorded in that time ('lbr box list' shows what there is)")
    with _robot(name) as bus, contextlib.suppress(KeyboardInterrupt), _typed() as keys:
        stage = Stage(bus, name)
        player = Player(start_ns, end_ns, speed, time.monotonic())
        click.echo(f"replays {chosen.name} as the robot '{name}': lbr topic list --robot {name}", err=True)
        while _play(stage, player, chosen.files, keys):
            if not loop:
                break
            player.seek(start_ns, time.monotonic())
    return 0


class Stage:
    """Publishes recorded messages on the bus of this robot."""

    def __init__(self, bus: Session, robot: str) -> None:
        self._bus = bus
        self._robot = robot
        self._publishers: dict[str, wire.Publisher] = {}
        self._schemas: dict[str, wire.StaticReply] = {}

    def publish(self, message: Message) -> None:
        """Publish a message."""
        if message.topic in NOT_ON_A_BUS or message.topic.startswith(lines.TAPED):
            return
        picture = message.channel.schema_name == PICTURES
        if message.topic not in self._publishers:
            key = f"{self._robot}/{message.topic}"
            self._publishers[message.topic] = wire.Publisher(self._bus, key, "replay", pictures=picture)
            self._describe(message.channel)
        publisher = self._publishers[message.topic]
        if not picture:
            publisher.put(Raw(self._renamed(message)))
        elif (data := picture_in(message)) is not None:
            publisher.put(JpegFrame(data))

    def _renamed(self, message: Message) -> bytes:
        """Return a message's bytes; the status gets the name of this robot."""
        if message.topic != "@status":
            return message.data
        try:
            status = msgspec.json.decode(message.data)
            return msgspec.json.encode(status | {"robot": self._robot})
        except (TypeError, *UNREADABLE):
            return message.data

    def _describe(self, channel: Channel) -> None:
        capability, _, port = channel.topic.partition("/")
        if channel.schema and port and not channel.topic.startswith("@"):
            key = keys.schema(self._robot, capability, port)
            self._schemas[channel.topic] = wire.StaticReply(self._bus, key, lambda: Raw(channel.schema))


def _play(stage: Stage, player: Player, files: tuple[Path, ...], keys: Callable[[float], str]) -> bool:
    """Play to the end; return False if a key ended it."""
    shown_at = 0.0
    while True:
        messages = _from(stage, player.at_ns(time.monotonic()), files, player.end_ns)
        for message in messages:
            while (wait_s := player.wait_s(message.log_ns, time.monotonic())) > 0:
                asked = keys(min(wait_s, SHOWN_S))
                if asked == "end":
                    return False
                if _obeyed(player, asked):
                    break
                shown_at = _show(player, shown_at)
            else:
                stage.publish(message)
                continue
            break  # after a jump, read on from the new place
        else:
            return True


def _obeyed(player: Player, asked: str) -> bool:
    """Apply a key; return whether it was a jump."""
    now = time.monotonic()
    if asked == "pause":
        player.pause(now, paused=not player.paused)
    elif asked in {"faster", "slower"}:
        player.faster(now, 2.0 if asked == "faster" else 0.5)
    elif asked in {"on", "back"}:
        player.seek(player.at_ns(now) + (JUMP_NS if asked == "on" else -JUMP_NS), now)
        return True
    return False


def _from(stage: Stage, at_ns: int, files: tuple[Path, ...], end_ns: int) -> Iterator[Message]:
    """Publish the newest earlier message of each stream; return the messages after that time."""
    path = selection.file_at(files, at_ns)
    if path is not None:
        newest = {each.topic: each for each in selection.messages([path], 0, at_ns) if each.topic != selection.EVENT}
        for message in newest.values():
            stage.publish(message)
    return selection.messages(files, at_ns + 1, end_ns)


def _show(player: Player, shown_at: float) -> float:
    """Show the position every `SHOWN_S` in a terminal; return when to show it again."""
    now = time.monotonic()
    if now < shown_at or not sys.stderr.isatty():
        return shown_at
    at_ns = player.at_ns(now)
    gone, whole = (at_ns - player.start_ns) / 1e9, (player.end_ns - player.start_ns) / 1e9
    how = "paused" if player.paused else f"x{player.speed:g}"
    text = f"{times.text(at_ns, time.time_ns())}  {gone:.0f} of {whole:.0f} s  {how}  ({KEYS})"
    print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
    return now + SHOWN_S


@contextlib.contextmanager
def _robot(name: str) -> Iterator[Session]:
    """Open a bus as a robot of that name, for readers only, and close it after the `with`."""
    lock = home.RunLock(name)
    try:
        endpoint, password = f"unixsock-stream/{home.socket_path(name)}", secrets.token_hex(16)
        router = session.Router(
            listen=(endpoint,),
            robot=name,
            users={access.TOOLS: password},
            rights={access.TOOLS: access.Rights(trusted=True)},
            never_waiting=access.everything(name),
        )
        with contextlib.closing(session.open_router(router)) as bus:
            lock.publish(
                home.Running(
                    robot=name,
                    pid=os.getpid(),
                    endpoints=(endpoint,),
                    profile="replay",
                    database=str(home.default_database()),
                    core=endpoint,
                    password=password,
                )
            )
            yield bus
    finally:
        lock.release()


def _sleep(wait_s: float) -> str:
    time.sleep(wait_s)
    return ""


@contextlib.contextmanager
def _typed() -> Iterator[Callable[[float], str]]:
    """Yield a function that waits for a key and returns its command, or ""; without a terminal it only waits."""
    if not sys.stdin.isatty():
        yield _sleep
        return
    fd = sys.stdin.fileno()
    before = termios.tcgetattr(fd)

    def wait(wait_s: float) -> str:
        if not select.select([fd], [], [], wait_s)[0]:
            return ""
        typed = os.read(fd, 16)
        return "end" if not typed else _ARROWS.get(typed[:3], _LETTERS.get(typed[:1], ""))

    try:
        tty.setcbreak(fd)
        yield wait
    finally:
        termios.tcsetattr(fd, termios.TCSADRAIN, before)
        print(file=sys.stderr)
