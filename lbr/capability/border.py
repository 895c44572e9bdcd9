"""The border to foreign code, and to the work of a thread that must survive any exception."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def border(failed: Callable[[Exception], Exception | None], *passing: type[Exception]) -> Iterator[None]:
    """Pass exceptions raised within to `failed`, except the types `passing`; raise its result instead."""
    try:
        yield
    except passing:
        raise
    except Exception as err:
        if (instead := failed(err)) is not None:
            raise instead from err
