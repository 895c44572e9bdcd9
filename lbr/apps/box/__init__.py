"""The black box: every stream, event and line of a log, always, into files that survive a power cut.

`ear` hears the bus, `logs` reads what processes write, `disk` writes beside the main loop, `keeping` decides what is kept for
longer, `clock` dates what others say. It only listens, and nothing waits for it.
"""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"box": "lbr.apps.box.kind:KIND"},
    commands={
        "box": CliCommand(
            entry="lbr.commands.box:command", help="Look at what the black box holds, take it along, and delete it."
        ),
        "at": CliCommand(
            entry="lbr.commands.at:command", help="Answer as then: why, status and rows of a moment that is past."
        ),
        "record": CliCommand(entry="lbr.commands.record:command", help="Record all that is said, on purpose."),
        "replay": CliCommand(
            entry="lbr.commands.replay:command",
            help="Publish what was recorded under another robot's name, to look at.",
        ),
        "plot": CliCommand(
            entry="lbr.commands.plot:command",
            help="Plot numbers of streams in the terminal, live or out of the black box.",
        ),
    },
)
