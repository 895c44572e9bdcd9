"""The `lbr` command. Every subcommand is imported only when it runs, so that all of them start fast."""

import re
import sys

import click
from click.shell_completion import CompletionItem

from lbr import plugins, surroundings
from lbr.component import COMMAND_GROUPS
from lbr.errors import AlreadyRunningError, InputError, LbrError, RowError
from lbr.names import near
from lbr.plugins import Plugin, PluginError

FAILED, BAD_INPUT, ALREADY_RUNNING, INTERRUPTED = 1, 2, 3, 130

_NO_COMMAND = re.compile(r"No such command '(.*)'\.", re.DOTALL)
NO_THREAD = "can't start new thread"
NO_ARGUMENTS = getattr(click.exceptions, "NoArgsIsHelpError", ())  # before click 8.2, it prints the help by itself
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


class Commands(click.Group):
    """Lists commands of components by name and one line of help; a command's module loads when it is called."""

    others = True
    """True: commands of other packages are included, which the reference leaves out."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Return the names, lbr's own first."""
        return [one.name for one in self._known()]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command; raise PluginError with the reason if it is unusable."""
        plugin = plugins.find("commands", cmd_name)
        if plugin is None:
            return None
        try:
            command = plugin.load()
        except PluginError:
            if ctx.resilient_parsing:  # the Tab key was pressed
                return None
            raise
        if isinstance(command, click.Command):
            return command
        raise PluginError(plugin, f"{plugin.value} is no click.Command, but of type {type(command).__name__}")

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write lbr's own commands by purpose and others by package, without an import."""
        known = self._known()
        width = max(len(plugin.name) for plugin in known)
        headed: dict[str, list[Plugin]] = {group: [] for group in COMMAND_GROUPS}
        for plugin in known:
            heading = plugin.group if plugin.ours and plugin.group else f"Commands of package '{plugin.package}'"
            headed.setdefault(heading, []).append(plugin)
        for heading, commands in headed.items():
            with formatter.section(heading[0].upper() + heading[1:]):
                formatter.write_dl([(plugin.name.ljust(width), plugin.help) for plugin in commands])
        if self.others and (broken := plugins.broken()):
            with formatter.section("Not loaded"):
                for why in broken:
                    formatter.write_text(why)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the possible continuations of a word, without importing any command."""
        found = [CompletionItem(one.name, help=one.help) for one in self._known() if one.name.startswith(incomplete)]
        return found + click.Command.shell_complete(self, ctx, incomplete)

    def _known(self) -> list[Plugin]:
        found = plugins.every("commands") if self.others else plugins.own("commands")
        return [one for one in found if not one.refusal]


def _version(ctx: click.Context, _parameter: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        click.echo(f"lbr {plugins.version()}")
        ctx.exit()


@click.group(cls=Commands, help=HELP, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_version, help="Show the version.")
def cli() -> None:
    """Accept the options before the command."""


def main(arguments: list[str] | None = None) -> int:
    """Run `lbr`; return its exit code."""
    try:
        code = _run(arguments)
    except KeyboardInterrupt:  # while an error was being reported
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
    """Return the fault, with the command that was probably meant if one was mistyped."""
    text = err.format_message()
    typed = _NO_COMMAND.fullmatch(text)  # newer versions of click suggest the loaded commands themselves
    if typed is None or not isinstance(context.command, click.Group):
        return text
    if close := near(typed[1], context.command.list_commands(context)):
        text = f"{text} Did you mean '{close[0]}'?"
    return text + plugins.perhaps_broken() if isinstance(context.command, Commands) else text


def code_of(err: LbrError) -> int:
    """Return the exit code for an error."""
    if isinstance(err, AlreadyRunningError):
        return ALREADY_RUNNING
    return BAD_INPUT if isinstance(err, InputError | RowError) else FAILED


def _complain(text: str, code: int) -> int:
    """Print lines without control characters: typed text may contain some that move a terminal's cursor."""
    try:
        for line in text.splitlines() or ["failed"]:
            shown = "".join(c if c.isprintable() else "?" for c in line.expandtabs())
            print(f"lbr: {shown}", file=sys.stderr, flush=True)
    except OSError:
        surroundings.drop_output([sys.stderr.fileno()])  # the interpreter would try again, and end with another code
    return code
