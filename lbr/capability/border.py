"""The border to code of others, and of a thread that goes on whatever its work raises."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def border(failed: Callable[[Exception], Exception | None], *passing: type[Exception]) -> Iterator[None]:
    """Give `failed` what is raised within, but for the types `passing`; what it returns is raised instead."""
    try:
        yield
    except passing:
        raise
    except Exception as err:
        if (instead := failed(err)) is not None:
            raise instead from err
