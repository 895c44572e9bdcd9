"""Tokens: made, shown once, kept nowhere, taken back while somebody is inside."""

import json
import socket
import sqlite3
import stat
import time
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from lbr import cli
from lbr.bus import tokens
from lbr.commands import token as token_command
from lbr.errors import InputError
from tests.support import needs
from tests.support.commands import here
from tests.support.door import Door, add_token, answer
from tests.support.waiting import STOPS_S, until


@given(st.text(max_size=120))
def test_what_is_no_token_is_refused_without_repeating_it(text):
    with pytest.raises(InputError) as refused:
        tokens.parse(text)
    assert str(refused.value).startswith("this is not a token: ")


@given(st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}", fullmatch=True), st.binary(min_size=32, max_size=32))
def test_a_token_is_read_as_it_was_written(name, secret):
    token = tokens.Token(name=name, secret=tokens.text(secret), fingerprint=tokens.fingerprint(secret))
    assert tokens.parse(f" {token}\n") == token
    assert tokens.check_name(name) == name


@pytest.mark.parametrize("name", ["", "@tools", "a:b", "a.b", "a\nb", "-a", "a b", "x" * 41, "ä"])
def test_a_name_that_could_be_taken_for_more_is_refused(name):
    with pytest.raises(InputError, match="up to 40 letters"):
        tokens.check_name(name)


def test_a_hash_fits_its_secret_alone():
    found = tokens.hashed("secret")
    assert found.startswith("$argon2id$v=19$m=19456,t=2,p=1$")
    assert tokens.fits("secret", found)
    assert not tokens.fits("Secret", found)
    assert not tokens.fits("secret", "secret")


def test_tokens_are_made_listed_and_revoked_where_no_robot_runs(home: Path, monkeypatch, capsys):
    monkeypatch.setenv("LBR_HOME", str(home))
    monkeypatch.delenv("LBR_TOKEN", raising=False)
    path = home.parent / "phone.json5"

    def said(code: int, *arguments: str) -> str:
        assert cli.main(["token", *arguments]) == code
        return "".join(capsys.readouterr())

    made = said(0, "add", "phone", "--role", "view", "--expires", "30d", "--file", str(path))
    token = tokens.parse(made.splitlines()[0])
    assert token.name == "phone"
    assert "SET enabled = 1 WHERE robot" in made
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert token.secret in path.read_text()
    (listed,) = json.loads(said(0, "list", "--json"))
    assert (listed["name"], listed["role"], listed["state"], listed["good_for"]) == ("phone", "view", "valid", "bus")
    assert not any(token.secret.encode() in path.read_bytes() for path in home.rglob("*") if path.is_file())
    assert "there is a token 'phone' already" in said(2, "add", "phone")
    assert said(0, "revoke", "phone") == ""
    assert "revoked" in said(0, "list")
    assert "there is no token 'phone'" in said(2, "revoke", "phone")
    assert "'soon' is not a time from now" in said(2, "add", "x", "--expires", "soon")
    assert "--for both" in said(2, "add", "kitchen", "--role", "host", "--for", "web")
    assert "console --connect" not in said(0, "add", "page", "--for", "web")
    assert "page   operate web  valid" in said(0, "list")
    again = tokens.parse(said(0, "add", "phone").splitlines()[0])
    assert again.secret != token.secret


