"""Coming in with a token by our own tools: what works, and the one sentence that says why something does not."""

import json
import os
import pty
import select
import socket
import stat
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from lbr import cli, client
from lbr.bus import certificates
from tests.support import programs
from tests.support.door import Door, opened
from tests.support.robot import LBR
from tests.support.waiting import HANG_S, until


def said(done: "subprocess.CompletedProcess[str]") -> str:
    """The one line of a refusal."""
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1, done.stderr
    return done.stderr


@pytest.fixture
def here(door: Door, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Run `lbr` in this process, as if on another machine; `Door.lbr` is a program of its own."""
    monkeypatch.setenv("LBR_HOME", str(door.away))

    def run(*arguments: str, token: str, endpoint: str = door.endpoint) -> "subprocess.CompletedProcess[str]":
        monkeypatch.setenv("LBR_TOKEN", token)
        code = cli.main([*arguments, "--connect", endpoint])
        return subprocess.CompletedProcess(arguments, code, *capsys.readouterr())

    return run


def connected(door: Door, token_file: Path | str) -> client.Robot:
    """Connect; on a busy machine a link may be lost before the robot has answered."""

    def connects() -> client.Robot | None:
        with suppress(client.BusError):
            return client.connect(at=door.endpoint, token_file=token_file)
        return None

    return until(connects)


def test_an_operator_drives_and_a_console_stops_when_its_input_ends(door: Door):
    assert door.drive("phone", "/r/0.1/90", hold_s=0.4)["text"] == "accepted"
    until(lambda: door.by("phone", "console", stdin="/r/0.1/90\n").returncode == 0, what="a line that is not late")
    door.rest()


def test_a_viewer_looks_and_stops_and_does_not_drive(door: Door):
    refused = door.by("eye", "send", "/r/0.1/90")
    assert refused.returncode == 1
    assert said(refused) == "this needs the role 'operate', and you have 'view'\n"
    until(lambda: door.by("eye", "send", "stop").stdout == "stopped\n")
    until(lambda: '"robot":"lbr"' in door.by("eye", "status", "--json").stdout)


def test_topics_can_be_seen_and_published_within_the_role(door: Door):
    assert "forward_m" in door.by("eye", "topic", "echo", "ranges/readings", "--once").stdout
    assert "published" in door.by("eye", "topic", "hz", "drive/state", "--seconds", "0.5").stdout
    needs = door.by("eye", "topic", "pub", "drive/command", '{"power": 0.1}')
    assert said(needs) == "lbr: this needs the role 'operate', and you have 'view'\n"
    never = door.by("boss", "topic", "pub", "motors/setpoint", '{"left": 1, "right": 1}')
    assert "'motors/setpoint' is neither" in said(never)
    unleased = door.by("phone", "topic", "pub", "drive/command", '{"power": 0.1}')
    assert "begins with a query" in said(unleased)


def test_graph_and_view_come_from_the_robot(door: Door):
    assert "drive.command" in door.by("eye", "graph").stdout
    assert "ranges  forward" in door.by("eye", "view", "--once").stdout
    assert said(door.by("eye", "view", "--png", "x.png")) == "lbr: this needs the role 'admin', and you have 'view'\n"


def test_a_token_can_be_in_a_file(door: Door):
    path = door.away / "token"
    path.write_text(f"{door.tokens['eye']}\n")
    until(lambda: door.lbr("send", "stop", "--token-file", str(path)).returncode == 0)
    assert "cannot be read" in said(door.lbr("send", "stop", "--token-file", str(path) + "x"))
    for named in (path, str(path)):
        with connected(door, named) as robot:
            assert robot.role == "view"


def test_a_program_whose_role_is_too_low_is_told_that_this_may_be_why_nothing_answers(door: Door):
    low = "the role 'view' may be too low for it"
    eye, boss = (door.away / f"{name}.token" for name in ("eye", "boss"))
    eye.write_text(str(door.tokens["eye"]))
    boss.write_text(str(door.tokens["boss"]))
    with connected(door, eye) as robot:
        with pytest.raises(client.BusError, match=f"nothing answers on 'drive/turn'; {low}; 'lbr topic list'"):
            robot.ask("drive/turn", angle_deg=10)
        with pytest.raises(client.RefusalError, match=f"does not answer; {low}"):
            robot.borrow("drive/command", power=0.1, angle_deg=0)
        with pytest.raises(client.BusError, match="nothing answers on 'no/stream'; 'lbr topic list'"):
            robot.latest("no/stream")
    with (
        connected(door, boss) as robot,
        pytest.raises(client.BusError, match="nothing answers on 'no/word'; 'lbr topic list'"),
    ):
        robot.ask("no/word")


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (lambda token: "", 1, "wants a token: set LBR_TOKEN, or use --token-file"),
        (lambda token: "secret", 2, "this is not a token"),
        (lambda token: "x" + token, 1, "refuses the token, the one in LBR_TOKEN: it is unknown, revoked or expired"),
        (lambda token: token.replace(".", ".A", 1)[:-1] + "A", 2, "this is not a token"),
        (lambda token: token[:-4] + "AAAA", 1, "another certificate"),
    ],
    ids=["none", "malformed", "unknown", "too long", "another robot's"],
)
def test_who_may_not_come_in_is_told_why_in_one_sentence(door: Door, here, change, code, words):
    done = here("send", "stop", token=change(str(door.tokens["phone"])))
    assert words in said(done)
    assert done.returncode == code
    assert door.tokens["phone"].secret not in done.stderr


def test_whose_clock_is_before_the_certificate_is_told_to_set_it(home: Path, monkeypatch: pytest.MonkeyPatch):
    tomorrow = datetime.now(UTC) + timedelta(days=1)
    monkeypatch.setattr(certificates, "VALID", (tomorrow, certificates.VALID[1]))
    with opened(home) as door:
        done = door.by("phone", "send", "stop")
        assert f"valid from {tomorrow:%Y-%m-%d} " in said(done)
        assert done.returncode == 1


@contextmanager
def listening(greeting: bytes) -> Iterator[str]:
    """A server that speaks no TLS."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            connection, _ = server.accept()
            with connection:
                connection.sendall(greeting)
                connection.recv(1000)

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"tls/127.0.0.1:{server.getsockname()[1]}"
        thread.join()


@pytest.mark.parametrize(
    ("endpoint", "code", "words"),
    [
        ("tls/127.0.0.1:1", 1, "nothing listens at tls/127.0.0.1:1"),
        ("tls/robot.invalid:7447", 1, "there is no machine 'robot.invalid'"),
        ("tls/robot", 2, "is not an endpoint"),
        ("tls/[::1]:99999", 2, "is not an endpoint"),
    ],
)
def test_where_no_robot_is_one_sentence_says_so(door: Door, here, endpoint, code, words):
    done = here("status", token=str(door.tokens["phone"]), endpoint=endpoint)
    assert words in said(done)
    assert done.returncode == code


def test_another_programs_port_is_recognised(door: Door):
    with listening(b"SSH-2.0-server\r\n") as endpoint:
        assert "does not speak TLS" in said(Door(door.robot, endpoint, door.tokens).by("phone", "status"))


@pytest.mark.parametrize("saved_before", [False, True])
def test_a_terminal_is_asked_for_the_token_once_and_shows_none_of_it(door: Door, saved_before):
    away = door.away.with_name(f"asked_{saved_before}")
    saved = away / "credentials" / "robots.json"
    saved.parent.mkdir(parents=True)
    if saved_before:
        saved.write_text(json.dumps({door.endpoint: f"locked_out_{door.tokens['eye']}"}))
    environment = {name: value for name, value in os.environ.items() if name != "LBR_TOKEN"} | {"LBR_HOME": str(away)}
    ours, theirs = pty.openpty()
    command = [*LBR, "send", "stop", "--connect", door.endpoint]
    popen = programs.start(command, env=environment, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True)
    os.close(theirs)
    shown = b""

    def read(words: bytes) -> bool:
        nonlocal shown
        if select.select([ours], [], [], 0.05)[0]:
            shown += os.read(ours, 4096)
        return words in shown

    until(lambda: read(b"token for"), what="it asks")
    assert (b"refuses the token, the one saved in" in shown) == saved_before
    os.write(ours, f"{door.tokens['eye']}\n".encode())
    until(lambda: read(b"stopped"), what="it says")
    assert popen.wait(HANG_S) == 0
    os.close(ours)
    assert door.tokens["eye"].secret.encode() not in shown
    assert stat.S_IMODE(saved.stat().st_mode) == 0o600
    again = programs.run(
        command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    assert again.stdout == "stopped\n", again.stderr
