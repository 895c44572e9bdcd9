"""A service that lists robots, by TLS and token; a robot that registers there, through the commands that people type."""

import json
import subprocess
from contextlib import contextmanager, suppress

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.registry import asking
from lbr.apps.registry.book import KEPT_S, MOST_ROBOTS, Book, Entry
from lbr.apps.registry.kind import KIND
from lbr.bus import tokens
from lbr.errors import BusError, InputError, LbrError
from tests.support import needs, programs
from tests.support.robot import LBR, environment, free_port, lbr, prepare, running
from tests.support.waiting import until

needs.modules("starlette", "uvicorn")

pytestmark = [pytest.mark.slow_start]


@contextmanager
def service(home, port):
    popen = programs.start(
        [*LBR, "registry", "serve", "--port", port], env=environment(home), stdout=subprocess.PIPE, text=True
    )
    try:
        assert f"https://127.0.0.1:{port}" in popen.stdout.readline()
        yield popen
    finally:
        popen.terminate()
        assert popen.wait(10.0) == 0
        popen.stdout.close()


def test_a_robot_registers_is_listed_and_found_leaves_and_is_locked_out(tmp_path):
    place, port = tmp_path / "registry", free_port()
    settings = json.dumps({"url": f"https://localhost:{port}", "every_s": 5, "endpoints": ["tls/robot.example:7447"]})
    home = prepare(
        tmp_path / "home",
        "registrar",
        edits=(
            "UPDATE capability SET enabled = 0 WHERE robot = 'lbr' AND name != 'registrar'",
            f"UPDATE capability SET enabled = 1, settings = '{settings}' WHERE robot = 'lbr' AND name = 'registrar'",
        ),
    )
    token = lbr(place, "registry", "add", "kitchen").stdout.strip()
    viewer = tmp_path / "viewer"
    viewer.write_text(lbr(place, "registry", "add", "viewer").stdout)
    (home / "credentials").mkdir(mode=0o700)
    (home / "credentials" / "registry.token").write_text(token)
    (home / "credentials" / "registry.token").chmod(0o600)

    def listed():
        said = lbr(home, "registry", "list", f"https://localhost:{port}", "--token-file", str(viewer), "--json")
        assert said.returncode == 0, said.stderr
        return json.loads(said.stdout)

    with running(home) as robot:
        until(lambda: "cannot be reached" in robot.capability("registrar")["reason"], what="that nobody is there")
        with service(place, port):
            (one,) = until(listed, what="the robot in the list")
            assert (one["name"], one["robot"], one["up"]) == ("kitchen", "lbr", True)
            assert one["endpoints"] == ["tls/robot.example:7447"]
            state = until(
                lambda: (said := robot.ask("registrar/state")) and said["registered"] and said, what="its word"
            )
            assert (state["name"], state["reason"]) == ("kitchen", "")
            assert lbr(place, "registry", "revoke", "kitchen").returncode == 0
            until(lambda: not listed(), what="an empty list")
            until(lambda: "(401)" in robot.capability("registrar")["reason"], what="its refusal")


def test_a_list_is_for_those_with_a_token_and_a_forged_service_gets_none(tmp_path):
    place, port = tmp_path / "registry", free_port()
    token = tokens.parse(lbr(place, "registry", "add", "one").stdout)
    again = lbr(place, "registry", "add", "one")
    assert (again.returncode, "has a token already" in again.stderr) == (2, True)
    url, entry = f"https://localhost:{port}", msgspec.json.encode(Entry(robot="rob"))
    with service(place, port):
        asking.ask(url, token, "POST", entry)
        (one,) = json.loads(asking.ask(url, token, "GET"))
        assert one["up"]
        asking.ask(url, token, "DELETE")
        (one,) = json.loads(asking.ask(url, token, "GET"))
        assert not one["up"]
        other = tokens.Token(name="one", secret=tokens.text(bytes(32)), fingerprint=token.fingerprint)
        with pytest.raises(LbrError, match=r"\(401\): show a token"):
            asking.ask(url, other, "GET")
        for body, complaint in [
            (b"{", r"\(400\)"),
            (b"[" * 8000, r"\(400\)"),
            (b" " * 9000, r"\(413\)"),
            (b'{"robot": "rob", "urls": ["javascript:alert(1)"]}', r"\(400\).*urls"),
            (b'{"robot": "rob", "every_s": 1e9}', r"\(400\).*every_s"),
        ]:
            with pytest.raises(LbrError, match=complaint):
                asking.ask(url, token, "POST", body)
        forged = tokens.Token(name="one", secret=token.secret, fingerprint="A" * 22)
        with pytest.raises(BusError, match="another certificate"):
            asking.ask(url, forged, "GET")
    with pytest.raises(BusError, match="cannot be reached"):
        asking.ask(url, token, "GET")
    with pytest.raises(InputError, match="is no address"):
        asking.ask("http://localhost:1", token, "GET")


@pytest.mark.parametrize(
    "url",
    [
        "https://[::1",
        "https://x:99999",
        "https://x:y",
        "https://a b/",
        "https://192.168..5",
        "https://.a",
        "https://\udcff",
        f"https://{'a' * 80}.b",
        "https://",
    ],
)
def test_what_is_no_address_is_told_as_that(url):
    with pytest.raises(InputError, match=r"is no (name or )?address of a"):
        asking.ask(url, tokens.parse(f"me.{'x' * 43}.{'y' * 22}"), "GET")


@given(st.binary(max_size=300))
def test_whatever_a_service_answers_is_a_sentence(answer):
    """What it says is never trusted: a list that is none, a reason that moves the cursor."""
    assert asking._reason(answer).isprintable()


@given(st.binary(max_size=200))
def test_whatever_registers_is_an_entry_or_refused(body):
    with suppress(msgspec.DecodeError, UnicodeDecodeError):
        msgspec.json.decode(body, type=Entry)


def test_who_is_silent_is_gone_after_three_periods_and_forgotten_after_a_day():
    book, entry = Book(), Entry(robot="rob", every_s=10.0)
    assert book.register("a", "1.2.3.4", entry, 100.0)
    assert [one.up for one in book.listed(130.0)] == [True]
    assert [(one.up, one.seen_s) for one in book.listed(131.0)] == [(False, 31.0)]
    assert book.register("b", "1.2.3.5", entry, 131.0)
    assert [one.name for one in book.listed(131.0)] == ["b", "a"]
    book.keep({"a"})
    assert [one.name for one in book.listed(131.0)] == ["a"]
    assert book.listed(100.0 + KEPT_S + 1.0) == ()


def test_a_book_that_is_full_takes_what_it_knows_and_nothing_else():
    book, entry = Book(), Entry(robot="rob")
    assert all(book.register(str(number), "", entry, 0.0) for number in range(MOST_ROBOTS))
    assert not book.register("one more", "", entry, 1.0)
    assert book.register("7", "", entry, 1.0)


@pytest.mark.parametrize("url", ["http://robots.example", "https://a b", "https://user@host", "https://host/path"])
def test_a_bad_address_is_refused_with_the_row(url):
    with pytest.raises(msgspec.ValidationError, match="url"):
        KIND.parse(json.dumps({"url": url}))
