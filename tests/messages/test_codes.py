"""Reasons as codes: one documented list, and nothing that reads the sentences beside them."""

import ast
import re
from collections.abc import Iterable
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from lbr.messages.codes import MEANINGS, Code, heard
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply

LBR = Path(__file__).parents[2] / "lbr"
MODULES = [str(path.relative_to(LBR)) for path in sorted(LBR.rglob("*.py"))]
SENTENCES = frozenset({"reason", "why", "why_not", "ended", "note", "detail", "refusal", "trouble", "refused"})
TOLD_BY = frozenset({"event", "reply", "result", "answer", "ending", "state", "err"})
"""Of these, `text` and `message` are sentences too."""
READERS = frozenset(
    {"startswith", "endswith", "removeprefix", "removesuffix", "partition", "rpartition", "find", "index"}
)
SAID = rf"(?:{'|'.join(sorted(SENTENCES))}|text|message)"
SUSPECT = re.compile(
    rf"\b{SAID}\)?\s*\.\s*(?:{'|'.join(sorted(READERS))})\b"
    rf"|\b{SAID}\)?\s*(?:==|!=|(?:not\s+)?in\b)\s*(?:[A-Z_]+\b|['\"])"
    rf"|(?:\b[A-Z_]+|['\"])\s*(?:==|!=|(?:not\s+)?in\b)\s*(?:str\()?(?:\w+\.)*{SAID}\b"
    r"|accepted\s*=\s*False|\.refuse\("
)
"""Without any of this a source reads no sentence and refuses nothing, and need not be parsed."""


def sentence(node: ast.AST) -> bool:
    """Say whether an expression is what people are told."""
    if isinstance(node, ast.Name):
        return node.id in SENTENCES
    if isinstance(node, ast.Attribute):
        of = node.value.id if isinstance(node.value, ast.Name) else getattr(node.value, "attr", "")
        return node.attr in SENTENCES or (node.attr in {"text", "message"} and of in TOLD_BY)
    if isinstance(node, ast.Call) and node.args:
        return isinstance(node.func, ast.Name) and node.func.id == "str" and sentence(node.args[0])
    return False


def words(node: ast.AST) -> bool:
    """Say whether an expression is part of a sentence: a literal of more than one word, or a constant."""
    if isinstance(node, ast.Name):
        return node.id.isupper()
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value


def readings(nodes: Iterable[ast.AST]) -> list[str]:
    """Return where a module reads sentences."""
    found = []
    for node in nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            if node.func.attr in READERS and sentence(node.func.value):
                found.append(ast.unparse(node))
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            if any(sentence(side) for side in sides) and any(words(side) for side in sides):
                found.append(ast.unparse(node))
    return found


def refusals(nodes: Iterable[ast.AST]) -> list[str]:
    """Return which refusals of a module have no code."""
    found = []
    for node in nodes:
        if not isinstance(node, ast.Call):
            continue
        fields = {keyword.arg: keyword.value for keyword in node.keywords}
        accepted = fields.get("accepted")
        if isinstance(accepted, ast.Constant) and accepted.value is False and "code" not in fields:
            found.append(ast.unparse(node))
        refuses = (
            isinstance(node.func, ast.Attribute) and node.func.attr == "refuse" and "call" in ast.unparse(node.func)
        )
        if refuses and len(node.args) == 1 and isinstance(node.args[0], ast.Constant | ast.JoinedStr | ast.Call):
            found.append(ast.unparse(node))
    return found


def faults(source: str) -> list[str]:
    """Return where a source reads sentences or refuses without a code."""
    nodes = [*ast.walk(ast.parse(source))] if SUSPECT.search(source) else []
    return [*readings(nodes), *refusals(nodes)]


def test_every_code_has_a_meaning_and_every_meaning_a_code():
    assert tuple(MEANINGS) == get_args(Code)
    assert all(len(text) > 10 and not text.endswith(".") for text in MEANINGS.values())


def test_nothing_reads_a_sentence_and_every_refusal_has_a_code():
    assert {path: found for path in MODULES if (found := faults((LBR / path).read_text()))} == {}


@pytest.mark.parametrize(
    "source",
    [
        "final = result.reason.startswith(FINAL)",
        "dead = str(answer.reason).startswith('lease is dead')",
        "how = 'stopped' if lost.reason.startswith('stopped by') else 'fault'",
        "quiet = BUT not in ended.why",
        "if CHANGED in reason: pass",
        "why = reason.removeprefix(DEAD_LEASE)",
        "but = result.reason.partition(BUT)",
        "news = not event.text.startswith(own)",
        "if reply.reason == 'a stop came': pass",
        "call.refuse('not now')",
        "call.refuse(f'{name}?')",
        "CommandReply(accepted=False, reason='no')",
    ],
)
def test_the_check_sees_sentences_being_read_and_refusals_without_a_code(source):
    assert len(faults(source)) == 1


def test_older_and_newer_robots_are_understood():
    older = msgspec.json.decode(b'{"accepted": false, "reason": "held by console"}', type=CommandReply)
    assert (older.code, older.why.code, older.why.text) == ("", "failed", "held by console")
    newer = b'{"goal": "g", "result": "fault", "reason": "x", "elapsed_s": 1, "code": "moonstruck"}'
    assert msgspec.json.decode(newer, type=GoalResult).code == "moonstruck"
    assert heard("moonstruck", "x").code == "failed"
