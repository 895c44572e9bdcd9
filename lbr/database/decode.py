"""Raw rows to rows, one at a time; what concerns several rows is in checks.py."""

import re
from collections.abc import Callable, Sequence
from typing import Any, get_args

from msgspec import Struct

from lbr.database import arguments, patterns
from lbr.database.reader import RowReader, shown
from lbr.database.rows import (
    Argument,
    ButtonRow,
    CalibrationRow,
    CapabilityRow,
    ChannelRow,
    ChoreographyRow,
    DeviceRow,
    ExternalCommandRow,
    JointRow,
    MotionRow,
    MotionStepRow,
    MotorRow,
    PhraseRow,
    Problem,
    Restart,
    RobotRow,
    Side,
    VerbRow,
)
from lbr.database.tables import KEYS, RawRow
from lbr.messages.system import Role

_LANGUAGE = re.compile(r"[a-z]{2}[a-z0-9-]{0,18}")
_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")

MOST_COUNTS = 16383
"""Fourteen bits: what a servo's position has at most."""
LONGEST_LABEL = 40


class Read(Struct):
    """A row as it was read; in `unread` columns are stand-ins, and in `wrong` ones what is against others."""

    table: str
    label: str
    row: Any
    unread: frozenset[str]
    wrong: set[str]


def decode(
    table: str, raw: Sequence[RawRow], reading: Callable[[RowReader, RawRow], Any], problems: list[Problem]
) -> tuple[Read, ...]:
    """Decode a table's rows, noting what is wrong with each."""
    found: list[Read] = []
    for values in raw:
        reader = RowReader(table, KEYS[table], values, problems)
        row = reading(reader, values)
        found.append(Read(table, reader.label, row, frozenset(reader.bad), set(reader.bad)))
    return tuple(found)


def robot(reader: RowReader, values: RawRow) -> RobotRow:
    """Read a robot's row; a latch that is not exactly 0 is engaged."""
    reader.flag("estop_engaged")
    return RobotRow(
        name=reader.name("name"),
        model=reader.text("model"),
        description=reader.text("description"),
        owner=reader.text("owner"),
        last_start=reader.text("last_start", null=True),
        last_shutdown=reader.text("last_shutdown", null=True),
        estop_engaged=values.get("estop_engaged") != 0,
        estop_reason=reader.text("estop_reason"),
    )


def capability(reader: RowReader, values: RawRow) -> CapabilityRow:
    """Read a capability's row."""
    name = reader.name("name")
    if name == "executive":
        reader.wrong("name", "'executive' is lbr itself: choose another name")
    reader.json_object("settings")
    return CapabilityRow(
        name=name,
        kind=reader.name("kind"),
        enabled=reader.flag("enabled"),
        settings=str(values.get("settings")),
        restart=reader.choice("restart", get_args(Restart)),
        needs=reader.json_texts("needs"),
        help=reader.text("help"),
    )


def channel(reader: RowReader, _: RawRow) -> ChannelRow:
    """Read a channel's row."""
    return ChannelRow(
        source=reader.end("source"),
        target=reader.end("target"),
        rate_hz=reader.rate("rate_hz"),
        history=reader.whole("history", 1, 64),
        enabled=reader.flag("enabled"),
    )


def device(reader: RowReader, _: RawRow) -> DeviceRow:
    """Read a device's row."""
    address = reader.text("address", empty=False)
    if len(address) > 500 or not address.isprintable():
        reader.wrong("address", "is not an address (printable, at most 500 characters)")
    return DeviceRow(
        name=reader.name("name"),
        type=reader.name("type"),
        address=address,
        settings=reader.json_object("settings"),
    )


def verb(reader: RowReader, values: RawRow) -> VerbRow:
    """Read a verb's row."""
    word = reader.matching("word", _WORD, "a word (letters, digits, underscores; at most 40)")
    payload = None if values.get("payload") is None else reader.json_object("payload")
    pattern = reader.text("pattern")
    if pattern:
        _check_pattern(reader, word, pattern, payload or {})
    elif reader.good("pattern"):
        reader.wrong("pattern", "is empty")
    return VerbRow(
        word=word,
        pattern=pattern,
        target=reader.end("target"),
        role=reader.choice("role", get_args(Role)),
        help=reader.text("help"),
        payload=payload,
    )


def _check_pattern(reader: RowReader, word: str, text: str, payload: dict[str, Any]) -> None:
    try:
        pattern = patterns.parse(text)
    except ValueError as err:
        reader.wrong("pattern", f"'{shown(text)}': {err}")
        return
    if reader.good("word") and pattern.word != word:
        reader.wrong("pattern", f"begins with '{pattern.word}', but the word of this row is '{word}'")
    for field in pattern.fields:
        if field in payload:
            reader.wrong("payload", f"sets '{field}', which the pattern binds: leave it out of one of them")


def external_command(reader: RowReader, values: RawRow) -> ExternalCommandRow:
    """Read an external command's row."""
    argv = reader.json_texts("argv")
    if reader.good("argv") and not (argv and argv[0]):
        reader.wrong("argv", "names no program")
    return ExternalCommandRow(
        name=reader.name("name"),
        argv=argv,
        blocking=reader.flag("blocking"),
        enabled=reader.flag("enabled"),
        help=reader.text("help"),
        arguments=_arguments(reader) if values.get("arguments") is not None else (),
        role=reader.choice("role", get_args(Role)),
    )


