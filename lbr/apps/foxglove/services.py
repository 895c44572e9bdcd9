"""The robot's words as services: what a service takes, and the console line that it says. Pure."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec
from msgspec import Struct

from lbr.bus.codec import decode_request
from lbr.errors import InputError, MalformedError

STOP, ESTOP = "stop", "estop"
LONGEST_VALUE = 1000
_PLACE = re.compile(r"\{[a-z_0-9]+(?:\.\.\.)?\}")
_RESPONSE = {
    "title": "Result",
    "type": "object",
    "properties": {"code": {"type": "integer"}, "text": {"type": "string"}, "data": {}},
}


class Service(Struct, frozen=True, kw_only=True):
    """A word, with what stands fast beside it (`torque/on`), and all ways to say it: patterns and their fields.

    An `external` line has blanks between its words.
    """

    word: str
    role: str
    help: str
    ways: tuple[tuple[str, tuple[str, ...]], ...]
    external: bool = False
    choices: Mapping[str, tuple[str, ...]] = {}

    def line(self, given: Mapping[str, Any]) -> str:
        """Return the line that says it with these fields; InputError says what does not fit."""
        said = {name: _value(name, value) for name, value in given.items() if value is not None and value != ""}
        for pattern, fields in self.ways:
            if set(fields) == set(said):
                values = [said[one] for one in fields]
                return " ".join([pattern, *values]) if self.external else _filled(pattern, values)
        ways = " or ".join(f"{{{', '.join(fields)}}}" for _, fields in self.ways)
        raise InputError(f"'{self.word}' takes {ways}, and not {{{', '.join(sorted(said))}}}", "bad_value")


def services(words: Iterable[Mapping[str, Any]]) -> tuple[Service, ...]:
    """Return a service for each word, by what the robot tells of its words; `stop` and `estop` always."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for entry in words:
        found.setdefault(_name(entry), []).append(entry)
    made = {word: _service(word, entries) for word, entries in found.items() if word}
    for word, text in ((STOP, "Stop whatever moves"), (ESTOP, "Latch the emergency stop")):
        made.setdefault(word, Service(word=word, role="view", help=text, ways=((word, ()),)))
    return tuple(made[word] for word in sorted(made))


def told(number: int, service: Service) -> dict[str, Any]:
    """Return a service as the protocol tells it."""
    fields = {name: _field(service, name) for _, fields in service.ways for name in fields}
    always = set.intersection(*(set(fields) for _, fields in service.ways))
    request = {
        "title": f"{service.word}Request",
        "description": service.help,
        "type": "object",
        "properties": fields,
        "required": sorted(always),
    }
    asked, answer = msgspec.json.encode(request).decode(), msgspec.json.encode(_RESPONSE).decode()
    return {
        "id": number,
        "name": f"/{service.word}",
        "type": f"lbr/{service.word}",
        "requestSchema": asked,
        "responseSchema": answer,
        "request": _written(f"{service.word}Request", asked),
        "response": _written("Result", answer),
    }


def read(payload: bytes) -> dict[str, Any]:
    """Return the fields of a request; InputError names the problem."""
    try:
        found = decode_request(payload or b"{}")
    except MalformedError as err:
        raise InputError(f"the request: {err}", "malformed") from None
    if not isinstance(found, dict):
        raise InputError("the request is no JSON object, such as {}", "malformed")
    return found


def _name(entry: Mapping[str, Any]) -> str:
    """Return what stands fast in the pattern of a word, so that each of its meanings is a service of its own."""
    fast = _PLACE.sub(" ", str(entry.get("pattern") or entry.get("word", "")))
    return "/".join(fast.replace("/", " ").split())


def _service(word: str, entries: list[Mapping[str, Any]]) -> Service:
    ways, choices = [], {}
    for entry in entries:
        fields = [field for field in entry.get("fields") or () if isinstance(field, dict)]
        ways.append((str(entry.get("pattern", word)), tuple(str(field.get("name", "")) for field in fields)))
        choices.update({str(f.get("name", "")): tuple(map(str, f.get("choices") or ())) for f in fields})
    first = entries[0]
    return Service(
        word=word,
        role=str(first.get("role", "operate")),
        help=str(first.get("help", "")),
        ways=tuple(dict.fromkeys(ways)),
        external=first.get("target") == "external",
        choices=choices,
    )


def _filled(pattern: str, values: Sequence[str]) -> str:
    """Return a pattern with its places filled in their order: they are named by the message, and fields for people."""
    left = iter(values)
    return _PLACE.sub(lambda _place: next(left, ""), pattern)


def _field(service: Service, name: str) -> dict[str, Any]:
    choices = service.choices.get(name, ())
    return {"type": ["string", "number"], **({"examples": list(choices[:20])} if choices else {})}


def _value(name: str, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise InputError(f"'{name}' is to be a text or a number", "bad_value")
    text = str(value)
    if len(text) > LONGEST_VALUE or not text.isprintable():
        raise InputError(f"'{name}' is to be a line of {LONGEST_VALUE} characters at most", "bad_value")
    return text


def _written(name: str, schema: str) -> dict[str, Any]:
    return {"encoding": "json", "schemaName": name, "schemaEncoding": "jsonschema", "schema": schema}
