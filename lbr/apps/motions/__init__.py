"""Motions as files: taken from other programs, written to their formats, drawn up anew, and checked for balance."""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    commands={
        "motion": CliCommand(
            entry="lbr.apps.motions.commands.motion:command",
            help="Take motions from files, and write them to files.",
            group="build",
        ),
    },
    needs=("simulation",),
)
