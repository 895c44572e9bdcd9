"""The only grammar: a line becomes a call, or one sentence with the permitted lines. Pure."""

import shlex
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from lbr.console.fields import Field, Message, MessageType
from lbr.console.printable import clean, listed
from lbr.database import arguments, builtin, patterns
from lbr.database.rows import BUILT_IN_VERBS, ExternalCommandRow, VerbRow
from lbr.errors import InputError
from lbr.messages.rows import short
from lbr.messages.schema import JsonObject
from lbr.messages.system import Role, higher
from lbr.names import near


class VerbCall(Struct, frozen=True, kw_only=True):
    """A verb with its message: send `payload` to `capability`'s `command`; `executive` is built in."""

    verb: VerbRow
    capability: str
    command: str
    payload: JsonObject


class ExternalCall(Struct, frozen=True, kw_only=True):
    """Start an external command with these arguments after its own."""

    command: ExternalCommandRow
    arguments: tuple[str, ...] = ()


class ExternalStop(Struct, frozen=True, kw_only=True):
    """End an external command."""

    command: ExternalCommandRow


class PythonLine(Struct, frozen=True, kw_only=True):
    """Python to run, only for the local console."""

    code: str


CONFIRMED = "confirmed"
"""The field of a message that marks it as confirmed by a person."""

OWN = "executive"
"""The owner of lbr's own words, in targets."""
_LEAVE = "Ctrl-D leaves 'lbr console' and the robot runs on; at 'lbr run' it shuts the robot down, as 'Shutdown' does"
_HINTS = {"quit": _LEAVE, "exit": _LEAVE, "?": "'help' lists all words"}

Parsed = VerbCall | ExternalCall | ExternalStop | PythonLine


