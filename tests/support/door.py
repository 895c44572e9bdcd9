"""A robot whose door is open, for tests: tokens, clients with nothing but Zenoh, and clients of ours."""

import json
import os
import ssl
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zenoh

from lbr.bus import session, tokens, wire
from lbr.bus.session import Session
from lbr.bus.tokens import Token
from lbr.database import store
from lbr.errors import BusError
from lbr.executive.planning import credentials
from tests.support import databases, programs
from tests.support.mover import HELD_UP
from tests.support.robot import LBR, Robot, free_port, running
from tests.support.trace import Trace
from tests.support.waiting import HANG_S, until

PLAIN = Path(__file__).parent / "clients" / "at_a_door.py"
COMMAND, TURN = "lbr/drive/command", {"power": 0.1, "angle_deg": 90}
ROLES = {"eye": "view", "phone": "operate", "boss": "admin"}


class Door:
    """A robot that listens at `endpoint`, its tokens by name, and the way to run programs on another machine."""

    def __init__(self, robot: Robot, endpoint: str, held: dict[str, Token], elsewhere: tuple[str, ...] = ()) -> None:
        self.robot = robot
        self.endpoint = endpoint
        self.tokens = held
        self.elsewhere = elsewhere
        self.trace = Trace(robot.trace)
        self.away = robot.home.parent / "away"
        self.away.mkdir(exist_ok=True)

    @property
    def certificate(self) -> str:
        return (self.robot.home / "credentials" / "bus.crt").read_text()

    def settings(self, token: Token, *, timeout_s: float = 2.0) -> dict[str, Any]:
        """Return a client's configuration in Zenoh's own words."""
        endpoints = [self.endpoint]
        found = session.client_settings(endpoints, token.credentials, certificate=self.certificate, timeout_s=timeout_s)
        return dict(found)

    @contextmanager
    def client(self, name: str) -> Iterator[Session]:
        with zenoh.open(zenoh.Config.from_json5(json.dumps(self.settings(self.tokens[name])))) as opened:
            yield opened

    def file(self, name: str) -> Path:
        path = self.away / f"{name}.json5"
        path.write_text(json.dumps(self.settings(self.tokens[name])))
        return path

    def lbr(self, *arguments: str, token: str = "", stdin: str = "") -> "subprocess.CompletedProcess[str]":
        """Run `lbr` on another machine, against this robot."""
        environment = os.environ | {"LBR_HOME": str(self.away), **({"LBR_TOKEN": token} if token else {})}
        return programs.run(
            [*self.elsewhere, *LBR, *arguments, "--connect", self.endpoint],
            env=environment,
            input=stdin,
            capture_output=True,
            text=True,
            timeout=HANG_S,
            check=False,
        )

    def by(self, name: str, *arguments: str, stdin: str = "") -> "subprocess.CompletedProcess[str]":
        """Run `lbr` with somebody's token."""
        return self.lbr(*arguments, token=str(self.tokens[name]), stdin=stdin)

    def drive(self, name: str, line: str, *, hold_s: float) -> dict[str, Any]:
        """Send a motion with `lbr send`, again where a busy machine held it up, and return its result."""

        def result() -> dict[str, Any] | None:
            done = self.by(name, "send", line, "--hold", str(hold_s), "--json")
            if "does not answer" in done.stderr:
                return None
            assert done.stdout, done.stderr
            sent: dict[str, Any] = json.loads(done.stdout)
            held_up = HELD_UP & {sent["reason_code"], sent["ending_code"]}
            assert done.returncode == 0 or held_up, sent
            return None if held_up else sent

        return until(result, what="a motion that nothing holds up")

    @contextmanager
    def plain(self, name: str, manner: str) -> Iterator["subprocess.Popen[str]"]:
        """Run the client with nothing but Zenoh, on another machine."""
        popen = programs.start(
            [*self.elsewhere, sys.executable, str(PLAIN), str(self.file(name)), manner],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            yield popen
        finally:
            popen.kill()
            popen.wait()
            for pipe in (popen.stdin, popen.stdout):
                assert pipe is not None
                pipe.close()

    def moving(self) -> bool:
        return not self.trace.now().zero

    def turn(self, bus: Session, source: str = "afar") -> str:
        """Have a client turn the robot, and return its lease; one that lapses on a busy machine is asked for again."""
        lease = ""

        def turns() -> bool:
            nonlocal lease
            said = answer(bus, COMMAND, {**TURN, "lease": lease}, source=source)
            lease = said["lease"] if said and said["accepted"] else ""
            return bool(lease) and self.moving()

        until(turns, what="it turns")
        return lease

    def rest(self) -> None:
        """Wait until the motors stand, and nobody holds the robot."""
        self.robot.ask("drive/stop", {})
        until(lambda: not self.moving(), what="the motors stand")
        until(lambda: (self.robot.ask("drive/state") or {"holder": "?"})["holder"] is None, what="nobody holds")

    def add(self, name: str, role: str, expires_at: str | None = None) -> None:
        """Make one more token, and wait until it is let in."""
        self.tokens[name] = add_token(self.robot.home, name, role, expires_at)
        until(lambda: self.refuses(name) == "", what=f"{name} is let in")

    def refuses(self, name: str) -> str:
        """Return why a token's holder does not get in, or nothing."""
        credentials = self.tokens[name].credentials
        try:
            session.open_client([self.endpoint], credentials, certificate=self.certificate, timeout_s=0.0).close()
        except BusError as err:
            return str(err)
        return ""

    def ready(self) -> None:
        until(lambda: self.robot.capability("lan")["phase"] == "ready", what="the door is open")


@contextmanager
def opened(home: Path, address: str = "127.0.0.1", *, prefix: tuple[str, ...] = (), elsewhere: tuple[str, ...] = ()):
    """Run a robot that listens, with a token for each role."""
    held = {name: add_token(home, name, role) for name, role in ROLES.items()}
    endpoint = f"tls/{address}:{free_port()}"
    with running(home, "--listen", endpoint, prefix=prefix) as robot:
        until(lambda: robot.line("/r/0.1/90")["code"] == 0, what="it drives")
        door = Door(robot, endpoint, held, elsewhere)
        door.rest()
        yield door


def add_token(home: Path, name: str, role: str, expires_at: str | None = None, good_for: str = "both") -> Token:
    """Make a token as `lbr token add` does, and faster."""
    before = os.environ.get("LBR_HOME")
    os.environ["LBR_HOME"] = str(home)
    try:
        created_at = f"2026-01-01T00:00:00.{time.monotonic_ns() % 10**6:06d}Z"
        secret = credentials.token_secret(credentials.token_key(), name, created_at)
        certificate = credentials.bus_certificate()[1].read_text()
        with store.Database.open(home / "robot.db") as database:
            row = databases.token(
                name, role, tokens.hashed(secret), expires_at, created_at=created_at, good_for=good_for
            )  # type: ignore[arg-type]
            database.add_token(row)
    finally:
        os.environ.pop("LBR_HOME") if before is None else os.environ.update(LBR_HOME=before)
    return Token(name=name, secret=secret, fingerprint=tokens.fingerprint(ssl.PEM_cert_to_DER_cert(certificate)))


def told(bus: Session, key: str, message: Any = None) -> Any:
    """Return the answer of a key that answers; asked again where a link was lost on a busy machine."""
    return until(lambda: answer(bus, key, message), what=f"an answer from {key}")


def answer(bus: Session, key: str, message: Any = None, *, source: str = "afar", timeout_s: float = 1.0) -> Any:
    """Query a key and return the decoded answer; None if nobody answered."""
    answers = wire.ask(bus, key, message, source=source, timeout_s=timeout_s)
    return json.loads(answers[0].payload) if answers else None
