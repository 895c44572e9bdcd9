"""Behaviours: state tables that anyone can write, run as the robot's muscle memory.

`files` reads and writes tables, `cells` parses a condition, `keys` a column and `outputs` an order. `table` checks a
whole table, and `kernel` runs it. None of these knows bus or clock. `capability` moves the robot under leases, as any
other client does.
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
