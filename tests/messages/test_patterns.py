"""Texts of a form: what is of it is so to its last character, in messages, settings, rows and the program's own checks."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from lbr.apps.web.api.page_message import Rubbish, parse
from lbr.apps.web.pairing import PairBody
from lbr.messages.pairing import Digits
from lbr.messages.units import NAME_OR_NONE_PATTERN, NAME_PATTERN, Name, NameOrNone

LBR = Path(__file__).parents[2] / "lbr"
END = re.compile(r"\$(?!\(\?!\\n\))(?=\||\)|\Z)")
"""An end of a text that lets a line's end follow."""
CALLED = ("Meta", "compile", "match", "search")
"""What is called with a pattern; most calls are not worth another look."""


def texts(node: ast.AST) -> Iterator[str]:
    """Yield the texts that an expression is written with."""
    for one in ast.walk(node):
        if isinstance(one, ast.Constant):
            value = one.value
            if isinstance(value, str | bytes):
                yield value if isinstance(value, str) else value.decode("latin-1")


def patterns(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the patterns that types declare and that `re` is given, without those that go by lines."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        if not getattr(node.func, "attr", getattr(node.func, "id", "")).endswith(CALLED):
            continue
        name = ast.unparse(node.func)
        if name.endswith("Meta"):
            found = [word.value for word in node.keywords if word.arg == "pattern"]
        elif name in {"re.compile", "re.match", "re.search"} and "MULTILINE" not in ast.unparse(node):
            found = node.args[:1]
        else:
            continue
        yield from ((node.lineno, text) for value in found for text in texts(value))


def test_no_pattern_lets_a_lines_end_follow_what_it_fits() -> None:
    """No pattern lets a line's end follow what it fits"""
    found = {
        f"{path.relative_to(LBR)}:{line}: {text}"
        for path in LBR.rglob("*.py")
        if "$" in (source := path.read_text(encoding="utf-8"))
        for line, text in patterns(ast.parse(source))
        if END.search(text)
    }
    assert not found
    assert not END.search(NAME_PATTERN + NAME_OR_NONE_PATTERN)


@pytest.mark.parametrize(
    ("kind", "text"), [(Name, "drive"), (NameOrNone, ""), (NameOrNone, "drive"), (Digits, "123456")]
)
def test_what_is_read_is_of_its_form_to_the_last_character(kind: type[str], text: str) -> None:
    """What is read is of its form to the last character"""
    assert msgspec.convert(text, kind) == text
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(text + "\n", kind)


def test_a_page_names_a_command_and_a_phone_a_code_without_a_lines_end() -> None:
    """A page names a command and a phone a code without a line's end"""
    assert parse(b'{"hold": {"to": "drive/command", "n": 1}}').hold is not msgspec.UNSET
    with pytest.raises(Rubbish):
        parse(b'{"hold": {"to": "drive/command\\n", "n": 1}}')
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(b'{"code": "123456\\n", "name": "phone"}', type=PairBody)
