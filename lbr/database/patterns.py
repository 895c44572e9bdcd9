"""Patterns of verbs: `/r/{power}/{angle_deg}`, `/s/{text...}` (the rest of the line), or an alias without a slash."""

import re

from msgspec import Struct

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_FIELD = re.compile(r"\{([a-z][a-z0-9_]*)(\.\.\.)?\}")


class Pattern(Struct, frozen=True):
    """A parsed pattern: its word, its parts (fields in braces), and whether the last field has the rest of the line."""

    word: str
    alias: bool
    parts: tuple[str, ...] = ()
    rest: bool = False

    @property
    def fields(self) -> tuple[str, ...]:
        """Return the message fields that it binds, in the order of the line."""
        return tuple(found[1] for part in self.parts if (found := _FIELD.fullmatch(part)))

    @property
    def shape(self) -> tuple[str, ...]:
        """Return the form of its lines; two patterns of one shape cannot be distinguished."""
        parts = tuple(
            ("{...}" if self.rest and part is self.parts[-1] else "{}") if part[0] == "{" else part
            for part in self.parts
        )
        return (self.word if self.alias else f"/{self.word}", *parts)


def parse(text: str) -> Pattern:
    """Parse a pattern; raise ValueError with its fault."""
    if not text.startswith("/"):
        return Pattern(_word(text), alias=True)
    word, *parts = text[1:].split("/")
    pattern = Pattern(_word(word), alias=False, parts=tuple(parts), rest=bool(parts) and parts[-1].endswith("...}"))
    for index, part in enumerate(parts, start=1):
        _check_part(part, last=index == len(parts))
    if len(set(pattern.fields)) < len(pattern.fields):
        raise ValueError("a field stands in it twice")
    return pattern


def _word(text: str) -> str:
    if not _WORD.fullmatch(text):
        raise ValueError("it begins with a word of letters, digits and underscores (an alias is nothing else)")
    return text


def _check_part(part: str, *, last: bool) -> None:
    if not part:
        raise ValueError("it has an empty part (two slashes, or one at the end)")
    field = _FIELD.fullmatch(part)
    if not field and not _WORD.fullmatch(part):
        raise ValueError(f"part '{part[:60]}' is neither a word nor a {{field}}")
    if field and field[2] and not last:
        raise ValueError(f"'{part[:60]}' takes the rest of the line, so nothing may follow it")
