"""A table that docks, and the beacon's manoeuvres, without bus, processes or drive: views and values in, actions out."""

from collections.abc import Callable
from pathlib import Path

from lbr.apps.behaviours import files
from lbr.apps.behaviours.kernel import DONE, Outcome, Run
from lbr.apps.behaviours.keys import Look
from lbr.apps.behaviours.outputs import Halt
from lbr.apps.behaviours.table import Table, compile_table
from lbr.messages.beacon import SeekCommand
from lbr.messages.behaviour import BehaviourTable
from lbr.messages.codes import Reason
from lbr.messages.speech import SayCommand
from lbr.robots.lbr.beacon import BeaconSettings
from lbr.robots.lbr.beacon.manoeuvres import Memory, script
from lbr.robots.lbr.beacon.view import STAND, Action, Ending, Script, View


def dock_table() -> Table:
    """Return the table `dock` as it is shipped."""
    content = Path("docs/examples/behaviours/dock.csv").read_bytes()
    compiled = compile_table(BehaviourTable(name="dock", max_s=900.0), files.read(content, "dock", json=False).rows)
    assert compiled.table is not None, compiled.faults
    return compiled.table


class TableRun:
    """A run of a table from `now`. `action` is what the robot is to do now, `said` the phrases; `follows` counts those begun."""

    def __init__(self, table: Table, now: float, draw: Callable[[int], int], settings: BeaconSettings) -> None:
        self.run = Run(table, {}, now, draw)
        self.action: Action = STAND
        self.said: list[str] = []
        self.follows = 0
        self._settings = settings
        self._memory = Memory(settings.side)
        self._script: Script[Ending] | None = None
        self._ticket = -1

    @property
    def ending(self) -> Ending | None:
        """Return how it ended."""
        over = self.run.over
        return None if over is None else Ending(good=self.run.good, text=over.text, code=over.code)

    def round(self, view: View, now: float, look: Look, *, failed: Ending | None = None) -> Action:
        """Return what the robot is to do after it was seen like this; `failed`: the manoeuvre cannot go on."""
        order = self.run.order
        if isinstance(order, SayCommand | Halt):
            self.said += [order.phrase] if isinstance(order, SayCommand) else []
            self.run.ended(DONE, now)
        elif isinstance(order, SeekCommand):
            self._seek(order, view, now, failed)
        self.run.step(now, look)
        return self.action

    def _seek(self, order: SeekCommand, view: View, now: float, failed: Ending | None) -> None:
        if self.run.ticket != self._ticket:
            self._ticket = self.run.ticket
            self.follows += order.manoeuvre == "follow"
            self._script = script(order.manoeuvre, self._settings, self._memory)
            self.action = next(self._script)
            return
        assert self._script is not None
        try:
            if failed is None:
                self.action = self._script.send(view)
                return
        except StopIteration as end:
            failed = end.value
        self.action = STAND
        assert failed is not None
        self.run.ended(Outcome(failed.good, Reason(failed.code, failed.text)), now)
