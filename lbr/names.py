"""Names: similar ones, free ones, and names made of texts."""

import difflib
import re
import unicodedata
from collections.abc import Callable, Iterable
from itertools import chain, count

MOST_TOLD = 8
LONGEST = 40
"""In letters of a row's name."""
_NO_NAME = re.compile(r"[^a-z0-9_]+")
_LONGEST = 80  # typed text may be a whole file, and the comparison takes quadratic time


def near(name: str, known: Iterable[str], *, most: int = 1, cutoff: float = 0.6) -> list[str]:
    """Return the known names that are most like a name, the nearest first; `cutoff` from 0 (any) to 1 (the same)."""
    return difflib.get_close_matches(name[:_LONGEST], sorted(set(known)), n=most, cutoff=cutoff)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return the known names that were probably meant, or all known names."""
    names = sorted(set(known))
    if not names:
        return "there is none"
    if close := near(name, names, most=3, cutoff=0.5):
        return f"did you mean {' or '.join(close)}?"
    more = ", …" if len(names) > MOST_TOLD else ""
    return f"there {'is' if len(names) == 1 else 'are'} {', '.join(names[:MOST_TOLD])}{more}"


def first_free(wanted: str, is_taken: Callable[[str], bool], mark: str = "_") -> str:
    """Return the name, or if it is taken the first free one of `name_2`, `name_3`..."""
    names = chain((wanted,), (f"{wanted}{mark}{number}" for number in count(2)))
    return next(name for name in names if not is_taken(name))


def without_marks(text: str) -> str:
    """Return a text without accents, umlauts' dots and the like: `Ça` is `Ca`."""
    return "".join(one for one in unicodedata.normalize("NFKD", text) if not unicodedata.combining(one))


def name_from(text: str, otherwise: str) -> str:
    """Return a valid row name that resembles a text; if it has no first letter, with `otherwise` before it."""
    found = _NO_NAME.sub("_", without_marks(text).casefold()).strip("_")
    if not found[:1].isalpha():
        found = f"{otherwise}_{found}"
    return found[:LONGEST].rstrip("_")
