"""The simulated robots in the machine, as a user starts them: `lbr run`, lines, a world, wheels and joints that are seen to move.

In the machine `python -m tests.lab.robots WORDS` plays all scenes, or those with these words, and tells of each as it ends. Times are by the machine's own clock.
"""

import re
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from tests.lab import stage
from tests.lab.machine import Machine
from tests.lab.stage import Scene, SceneError, within
from tests.support import programs, robot
from tests.support.mover import Mover
from tests.support.trace import Trace
from tests.support.waiting import until

USER = "owner"
MAKE_USER = f"id {USER} 2>/dev/null || useradd --create-home {USER}"
START_S, SOON_S, MOTION_S = 120.0, 10.0, 60.0
ZERO_S = 0.3
STILL_S = 1.0
AHEAD_M = 0.2
MOVED_RAD = 0.5
DRIVES = "/r/0.3/90"
PIPED_DEG, TURNED_DEG = 45.0, 10.0
KEPT = "robots.json"


def play(machine: Machine, send: Callable[[Machine], None], words: Sequence[str] = ()) -> Generator[Scene]:
    """Have the machine play the scenes, as a user without rights, and pass on what it tells of each."""
    send(machine)
    machine.run(MAKE_USER)
    command = f"cd /opt/lab && runuser -u {USER} -- /opt/lbr/bin/python -B -m tests.lab.robots {shlex.join(words)}"
    playing = programs.start([*machine.ssh(), command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)
    assert playing.stdout is not None
    with playing.stdout:
        for line in playing.stdout:
            yield msgspec.json.decode(line, type=Scene)
    if playing.wait():
        yield Scene("the scenes", False, f"what plays them ends with {playing.returncode}")


class Wheels:
    """The robot lbr in its room."""

    def __init__(self, found: robot.Robot) -> None:
        self.robot = found
        self._trace = Trace(found.trace)

    def drives(self) -> str:
        """Drive ahead until the encoders have counted a way, and stop, though the sender goes on."""
        way_m = self._way_m()
        at = time.monotonic_ns()
        with self._moves(0.0):
            until(lambda: self._way_m() > way_m + AHEAD_M, limit_s=SOON_S, what="a way by its encoders")
            first = next(one for one in self._seen(at) if not one.zero)
            zero_ms = self._zero_ms(lambda: self.robot.say("stop"))
            self._still()
        return (
            f"bytes that turn the motors {(first.at_ns - at) / 1e6:.0f} ms after the command; "
            f"{self._way_m() - way_m:.2f} m by its encoders; zero {zero_ms:.0f} ms after the stop was said"
        )

    def loses_its_sender(self) -> str:
        """Kill the program that drives."""
        words = [*robot.LBR, "send", "--hold", "30", DRIVES]
        sender = programs.start(words, env=robot.environment(self.robot.home), stdout=subprocess.DEVNULL)
        try:
            until(lambda: not self._trace.now().zero, limit_s=START_S, what="motion")
            zero_ms = self._zero_ms(lambda: sender.send_signal(signal.SIGKILL))
        finally:
            sender.kill()
            sender.wait()
        return f"zero after {zero_ms:.0f} ms"

    def is_stopped_by_emergency(self) -> str:
        """Stop it in motion for good, reset, and drive anew."""
        with self._moves(90.0):
            zero_ms = self._zero_ms(lambda: self.robot.say("estop"))
            refused = self.robot.say(DRIVES)
            if refused["code"] == 0:
                raise SceneError("it takes a motion in an emergency stop")
            self.robot.say("reset")
            self._still()
        with self._moves(270.0):
            pass
        return f"zero after {zero_ms:.0f} ms; '{refused['text']}'; after reset nothing resumes, a new command drives"

    @contextmanager
    def _moves(self, angle_deg: float) -> Iterator[None]:
        """Have a sender drive that does not care for answers; the wheels turn."""
        mover = Mover(self.robot, angle_deg, source=f"to {angle_deg:g}").start(SOON_S)
        try:
            until(lambda: not self._trace.now().zero, limit_s=SOON_S, what="motion")
            yield
        finally:
            mover.cease()
            self.robot.say("stop")

    def _zero_ms(self, act: Callable[[], object]) -> float:
        """Return how long after an act the motors got zero, if that is as promised."""
        at = time.monotonic_ns()
        act()
        if (zero := self._trace.first_zero(at, SOON_S)) is None:
            raise SceneError(f"the motors did not get zero within {SOON_S:g} s")
        return within((zero.at_ns - at) / 1e9, ZERO_S) * 1e3

    def _still(self) -> None:
        at = time.monotonic_ns()
        time.sleep(STILL_S)
        if any(not one.zero for one in self._seen(at)):
            raise SceneError("the old motion goes on")

    def _seen(self, since_ns: int) -> list[Any]:
        self._trace.read()
        return self._trace.outputs(since_ns)

    def _way_m(self) -> float:
        return float(_told(self.robot, "odometry/state")["distance_m"])


class Humanoid:
    """A robot on legs in its world, held by a hand until its joints hold it."""

    def __init__(self, found: robot.Robot) -> None:
        self.robot = found

    def waves(self) -> str:
        """Switch its joints on, and have it wave: its shoulder is looked at in the world, not in what its servos say."""
        until(self._stands_by_itself, limit_s=START_S, what="it stands by itself")
        said, seen = self._watched("/play/wave", lambda pose: pose["joints"]["right_shoulder_roll"])
        if max(seen) - min(seen) < MOVED_RAD:
            raise SceneError(f"its shoulder moved by {max(seen) - min(seen):.2f} rad only")
        pose = _told(self.robot, "world/pose")
        return f"{said}; its shoulder moved by {max(seen) - min(seen):.2f} rad, on its feet: {pose['on_floor']}"

    def stands_up(self) -> str:
        """Have it stand up from where it sits."""
        said, heights = self._watched("/play/reset", lambda pose: pose["z_m"])
        pose = until(
            lambda: (found := _told(self.robot, "world/pose"))["stands"] and found, limit_s=SOON_S, what="it stands"
        )
        return f"{said}; its trunk {heights[0]:.2f} m above the floor before, {pose['z_m']:.2f} m then"

    def _stands_by_itself(self) -> bool:
        self.robot.say("/torque/on")
        return not _told(self.robot, "world/pose")["held"]

    def _watched(self, line: str, look: Callable[[dict[str, Any]], float]) -> tuple[str, list[float]]:
        """Say a line as `lbr send` does; return what it said, and what was seen of the world until it was done."""
        seen = [look(_told(self.robot, "world/pose"))]
        words = [*robot.LBR, "send", line]
        sender = programs.start(
            words, env=robot.environment(self.robot.home), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        try:
            end = time.monotonic() + MOTION_S
            while sender.poll() is None and time.monotonic() < end:
                seen.append(look(_told(self.robot, "world/pose")))
                time.sleep(0.1)
        finally:
            sender.kill()
            said = " ".join(sender.communicate()[0].split())
        if sender.returncode:
            raise SceneError(f"'{line}': {said or 'not done in time'}")
        return said, seen


def _piped() -> str:
    """Pipe a line into it, as who tries it first; how far it turned it tells by its own encoders and gyroscope."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home, began = robot.prepare(Path(place) / "h", whole=True), time.monotonic()
        running = programs.start(
            [*robot.LBR, "run"], env=robot.environment(home), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        late = threading.Timer(START_S + MOTION_S, running.kill)
        late.start()
        try:
            with running.stdin, running.stdout:
                running.stdin.write(f"/t/{PIPED_DEG:g}\n")
                running.stdin.flush()
                heard = ""
                while not heard.rpartition("\n")[2].startswith("turned") and (line := running.stdout.readline()):
                    heard += f"\n{line.rstrip()}"
                done_s = time.monotonic() - began
                running.stdin.write("Shutdown\n")
                running.stdin.close()
                running.stdout.read()
            code = running.wait()
        finally:
            late.cancel()
            running.kill()
            running.wait()
    turned = re.search(r"turned ([\d.]+) of .*", heard)
    if code or turned is None or abs(float(turned[1]) - PIPED_DEG) > TURNED_DEG:
        raise SceneError(f"ends with {code}: {heard[-300:]}")
    return f"{turned[0]}; {done_s:.1f} s after `lbr run` was typed; Shutdown: exit code {code}"


def _up(found: robot.Robot, began: float) -> str:
    """Wait until all are ready, and tell after how long."""
    seen: dict[str, str] = {}

    def ready() -> bool:
        seen.update({one["name"]: one["phase"] for one in found.status()["capabilities"]})
        return all(phase == "ready" for phase in seen.values())

    with suppress(AssertionError):
        until(ready, limit_s=START_S)
    late = [f"{name} {phase}" for name, phase in seen.items() if phase != "ready"]
    if late:
        raise SceneError(f"not ready: {', '.join(late)}")
    restarts = sum(one["restarts"] for one in found.status()["capabilities"])
    return f"{len(seen)} capabilities ready after {time.monotonic() - began:.1f} s, started again: {restarts}"


def _told(found: robot.Robot, key: str) -> dict[str, Any]:
    return dict(until(lambda: found.ask(key), limit_s=SOON_S, what=f"{key} is told"))


PIPED = "lines piped into `lbr run`"
SCENES: dict[str, tuple[Callable[[robot.Robot], Any], dict[str, Callable[[Any], str]]]] = {
    "lbr-sim": (
        Wheels,
        {
            "drives ahead, and is stopped": Wheels.drives,
            "its sender is killed": Wheels.loses_its_sender,
            "emergency stop in motion, and reset": Wheels.is_stopped_by_emergency,
        },
    ),
    "bioloid-sim": (Humanoid, {"waves": Humanoid.waves}),
    "uxa90-sim": (Humanoid, {"stands up": Humanoid.stands_up}),
}
"""By launch profile. That it starts is told first of each."""


def scenes(words: Sequence[str]) -> Iterator[Scene]:
    """Play those with one of these words, or all, on one robot after the other."""

    def wanted(what: str) -> bool:
        return not words or any(one in what for one in words)

    if wanted(PIPED):
        yield stage.tell(PIPED, _piped)
    for profile, (kind, parts) in SCENES.items():
        chosen = {f"{profile}: {what}": scene for what, scene in parts.items() if wanted(f"{profile}: {what}")}
        if chosen:
            yield from _on_a_robot(profile, kind, chosen)


def _on_a_robot(
    profile: str, kind: Callable[[robot.Robot], Any], parts: dict[str, Callable[[Any], str]]
) -> Iterator[Scene]:
    starts = f"{profile}: starts"
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home, began = robot.prepare(Path(place) / "h", whole=True), time.monotonic()
        try:
            found = robot.start(home, profile=profile, limit_s=START_S)
        except AssertionError as err:
            yield Scene(starts, False, str(err)[:400])
            return
        try:
            yield stage.tell(starts, lambda: _up(found, began))
            played = kind(found)
            for what, scene in parts.items():
                yield stage.tell(what, partial(scene, played))
        finally:
            found.close()


def main() -> None:
    """Tell of each scene on a line."""
    for one in scenes(sys.argv[1:]):
        print(msgspec.json.encode(one).decode(), flush=True)


if __name__ == "__main__":
    main()