def _arguments(reader: RowReader) -> tuple[Argument, ...]:
    allowed = reader.json_list("arguments")
    if reader.good("arguments") and (fault := arguments.fault(allowed)):
        reader.wrong("arguments", fault)
    return tuple(one if isinstance(one, str) else tuple(one) for one in allowed) if reader.good("arguments") else ()


def phrase(reader: RowReader, _: RawRow) -> PhraseRow:
    """Read a phrase's row."""
    return PhraseRow(
        name=reader.name("name"),
        language=reader.matching("language", _LANGUAGE, "a language tag in small letters, such as en"),
        text=reader.text("text", empty=False),
    )


def choreography(reader: RowReader, _: RawRow) -> ChoreographyRow:
    """Read one move of a dance."""
    return ChoreographyRow(
        dance=reader.name("dance"),
        step=reader.whole("step", 1, 10_000),
        power=reader.within("power", 0.0, 1.0),
        angle_deg=reader.within("angle_deg", -360.0, 360.0),
        beats=reader.whole("beats", 1, 64),
    )


def calibration(reader: RowReader, _: RawRow) -> CalibrationRow:
    """Read a calibration's row."""
    return CalibrationRow(
        device=reader.name("device"),
        name=reader.name("name"),
        value=reader.number("value"),
        measured_at=reader.text("measured_at"),
    )


def joint(reader: RowReader, _: RawRow) -> JointRow:
    """Read a joint's row."""
    lower, upper = reader.within("lower_rad", -10.0, 10.0), reader.within("upper_rad", -10.0, 10.0)
    if reader.good("lower_rad", "upper_rad") and not lower < upper:
        reader.wrong("upper_rad", f"{upper:g} is not above lower_rad, {lower:g}")
    speed = reader.within("speed_rps", 0.0, 100.0)
    if reader.good("speed_rps") and not speed > 0.0:
        reader.wrong("speed_rps", "0 would never get anywhere")
    return JointRow(
        name=reader.name("name"),
        device_id=reader.whole("device_id", 0, 253),
        side=reader.choice("side", get_args(Side)),
        sign=reader.choice("sign", (1, -1)),
        zero_rad=reader.within("zero_rad", -10.0, 10.0),
        lower_rad=lower,
        upper_rad=upper,
        speed_rps=speed,
    )


def motion(reader: RowReader, values: RawRow) -> MotionRow:
    """Read a motion's row; slot and the time for it go together."""
    slotted = values.get("slot") is not None or values.get("slot_s") is not None
    return MotionRow(
        name=reader.name("name"),
        help=reader.text("help"),
        lead_in=reader.name("lead_in") if values.get("lead_in") != "" else "",
        lead_out=reader.name("lead_out") if values.get("lead_out") != "" else "",
        slot=reader.whole("slot", 1, 255) if slotted else None,
        slot_s=_slot_s(reader) if slotted else None,
        limp=reader.flag("limp"),
        builtin=reader.flag("builtin"),
    )


def motion_step(reader: RowReader, _: RawRow) -> MotionStepRow:
    """Read a key frame."""
    duration_s = reader.within("duration_s", 0.0, 60.0)
    if reader.good("duration_s") and not duration_s > 0.0:
        reader.wrong("duration_s", "0 is no time to get anywhere")
    return MotionStepRow(
        motion=reader.name("motion"),
        step=reader.whole("step", 1, 10_000),
        duration_s=duration_s,
        positions=_positions(reader),
    )


def motor(reader: RowReader, _: RawRow) -> MotorRow:
    """Read a motor's row."""
    lowest, highest = reader.whole("lowest", 0, MOST_COUNTS), reader.whole("highest", 0, MOST_COUNTS)
    if reader.good("lowest", "highest") and not lowest < highest:
        reader.wrong("highest", f"{highest} is not above lowest, {lowest}")
    return MotorRow(
        layer=reader.name("layer"),
        id=reader.whole("id", 0, 253),
        name=_label(reader),
        description=reader.text("description"),
        initial=reader.whole("initial", 0, MOST_COUNTS),
        lowest=lowest,
        highest=highest,
        rest=reader.whole("rest", 0, MOST_COUNTS),
        inverted=reader.flag("inverted"),
        builtin=reader.flag("builtin"),
    )


def button(reader: RowReader, values: RawRow) -> ButtonRow:
    """Read a button's row."""
    return ButtonRow(
        id=reader.whole("id", 0, 9999),
        name=_label(reader),
        button=reader.text("button"),
        motion=reader.name("motion") if values.get("motion") != "" else "",
        builtin=reader.flag("builtin"),
    )


def _label(reader: RowReader) -> str:
    name = reader.text("name", empty=False)
    if reader.good("name") and len(name) > LONGEST_LABEL:
        reader.wrong("name", f"is longer than {LONGEST_LABEL} characters")
    return name


def _slot_s(reader: RowReader) -> float:
    slot_s = reader.within("slot_s", 0.0, 600.0)
    if reader.good("slot_s") and not slot_s > 0.0:
        reader.wrong("slot_s", "0 is no time to play anything")
    return slot_s


def _positions(reader: RowReader) -> dict[str, float]:
    positions = reader.json_object("positions")
    for name, angle in positions.items():
        if isinstance(angle, bool) or not isinstance(angle, int | float) or not -10.0 <= angle <= 10.0:
            reader.wrong("positions", f"'{shown(name)}': '{shown(angle)}' is not an angle in radians")
    return {name: float(angle) for name, angle in positions.items()} if reader.good("positions") else {}
