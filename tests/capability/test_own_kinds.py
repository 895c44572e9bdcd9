"""A file of the user's own is tried elsewhere: what it does at its import is one sentence with its line, and harms nothing."""

import os
import signal
import sys
import threading
from pathlib import Path

import msgspec
import pytest

from lbr.capability import registry, user_kinds
from lbr.capability.faults import faults
from lbr.capability.kind import KindError
from tests.support.waiting import until

HEAD = """
from msgspec import Struct
from lbr.capability import Capability, Command, Kind, OnDevice, Rights, Row, Rows
class Settings(Struct, frozen=True, forbid_unknown_fields=True):
    device: str = ""
class Go(Struct, frozen=True):
    pass
class Loose(Struct, frozen=True):
    a: int = 0
class Soft(Struct):
    a: int = 0
class Thing:
    pass
class Odd(Struct, frozen=True):
    thing: Thing
class Untold(Row, frozen=True, kw_only=True):
    a: int
class Keyless(Row, frozen=True, kw_only=True):
    TABLE = "keyless"
    KEY = ("gone",)
    a: int
class Told(Row, frozen=True, kw_only=True):
    TABLE = "told"
    KEY = ("a",)
    a: int
"""
GOOD = {"name": "'own'", "summary": "''", "family": "'app'", "entry": "Capability"}
KIND_LINE = HEAD.count("\n") + 1


def declared(**fields: str) -> str:
    return HEAD + "KIND = Kind(" + ", ".join(f"{name}={value}" for name, value in (GOOD | fields).items()) + ")\n"


@pytest.fixture
def folder(tmp_path):
    made = registry.user_directory(tmp_path)
    made.mkdir(mode=0o700)
    return made


