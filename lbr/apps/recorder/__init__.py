"""The past: the black box beside the robot, recordings on purpose, and the commands for both.

`box` writes, `recording` reads and writes the files, and `rerun` checks a recording against today's capabilities.
"""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"box": "lbr.apps.recorder.box.kind:KIND"},
    commands={
        "box": CliCommand(
            entry="lbr.apps.recorder.commands.box:command",
            help="Look at what the black box holds, take it along, and delete it.",
            group="look",
        ),
        "at": CliCommand(
            entry="lbr.apps.recorder.commands.at:command",
            help="Answer as then: why, status and rows of a moment that is past.",
            group="look",
        ),
        "record": CliCommand(
            entry="lbr.apps.recorder.commands.record:command", help="Record all messages, on purpose.", group="look"
        ),
        "replay": CliCommand(
            entry="lbr.apps.recorder.commands.replay:command",
            help="Publish what was recorded under another robot's name, to look at.",
            group="look",
        ),
        "logs": CliCommand(
            entry="lbr.apps.recorder.commands.logs:command",
            help="Print what a part has written to its log, and go on with it.",
            group="look",
        ),
        "plot": CliCommand(
            entry="lbr.apps.recorder.commands.plot:command",
            help="Plot numbers of streams in the terminal, live or out of the black box.",
            group="look",
        ),
    },
    faces={"recordings": "lbr.apps.recorder.face:RecordingsFace"},
    needs=("simulation", "web"),
    messages=("lbr.apps.recorder.messages", "lbr.apps.recorder.recording.recorded"),
)
