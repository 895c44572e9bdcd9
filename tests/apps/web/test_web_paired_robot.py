"""From the word at the console to a token that counts, and to one that counts no more, on a whole robot."""

import hashlib
import http.client
import json
import re
import sqlite3
import ssl
import tempfile
from contextlib import closing
from pathlib import Path

import pytest
from websockets.sync.client import connect

from lbr.bus import keys
from tests.apps.web.web_stage import ending
from tests.support.commands import here
from tests.support.robot import Robot, only, prepare, running
from tests.support.waiting import HANG_S, until

pytestmark = [pytest.mark.slow_start]
EDITS = (
    "UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'web'",
    only("lbr", "web"),
    "UPDATE capability SET settings = json_set(settings, '$.tls', json('true')) WHERE robot = 'lbr' AND name = 'web'",
)
UNKNOWN = "000000", "111111"


@pytest.fixture(scope="module")
def robot():
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder, running(prepare(Path(folder) / "h", edits=EDITS)) as one:
        until(lambda: one.capability("web")["phase"] == "ready")
        yield one


def no_check() -> ssl.SSLContext:
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


def ask(robot: Robot, method: str, path: str, body: object = None, token: str = "") -> tuple[int, dict, bytes]:
    """Ask by HTTPS; return status, what is said, and the fingerprint of the certificate."""
    place = robot.web.removeprefix("http://")
    connection = http.client.HTTPSConnection(place, timeout=8, context=no_check())
    headers = {"Content-Type": "application/json"} if body is not None else {}
    headers |= {"Authorization": f"Bearer {token}"} if token else {}
    try:
        connection.request(method, path, json.dumps(body) if body is not None else None, headers)
        certificate = connection.sock.getpeercert(binary_form=True)
        answer = connection.getresponse()
        said = answer.read()
        return answer.status, json.loads(said) if said.startswith(b"{") else {}, certificate
    finally:
        connection.close()


def pair(robot: Robot, digits: str) -> tuple[int, dict, bytes]:
    return ask(robot, "POST", "/api/pair", {"code": digits, "name": "Ann's phone"})


def test_a_phone_gets_in_by_the_code_and_is_out_once_its_token_is_revoked(robot):
    shown = robot.line("pair")
    digits = shown["data"]["digits"]
    assert shown["data"]["url"] == f"{robot.web.replace('http:', 'https:')}/#pair={digits}"
    wrong = next(one for one in UNKNOWN if one != digits)
    assert pair(robot, wrong)[0] == 403
    before = robot.capability("web")["pid"]
    status, given, certificate = pair(robot, digits)
    assert status == 200, given
    assert given["role"] == "operate"
    assert shown["data"]["fingerprint"] == hashlib.sha256(certificate).digest().hex(":").upper()
    token, name = given["token"], given["name"]
    assert name == "Ann-s-phone"
    assert ask(robot, "POST", "/estop/reset", token=token)[0] == 200
    assert pair(robot, digits)[0] == 403, "a code is good for one device"
    until(lambda: any(f"token '{name}' (operate) is valid" in event["text"] for event in robot.events()))
    assert robot.capability("web")["pid"] == before, "who was connected is cut off by it"
    (row,) = json.loads(here(robot.home, "token", "list", "--json").stdout)
    assert (row["name"], row["good_for"], row["state"], row["paired_from"]) == (name, "web", "valid", "127.0.0.1")
    with connect(
        robot.web.replace("http:", "wss:") + "/ws",
        additional_headers={"Authorization": f"Bearer {token}"},
        ssl=no_check(),
    ) as states:
        states.recv(timeout=HANG_S)
        assert here(robot.home, "token", "revoke", name).returncode == 0
        ending(states)
    assert ask(robot, "POST", "/estop/reset", token=token)[0] == 401
    assert robot.capability("web")["pid"] == before, "who has another token is cut off by it"
    told = f"token '{name}' (operate) was made for 127.0.0.1, by the code that a bus client asked for"

    def paired() -> list[tuple[str, str]] | None:
        with closing(sqlite3.connect(robot.home / "robot.db")) as database:
            trail = database.execute("SELECT kind, text FROM audit").fetchall()
        who = [(kind, re.sub("that .* asked", "that a bus client asked", text)) for kind, text in trail]
        return trail if ("paired", told) in who else None

    trail = until(paired, what="the pairing in the trail")
    assert any(kind == "pair_refused" and text.startswith("127.0.0.1 tried") for kind, text in trail)
    secret = token.split(".")[1]
    assert not any(secret.encode() in path.read_bytes() for path in robot.home.rglob("*") if path.is_file())
    assert not re.search(rf"\b{digits}\b", json.dumps([trail, robot.events(), robot.status()]))


def line(robot: Robot, text: str, key: str = keys.console("lbr", "admin")) -> dict:
    """Say a line and wait for as long as a server may take to start."""
    with closing(robot.as_owner()) as bus:
        return json.loads(next(iter(bus.get(key, payload=text, timeout=15.0))).ok.payload.to_bytes())


@pytest.mark.parametrize("role", ["view", "operate"])
def test_on_a_page_a_code_is_for_admins_alone(robot, role):
    refused = line(robot, "pair", keys.console_of_pages("lbr", role))
    assert (refused["code"], refused["reason_code"], refused["data"]) == (1, "role", None)
    assert len(line(robot, "pair", keys.console_of_pages("lbr", "admin"))["data"]["digits"]) == 6


def test_open_is_said_once_and_close_takes_it_back(robot):
    opened = line(robot, "open")
    assert opened["code"] == 0
    assert "'web' is open to" in opened["text"]
    assert opened["data"]["open"] is True
    assert "open already" in line(robot, "open")["text"]
    assert any("had 'web' listen at 0.0.0.0" in event["text"] for event in robot.events() if event["kind"] == "edit")
    assert "'web' is closed" in line(robot, "close")["text"]
    until(lambda: robot.ask("web/address", {})["open"] is False)


def test_one_word_opens_it_and_its_code_lets_a_phone_in(robot):
    shown = line(robot, "phone")
    assert shown["code"] == 0
    assert "'web' is open to your network now; 'close' takes it back." in shown["text"]
    assert shown["data"]["open"] is True
    assert pair(robot, shown["data"]["digits"])[0] == 200
    assert line(robot, "close")["code"] == 0
