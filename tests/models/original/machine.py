"""The state machine of the first lbr, as its documents describe it: a client of the old API that runs a table."""

import csv
import http.client
import json
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

CLOCK_S, SETTLE_S, MOST_ROUNDS = 0.5, 1.0, 60
Ask = Callable[[str, str, Any], Any]
COMPARISONS: Mapping[str, Callable[[float, float], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}


def fits(condition: str, value: Any) -> bool:
    """Say whether a value fits a cell: a number, `least:most`, or an operator, a blank and a number; else nothing does."""
    if value is None:
        return False
    try:
        operator, _, number = condition.partition(" ")
        if operator in COMPARISONS:
            return COMPARISONS[operator](value, float(number))
        if ":" in condition:
            least, most = map(float, condition.split(":"))
            return least <= float(value) <= most
        return float(condition) == float(value)
    except (ValueError, TypeError):
        return isinstance(value, str) and condition == value


class Machine:
    """A table and the robot that it asks."""

    def __init__(self, lines: Iterable[str], ask: Ask) -> None:
        self._rows = [row for row in csv.DictReader(lines) if row["Type"] != "#"]
        self._ends = [row for row in self._rows if row["Type"] == "end"]
        self._ask = ask

    def run(self) -> str:
        """Run the table from its start; return the name of its end. A part that is missing, or null, raises as it did."""
        state = next(row["Current State"] for row in self._rows if row["Type"] == "start")
        for _ in range(MOST_ROUNDS):
            state = self._round(state, self._sample())
            end = next((row for row in self._ends if row["Current State"] == state), None)
            if end is not None:
                self._act(end)
                return state
        return self._ends[1]["Current State"]

    def _round(self, state: str, sample: Mapping[str, Any]) -> str:
        for row in (row for row in self._rows if row["Current State"] == state):
            if self._matches(row, sample):
                self._act(row)
                time.sleep(SETTLE_S)
                while not self._stands():
                    time.sleep(CLOCK_S)
                return row["Next State"]
            time.sleep(CLOCK_S)
        return state

    def _matches(self, row: Mapping[str, str], sample: Mapping[str, Any]) -> bool:
        named = {name: cell for name, cell in row.items() if name not in {"Type", "Current State", "Next State"}}
        return all(fits(cell, sample.get(name)) for name, cell in named.items() if cell and ":" not in name)

    def _act(self, row: Mapping[str, str]) -> None:
        asked: dict[str, Any] = {name[2:]: _number(cell) for name, cell in row.items() if name[:2] == "O:" and cell}
        duration_s = asked.get("duration", 0.0)
        time.sleep(max(0.0, -duration_s))
        if asked:
            self._ask("POST", "/", asked)
        time.sleep(max(0.0, duration_s))

    def _stands(self) -> bool:
        sample = self._sample()
        return bool(sample["Amps Left"] == 0.0 and sample["Amps Right"] == 0.0)

    def _sample(self) -> dict[str, Any]:
        told = self._ask("GET", "/telemetry", None)
        ranges, amps, dock = told["Ranges"], told["amperages"], told.get("dockSignal", {})
        return {
            "heading": told["MPU"]["heading"] + 0.0,
            "Rear": ranges["Back"],
            **{name: ranges[name] for name in ("Forward", "Left", "Right")},
            "Amps Left": amps["leftMotor"],
            "Amps Right": amps["rightMotor"],
            "Volts": told["Bat"]["voltage"],
            **{f"Dock {side.capitalize()}": dock[side] for side in ("left", "right") if side in dock},
        }


def _number(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


def ask(port: int, method: str, path: str, body: Any) -> Any:
    """Ask the old API as the first lbr's programs did; return what it tells."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    try:
        text = None if body is None else json.dumps(body) + "\r\n"
        connection.request(method, path, text, {"Content-type": "application/json"})
        return json.loads(connection.getresponse().read())
    finally:
        connection.close()
