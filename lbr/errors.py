"""The errors people handle. Each has the fault, its place, and the cure; all others are bugs and crash loudly."""

from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lbr.messages.codes import Code

LONGEST_TEXT = 300


class LbrError(Exception):
    """Any error of lbr with a text for people."""


class DeviceError(LbrError, OSError):
    """A device is missing, busy, wrong or silent; its capability is degraded and tries again."""

    def __init__(self, text: str = "", code: "Code" = "unreachable") -> None:
        super().__init__(text)
        self.code: Code = code


class RowError(LbrError, ValueError):
    """Rows that cannot become a robot; `problems` has all of them, each with table, row and column."""

    def __init__(self, problems: tuple[str, ...]) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems


class InputError(LbrError, ValueError):
    """A line, option or file from a person that is invalid; the text has the permitted values, `code` the reason."""

    def __init__(self, text: str, code: "Code" = "bad_value") -> None:
        super().__init__(text)
        self.code: Code = code


class MalformedError(LbrError, ValueError):
    """Bytes that are not a message of the expected type, with the reason in one line."""


class BusError(LbrError, ConnectionError):
    """The bus cannot be reached or did not answer."""


class AlreadyRunningError(LbrError, RuntimeError):
    """This robot already runs here."""


def told(err: BaseException) -> str:
    """Return an exception as one short line; its `__str__` may be foreign code."""
    text = ""
    with suppress(Exception):
        text = "".join(c if c.isprintable() else "?" for c in " ".join(str(err).split()))
    return f"{type(err).__name__}: {text[:LONGEST_TEXT]}" if text else type(err).__name__
