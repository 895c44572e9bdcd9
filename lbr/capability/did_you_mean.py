"""Suggests which name may have been meant."""

import difflib
from collections.abc import Iterable

MOST_TOLD = 8


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return which of the known names may have been meant, or which there are."""
    names = sorted(set(known))
    if not names:
        return "there is none"
    close = difflib.get_close_matches(name[:64], names, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(close)}?"
    more = ", …" if len(names) > MOST_TOLD else ""
    return f"there {'is' if len(names) == 1 else 'are'} {', '.join(names[:MOST_TOLD])}{more}"