class Vocabulary:
    """The vocabulary of one robot: the words that every robot has, and those of its rows.

    `messages` maps targets (`drive.command`) to the types of their messages (a Struct or a JSON Schema); without one,
    all fields are texts. `roles` maps targets to their least roles; a row may require a higher one.
    """

    def __init__(
        self,
        verbs: Iterable[VerbRow],
        external: Iterable[ExternalCommandRow] = (),
        messages: Mapping[str, MessageType] | None = None,
        roles: Mapping[str, Role] | None = None,
    ) -> None:
        needed = roles or {}
        rows = (
            *BUILT_IN_VERBS,
            *(replace(row, role=higher(row.role, needed.get(row.target, "view"))) for row in verbs),
        )
        self._verbs = [_Verb(row, patterns.parse(row.pattern), messages or {}) for row in rows]
        self._external = {row.name: row for row in external if row.enabled}
        self._bare = {verb.pattern.word: verb for verb in reversed(self._verbs) if verb.pattern.alias}

    def parse(self, line: str | bytes) -> Parsed | None:
        """Return the call of a line, None if it is empty; raise InputError with the permitted lines."""
        line = clean(line)
        if not line:
            return None
        if line.startswith("!"):
            return PythonLine(code=line[1:].strip())
        return self._path(line) if line.startswith("/") else self._words(line)

    def confirming(self, call: VerbCall) -> VerbRow | None:
        """Return the verb that sends a confirmed call directly; None if the call needs no confirmation."""
        if CONFIRMED in call.payload:
            return None
        outright = call.payload | {CONFIRMED: True}
        said = (verb.row for verb in self._verbs if verb.row.target == call.verb.target and not verb.pattern.fields)
        return next((row for row in said if row.payload == outright), None)

    def entries(self, choices: Mapping[str, Iterable[str]] | None = None) -> list[JsonObject]:
        """Return the words as plain data, for completion.

        `choices` are the values of a target's first field, or of another one by `target.field`.
        """
        known = choices or {}
        said = [verb.entry(known) for verb in self._verbs]
        return said + [
            {
                "word": row.name,
                "pattern": row.name,
                "role": row.role,
                "help": row.help,
                "target": "external",
                "fields": [
                    {
                        "name": f"argument_{n}",
                        "hint": arguments.described(one),
                        "choices": [] if isinstance(one, str) else list(one),
                    }
                    for n, one in enumerate(row.arguments or (), start=1)
                ],
            }
            for row in self._external.values()
        ]

    def help(self, running: Collection[str] | None = None) -> str:
        """Return the words as aligned lines for a person, by capability: all, or those of the running ones."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for verb in self._verbs:
            owner = verb.row.target_end[0]
            if running is None or owner in {OWN, *running}:
                groups.setdefault("" if owner == OWN else owner, []).append((verb.plain, verb.row.help))
        lines = [(_usage(row), row.help or "An external command") for row in self._external.values()]
        width = min(max((len(usage) for rows in (*groups.values(), lines) for usage, _ in rows), default=0), 44)
        order = [(name, groups[name]) for name in sorted(groups)] + [("programs beside the robot", lines)]
        texts = [
            ([f"\n{name}:"] if name else []) + [f"{usage:<{width}}  {text}".rstrip() for usage, text in rows]
            for name, rows in order
            if rows
        ]
        return "\n".join(line for group in texts for line in group)

    def tell(self, word: str, entries: Iterable[Mapping[str, Any]]) -> str:
        """Return the fields of a word, as lines for a person, from its entries; InputError if it is not a word."""
        lines = []
        for entry in entries:
            role = "" if entry["role"] == "view" else f" (needs the role {entry['role']})"
            names = iter(field["name"] for field in entry["fields"])
            said = [next(names, part) if part.startswith("{") else part for part in entry["pattern"].split("/")]
            lines.append(f"{'/'.join(said)}  {entry['help']}{role}".rstrip())
            first = entry.get("choices") or []
            for number, field in enumerate(entry["fields"]):
                choices = field["choices"] or (first if number == 0 else [])
                known = f"one of {', '.join(map(str, choices))}" if choices else field["hint"]
                lines.append(f"    {field['name']}: {known}")
        if not lines:
            raise self._unknown(word)
        return "\n".join(lines)

    def _path(self, line: str) -> Parsed:
        parts = [part for part in line.split("/") if part]
        word = parts[0].strip() if parts else ""
        if len(parts) == 1 and builtin.is_builtin(word) and self._is_bare(word):
            return self._words(word)
        known = [verb for verb in self._verbs if not verb.pattern.alias and verb.pattern.word == word]
        fitting = [verb for verb in known if verb.takes(parts[1:])]
        if not fitting and len(parts) == 1 and self._is_bare(word):
            return self._words(word)
        if not known:
            raise self._unknown(f"/{word}")
        if not fitting:
            allowed = listed([verb.plain for verb in known])
            raise InputError(f"'{short(line)}' has {_count(len(parts) - 1)} after '/{word}'; say {allowed}")
        return min(fitting, key=_Verb.looseness).bind(line, parts[1:])

    def _words(self, line: str) -> Parsed:
        word, _, rest = line.partition(" ")
        rest = rest.strip()
        verb = self._bare.get(word) or self._bare.get(word.lower())
        if rest and word.lower() == "stop" and word not in self._external:
            return self._stop_external(rest)
        if verb and not rest:
            return verb.bind(line, [])
        if word in self._external:
            return ExternalCall(command=self._external[word], arguments=_arguments(self._external[word], rest))
        if verb and (longer := self._longer(verb)):
            return longer.bind(f"/{word}/{rest}", [rest])
        if verb:
            raise InputError(f"nothing may follow '{word}', but '{short(rest)}' does")
        raise self._unknown(word)

    def _longer(self, verb: "_Verb") -> "_Verb | None":
        """Return the pattern of one of lbr's own words with one field after it: `why drive` is `/why/drive`."""
        own = verb.row.target_end[0] == OWN
        fitting = (one for one in self._verbs if one.row.target == verb.row.target and one.pattern.parts)
        return next((one for one in fitting if own and len(one.pattern.parts) == len(one.pattern.fields) == 1), None)

    def _is_bare(self, word: str) -> bool:
        return word in self._bare or word.lower() in self._bare or word in self._external

    def _stop_external(self, name: str) -> ExternalStop:
        if name in self._external:
            return ExternalStop(command=self._external[name])
        there = f"there is {listed(sorted(self._external), 'and')}" if self._external else "there is none"
        text = f"no external command is called '{short(name)}' ({there}); 'stop' alone stops the robot"
        raise InputError(text, "unknown_name")

    def _unknown(self, word: str) -> InputError:
        if word.lower().lstrip("/") in _HINTS:
            text = f"'{short(word)}' is not a word of this robot; {_HINTS[word.lower().lstrip('/')]}"
            return InputError(text, "unknown_command")
        words = {verb.pattern.word if verb.pattern.alias else f"/{verb.pattern.word}" for verb in self._verbs}
        words |= set(self._external)
        by_word = {known.lstrip("/"): known for known in sorted(words)}
        exact = [known for known in by_word if known.lower() == word.lower().lstrip("/")]
        changes = {verb.pattern.word for verb in self._verbs if verb.row.role == "admin"}
        close = exact or near(word.lstrip("/"), by_word.keys() - changes)
        hint = f"did you mean '{by_word[close[0]]}'? " if close else ""
        if any(word == verb.row.target_end[0] for verb in self._verbs):
            hint = f"'help {word}' lists the words of that part, "
        text = f"'{short(word)}' is not a word of this robot; {hint}'help' lists all words"
        return InputError(text, "unknown_command")


