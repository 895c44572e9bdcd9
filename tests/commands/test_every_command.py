"""Every `lbr` command, whatever is typed: a result or one sentence, the exit code that is promised, and never a traceback.

They run in this process, as `lbr` runs them, unless their standard streams matter.
"""

import errno
import json
import os
from contextlib import closing
from pathlib import Path

import click
import pytest

from lbr import cli
from lbr.executive.processes import scheduling
from tests.support import databases, programs
from tests.support.robot import LBR, environment
from tests.support.waiting import HANG_S

RUBBISH = [
    "\udc80\udcff",
    "",
    " ",
    "-1",
    "1e999",
    "NaN",
    "💥",
    "../../etc/passwd",
    "a" * 5000,
    "\x1b[31mred",
    "/dev/null",
    "%s%n",
]


def leaves(group: click.Group, *path: str) -> dict[tuple[str, ...], click.Command]:
    ctx, found = click.Context(group), {}
    for name in group.list_commands(ctx):
        command = group.get_command(ctx, name)
        assert command is not None
        found |= leaves(command, *path, name) if isinstance(command, click.Group) else {(*path, name): command}
    return found


COMMANDS = leaves(cli.cli)
GROUPS = sorted({path[:-1] for path in COMMANDS if len(path) > 1})
NEED_A_ROBOT = {
    ("console",): (), ("send",): ("status",), ("status",): (), ("stop",): (), ("topic", "list"): (), ("view",): (),
    ("topic", "echo"): ("drive/state",), ("topic", "hz"): ("drive/state",), ("topic", "info"): ("drive/state",),
    ("topic", "pub"): ("drive/state", "{}"),
}  # fmt: skip
"""The commands that talk to a robot, with arguments that are good."""
SETTLE = {("run",), ("agent",), ("mcp",), ("service", "install"), ("service", "remove"), ("doctor",)}
"""What starts a robot, serves its input, writes into the system or looks at this machine: rubbish goes only into what they
read first."""


def named(path: tuple[str, ...]) -> str:
    return "-".join(path)


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    place = tmp_path / "home"
    place.mkdir(mode=0o700)
    (tmp_path / "here").mkdir()
    monkeypatch.setenv("LBR_HOME", str(place))
    monkeypatch.setattr(scheduling, "rank", lambda *_values: None)  # of the process of the tests
    monkeypatch.chdir(tmp_path / "here")
    return place


@pytest.fixture
def lbr(capfd):
    """Run a command here; whatever it does but answer is an error of the test."""

    def run(*arguments: str) -> tuple[int, str, str]:
        code = cli.main(list(arguments))
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        assert all(line.startswith(("lbr: ", "note: ")) for line in err.splitlines()), err
        return code, out, err

    return run


def needed(command: click.Command, path: tuple[str, ...], filler: str = "x") -> list[str]:
    """Return arguments that are there, whatever they are worth."""
    options = [p for p in command.params if isinstance(p, click.Option) and p.required]
    arguments = [p for p in command.params if isinstance(p, click.Argument) and p.required]
    good = NEED_A_ROBOT.get(path, ())
    return [*good, *(filler for _ in arguments[len(good) :]), *(part for p in options for part in (p.opts[0], filler))]


@pytest.mark.parametrize("flag", ["--help", "-h"])
@pytest.mark.parametrize("path", [*COMMANDS, *GROUPS], ids=named)
def test_help_says_how_and_does_nothing(lbr, home, path, flag):
    code, out, err = lbr(*path, flag)
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: lbr {' '.join(path)} ")
    assert all(len(line) <= 120 for line in out.splitlines())
    assert list(home.iterdir()) == []


@pytest.mark.parametrize("path", COMMANDS, ids=named)
def test_every_option_and_every_command_says_what_it_is_for(path):
    command = COMMANDS[path]
    assert command.help
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, f"{' '.join(path)} {parameter.opts[0]} has no help"


