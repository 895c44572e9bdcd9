"""What a text may be, in words: who sends another is told that, not the regular expression."""

from lbr.messages.units import A_NAME, FILE_STEM, FILE_STEM_PATTERN, NAME_OR_NONE_PATTERN, NAME_PATTERN

MEANT = {
    FILE_STEM_PATTERN: f"a file's name ({FILE_STEM})",
    NAME_PATTERN: A_NAME["meant"],
    NAME_OR_NONE_PATTERN: A_NAME["meant"],
}


def in_words(said: str) -> str:
    """Return what msgspec says against a value, with words for the expressions that are known."""
    for pattern, meant in MEANT.items():
        said = said.replace(f"`str` matching regex {pattern!r}", meant)
    return said
