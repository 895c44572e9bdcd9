"""Behaviours: state tables that anyone can write, run as the robot's muscle memory.

`files` reads and writes them, `cells` understands a condition, `keys` a column, `outputs` an order, `table` checks all
of it, `kernel` runs it; none of these knows bus or clock. `capability` moves the robot as they say, by leases as anyone
does.
"""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"behaviour": "lbr.apps.behaviours.kind:KIND"},
    commands={
        "behaviour": CliCommand(
            entry="lbr.apps.behaviours.commands.behaviour:command",
            help="Write state tables, check and take them, and run them.",
            group="build",
        ),
    },
    needs=("simulation",),
)