class _Verb:
    """A row with its parsed pattern and its message's fields."""

    def __init__(self, row: VerbRow, pattern: patterns.Pattern, messages: Mapping[str, MessageType]) -> None:
        self.row = row
        self.pattern = pattern
        self._message = Message(messages.get(row.target))

    @property
    def plain(self) -> str:
        """Return the pattern for people: `/r/power/angle`; a field named like its word is called `name`."""
        if self.pattern.alias:
            return self.pattern.word
        return "/".join(("", self.pattern.word, *self._named()))

    def looseness(self) -> tuple[bool, int]:
        """Return the order of patterns that fit one line: the one with the most fixed words first."""
        return self.pattern.rest, len(self.pattern.fields)

    def takes(self, parts: list[str]) -> bool:
        """Return whether the number of parts and the fixed words fit."""
        wanted = self.pattern.parts
        enough = len(parts) >= len(wanted) if self.pattern.rest else len(parts) == len(wanted)
        return enough and all(want[0] == "{" or want == part.strip() for want, part in zip(wanted, parts, strict=False))

    def bind(self, line: str, parts: list[str]) -> VerbCall:
        """Return the call with its message; raise InputError with the first wrong field."""
        texts = [part.strip() for part in parts]
        if self.pattern.rest:
            texts[len(self.pattern.parts) - 1] = _rest(line, len(self.pattern.parts))
        payload = dict(self.row.payload or {})
        for (_, field), text in zip(self._parts(), texts, strict=False):
            if field is not None:
                payload[field.name] = field.read(text)
        self._message.check(payload)
        capability, command = self.row.target_end
        return VerbCall(verb=self.row, capability=capability, command=command, payload=payload)

    def entry(self, known: Mapping[str, Iterable[str]]) -> JsonObject:
        """Return the row as plain data, with the values of each field."""
        row = self.row
        fields = [
            {"name": f.word, "hint": f.allowed, "choices": sorted(known.get(f"{row.target}.{f.name}", f.choices))}
            for _, f in self._parts()
            if f
        ]
        choices = known.get(row.target)
        said: JsonObject = {"word": row.word, "pattern": row.pattern, "role": row.role, "help": row.help}
        said |= {"target": row.target, "fields": fields}
        return said | ({"choices": sorted(choices)} if choices is not None else {})

    def _named(self) -> Iterator[str]:
        for part, field in self._parts():
            yield part if field is None else "name" if field.word == self.pattern.word else field.word

    def _parts(self) -> list[tuple[str, Field | None]]:
        fields = iter(self.pattern.fields)
        return [(part, self._message.field(next(fields)) if part[0] == "{" else None) for part in self.pattern.parts]


def _rest(line: str, count: int) -> str:
    """Return the line after the word and `count - 1` parts, with its slashes."""
    for _ in range(count):
        line = line.lstrip("/").partition("/")[2]
    return line.lstrip("/").strip()


def _arguments(row: ExternalCommandRow, text: str) -> tuple[str, ...]:
    try:
        given = tuple(shlex.split(text))
    except ValueError:
        raise InputError("a quotation mark or backslash in the arguments has no partner") from None
    if refusal := arguments.refusal(row.arguments or (), given):
        raise InputError(f"'{row.name}' {refusal}; the row's column 'arguments' lists them")
    return given


def _usage(row: ExternalCommandRow) -> str:
    """Return the usage of a command for people: its name, and the values of each argument."""
    return " ".join((row.name, *(f"[{arguments.described(argument)}]" for argument in row.arguments or ())))


def _count(number: int) -> str:
    return f"{number} field{'' if number == 1 else 's'}" if number else "nothing"
