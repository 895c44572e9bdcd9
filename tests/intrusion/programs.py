"""A12: words that mean something to a shell, in rows and at the console, and options and files that no row allows."""

import json
import sqlite3
from pathlib import Path
from typing import Any

from tests.support.bench import bench
from tests.support.figures import Results
from tests.support.robot import Robot

WORDS = (
    "; touch {mark}", "| touch {mark}", "|| touch {mark}", "&& touch {mark}", "& touch {mark}", "$(touch {mark})",
    "`touch {mark}`", "> {mark}", ">> {mark}", "< /dev/null > {mark}", "${{IFS}}touch${{IFS}}{mark}", "%0atouch {mark}",
    "\\; touch {mark}", "'; touch {mark}; '", '"; touch {mark}; "', "$((1+1))", "*", "~", "$HOME", "{{1,2}}", "!!", "#",
    "--help; touch {mark}", "-e $(touch {mark})", "\u037e touch {mark}", "{mark}\\", "a=$(touch {mark})", "@(touch {mark})",
)  # fmt: skip
SMUGGLED = (
    "-f {key}", "--file={key}", "-f{key}", "'-f' '{key}'", "-u", "+%s", "''", "'' -f {key}", "{key}", "--", "-- -f {key}",
    "--help", "--version", "left -f {key}", "'left -f {key}'", "'left\\' -f {key}", "@{key}", "left --set=@0", "=-f{key}",
)  # fmt: skip
"""What makes a program read or do what its row does not say: typed after `clock`, `docksignal`, `navcam`, `autodock`."""
BAD_INPUT = 2
SHELL_ONLY = ("; touch {mark}", "/bin/sh; touch {mark}", "$(touch {mark})", "`touch {mark}`", "| touch {mark}")


def programs(results: Results, words: tuple[str, ...] = WORDS) -> None:
    """Say them after a program's name, and write them into its row: each is a word, or no program at all."""
    _smuggled(results)
    edits = (
        "UPDATE external_command SET argv = '[\"/bin/echo\"]'",
        "UPDATE external_command SET arguments = '[\".*\"]' WHERE name = 'clock'",
    )
    with bench(results, edits=edits) as under_test:
        robot, mark = under_test.robot, under_test.robot.home / "canary"
        said_words = [word.format(mark=mark) for word in words]
        for word in said_words:
            quoted = "'" + word.replace("'", "'\"'\"'") + "'"
            said = robot.line(f"clock {quoted}")
            taken = _literal(said["text"], word) if not word.startswith("-") else _refused(said, f"clock {quoted}")
            results.check("A12", _marked(mark, f"clock {quoted}") + taken)
            results.check("A12", _marked(mark, f"clock {word}") if robot.line(f"clock {word}") else [])
        said = _in_row(robot, ["/bin/echo", *said_words])
        results.check(
            "A12", _marked(mark, "words in a row") + [text for word in said_words for text in _literal(said, word)]
        )
        for argv in SHELL_ONLY:
            _in_row(robot, [argv.format(mark=mark)])
            results.check("A12", _marked(mark, f"program {argv}"))


def _smuggled(results: Results) -> None:
    """Say to the shipped programs what would have them read the key of the tokens, or open a door."""
    with bench(results) as under_test:
        robot = under_test.robot
        key = robot.home / "credentials" / "token.key"
        key.parent.mkdir(exist_ok=True)
        key.write_text("the-key-of-all-tokens\n")
        for program in ("clock", "docksignal", "navcam", "autodock"):
            for words in SMUGGLED:
                line = f"{program} {words.format(key=key)}"
                said = robot.line(line)
                leaked = [f"{line}: the key was told"] if "the-key-of" in json.dumps(said) else []
                results.check("A12", leaked + _refused(said, line))
        for line in ("navcam --host 0.0.0.0", "navcam 0.0.0.0", "navcam --port 80", "autodock --tries 9999"):
            results.check("A12", _refused(robot.line(line), line))


def _refused(said: dict[str, Any], line: str) -> list[str]:
    good = said["code"] == BAD_INPUT and " takes " in said["text"]
    return [] if good else [f"{line}: it was not refused: {said['text'][:80]!r}"]


def _in_row(robot: Robot, argv: list[str]) -> str:
    """Put a program into its row, wait until the robot knows, and start it."""
    with sqlite3.connect(robot.home / "robot.db", timeout=5.0) as database:
        database.execute("UPDATE external_command SET argv = ?, help = ?", (json.dumps(argv), repr(argv)[:60]))
    database.close()
    for _ in range(400):
        if any(entry.get("help") == repr(argv)[:60] for entry in robot.line("help")["data"]):
            break
    return str(robot.line("clock")["text"])


def _literal(said: str, word: str) -> list[str]:
    return [] if word in said else [f"{word!r} became {said!r}"]


def _marked(mark: Path, what: str) -> list[str]:
    found = mark.exists()
    mark.unlink(missing_ok=True)
    return [f"{what}: a shell minded it"] if found else []
