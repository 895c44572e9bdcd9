"""The tables of the UXA-90's first API, motors, motions and their buttons, and its settings file."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from lbr.messages.rows import short
from lbr.names import name_from
from lbr.robot.old_data import Choice, Here, Note, OldData, Source, Want, no_place

LAYER = "original"
"""The layer of imported motors in the table `motor`; the shipped layers stay beside it."""
_MOTOR = {"id", "name", "min", "max", "default"}
_MOTION = {"id", "name", "button"}
_LINE = re.compile(r"\s*(?:export\s+)?([A-Z][A-Z0-9_]*)\s*=\s*(.*?)\s*", re.ASCII)
_HIGHEST_PORT = 65_535


class OldTables(NamedTuple):
    """Motors and motions of the API, in their order."""

    motors: Sequence[Mapping[str, Any]]
    motions: Sequence[Mapping[str, Any]]

    def fits(self, target: Here) -> bool:
        """Return whether a robot has motors by number."""
        return bool(target.rows("motor"))

    def wants(self, target: Here, choice: Choice) -> Iterator[Want | Note]:  # noqa: ARG002
        """Yield motors in a layer of their own, and numbers of motions."""
        for row in self.motors:
            yield from _motor(row)
        if self.motors:
            text = f"the API shows them once web's setting layer is '{LAYER}'; joints keep their own limits"
            yield Note("changed", "motor", LAYER, "layer", text)
        for row in self.motions:
            yield from _button(row, target)


class OldSettings(NamedTuple):
    """The environment in which the API was started."""

    settings: Mapping[str, str]

    def fits(self, target: Here) -> bool:
        """Return whether a robot has motors by number, and with them the API."""
        return bool(target.rows("motor"))

    def wants(self, target: Here, choice: Choice) -> Iterator[Want | Note]:  # noqa: ARG002
        """Yield the port of the API."""
        web = [row["name"] for row in target.rows("capability") if row["kind"] == "web"]
        for name, value in self.settings.items():
            if name != "PORT":
                yield no_place("settings", short(name), "", "nothing here is set by it")
            elif len(web) == 1 and value.isascii() and value.isdecimal() and int(value) <= _HIGHEST_PORT:
                yield Want("capability", {"name": web[0]}, {"settings.port": int(value)}, "PORT")
            else:
                yield no_place("settings", name, "", f"'{short(value)}' is no port, or there is no web server")


def read(source: Source) -> OldData | None:
    """Return tables from an answer to `GET /motor` or `GET /motion`, a list of such rows, or both by their names."""
    content = source.json
    if isinstance(content, dict) and isinstance(content.get("data"), list):
        content = content["data"]
    if isinstance(content, list):
        content = {
            "motors": _like(content, _MOTOR),
            "motions": [] if _like(content, _MOTOR) else _like(content, _MOTION),
        }
    if not isinstance(content, dict):
        return None
    motors, motions = (content.get(name) or [] for name in ("motors", "motions"))
    if not (motors or motions) or _like(motors, _MOTOR) != motors or _like(motions, _MOTION) != motions:
        return None
    return OldTables(motors, motions)


def read_settings(source: Source) -> OldData | None:
    """Return the settings of a file of lines such as `PORT=50000`; None if it has other lines."""
    if source.text is None or not (source.name.endswith(".env") or source.name.startswith(".env")):
        return None
    lines = [line for line in source.text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    matches = [_LINE.fullmatch(line) for line in lines]
    if not matches or None in matches:
        return None
    return OldSettings({one[1]: one[2].strip("'\"") for one in matches if one is not None})


def _like(rows: object, columns: set[str]) -> list[Mapping[str, object]]:
    """Return the rows if all of them have these columns."""
    if not isinstance(rows, list) or not all(isinstance(row, dict) and columns <= set(row) for row in rows):
        return []
    return rows


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _motor(row: Mapping[str, Any]) -> Iterator[Want | Note]:
    number = row["id"]
    default = row["default"]
    if not all(_whole(row[name]) for name in ("id", "min", "max", "default")) or not row["min"] < row["max"]:
        yield no_place(
            "motor", short(number), "min, max", "they are no whole numbers, or the first is not below the second"
        )
        return
    columns = {
        "name": row["name"],
        "description": row.get("description") or "",
        "initial": row.get("position", default),
        "lowest": row["min"],
        "highest": row["max"],
        "rest": default,
        "inverted": row.get("inverted", False),
    }
    yield Want("motor", {"layer": LAYER, "id": number}, columns, f"motor '{short(number)}'", create=True)
    for column in sorted(set(row) - {"id", "name", "description", "position", "min", "max", "default", "inverted"}):
        yield no_place("motor", short(number), short(column), "the original has no such column")


def _button(row: Mapping[str, object], target: Here) -> Iterator[Want | Note]:
    number, name = row["id"], row["name"]
    if not _whole(number) or not isinstance(name, str) or not isinstance(row["button"], str):
        yield no_place("motion", short(number), "", "its number is no number, or its name no text")
        return
    known = {button["id"]: button for button in target.rows("button")}
    same = known.get(number)
    if same is not None and (same["name"], same["button"]) == (name, row["button"]):
        motion = same["motion"]
    elif any(motion["name"] == name_from(name, "motion") for motion in target.rows("motion")):
        motion = name_from(name, "motion")
    else:
        text = (
            f"there is no motion '{short(name)}' here: enter a row of motion with slot {short(number)} and the time "
            "that the main board takes for it, then take this again"
        )
        yield no_place("motion", short(number), "name", text)
        return
    columns = {"name": name, "button": row["button"], "motion": motion}
    yield Want("button", {"id": number}, columns, f"motion '{short(number)}'", create=True)
