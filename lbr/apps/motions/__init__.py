"""Imports the files of a robot's former programs as rows; imports, exports, builds and checks motions."""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    commands={
        "import": CliCommand(
            "lbr.apps.motions.commands.importing:command",
            "Take what a robot's former programs kept: databases, tables, motions.",
            "change",
        ),
        "motion": CliCommand(
            "lbr.apps.motions.commands.motion:command", "Take motions from files, and write them to files.", "build"
        ),
    },
    needs=("simulation",),
)