@pytest.mark.parametrize("path", [p for p in COMMANDS if p != ("send",)], ids=named)
def test_an_option_that_there_is_not_is_named_with_where_help_is(lbr, home, path):
    code, out, err = lbr(*path, *needed(COMMANDS[path], path), "--no-such-thing")
    assert (code, out) == (2, "")
    assert "--no-such-thing" in err
    assert f"lbr {' '.join(path)} --help" in err
    assert list(home.iterdir()) == []


@pytest.mark.parametrize("path", [p for p in COMMANDS if p != ("send",)], ids=named)
def test_an_argument_too_many_is_told_and_nothing_is_done(lbr, home, path):
    code, out, err = lbr(*path, *["one", "two", "three", "four"][: len(COMMANDS[path].params) + 1], "--", "five", "six")
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert list(home.iterdir()) == []


@pytest.mark.parametrize("path", [p for p, c in COMMANDS.items() if any(a.required for a in c.params)], ids=named)
def test_what_is_missing_is_named(lbr, path):
    code, out, err = lbr(*path)
    assert (code, out) == (2, "")
    first = next(p for p in COMMANDS[path].params if p.required)
    assert (first.human_readable_name if isinstance(first, click.Argument) else first.opts[0]) in err


@pytest.mark.parametrize("group", [(), *GROUPS], ids=named)
def test_a_word_that_is_no_command_is_told_with_where_help_is(lbr, group):
    code, out, err = lbr(*group, "nonsense")
    assert (code, out) == (2, "")
    assert "nonsense" in err
    assert "--help" in err


@pytest.mark.parametrize("path", NEED_A_ROBOT, ids=named)
def test_where_no_robot_runs_it_is_said_with_what_starts_one(lbr, path):
    code, out, err = lbr(*path, *NEED_A_ROBOT[path])
    assert (code, out) == (1, "")
    assert "lbr run" in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    "path", [p for p in NEED_A_ROBOT if "as_json" in {q.name for q in COMMANDS[p].params}], ids=named
)
def test_a_program_that_asks_for_json_gets_nothing_else_when_no_robot_runs(lbr, path):
    code, out, _ = lbr(*path, *NEED_A_ROBOT[path], "--json")
    assert code == 1
    assert out == "" or json.loads(out)


@pytest.mark.parametrize("path", NEED_A_ROBOT, ids=named)
@pytest.mark.parametrize("name", ["Capital", "a b", "", "../x", "*", "@tools", "a" * 300])
def test_a_name_that_no_robot_has_finds_none(lbr, path, name):
    code, out, err = lbr(*path, *NEED_A_ROBOT[path], "--robot", name)
    assert code in {1, 2}
    assert out == ""
    assert err


@pytest.mark.parametrize("endpoint", ["nonsense", "\x1b[31mred", "tcp/", "quic/:", "udp/127.0.0.1", ""])
def test_an_endpoint_that_is_none_is_told_in_a_sentence(lbr, endpoint):
    code, out, err = lbr("status", "--connect", endpoint)
    assert code in {1, 2}
    assert out == ""
    assert err
    assert "\x1b" not in err


@pytest.mark.parametrize("path", [p for p in COMMANDS if p not in SETTLE], ids=named)
def test_rubbish_for_every_argument_is_refused_or_not_found_in_a_sentence(lbr, path):
    for rubbish in RUBBISH if "x" in needed(COMMANDS[path], path) else ():
        code, _, err = lbr(*path, *(rubbish if one == "x" else one for one in needed(COMMANDS[path], path)))
        assert code in {0, 1, 2}, rubbish
        assert code == 0 or err, rubbish
        assert "\x1b" not in err


