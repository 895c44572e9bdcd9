"""The completions of a command line, from the running robots and their rows. Quick and silent, also without a robot."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import click
import msgspec
from click.shell_completion import CompletionItem

from lbr import home
from lbr.database import glance
from lbr.errors import LbrError

if TYPE_CHECKING:
    from lbr.bus.session import Session

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def complete_topic(context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the topics of the chosen robot, with their messages."""
    with suppress(LbrError, OSError), _bus(context) as (bus, robot, source):
        from lbr.console import topics  # noqa: PLC0415 - kept out of its `--help`

        return items(begun, ((one.name, one.message) for one in topics.catalogue(bus, robot, source)))
    return []


def complete_field(context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the numeric fields of streams, such as `drive/state.power`."""
    with suppress(LbrError, OSError), _bus(context) as (bus, robot, source):
        from lbr.console import topics  # noqa: PLC0415

        streams = [stream for stream in topics.catalogue(bus, robot, source) if stream.role != "command"]
        return items(
            begun,
            (
                (f"{stream.name}.{field.name}", str(field.schema.get("description", "")))
                for stream in streams
                for field in topics.fields_of(stream)
            ),
        )
    return []


def complete_line(context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the possible continuations of a console line: words, then fields."""
    with suppress(LbrError, OSError), _bus(context) as (bus, robot, source):
        from prompt_toolkit.completion import CompleteEvent
        from prompt_toolkit.document import Document

        from lbr.console.completion import LineCompleter  # noqa: PLC0415
        from lbr.console.operator import BusOperator  # noqa: PLC0415

        typed = " ".join([*(context.params.get("words") or ()), begun])
        words = BusOperator(bus, robot, source, listen=False).words()
        found = LineCompleter(words).get_completions(Document(typed), CompleteEvent(completion_requested=True))
        before = len(typed) - len(begun)
        lines = (
            (typed[: len(typed) + one.start_position] + one.text, one.display_meta_text) for one in found if one.text
        )
        return [CompletionItem(line[before:], help=text) for line, text in lines]
    return []


def of_rows(table: str, text: str) -> Complete:
    """Return a completion by the names of rows here; the column `text` explains each value."""

    def complete(context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
        with suppress(LbrError):
            return items(
                begun, glance.rows(context.params.get("database") or home.default_database(), table, "name", text)
            )
        return []

    return complete


complete_capability = of_rows("capability", "help")
complete_motion = of_rows("motion", "help")
complete_behaviour = of_rows("behaviour", "help")
complete_token = of_rows("user_token", "role")


def complete_setting(context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the parts that have settings; once only one is left, its settings, such as `drive.max_power`."""
    from lbr.capability import registry  # noqa: PLC0415

    part, dot, _ = begun.partition(".")
    with suppress(LbrError, OSError):
        database = context.params.get("database") or home.default_database()
        rows = glance.rows(database, "capability", "name", "kind")
        parts = {name: kind for name, kind in rows if (name == part if dot else name.startswith(part))}
        if len(parts) != 1:
            return [CompletionItem(f"{name}.", help=kind) for name, kind in parts.items()]
        ((name, kind),) = parts.items()
        fields = msgspec.structs.fields(registry.find(kind, home.home()).settings)
        return items(begun, ((f"{name}.{field.encode_name}", "") for field in fields))
    return []


@contextmanager
def _bus(context: click.Context) -> "Iterator[tuple[Session, str, str]]":
    from lbr.console import target  # noqa: PLC0415

    found = target.find(context.params.get("robot"), context.params.get("connect"), context.params.get("token_file"))
    with target.connected(found) as bus:
        yield bus, found.robot, target.source("completion")


def items(begun: str, found: Iterable[Any]) -> list[CompletionItem]:
    """Return the pairs of name and help whose name begins so."""
    return [CompletionItem(name, help=text or None) for name, text in found if name.startswith(begun)]