def test_a_written_file_lets_a_client_in_although_its_first_address_leads_nowhere(door: Door, monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        dead = f"tls/127.0.0.1:{nobody.getsockname()[1]}"
    monkeypatch.setenv("LBR_HOME", str(door.robot.home))
    path = door.away / "two_addresses.json5"
    with token_command.new_file(path) as file:
        token_command.write_configuration(file, door.tokens["eye"], [dead, door.endpoint])
    with zenoh.open(zenoh.Config.from_file(str(path))) as bus:
        assert answer(bus, "lbr/@status") is not None


def refused(door: Door, name: str) -> bool:
    return "Unable to connect" in door.refuses(name)


def test_a_token_for_the_web_alone_opens_no_bus(door: Door):
    door.tokens["page"] = add_token(door.robot.home, "page", "admin", good_for="web")
    door.tokens["tool"] = add_token(door.robot.home, "tool", "view", good_for="bus")
    until(lambda: door.refuses("tool") == "", what="the token for the bus is let in")
    assert refused(door, "page")


def test_who_is_revoked_drives_no_longer_and_stays_out(door: Door):
    door.add("leaver", "operate")
    with door.plain("leaver", "asking"), door.client("leaver") as bus:
        until(door.moving, what="it drives")
        asked_ns = time.monotonic_ns()
        with closing(sqlite3.connect(door.robot.home / "robot.db")) as database, database:
            database.execute("UPDATE user_token SET revoked_at = '2026-01-02T00:00:00Z' WHERE name = 'leaver'")
            database.execute("UPDATE capability SET kind = 'nonsense' WHERE name = 'ranges'")
        assert door.trace.first_zero(asked_ns, STOPS_S) is not None
        until(lambda: refused(door, "leaver"), what="it is refused")
        until(lambda: not door.moving(), limit_s=STOPS_S, what="it drives no longer")
        until(lambda: not refused(door, "eye"), what="the door is open for others")
        assert answer(bus, "lbr/@status", timeout_s=0.3) is None
    assert refused(door, "leaver")
    assert not door.moving()
    assert door.robot.status()["problems"], "another edit was wrong, and that did not matter"
    door.robot.edit("UPDATE capability SET kind = 'ultrasonic_ring' WHERE name = 'ranges'")
    until(lambda: not door.robot.status()["problems"], what="the rows are good again")
    gone = "token 'leaver' has no rights any more"
    until(lambda: gone in here(door.robot.home, "db", "audit").stdout, what="the trail")


def test_a_token_ends_by_itself_and_others_begin_while_somebody_drives(door: Door):
    soon = (datetime.now(UTC) + timedelta(seconds=2)).isoformat()
    with door.plain("phone", "asking"):
        until(door.moving, what="it drives")
        door.add("guest", "view", soon)
        until(door.moving, what="the driver goes on by itself")
        until(lambda: refused(door, "guest"), what="the guest's time is over")
        until(lambda: not refused(door, "phone"), what="the driver is still let in")
        until(door.moving, what="the driver goes on by itself")
        assert refused(door, "guest")
    door.rest()


def test_a_hash_that_somebody_wrote_lets_nobody_in_and_is_told(door: Door):
    door.robot.edit("INSERT INTO user_token (name, role, hash) VALUES ('mole', 'admin', ?)", tokens.hashed("mine"))
    until(lambda: any("the token 'mole' is not let in" in event["text"] for event in door.robot.events()), what="told")
    until(lambda: not refused(door, "eye"), what="the door is open for others")
    door.tokens["mole"] = tokens.Token(name="mole", secret="mine", fingerprint="")
    assert refused(door, "mole")


def test_comings_and_goings_are_told_and_go_into_the_trail(door: Door):
    with door.client("eye"):
        until(lambda: any(event["kind"] == "login" for event in door.robot.events()), what="a login")
    until(lambda: any(event["kind"] == "logout" for event in door.robot.events()), what="a logout")
    until(lambda: door.robot.capability("lan")["reason"].startswith(f"at {door.endpoint} with certificate "))
    until(lambda: "came in" in here(door.robot.home, "db", "audit").stdout, what="the trail")
    record = json.loads((door.robot.home / "run" / "lbr.json").read_text())
    assert record["lan"] == [door.endpoint]
    assert (door.robot.home / "credentials" / "bus.key").stat().st_mode & 0o077 == 0


@needs.LOOKING_INSIDE
def test_a_secret_is_in_no_file_and_no_process_of_the_robot(own_door: Door):
    secret = own_door.tokens["phone"].secret.encode()
    own_door.drive("phone", "/r/0.1/90", hold_s=0.2)
    own_door.robot.edit("UPDATE user_token SET revoked_at = '2026-01-02T00:00:00Z' WHERE name = 'phone'")
    until(lambda: refused(own_door, "phone"), what="it is revoked")
    own_door.ready()
    pids = [own_door.robot.popen.pid, *(one["pid"] for one in own_door.robot.status()["capabilities"])]
    for pid in pids:
        for name in ("cmdline", "environ"):
            assert secret not in Path(f"/proc/{pid}/{name}").read_bytes()
    own_door.robot.close()
    files = [path for path in own_door.robot.home.rglob("*") if path.is_file()]
    assert len(files) > 8
    assert not [path for path in files if secret in path.read_bytes()]
