"""The kind `behaviour`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.behaviours.keys import STREAMS
from lbr.capability.kind import Command, Kind, Rows, Wire, names
from lbr.capability.word import Word
from lbr.messages.beacon import SeekCommand
from lbr.messages.behaviour import (
    BehaviourChecked,
    BehaviourOrder,
    BehaviourRow,
    BehaviourState,
    BehaviourTable,
    BehaviourTables,
    BehaviourWritten,
    CheckBehaviour,
    NamedBehaviour,
    ReadBehaviour,
    RunBehaviour,
    WriteBehaviour,
)
from lbr.messages.drive import DriveCommand, GoalResult, HeadingCommand, TurnCommand
from lbr.messages.joints import PlayCommand
from lbr.messages.leases import StopCommand
from lbr.messages.sensing import RangeSensor
from lbr.messages.sighting import WatchCommand
from lbr.messages.speech import SayCommand
from lbr.messages.units import NameOrNone


class BehaviourSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `behaviour`."""

    ttl_s: Annotated[float, Meta(ge=0.2, le=1.0, description="motion outlives this process for so long")] = 0.5
    when_low: Annotated[
        NameOrNone,
        Meta(description="the table for a low battery of a robot left alone; empty: none"),
    ] = ""


_TABLES = {"name": names(BehaviourTable)}
_STREAM_DEPTH = 4
"""The queue of each telemetry input: this many capabilities can publish one kind without hiding each other."""
_ASKED = {
    "move": Wire("drive.command"),
    "turn": Wire("drive.turn"),
    "heading": Wire("drive.heading"),
    "halt": Wire("drive.stop"),
    "play": Wire("motions.play"),
    "play_halt": Wire("motions.stop"),
    "seek": Wire("beacon.seek"),
    "seek_halt": Wire("beacon.stop"),
    "say": Wire("speech.say"),
    "watch": Wire("sighting.watch"),
}

KIND = Kind(
    name="behaviour",
    summary="runs state tables that anyone can write: conditions over telemetry in, commands out",
    family="app",
    entry="lbr.apps.behaviours.capability:Behaviours",
    settings=BehaviourSettings,
    inputs={**STREAMS, "results": GoalResult},
    optional=(*STREAMS, "results"),
    outputs={"state": BehaviourState, "tables": BehaviourTables},
    commands={
        "run": Command(RunBehaviour, choices=_TABLES),
        "show": Command(NamedBehaviour, choices=_TABLES, role="view"),
        **dict.fromkeys(("list", "why"), Command(BehaviourOrder, role="view")),
        **dict.fromkeys(("pause", "step", "resume"), BehaviourOrder),
        "stop": StopCommand,
        "check": Command(CheckBehaviour, role="view"),
        "read": Command(ReadBehaviour, role="view"),
        "write": Command(WriteBehaviour, choices=_TABLES, role="view"),
    },
    requests={
        "move": DriveCommand,
        "turn": TurnCommand,
        "heading": HeadingCommand,
        "halt": StopCommand,
        "play": PlayCommand,
        "play_halt": StopCommand,
        "seek": SeekCommand,
        "seek_halt": StopCommand,
        "say": SayCommand,
        "watch": WatchCommand,
    },
    replies={"check": BehaviourChecked, "read": BehaviourChecked, "write": BehaviourWritten},
    rows=tuple(Rows(row, followed=True) for row in (BehaviourTable, BehaviourRow, RangeSensor)),
    wires={
        **{stream: Wire("state" if stream != "ranges" else "readings", _STREAM_DEPTH) for stream in STREAMS},
        "dock": Wire("signal", _STREAM_DEPTH),
        "results": Wire("result", 16),
        **_ASKED,
    },
    moves=True,
    words=(
        Word("/behaviour/list", "list", "List the behaviours, and what is wrong with those that cannot be run"),
        Word("/behaviour/show", "show", "Show the table that runs, or ran last: its states, and where the robot is"),
        Word("/behaviour/show/{name}", "show", "Show a table: its states and what leads from one to the next"),
        Word(
            "/behaviour/run/{name}", "run", "Run a behaviour from its start, such as /behaviour/run/patrol; s ends it"
        ),
        Word("/behaviour/stop", "stop", "End the behaviour that runs, and stand still"),
        Word("/behaviour/pause", "pause", "Stand still; /behaviour/resume goes on"),
        Word("/behaviour/step", "step", "Go on up to the next state, and pause there"),
        Word("/behaviour/resume", "resume", "Go on after a pause"),
        Word("/behaviour/why", "why", "Explain for each row of the state why it is not taken, and by how much"),
    ),
)
