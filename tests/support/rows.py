"""Rows of a robot as a fake context gives them."""

from collections.abc import Callable
from typing import TypeVar

from lbr.messages.rows import Row

R = TypeVar("R", bound=Row)


def given(*rows: Row) -> Callable[[type[R]], tuple[R, ...]]:
    """Return what a context's `rows` is, when these are all that there are."""
    return lambda row: tuple(one for one in rows if type(one) is row)
