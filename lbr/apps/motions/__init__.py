"""What other programs kept of a robot becomes rows. Motions go to files, too, are drawn up anew, and checked for balance."""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    commands={
        "import": CliCommand(
            entry="lbr.apps.motions.commands.importing:command",
            help="Take what a robot's former programs kept: databases, tables, motions.",
            group="change",
        ),
        "motion": CliCommand(
            entry="lbr.apps.motions.commands.motion:command",
            help="Take motions from files, and write them to files.",
            group="build",
        ),
    },
    needs=("simulation",),
)
