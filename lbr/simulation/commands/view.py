"""`lbr view`."""

import contextlib
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, TypeVar

import click
import msgspec
from msgspec import Struct

from lbr.bus import wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.commands.options import FileName, Whom, robot_options
from lbr.console import target
from lbr.errors import BusError, MalformedError
from lbr.messages.joints import JointsState
from lbr.messages.sensing import Ranges
from lbr.simulation.commands import joint_table
from lbr.simulation.messages import HumanoidPose, WorldPose, WorldScene

S = TypeVar("S", bound="Struct")

FRAME_S = 0.2
SILENT_S = 2.0
WAIT_S = 5.0


@click.command("view")
@robot_options
@click.option("--png", type=FileName(), metavar="FILE", help="Save one picture instead.")
@click.option("--once", is_flag=True, help="Print one view and leave; so does an output that is not a terminal.")
def command(whom: Whom, png: Path | None, once: bool) -> int:
    """Watch a simulated robot from above, or a humanoid joint by joint, until Ctrl-C; a missing update is reported."""
    robot = target.find(*whom)
    with target.connected(robot) as bus:
        if png is not None:
            target.need(robot, "admin")
            return _picture(bus, robot.robot, png)
        frame = _frames(bus, robot.robot)
        _wait(frame)
        if once or not sys.stdout.isatty():
            for line in frame(80, 24):
                click.echo(line)
            return 0
        return _live(frame)


def _live(frame: Callable[[int, int], list[str]]) -> int:
    from lbr.commands.screen import redraw  # noqa: PLC0415 - rich, for people alone

    redraw(lambda: "\n".join(frame(*shutil.get_terminal_size())), FRAME_S)


def _wait(frame: Callable[[int, int], list[str]]) -> None:
    until = time.monotonic() + WAIT_S
    while not frame(80, 24):
        if not time.monotonic() < until:
            raise BusError("nothing to see: neither joints nor a simulated world answer ('lbr status' shows what runs)")
        time.sleep(FRAME_S / 4)


def _frames(bus: Session, robot: str, clock: Callable[[], float] = time.monotonic) -> Callable[[int, int], list[str]]:
    """Return a function that draws the newest view, or nothing until all parts are known."""
    from lbr.simulation import topdown  # noqa: PLC0415

    scene = _Latest(bus, f"{robot}/world/scene", WorldScene, clock)
    pose = _Latest(bus, f"{robot}/world/pose", WorldPose, clock)
    ranges = _Latest(bus, f"{robot}/ranges/readings", Ranges, clock)
    joints = _Latest(bus, f"{robot}/joints/state", JointsState, clock)
    body = _Latest(bus, f"{robot}/world/pose", HumanoidPose, clock)

    def frame(width: int, height: int) -> list[str]:
        seen, where, moved = scene.read(), pose.read(), joints.read()
        late = _late(pose if moved is None else joints, width)
        if moved is not None:
            return [*late, *joint_table.lines(moved, body.read(), width, height - len(late))]
        if seen is None or where is None:
            return []
        return [*late, *topdown.text(seen, where, ranges.read(), width, height - len(late))]

    return frame


def _late(what: "_Latest[Any]", width: int) -> list[str]:
    age_s = what.age_s
    return [] if age_s <= SILENT_S else [f"no news for {age_s:.0f} s; is the robot gone?"[:width]]


class _Latest(Generic[S]):
    """The newest message of a stream, and its age."""

    def __init__(self, bus: Session, key: str, kind: type[S], clock: Callable[[], float]) -> None:
        self._clock = clock
        self._feed = wire.Subscription(bus, key)
        self._decoder = Decoder(kind)
        self._seen = clock()
        start = wire.ask(bus, key, None, source=target.source("lbr view"), timeout_s=1.0)
        self._last: S | None = None
        if start:
            self._read(start[0].payload)

    @property
    def age_s(self) -> float:
        return self._clock() - self._seen

    def read(self) -> S | None:
        for raw in self._feed.take():
            self._read(raw.payload)
        return self._last

    def _read(self, payload: bytes) -> None:
        with contextlib.suppress(MalformedError):  # a humanoid's world publishes other messages than a room
            self._last, self._seen = self._decoder.decode(payload), self._clock()


def _picture(bus: Session, robot: str, png: Path) -> int:
    message = {"path": str(png.absolute())}
    source = target.source("lbr view")
    answers = wire.ask(bus, f"{robot}/world/picture", message, source=source, timeout_s=10.0)
    if not answers:
        raise BusError("no simulated world answers; only a profile that simulates has one ('lbr status' shows it)")
    reply = msgspec.json.decode(answers[0].payload)
    if not reply.get("accepted"):
        raise BusError(str(reply.get("reason") or "the picture was refused"))
    click.echo(str(reply.get("path", png)))
    return 0
