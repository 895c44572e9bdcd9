"""Completion of lines: words, then the fields with their values."""

from collections.abc import Iterable, Iterator

from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document

from lbr.console.verbs import OWN
from lbr.messages.schema import JsonObject


class LineCompleter(Completer):
    """Completes lines from the robot's entries, which may change while it runs."""

    def __init__(self, entries: Iterable[JsonObject] = ()) -> None:
        self.entries = list(entries)

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        """Yield the possible continuations; at an empty line only on request."""
        text = document.text_before_cursor.lstrip()
        if not text and not complete_event.completion_requested:
            return
        if text.startswith("/") and "/" in text[1:]:
            yield from self._fields(text)
        elif text.lower().startswith("stop "):
            yield from self._external(text[5:].lstrip())
        elif " " in text:
            yield from self._arguments(text)
        else:
            yield from self._words(text)

    def _words(self, text: str) -> Iterator[Completion]:
        seen = set()
        for entry in self.entries:
            path = entry.get("pattern", "").startswith("/")
            fields = "/" if path and entry["pattern"].count("/") > 1 else ""
            word = f"/{entry['word']}{fields}" if path else str(entry.get("word", ""))
            if word.lower().startswith(text.lower()) and word not in seen:
                seen.add(word)
                yield Completion(word, -len(text), display=word, display_meta=str(entry.get("help", "")))

    def _external(self, text: str) -> Iterator[Completion]:
        for entry in self.entries:
            if entry.get("target") == "external" and entry["word"].startswith(text):
                yield Completion(entry["word"], -len(text), display_meta="end this external command")

    def _arguments(self, text: str) -> Iterator[Completion]:
        """Yield the arguments that the row of an external command permits next."""
        word, *given = text.split(" ")
        index, start = len([one for one in given[:-1] if one]), given[-1]
        for entry in self.entries:
            fields = entry.get("fields") or []
            if entry.get("target") == "external" and entry.get("word") == word and index < len(fields):
                for insert, label, meta in _allowed(fields[index], fields[index]["choices"], start, entry):
                    yield Completion(insert, -len(start) if insert else 0, display=label, display_meta=meta)
            elif str(entry.get("target", "")).startswith(f"{OWN}.") and index == 0 and _bare(entry, word, self.entries):
                for insert, label, meta in _next(entry, index, start):
                    yield Completion(insert, -len(start) if insert else 0, display=label, display_meta=meta)

    def _fields(self, text: str) -> Iterator[Completion]:
        word, *parts = text[1:].split("/")
        index, start = len(parts) - 1, parts[-1]
        seen = set()
        for entry in self.entries:
            if not entry.get("pattern", "").startswith("/") or entry.get("word") != word:
                continue
            for said, shown, meta in _next(entry, index, start):
                if shown not in seen:
                    seen.add(shown)
                    yield Completion(said, -len(start) if said else 0, display=shown, display_meta=meta)


def _bare(entry: JsonObject, word: str, entries: Iterable[JsonObject]) -> bool:
    """Return whether a word of lbr itself with one field may be typed with a space: `why drive`."""
    alone = any(one.get("pattern") == word and one.get("target") == entry["target"] for one in entries)
    return alone and entry.get("word") == word and entry.get("pattern", "").count("/") == 2


def _next(entry: JsonObject, index: int, start: str) -> Iterator[tuple[str, str, str]]:
    """Yield the continuations at a field: the text to insert (empty for a hint), its display, and its meaning."""
    wanted = entry["pattern"].split("/")[2:]
    if index >= len(wanted):
        return
    part = wanted[index]
    if not part.startswith("{"):
        if part.startswith(start):
            yield part, part, str(entry.get("help", ""))
        return
    at = sum(one.startswith("{") for one in wanted[:index])
    fields = entry.get("fields") or []
    field = fields[at] if at < len(fields) else {"name": part.strip("{.}"), "hint": "", "choices": []}
    choices = field.get("choices") or (entry.get("choices", []) if at == 0 else [])
    yield from _allowed(field, choices, start, entry)


def _allowed(
    field: JsonObject, choices: Iterable[object], start: str, entry: JsonObject
) -> Iterator[tuple[str, str, str]]:
    """Yield the choices of a field that begin so, or a hint if it has none."""
    for choice in choices:
        if str(choice).lower().startswith(start.lower()):
            yield str(choice), str(choice), str(field["name"])
    if not choices and not start:
        yield "", f"{field['name']}: {field['hint']}", str(entry.get("help", ""))
