"""The words of a robot: its own rows, and the words of its capabilities' kinds."""

from collections.abc import Iterator, Mapping

from msgspec import structs

from lbr.capability.kind import Kind
from lbr.capability.word import Word
from lbr.database import builtin, patterns
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow, RobotRows, VerbRow
from lbr.executive.planning.draft import Draft
from lbr.executive.planning.wiring import EXECUTIVE, EXECUTIVE_VERBS

OF_EVERY_ROBOT = (
    Word("/report/{name}", "report", "Show telemetry, settings, statistics, health, events, wiring or robot"),
    Word("why", "why", "Explain what holds the robot still, and what to type"),
    Word("/why/{part}", "why", "Explain what holds a part still, such as `why drive`: a capability, joint or device"),
    Word("/restart/{name}", "restart", "Stop a capability and start it again, by its name", role="admin"),
)
"""The words of lbr itself that a robot may replace, unlike those of `lbr.database.builtin`."""


def words(rows: RobotRows, kinds: Mapping[str, Kind]) -> tuple[VerbRow, ...]:
    """Return all verbs of a robot, in the order of its rows. Its own row has priority over a kind's word for the same
    lines.

    Of several capabilities with the same word, the word belongs to the one that is enabled, or is named like its kind.
    """
    verbs = {_lines(row.pattern): row for row in rows.verbs}
    line_forms = {*verbs, *((row.name,) for row in rows.external_commands)}
    for name, word in _brought(rows, kinds):
        if (lines := _lines(word.pattern)) not in line_forms:
            line_forms.add(lines)
            verbs[lines] = as_row(name, word)
    return tuple(sorted(verbs.values(), key=lambda row: (row.word, row.pattern)))


def as_row(capability: str, word: Word) -> VerbRow:
    """Return the verb row that corresponds to a capability's word."""
    return VerbRow(
        word=_word(word.pattern),
        pattern=word.pattern,
        target=f"{EXECUTIVE if word.executive else capability}.{word.command}",
        payload=word.fixed or None,
        role=word.role,
        help=word.help,
    )


def problems(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the words of kinds, which are as unreliable as rows."""
    for kind in {kind.name: kind for kind in draft.kinds.values()}.values():
        for word in kind.words:
            if fault := _fault(kind, word):
                yield Problem("kind", kind.name, "words", f"'{word.pattern}': {fault}")


def _fault(kind: Kind, word: Word) -> str:
    try:
        pattern = patterns.parse(word.pattern)
    except ValueError as err:
        return str(err)
    if builtin.shadowed(pattern):
        return "it is a word that every robot has: choose another"
    if word.executive and word.command not in EXECUTIVE_VERBS:
        return f"the executive has no '{word.command}'"
    if not word.executive and word.command not in kind.commands:
        return f"the kind has no command '{word.command}'"
    known_fields = (
        set(EXECUTIVE_VERBS[word.command])
        if word.executive
        else {field.name for field in structs.fields(kind.command(word.command).message)}
    )
    wrong = sorted({*pattern.fields, *word.fixed} - known_fields)
    has = ", ".join(sorted(known_fields)) or "none"
    return f"{word.command} has no field '{wrong[0]}'; it has {has}" if wrong else ""


def _brought(rows: RobotRows, kinds: Mapping[str, Kind]) -> Iterator[tuple[str, Word]]:
    for row in sorted((row for row in rows.capabilities if row.name in kinds), key=_rank):
        for word in kinds[row.name].words:
            yield row.name, word
    for word in OF_EVERY_ROBOT:
        yield EXECUTIVE, word


def _rank(row: CapabilityRow) -> tuple[bool, bool, str]:
    return not row.enabled, row.name != row.kind, row.name


def _lines(pattern: str) -> tuple[str, ...]:
    return patterns.parse(pattern).shape


def _word(pattern: str) -> str:
    return pattern.strip("/").partition("/")[0]