@pytest.mark.parametrize(
    ("path", "option"),
    [
        (path, parameter.opts[0])
        for path, command in COMMANDS.items()
        for parameter in command.params
        if path not in SETTLE
        and isinstance(parameter, click.Option)
        and not parameter.is_flag
        and parameter.name != "connect"
    ],
    ids=lambda part: named(part) if isinstance(part, tuple) else part,
)
def test_rubbish_for_every_option_is_refused_or_not_found_in_a_sentence(lbr, path, option):
    for rubbish in RUBBISH:
        code, _, err = lbr(*path, *needed(COMMANDS[path], path), option, rubbish)
        assert code in {0, 1, 2}, rubbish
        assert code == 0 or err, rubbish
        assert "\x1b" not in err


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("run", "no-such-profile", "--no-console"), "no-such-profile"),
        (("run", "../../etc/passwd", "--no-console"), "passwd"),
        (("run", "--listen", "nonsense", "--no-console"), "listen"),
        (("run", "--db", "/nowhere/at/all.db", "--no-console"), "/nowhere/at"),
        (("service", "show", "no-such-profile"), "no-such-profile"),
        (("service", "install", "--motor-relay", "nonsense", "--dry-run"), "nonsense"),
        (("topic", "pub", "drive/state", "{", "--count", "0"), "count"),
        (("topic", "hz", "drive/state", "--seconds", "-1"), "seconds"),
        (("send", "status", "--hold", "NaN"), "NaN"),
        (("console", "--hold", "nan"), "not a number from 0 to 30"),
        (("topic", "hz", "drive/state", "--seconds", "NAN"), "not a number from 0.1 to 3600"),
        (("topic", "pub", "drive/state", "{}", "--rate", "NaN"), "not a number from 0.01 to 1000"),
        (("db", "audit", "-n", "-5"), "-n"),
        (("token", "add", "ann", "--role", "king"), "king"),
        (("token", "add", "ann", "--expires", "yesterday"), "yesterday"),
    ],
)
def test_what_cannot_be_meant_is_named(lbr, arguments, why):
    code, _, err = lbr(*arguments)
    assert code in {1, 2}
    assert why in err


# -- what others read -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ("robots",), ("doctor",), ("token", "list"), ("motion", "list"), ("db", "check"), ("db", "diff"), ("db", "audit"),
        ("db", "restore", "--list"), ("graph", "--db", "{db}"),
    ],
    ids=named,
)  # fmt: skip
def test_json_is_one_document_and_nothing_else(lbr, home, arguments):
    databases.fresh(home / "robot.db")
    code, out, _ = lbr(*(one.format(db=home / "robot.db") for one in arguments), "--json")
    assert code in {0, 1, 2}
    assert json.loads(out) is not None


@pytest.mark.parametrize(
    "arguments", [("db", "check"), ("db", "diff"), ("token", "list"), ("motion", "list"), ("db", "audit")], ids=named
)
def test_a_database_that_is_none_is_named_and_left_as_it_is(lbr, home, arguments):
    bad = home / "robot.db"
    bad.write_bytes(b"SQLite format 3\0" + bytes(range(256)) * 20)
    bad.chmod(0o600)
    before = bad.read_bytes()
    code, _, err = lbr(*arguments)
    assert code in {1, 2}
    assert str(bad) in err
    assert bad.read_bytes() == before


@pytest.mark.parametrize(
    "arguments", [("db", "check"), ("token", "list"), ("motion", "list"), ("db", "diff")], ids=named
)
def test_a_database_that_is_not_there_is_told_with_what_makes_one(lbr, home, arguments):
    code, out, err = lbr(*arguments)
    assert code in {1, 2}
    assert out == ""
    assert "lbr run" in err or "lbr db init" in err
    assert not (home / "robot.db").exists()


@pytest.mark.parametrize("kind", ["robot", "driver", "capability"])
@pytest.mark.parametrize("name", ["9lives", "With Space", "", "lbr", "class", "a" * 60, "../up", "-x"])
def test_a_name_that_a_package_cannot_have_writes_nothing(lbr, tmp_path, kind, name):
    code, _, err = lbr("new", kind, "--", name)
    assert code in {1, 2}
    assert err
    assert list((tmp_path / "here").iterdir()) == []
    assert not (tmp_path / "up").exists()


# -- streams that are closed, full or gone ----------------------------------------------------------------------------

LISTING = [("--help",), ("robots", "--json"), ("status",), ("nonsense",)]


