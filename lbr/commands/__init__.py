"""One module for each command of `lbr`, and the component `core`: what every robot needs."""

from lbr.component import CliCommand, CommandGroup, Component

_COMMANDS: tuple[tuple[str, CommandGroup, str], ...] = (
    ("run", "start", "Start a robot."),
    ("demo", "start", "Have a simulated robot show what it can do."),
    ("robots", "start", "List the robots that there are, and how to start them."),
    ("agent", "run for good", "Run a share of a robot that is on another machine."),
    ("console", "drive", "Open a console on a running robot, here or over the LAN."),
    ("send", "drive", "Say one console line; its result is text and exit code."),
    ("status", "look", "Show what runs."),
    ("why", "look", "Say what holds a part still, and what to type."),
    ("stop", "start", "Shut a robot down and wait until it is gone."),
    ("doctor", "start", "Look for what is wrong with this machine, and say what to type."),
    ("devices", "change", "See what is plugged in, and have the rows say so."),
    ("service", "run for good", "Run a robot as a service, from the start of the machine on."),
    ("token", "run for good", "Let people on other machines in, and lock them out."),
    ("topic", "look", "List, describe, print, measure and publish streams."),
    ("graph", "look", "Show who feeds whom."),
    ("get", "change", "Print the settings of the robot's parts."),
    ("set", "change", "Change one setting of one part; the robot follows."),
    ("db", "change", "Create, check and compare the robot's rows."),
    ("completion", "run for good", "Print what makes a shell complete lbr's commands."),
    ("new", "build", "Write a robot, a driver, servos, wheels or a capability of your own, to begin with."),
)
"""Each with its heading in `lbr --help`, in the order of these."""
COMPONENT = Component(
    kinds={"exec": "lbr.capability.program:KIND"},
    commands={name: CliCommand(f"lbr.commands.{name}:command", help_, group) for name, group, help_ in _COMMANDS},
)
