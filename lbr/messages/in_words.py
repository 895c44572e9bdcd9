"""The bounds of a text, in words: people read them instead of the regular expression."""

from lbr.messages.shapes import NAME
from lbr.messages.units import FILE_STEM, FILE_STEM_PATTERN, NAME_OR_NONE_PATTERN, NAME_PATTERN

MEANT = {
    FILE_STEM_PATTERN: f"a file's name ({FILE_STEM})",
    NAME_PATTERN: NAME.words,
    NAME_OR_NONE_PATTERN: NAME.words,
}


def in_words(said: str) -> str:
    """Return msgspec's objection to a value, with words for the known expressions."""
    for pattern, meant in MEANT.items():
        said = said.replace(f"`str` matching regex {pattern!r}", meant)
    return said