def run_with(home: Path, streams: str, *arguments: str) -> tuple[int, str]:
    """Run a command in a shell, with its streams as the shell redirects them; return its code and what it complained."""
    line = f'"$@" {streams}'
    done = programs.run(
        ["/bin/sh", "-c", line, "sh", *LBR, *arguments],
        env=environment(home),
        capture_output=True,
        text=True,
        timeout=HANG_S,
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("streams", [">&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full"])
@pytest.mark.parametrize("arguments", LISTING, ids=named)
def test_streams_that_are_closed_or_full_are_an_exit_code_and_no_traceback(home, arguments, streams):
    code, told = run_with(home, streams, *arguments)
    assert code in {0, 1, 2}
    assert "Traceback" not in told
    assert "Exception ignored" not in told
    if streams == ">/dev/full" and arguments not in {("status",), ("nonsense",)}:
        assert (code, "cannot be written" in told) == (1, True)


@pytest.mark.parametrize("arguments", [("--help",), ("robots",), ("db", "check", "--json")], ids=named)
def test_a_reader_that_is_gone_ends_it_quietly(home, arguments):
    databases.fresh(home / "robot.db")
    reading, writing = os.pipe()
    os.close(reading)
    with closing(os.fdopen(writing, "wb")) as gone:
        done = programs.run([*LBR, *arguments], env=environment(home), stdout=gone, stderr=-1, timeout=HANG_S)
    assert done.returncode in {0, 1}
    assert b"Traceback" not in done.stderr


# -- what was found so ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [("run", "{file}", "--no-console"), ("db", "init", "--sql", "{file}")], ids=named)
@pytest.mark.parametrize("content", [b"robot = '\xbf\xff'", b"SELECT 1;\0"])
def test_a_file_of_bytes_that_are_no_text_is_named(lbr, tmp_path, arguments, content):
    file = tmp_path / "robot-sim.toml"
    file.write_bytes(content)
    code, _, err = lbr(*(one.format(file=file) for one in arguments))
    assert code == 2
    assert str(file) in err


def test_a_launch_profile_without_an_end_of_brackets_is_told(lbr, tmp_path):
    file = tmp_path / "deep.toml"
    file.write_text(f"robot = {'[' * 5000}")
    code, _, err = lbr("run", str(file), "--no-console")
    assert code == 2
    assert f"launch profile {file}" in err


@pytest.mark.parametrize("host", ["192.168..5", ".a", f"{'a' * 80}.b", "\udcff"])
def test_a_name_that_no_machine_can_have_is_told_as_that(lbr, host, wording):
    code, _, err = lbr("send", "help", "--connect", f"tls/{host}:7447")
    assert code == 2
    wording(err)


def test_a_message_of_bytes_that_are_no_text_is_told(lbr):
    code, _, err = lbr("topic", "pub", "drive/command", '{"power": "\udcff"}')
    assert code == 2
    assert "the message is not JSON" in err


def test_a_database_whose_name_leaves_no_room_for_one_beside_it_is_told(lbr, tmp_path):
    code, _, err = lbr("db", "init", "--db", str(tmp_path / ("a" * 250)))
    assert code in {1, 2}
    assert "too long" in err


def test_what_was_typed_moves_no_cursor_when_it_is_repeated(lbr):
    _, _, err = lbr("new", "robot", "\x1b[2J\x07\tname")
    assert "'?[2J? name'" in err or "'?[2J?" in err
    assert err.isascii()
    assert all(c.isprintable() or c == "\n" for c in err)


def test_a_recording_that_cannot_be_deleted_is_not_called_written(capfd, home, monkeypatch, wording):
    place = home / "recordings" / "lbr"
    place.mkdir(parents=True)
    (place / "walk.mcap").write_bytes(b"x")
    monkeypatch.setattr(Path, "unlink", refuse)
    assert cli.main(["box", "delete", "walk"]) == 1
    out, err = capfd.readouterr()
    assert out == ""
    wording(err)


def refuse(_path: Path, missing_ok: bool = False) -> None:
    raise OSError(errno.EROFS, "Read-only file system")
