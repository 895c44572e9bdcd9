"""Three people at once: one drives under leases, one talks to the console, one edits rows; whatever becomes of the robot."""

import json
import random
import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from typing import Any

from lbr.bus import keys, session, wire
from lbr.bus.session import Session
from tests.support.bench import ANGLES
from tests.support.mover import POWER, RENEW_S
from tests.support.robot import Robot

LINES = (
    *("/r/0.4/90", "/r/0.3/270/0/forward/0.4", "s", "stop", "status", "help", "/report/telemetry", "/report/events"),
    *("/r/2/0", "/nonsense", "/r/nan/0", "disable", "enable", ""),
)
KEPT_PHRASES = 50
ADD = "INSERT OR REPLACE INTO phrase (name, language, text) VALUES (?, 'en', ?)"
TOUCH = "UPDATE verb SET help = ? WHERE robot = 'lbr' AND word = 'f'"


class Traffic:
    """The three; `acknowledged` maps each phrase that was written to its newest text."""

    def __init__(self, robot: Robot, seed: int) -> None:
        self.acknowledged: dict[str, str] = {}
        self.answered = 0
        self._endpoints, self._name, self._database = robot.endpoints, robot.name, robot.home / "robot.db"
        self._seed = seed
        self._over = threading.Event()
        people: tuple[Callable[[random.Random], None], ...] = (self._drives, self._talks, self._edits)
        self._threads = [
            threading.Thread(target=self._again_and_again, args=(one, random.Random(seed + n)), daemon=True)
            for n, one in enumerate(people)
        ]

    def start(self) -> None:
        """Let them begin."""
        for thread in self._threads:
            thread.start()

    def end(self) -> None:
        """Let them go home."""
        self._over.set()
        for thread in self._threads:
            thread.join()

    def lost(self) -> list[str]:
        """Return the writes that were acknowledged and are not there."""
        with closing(sqlite3.connect(self._database)) as database:
            there = dict(database.execute("SELECT name, text FROM phrase WHERE language = 'en'").fetchall())
        return [
            f"phrase {name} is {there.get(name)!r}"
            for name, text in self.acknowledged.items()
            if there.get(name) != text
        ]

    def _again_and_again(self, person: Callable[[random.Random], None], dice: random.Random) -> None:
        while not self._over.wait(0.1):
            with suppress(Exception):  # the robot may be away, or half dead
                person(dice)

    def _drives(self, dice: random.Random) -> None:
        key, angle = f"{self._name}/drive/command", dice.choice(ANGLES)
        command: dict[str, Any] = {"power": round(dice.uniform(0.1, POWER), 2), "angle_deg": angle}
        with self._bus() as bus:
            while not self._over.is_set():
                lease = self._asked(bus, key, command, "driver").get("lease", "")
                for _ in range(dice.randint(1, 20)):
                    if self._over.wait(RENEW_S):
                        break
                    bus.put(key, json.dumps(command | {"lease": lease}))
                if dice.random() < 0.5:
                    self._asked(bus, f"{self._name}/drive/stop", {}, "driver")
                self._over.wait(dice.uniform(0.0, 0.5))

    def _talks(self, dice: random.Random) -> None:
        with self._bus() as bus:
            while not self._over.wait(dice.uniform(0.05, 0.5)):
                self._asked(bus, keys.console(self._name), dice.choice(LINES), "talker")

    def _edits(self, dice: random.Random) -> None:
        with closing(sqlite3.connect(self._database, timeout=5.0, isolation_level=None)) as database:
            while not self._over.wait(dice.uniform(0.1, 0.6)):
                name, text = f"p{dice.randrange(KEPT_PHRASES)}", f"{dice.random()}"
                self.acknowledged.pop(name, None)
                database.execute(ADD, (name, text))
                self.acknowledged[name] = text
                database.execute(TOUCH, (text,))

    def _asked(self, bus: Session, key: str, message: Any, source: str) -> dict[str, Any]:
        answers = wire.ask(bus, key, message, source=source, timeout_s=1.0)
        if not answers:
            raise TimeoutError(key)
        self.answered += 1
        found = json.loads(answers[0].payload)
        return found if isinstance(found, dict) else {}

    @contextmanager
    def _bus(self) -> Iterator[Session]:
        bus = session.open_client(self._endpoints, timeout_s=0.5)
        try:
            yield bus
        finally:
            bus.close()
