"""One module for each command of `lbr`, and the component `core`: what every robot needs."""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"exec": "lbr.capability.program:KIND"},
    commands={
        "run": CliCommand(entry="lbr.commands.run:command", help="Start a robot.", group="start"),
        "robots": CliCommand(
            entry="lbr.commands.robots:command",
            help="List the robots that there are, and how to start them.",
            group="start",
        ),
        "agent": CliCommand(
            entry="lbr.commands.agent:command",
            help="Run a share of a robot that is on another machine.",
            group="run for good",
        ),
        "console": CliCommand(
            entry="lbr.commands.console:command",
            help="Open a console on a running robot, here or over the LAN.",
            group="drive",
        ),
        "send": CliCommand(
            entry="lbr.commands.send:command",
            help="Say one console line; its result is text and exit code.",
            group="drive",
        ),
        "status": CliCommand(entry="lbr.commands.status:command", help="Show what runs.", group="look"),
        "why": CliCommand(
            entry="lbr.commands.why:command", help="Say what holds a part still, and what to type.", group="look"
        ),
        "stop": CliCommand(
            entry="lbr.commands.stop:command", help="Shut a robot down and wait until it is gone.", group="start"
        ),
        "doctor": CliCommand(
            entry="lbr.commands.doctor:command",
            help="Look for what is wrong with this machine, and say what to type.",
            group="start",
        ),
        "devices": CliCommand(
            entry="lbr.commands.devices:command",
            help="See what is plugged in, and have the rows say so.",
            group="change",
        ),
        "service": CliCommand(
            entry="lbr.commands.service:command",
            help="Run a robot as a service, from the start of the machine on.",
            group="run for good",
        ),
        "token": CliCommand(
            entry="lbr.commands.token:command",
            help="Let people on other machines in, and lock them out.",
            group="run for good",
        ),
        "topic": CliCommand(
            entry="lbr.commands.topic:command", help="List, describe, print, measure and publish streams.", group="look"
        ),
        "graph": CliCommand(entry="lbr.commands.graph:command", help="Show who feeds whom.", group="look"),
        "get": CliCommand(
            entry="lbr.commands.getting:command", help="Print the settings of the robot's parts.", group="change"
        ),
        "set": CliCommand(
            entry="lbr.commands.setting:command",
            help="Change one setting of one part; the robot follows.",
            group="change",
        ),
        "db": CliCommand(
            entry="lbr.commands.db:command", help="Create, check and compare the robot's rows.", group="change"
        ),
        "completion": CliCommand(
            entry="lbr.commands.completion:command",
            help="Print what makes a shell complete lbr's commands.",
            group="run for good",
        ),
        "new": CliCommand(
            entry="lbr.commands.new:command",
            help="Write a robot, a driver, servos, wheels or a capability of your own, to begin with.",
            group="build",
        ),
    },
)
