"""Every event of the executive says why by a code, or is of a kind that tells no why."""

import ast
from pathlib import Path

import pytest

import lbr.executive
from lbr.executive.processes.restart import CODES as END_CODES
from lbr.executive.processes.restart import End
from lbr.executive.service.journal import AUDITED, CODES
from lbr.messages.codes import MEANINGS

TELLERS = {"_happened", "happened", "_process_happened", "_note", "note"}
NO_WHY = {kind for kind, code in CODES.items() if not code}
SOURCES = sorted(Path(lbr.executive.__file__).parent.rglob("*.py"))


def kinds(source: str) -> set[str]:
    """Return the kinds of events that a source tells without a code of their own."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Tuple | ast.Call):
            call = isinstance(node, ast.Call)
            name = getattr(node.func, "attr", getattr(node.func, "id", "")) if call else ""
            told = node.args if call and name in TELLERS else node.elts if not call and len(node.elts) == 4 else ()
            if told and isinstance(told[0], ast.Constant) and isinstance(told[0].value, str) and len(told) < 5:
                found |= (
                    {told[0].value} if call or getattr(told[-1], "value", "") in {"info", "warning", "error"} else set()
                )
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.stem)
def test_each_kind_that_the_executive_tells_has_its_code_or_none_by_decision(path):
    unknown = kinds(path.read_text()) - CODES.keys()
    assert not unknown, f"{path.name} tells {sorted(unknown)}: say why, by a code in journal.CODES or at the call"


def test_the_check_sees_a_kind_without_a_code():
    assert kinds('self._happened("fire", "executive", "it burns", "error")') == {"fire"}
    assert kinds('self._news.append(("fire", "executive", text, "error"))') == {"fire"}
    assert kinds('self._happened("fire", "executive", "it burns", "error", "failed")') == set()


def test_all_codes_are_on_the_list_and_what_is_bad_news_has_one():
    assert {code for code in CODES.values() if code} <= MEANINGS.keys()
    assert set(END_CODES) == set(End)
    assert not NO_WHY & {"rows_refused", "trouble", "host_lost", "estop", "shutdown", "learnt_lost"}
    assert {"estop", "estop_reset", "rows_refused", "shutdown"} <= AUDITED & CODES.keys()
