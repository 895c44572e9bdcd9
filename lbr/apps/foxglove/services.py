"""The robot's words as services: the fields of a service, and its console line. Pure."""

import re
from collections.abc import Iterable, Mapping, Sequence

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
    """A word with the fixed parts of its pattern (`torque/on`); `ways` are its patterns and their fields.

    An `external` line has blanks between its words.
    """

    word: str
    role: str
    help: str
    ways: tuple[tuple[str, tuple[str, ...]], ...]
    external: bool = False
    choices: Mapping[str, tuple[str, ...]] = {}

    def line(self, given: Mapping[str, object]) -> str:
        """Return the console line with these fields; raise InputError for fields that do not fit."""
        given_values = {name: _value(name, value) for name, value in given.items() if value is not None and value != ""}
        for pattern, fields in self.ways:
            if set(fields) == set(given_values):
                parts = [given_values[field] for field in fields]
                return " ".join([pattern, *parts]) if self.external else _filled(pattern, parts)
        ways = " or ".join(f"{{{', '.join(fields)}}}" for _, fields in self.ways)
        raise InputError(f"'{self.word}' takes {ways}, and not {{{', '.join(sorted(given_values))}}}", "bad_value")


def services(words: Iterable[Mapping[str, object]]) -> tuple[Service, ...]:
    """Return a service for each word of the robot, and always for `stop` and `estop`."""
    found: dict[str, list[Mapping[str, object]]] = {}
    for entry in words:
        found.setdefault(_name(entry), []).append(entry)
    made = {word: _service(word, entries) for word, entries in found.items() if word}
    for word, text in ((STOP, "Stop whatever moves"), (ESTOP, "Latch the emergency stop")):
        made.setdefault(word, Service(word=word, role="view", help=text, ways=((word, ()),)))
    return tuple(made[word] for word in sorted(made))


def advertisement(number: int, service: Service) -> dict[str, object]:
    """Return the advertisement of a service in the protocol."""
    fields = {name: _field(service, name) for _, fields in service.ways for name in fields}
    always = set.intersection(*(set(fields) for _, fields in service.ways))
    request = {
        "title": f"{service.word}Request",
        "description": service.help,
        "type": "object",
        "properties": fields,
        "required": sorted(always),
    }
    request_schema, response_schema = msgspec.json.encode(request).decode(), msgspec.json.encode(_RESPONSE).decode()
    return {
        "id": number,
        "name": f"/{service.word}",
        "type": f"lbr/{service.word}",
        "requestSchema": request_schema,
        "responseSchema": response_schema,
        "request": _written(f"{service.word}Request", request_schema),
        "response": _written("Result", response_schema),
    }


def read(payload: bytes) -> dict[str, object]:
    """Decode the fields of a request; raise InputError for others."""
    try:
        fields = decode_request(payload or b"{}")
    except MalformedError as err:
        raise InputError(f"the request: {err}", "malformed") from None
    if not isinstance(fields, dict):
        raise InputError("the request is no JSON object, such as {}", "malformed")
    return fields


def _name(entry: Mapping[str, object]) -> str:
    """Return the fixed parts of a word's pattern, so that each of its meanings is its own service."""
    fast = _PLACE.sub(" ", str(entry.get("pattern") or entry.get("word", "")))
    return "/".join(fast.replace("/", " ").split())


def _service(word: str, entries: list[Mapping[str, object]]) -> Service:
    ways, choices = [], {}
    for entry in entries:
        listed = entry.get("fields")
        fields = [field for field in listed if isinstance(field, dict)] if isinstance(listed, list | tuple) else []
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
    """Fill the places of a pattern in sequence: they have the names of the message, the fields those for people."""
    left = iter(values)
    return _PLACE.sub(lambda _place: next(left, ""), pattern)


def _field(service: Service, name: str) -> dict[str, object]:
    choices = service.choices.get(name, ())
    return {"type": ["string", "number"], **({"examples": list(choices[:20])} if choices else {})}


def _value(name: str, value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise InputError(f"'{name}' is to be a text or a number", "bad_value")
    text = str(value)
    if len(text) > LONGEST_VALUE or not text.isprintable():
        raise InputError(f"'{name}' is to be a line of {LONGEST_VALUE} characters at most", "bad_value")
    return text


def _written(name: str, schema: str) -> dict[str, object]:
    return {"encoding": "json", "schemaName": name, "schemaEncoding": "jsonschema", "schema": schema}
