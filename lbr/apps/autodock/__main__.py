"""The program: `python -m lbr.apps.autodock --help`."""

import argparse
import sys
import time
from contextlib import ExitStack

from lbr.apps import program
from lbr.apps.program import Robot
from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.errors import BusError, MalformedError
from lbr.messages.behaviour import BehaviourState, RunBehaviour
from lbr.messages.drive import DriveState
from lbr.messages.leases import CommandReply, StopCommand

ANSWER_S = 2.0
SILENT_S = 5.0
"""The behaviours publish their state at least once a second; a busy machine may be late."""
LOOK_S = 0.1


def main() -> int:
    """Dock; exit code 0 if the table ended well."""
    given = _arguments(sys.argv[1:])
    with program.connected("autodock") as robot:
        good, text = run(robot, given.table)
    sys.stdout.write(f"{text}\n")
    return 0 if good else program.FAILED


def run(robot: Robot, table: str) -> tuple[bool, str]:
    """Run a table, and return whether it ended well and how; an interrupt of this program ends the table."""
    states = wire.Subscription(robot.bus, keys.port(robot.name, "behaviour", "state"), depth=64)
    if stopped := _stopped_since(robot):
        return False, stopped
    reply = _asked(robot, "run", RunBehaviour(name=table))
    if not reply.accepted:
        return False, reply.reason
    _tell(reply.reason)
    with ExitStack() as interrupted:
        interrupted.callback(_asked, robot, "stop", StopCommand(reason="the program that wanted it ends"))
        ended = _watched(states, table)
        interrupted.pop_all()
    return ended


def _watched(states: wire.Subscription, table: str) -> tuple[bool, str]:
    """Report each state until the table ends."""
    heard_s, reported, decoder = time.monotonic(), "", Decoder(BehaviourState)
    runs = False
    while time.monotonic() - heard_s < SILENT_S:
        for raw in states.take():
            try:
                state = decoder.decode(raw.payload)
            except MalformedError:
                continue
            heard_s = time.monotonic()
            mine = table in {state.table, *state.called}
            runs = runs or (mine and state.phase in {"running", "paused"})
            if runs and not mine:
                return False, "the table is gone: the behaviours started over"
            if runs and state.state != reported:
                reported = state.state
                _tell(reported)
            if runs and state.phase in {"ended", "resting"}:
                return bool(state.good), state.reason
        time.sleep(LOOK_S)
    raise BusError("the capability 'behaviour' is gone; what moved has stopped by itself")


def _stopped_since(robot: Robot) -> str:
    """Return a stop since this program was started, in words, or an empty string."""
    key = keys.port(robot.name, "drive", "state")
    drive, end = wire.Subscription(robot.bus, key, depth=4), time.monotonic() + ANSWER_S
    while time.monotonic() < end:
        for raw in drive.take():
            try:
                state = Decoder(DriveState).decode(raw.payload)
            except MalformedError:
                continue
            stopped = state.stopped_s is not None and state.stopped_s > robot.started_s
            return f"stopped by {state.stopped_by or 'a stop'}" if stopped else ""
        time.sleep(LOOK_S / 2)
    raise BusError("the drive does not say whether the robot was stopped: the capability 'drive' is silent")


def _asked(robot: Robot, command: str, message: object) -> CommandReply:
    key = keys.port(robot.name, "behaviour", command)
    for answer in wire.ask(robot.bus, key, message, source=robot.source, timeout_s=ANSWER_S, origin=robot.origin):
        return Decoder(CommandReply).decode(answer.payload)
    raise BusError("the capability 'behaviour' does not answer; without it no table runs")


def _tell(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def _arguments(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="autodock",
        description="Run the table that brings the robot to its dock. How it lies there, settings of the row of kind"
        " 'beacon' say: heading_deg, side, docked_back_cm.",
    )
    parser.add_argument("--table", default="dock", metavar="NAME", help="the table to run (dock)")
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(program.run(main))
