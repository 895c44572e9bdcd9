"""What other programs kept of a robot becomes rows. Motions go to files, too, are drawn up anew, and checked for balance."""

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
