"""The words of a robot, as methods that complete: each is a word of its rows."""

import inspect
import keyword
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

from lbr.errors import InputError

Entry = dict[str, Any]
R = TypeVar("R")
SHOWN_CHOICES = 12


class Words(Generic[R]):
    """The words of a robot as attributes, for programs and their completion: `words.play("wave")` is `/play/wave`.

    They are requested when they are first needed, and again for an unknown word, as rows may have changed. A word that
    is not a Python name is `words["word"]`. `say` sends a line and returns the answer.
    """

    def __init__(self, entries: Callable[[], list[Entry]], say: Callable[[str], R]) -> None:
        self._ask = entries
        self._say = say
        self._known: dict[str, list[Entry]] = {}

    def __dir__(self) -> Iterator[str]:
        if not self._known:
            self._look()
        return (word for word in sorted(self._known) if word.isidentifier() and not keyword.iskeyword(word))

    def __getattr__(self, name: str) -> "Word[R]":
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __getitem__(self, word: str) -> "Word[R]":
        if word not in self._known:
            self._look()
        if word not in self._known:
            raise KeyError(f"'{word}' is not a word of this robot; dir() lists them")
        return Word(word, self._known[word], self._say)

    def _look(self) -> None:
        known: dict[str, list[Entry]] = {}
        for entry in self._ask():
            known.setdefault(str(entry["word"]), []).append(entry)
        self._known = known


class Word(Generic[R]):
    """A word: a call with its fields does the same as the console."""

    def __init__(self, word: str, entries: list[Entry], say: Callable[[str], R]) -> None:
        self.__name__ = word
        self.__doc__ = "\n".join(_described(entry) for entry in entries)
        self.__signature__ = _signature(entries)
        self._entries = entries
        self._say = say

    def __call__(self, *values: object) -> R:
        """Send it."""
        return self._say(self.line(*values))

    def __repr__(self) -> str:
        return self.__doc__ or self.__name__

    def line(self, *values: object) -> str:
        """Return the line for the console; raise InputError if a value does not fit into one."""
        texts = [_text(value) for value in values]
        if any(entry.get("target") == "external" for entry in self._entries):
            return " ".join((self.__name__, *texts))
        whole = any(entry["pattern"].endswith("...}") for entry in self._entries)
        for text in texts if not whole else texts[:-1]:
            if "/" in text:
                raise InputError(f"'{text}' has a '/' in it, which separates fields: '{self.__name__}' takes none")
        if not texts and any(not entry["pattern"].startswith("/") for entry in self._entries):
            return self.__name__
        return "/".join(("", self.__name__, *texts))


def _text(value: object) -> str:
    text = str(value)
    if not text.strip() or not text.isprintable():
        raise InputError(f"{text!r} cannot be sent: it is empty, or more than a line")
    return text


def _described(entry: Entry) -> str:
    fields = [field for field in entry.get("fields") or [] if field.get("choices")]
    choices = "; ".join(f"{field['name']}: {_listed(field['choices'])}" for field in fields)
    if not fields and entry.get("choices"):
        choices = _listed(entry["choices"])
    return f"{entry['pattern']}: {entry.get('help', '')}" + (f" ({choices})" if choices else "")


def _listed(choices: list[Any]) -> str:
    more = f", … {len(choices) - SHOWN_CHOICES} more" if len(choices) > SHOWN_CHOICES else ""
    return ", ".join(map(str, choices[:SHOWN_CHOICES])) + more


def _signature(entries: list[Entry]) -> inspect.Signature:
    """Return the fields of its longest form; those that a shorter form lacks are optional."""
    fields = [[str(field["name"]) for field in entry.get("fields") or []] for entry in entries]
    longest, fewest = max(fields, key=len), min(map(len, fields))
    parameters = []
    for at, name in enumerate(longest):
        plain = name.isidentifier() and not keyword.iskeyword(name) and name not in longest[:at]
        default = inspect.Parameter.empty if at < fewest else None
        parameters.append(
            inspect.Parameter(name if plain else f"field_{at}", inspect.Parameter.POSITIONAL_ONLY, default=default)
        )
    return inspect.Signature(parameters)
