"""The `lbr` command. Every subcommand is imported only when it runs, so that all of them start fast."""

import importlib
import re
import sys
from importlib import metadata

import click

from lbr import surroundings
from lbr.errors import AlreadyRunningError, InputError, LbrError, RowError
from lbr.names import near

FAILED, BAD_INPUT, ALREADY_RUNNING, INTERRUPTED = 1, 2, 3, 130

COMMANDS = {
    "run": ("run", "Start a robot."),
    "robots": ("robots", "List the robots that there are, and how to start them."),
    "agent": ("agent", "Run a share of a robot that is on another machine."),
    "console": ("console", "Open a console on a running robot, here or over the LAN."),
    "send": ("send", "Say one console line; its result is text and exit code."),
    "status": ("status", "Show what runs."),
    "why": ("why", "Say what holds a part still, and what to type."),
    "stop": ("stop", "Shut a robot down and wait until it is gone."),
    "doctor": ("doctor", "Look for what is wrong with this machine, and say what to type."),
    "devices": ("devices", "See what is plugged in, and have the rows say so."),
    "service": ("service", "Run a robot as a service, from the start of the machine on."),
    "token": ("token", "Let people on other machines in, and lock them out."),
    "registry": ("registry", "List which robots are up and how to reach them, or run the service that does."),
    "topic": ("topic", "List, describe, print, measure and publish streams."),
    "graph": ("graph", "Show who feeds whom."),
    "logs": ("logs", "Print what a part has written to its log, and go on with it."),
    "plot": ("plot", "Plot numbers of streams in the terminal, live or out of the black box."),
    "record": ("record", "Record all that is said, on purpose."),
    "replay": ("replay", "Publish what was recorded under another robot's name, to look at."),
    "box": ("box", "Look at what the black box holds, take it along, and delete it."),
    "at": ("at", "Answer as then: why, status and rows of a moment that is past."),
    "view": ("view", "Watch a simulated robot: its room from above, or its joints."),
    "motion": ("motion", "Take motions from files, and write them to files."),
    "behaviour": ("behaviour", "Write state tables, check and take them, and run them."),
    "import": ("importing", "Take what a robot's former programs kept: databases, tables, motions."),
    "get": ("getting", "Print the settings of the robot's parts."),
    "set": ("setting", "Change one setting of one part; the robot follows."),
    "db": ("db", "Create, check and compare the robot's rows."),
    "completion": ("completion", "Print what makes a shell complete lbr's commands."),
    "new": ("new", "Write a robot, a driver, servos or a capability of your own, to begin with."),
}
_NO_COMMAND = re.compile(r"No such command '(.*)'\.", re.DOTALL)
NO_THREAD = "can't start new thread"
NO_ARGUMENTS = getattr(click.exceptions, "NoArgsIsHelpError", ())  # before click 8.2 it prints the help by itself
HELP = """Run a robot that is rows in a database, and talk to it.

\b
  lbr run                  start the simulated robot, with a console
  lbr robots               which robots there are, and what to run
  lbr send /r/0.2/0        drive at a fifth of full power, for 5 s
  lbr status               what runs
  lbr why drive            what holds the base still, and what to type

Commands that talk to a robot mean the only one that runs here, unless --robot or --connect says otherwise.

\b
Exit codes: 0 done, 1 failed or refused, 2 bad input or rows, 3 already running.
Completion: eval "$(lbr completion bash)"    (or zsh; in fish: lbr completion fish | source)
"""


class LazyGroup(click.Group):
    """Knows its commands by name and one line of help; a command's module loads when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Return the names in the order of a robot's day."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Import a command."""
        if cmd_name not in COMMANDS:
            return None
        command = importlib.import_module(f"lbr.commands.{COMMANDS[cmd_name][0]}").command
        if not isinstance(command, click.Command):
            raise TypeError(f"lbr.commands.{cmd_name} has no command")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write the commands without importing any."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


def _version(ctx: click.Context, _parameter: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        click.echo(f"lbr {metadata.version('lbr')}")
        ctx.exit()


@click.group(cls=LazyGroup, help=HELP, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_version, help="Show the version.")
def cli() -> None:
    """Take the options before the command."""


def main(arguments: list[str] | None = None) -> int:
    """Run `lbr`; return its exit code."""
    try:
        code = _run(arguments)
    except KeyboardInterrupt:  # while what went wrong was told
        code = INTERRUPTED
    if code == INTERRUPTED:
        surroundings.drop_output()
    elif why := surroundings.output_failure():
        code = _complain(why, code or FAILED)
        surroundings.drop_output()
    return code


def _run(arguments: list[str] | None) -> int:
    try:
        surroundings.lift_limits()
        code = cli.main(arguments, prog_name="lbr", standalone_mode=False)
    except click.exceptions.Exit as leaving:
        code = leaving.exit_code
    except NO_ARGUMENTS as err:
        code = _help(err)
    except click.ClickException as err:
        code = _complain(_explained(err), err.exit_code)
    except (click.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except LbrError as err:
        code = _complain(str(err), code_of(err))
    except OSError as err:
        why = surroundings.explained(err)
        if not why:
            raise
        code = _complain(why, FAILED)
        surroundings.drop_output()
    except RuntimeError as err:
        if NO_THREAD not in str(err):
            raise
        code = _complain("this user may start no more threads and processes: end some, or raise 'ulimit -u'", FAILED)
    return code if isinstance(code, int) else 0


def _help(err: click.UsageError) -> int:
    click.echo(err.ctx.get_help() if err.ctx is not None else err.format_message())
    return 0


def _explained(err: click.ClickException) -> str:
    if isinstance(err, click.UsageError) and err.ctx is not None:
        return f"{_meant(err, err.ctx)} ('{err.ctx.command_path} --help' shows how)"
    return err.format_message()


def _meant(err: click.UsageError, context: click.Context) -> str:
    """Return what is wrong, and which command was meant, where one was mistyped."""
    text = err.format_message()
    typed = _NO_COMMAND.fullmatch(text)  # newer versions of click know those that are loaded
    if typed is None or not isinstance(context.command, click.Group):
        return text
    close = near(typed[1], context.command.list_commands(context))
    return f"{text} Did you mean '{close[0]}'?" if close else text


def code_of(err: LbrError) -> int:
    """Return the exit code for an error."""
    if isinstance(err, AlreadyRunningError):
        return ALREADY_RUNNING
    return BAD_INPUT if isinstance(err, InputError | RowError) else FAILED


def _complain(text: str, code: int) -> int:
    """Print lines as people may read them: what was typed may hold characters that move a terminal's cursor."""
    try:
        for line in text.splitlines() or ["failed"]:
            shown = "".join(c if c.isprintable() else "?" for c in line.expandtabs())
            print(f"lbr: {shown}", file=sys.stderr, flush=True)
    except OSError:
        surroundings.drop_output([sys.stderr.fileno()])  # the interpreter would try again, and end with another code
    return code
