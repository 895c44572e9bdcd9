"""The rows' UXA-90 in the engine, moved by its emulated main board; time passes as fast as it can be computed."""

import sqlite3
from functools import cache

import msgspec
from humanoid_bench import SCHEMA, rows

from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.uxa90.board import MainBoard

TICK_S = 0.008


@cache
def settings():
    """What the row of its world sets."""
    database = sqlite3.connect(":memory:")
    database.executescript(SCHEMA.read_text())
    query = "SELECT settings FROM capability WHERE robot = 'uxa90' AND kind = 'humanoid_world'"
    return msgspec.json.decode(database.execute(query).fetchone()[0], type=HumanoidWorldSettings)


def humanoid(**changed):
    """An engine with its body, as it begins."""
    return HumanoidEngine(msgspec.structs.replace(settings(), **changed), rows("uxa90")[0], "/nonexistent")


class Robot:
    """A body and its main board."""

    def __init__(self):
        self.engine, self.board, self.now = humanoid(), MainBoard(), 0.0
        self.seen = []
        self.run(0.2)

    def play(self, slot, rest_s=0.6):
        """Press a button of the remote control and wait until its motion is over, and a little longer."""
        self.seen = []
        assert self.board.press(slot, self.now)
        return self.run(self.board.programmes[slot].duration_s + rest_s)

    def run(self, seconds):
        """Let time pass; return how it is then."""
        for _ in range(round(seconds / TICK_S)):
            self.now += TICK_S
            self.engine.step(self.board.drives(self.now), TICK_S)
            self.board.feel(self.engine.felt(), self.engine.battery.voltage_v, self.now)
            self.seen.append(self.engine.pose())
        return self.seen[-1]