def why(folder, text: str, *, trial: bool = True) -> str:
    (folder / "own.py").write_text(text)
    with pytest.raises(KindError) as caught:
        registry.find("own", folder.parent, trial=trial)
    said = str(caught.value)
    assert said.startswith(str(folder / "own.py"))
    assert said.isprintable()
    assert len(said) < 1200
    return said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "\nimport nothing_like_this",
            "line 2 does not load: ModuleNotFoundError: No module named 'nothing_like_this'",
        ),
        ("x = 1\ndef (:", "line 2 does not load: SyntaxError: invalid syntax"),
        ("raise SystemExit(3)", "line 1 does not load: SystemExit: 3"),
        ("\nexit()", "line 2 does not load: SystemExit"),
        ("\n\nraise KeyboardInterrupt", "line 3 does not load: KeyboardInterrupt"),
        ("raise GeneratorExit", "line 1 does not load: GeneratorExit"),
        ("input()", "line 1 does not load: EOFError"),
        ("import os\nos._exit(0)", "with exit code 0"),
        ("import os\nos.kill(os.getpid(), 9)", "by signal 9"),
        ("raise ValueError('a\\nb\\x1b[31m')", "line 1 does not load: ValueError: a b?[31m"),
        ("class E(Exception):\n    def __str__(self): raise self\nraise E", "line 3 does not load: E"),
        ("def f(): f()\nf()", "line 1 does not load: RecursionError"),
        ("\n\nKIND = 3", "line 3 declares no KIND"),
        ("", "declares no KIND"),
        ("\ufeff\x00", "does not load: "),
        (declared(name="'other'"), f"line {KIND_LINE}: kind 'own' calls itself 'other'"),
        (declared(input="{}"), f"line {KIND_LINE} does not load: TypeError: Kind.__init__() got an unexpected"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_sentence_with_its_line(folder, text, words):
    assert words in why(folder, text)


def test_a_ctrl_c_while_a_file_is_imported_is_no_fault_of_the_file(folder):
    (folder / "own.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\n")
    before = sys.modules.get("lbr_user_capabilities.own")
    with pytest.raises(KeyboardInterrupt):
        registry.find("own", folder.parent, trial=False)
    assert sys.modules.get("lbr_user_capabilities.own") is before


@pytest.mark.parametrize(
    "fields",
    [
        {"summary": "3"},
        {"moves": "'yes'"},
        {"family": "'gadget'"},
        {"family": "'program'"},
        {"entry": "3"},
        {"entry": "Go"},
        {"entry": "'Go'"},
        {"settings": "dict"},
        {"settings": "Loose"},
        {"settings": "Soft"},
        {"inputs": "[Go]"},
        {"inputs": "{'Big': Go}"},
        {"outputs": "{'said': str}"},
        {"commands": "{'go': Soft}"},
        {"outputs": "{'said': Odd}"},
        {"replies": "{'go': Go}"},
        {"commands": "{'go': Command(Go, role='king')}"},
        {"device": "OnDevice('servo')"},
        {"device": "'servo'"},
        {"rows": "'gone'"},
        {"rows": "('gone',)"},
        {"rows": "(Untold,)"},
        {"rows": "(Keyless,)"},
        {"rows": "(Rows(Told, where={'gone': 'device'}),)"},
        {"rows": "(Rows(Told, where={'a': 'device'}),)"},
        {"commands": "{'go': Command(Soft, leased=True)}"},
        {"needs": "'numpy'"},
        {"rights": "Rights(edits=(Keyless,))"},
    ],
)
def test_a_kind_that_is_not_whole_is_told_at_the_line_of_KIND(folder, fields, wording):  # noqa: N802
    said = why(folder, declared(**fields), trial=False)  # which says the same, as the test below has it
    assert said.startswith(f"{folder / 'own.py'}, line {KIND_LINE}: ")
    wording(said)


def test_all_that_is_wrong_with_a_kind_is_told_at_once_and_a_trial_says_the_same(folder):
    text = declared(family="'gadget'", settings="Loose", outputs="{'a': int, 'b': str}")
    said = why(folder, text)
    assert why(folder, text, trial=False) == said
    assert [word in said for word in ("'family'", "'settings'", "'a' in 'outputs'", "'b' in 'outputs'")] == [True] * 4


def test_a_file_that_hangs_is_ended_and_named_with_its_line(folder, monkeypatch):
    monkeypatch.setattr(user_kinds, "LIMIT_S", 0.5)
    said = "own.py, line 3 is not imported within 0.5 s: import what is slow in `open`"
    until(lambda: said in why(folder, "import time\ndef wait():\n    time.sleep(1000)\nwait()\n"), what=said)


def test_a_file_that_holds_the_interpreter_is_ended_too(folder, monkeypatch):
    monkeypatch.setattr(user_kinds, "LIMIT_S", 0.5)
    text = "import re; re.match('(a+)+$', 'a' * 60 + 'b')"
    until(lambda: "line 1 is not imported within" in why(folder, text), what="it is ended at that line")


def test_what_a_file_starts_at_its_trial_ends_with_it(folder):
    place = folder / "pid"
    text = "import time\nfrom os import fork\npid = fork()\nif not pid: time.sleep(600)\n"
    why(folder, f"{text}open({str(place)!r}, 'w').write(str(pid))\nraise ValueError")
    stat = Path("/proc") / place.read_text() / "stat"
    until(lambda: not stat.exists() or stat.read_text().split(") ")[1][0] == "Z")


def test_what_a_file_prints_is_no_output_of_who_reads_it(folder, capfd):
    (folder / "own.py").write_text("print('hello')\n" + declared())
    assert registry.find("own", folder.parent).name == "own"
    print("after")
    assert capfd.readouterr() == ("after\n", "hello\n")


def test_a_file_cannot_take_the_signals_of_who_reads_it(folder):
    before = signal.getsignal(signal.SIGTERM)
    text = "import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
    assert "line 2 does not load: ValueError" in why(folder, text + declared())
    assert signal.getsignal(signal.SIGTERM) is before


def test_an_edit_of_the_same_size_within_a_second_is_read_and_no_compiled_copy_is(folder):
    for word in ("one", "two"):
        (folder / "own.py").write_text(declared(summary=f"'{word}'"))
        os.utime(
            folder / "own.py", ns=(1_700_000_000_000_000_000 + len(word), 1_700_000_000_000_000_000 + ord(word[0]))
        )
        assert registry.find("own", folder.parent).summary == word
    assert list(folder.iterdir()) == [folder / "own.py"]


def test_the_text_that_was_accepted_is_what_a_process_imports_whatever_the_file_holds_now(folder):
    (folder / "own.py").write_text(declared(summary="'accepted'"))
    registry.find("own", folder.parent)
    text = registry.source("own")
    (folder / "own.py").write_text("raise ValueError")
    with pytest.raises(KindError):
        registry.find("own", folder.parent)
    assert registry.source("own") == text
    assert registry.accepted("own", folder.parent, text).summary == "accepted"
    assert registry.source("drive") == ""


def test_a_file_that_breaks_leaves_the_types_of_what_runs_where_they_are_looked_up(folder):
    (folder / "own.py").write_text(
        "from __future__ import annotations\n"
        + declared(commands="{'go': Odd2}").replace(
            "class Go(", "Word = int\nclass Odd2(Struct, frozen=True):\n    a: Word = 0\nclass Go("
        )
    )
    kind = registry.find("own", folder.parent)
    own_module = sys.modules["lbr_user_capabilities.own"]
    why(folder, "raise ValueError")
    assert sys.modules["lbr_user_capabilities.own"] is own_module
    assert msgspec.json.decode(b'{"a": 3}', type=kind.commands["go"]).a == 3


def test_the_kinds_that_come_with_lbr_are_whole(tmp_path):
    found = {name: faults(registry.find(name, tmp_path)) for name in registry.names(tmp_path)}
    assert {name: told for name, told in found.items() if told} == {}


def test_no_thread_of_a_good_file_is_left(folder):
    (folder / "own.py").write_text(declared())
    before = threading.active_count()
    registry.find("own", folder.parent)
    assert threading.active_count() == before
