"""Texts without characters that no voice speaks, and phrases by name and language. Pure."""

import unicodedata
from collections.abc import Iterable, Mapping

from lbr.errors import InputError
from lbr.messages.speech import Phrase, SayCommand
from lbr.names import did_you_mean

MOST_CHARACTERS = 5000
LAST_RESORT = "en"
_PICTURES = 0x2190  # from here on, symbols are arrows and pictures; ° and № before them have words
_SELECTORS = range(0xFE00, 0xFE10)
_SKIN = range(0x1F3FB, 0x1F400)
_SPOKEN_SIGNS = frozenset("%&@#*")


def sayable(text: str) -> str:
    """Return a text without control characters and pictures; raise InputError if nothing is left to speak."""
    if len(text) > MOST_CHARACTERS:
        raise InputError(f"the text has {len(text)} characters; at most {MOST_CHARACTERS} can be spoken at once")
    spoken = " ".join("".join(map(_spoken, text)).split())
    if any(char.isalnum() or char in _SPOKEN_SIGNS or unicodedata.category(char)[0] == "S" for char in spoken):
        return spoken
    raise InputError("it has nothing that can be spoken" if text.strip() else "there is nothing to speak")


def phrase(phrases: Iterable[Phrase], name: str, language: str) -> Phrase:
    """Return a phrase in a language, or else in English; raise InputError with similar names."""
    known = {(row.name, row.language): row for row in phrases}
    base = language.partition("-")[0]
    for tag in (language, base, LAST_RESORT):
        if (name, tag) in known:
            return known[name, tag]
    names = {row.name for row in known.values()}
    if name in names:
        has = ", ".join(sorted(tag for other, tag in known if other == name))
        raise InputError(f"the phrase '{name}' has no text in '{language}'; it has one in {has}")
    raise InputError(f"there is no phrase '{name[:40]}'; {did_you_mean(name, names)}", "unknown_name")


def to_say(command: SayCommand, phrases: Iterable[Phrase], language: str) -> tuple[str, str]:
    """Return text and language of a command."""
    wanted = command.language.lower() or language
    if command.text and command.phrase:
        raise InputError("give a text or the name of a phrase, not both")
    if not command.phrase:
        return sayable(command.text), wanted
    found = phrase(phrases, command.phrase, wanted)
    return sayable(found.text), found.language


def voice_of(language: str, voices: Mapping[str, str]) -> str:
    """Return the row's voice for a language or its base language, or an empty string."""
    return voices.get(language) or voices.get(language.partition("-")[0], "")


def _spoken(char: str) -> str:
    category, code = unicodedata.category(char), ord(char)
    if char.isspace() or category in {"Zl", "Zp"}:
        return " "
    unsaid = category in {"Cc", "Cf", "Cs", "Co", "Cn"} or code in _SELECTORS or code in _SKIN
    picture = category == "So" and code >= _PICTURES
    return "" if unsaid else " " if picture else char
