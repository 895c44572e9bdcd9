"""Reads and writes the text form of RoboPlus motion files (`.mtn`). Pure.

    type=motion                          one line for each, in any order
    version=1.01
    enable=0 1 1 …                       which of the servos 0 to 25 are present
    motor_type=0 0 0 …                   0: 1024 counts over 300 degrees; others are finer
    page_begin
    name=Bow
    compliance=5 5 5 …                   the softness of each servo
    play_param=0 0 1 1.0 32              next page, page after a stop, times, speed, inertial force
    step=512 235 788 … 0.000 1.000       a position of each servo, the pause afterwards, the time to get there
    page_end
    (two bytes: a checksum)

Derived from descriptions and from programs that read such files. Lines end with LF. The checksum is the ones'
complement of the 16-bit sum of all bytes before it, the mark of UTF-8 included. Its high byte comes first.
"""

import math
import re
from typing import Literal, NamedTuple

from lbr.errors import InputError
from lbr.messages.rows import short

SERVOS = 26
MOST_SERVOS = 64
MOST_COUNTS = 65_535
MOST_SECONDS = 3600.0
MOST_PAGES = 255
LONGEST_NAME = 200
BOM = b"\xef\xbb\xbf"
_WHOLE = re.compile(r"\d{1,5}", re.ASCII)
_NUMBER = re.compile(r"\d{1,6}(?:[.,]\d{1,6})?", re.ASCII)
_HEAD = {"type", "version", "enable", "motor_type"}
_OF_PAGE = {"name", "compliance", "play_param", "step"}
_PAGE_END = re.compile(rb"(?:^|[\r\n])[\0\t ]*page_end[\0\t ]*(?:\r\n|\r|\n|\Z)")
_LINE_END = re.compile(rb"\r\n|\r")
_HEX = re.compile(rb"[0-9A-Fa-f]{2}")
_LONGEST_CHECKSUM = 12
"""Two bytes, or an editor's text in their place: `\\82\\09`, `\\u0082\\u0009`."""
Checksum = Literal["right", "stale", "missing"]


class Step(NamedTuple):
    """A position of each servo, by its number; the time to get there, and the pause afterwards."""

    positions: tuple[int, ...]
    pause_s: float
    time_s: float
    line: int = 0


class Page(NamedTuple):
    """A motion, or a part of one: `next` and `exit` are numbers of pages, counted from 1; 0 ends there."""

    name: str
    steps: tuple[Step, ...]
    compliance: tuple[int, ...] = ()
    next: int = 0
    exit: int = 0
    times: int = 1
    speed: float = 1.0
    inertia: int = 32


class MtnFile(NamedTuple):
    """A whole file; the positions of servos that are not `enabled` have no meaning."""

    pages: tuple[Page, ...]
    enabled: tuple[int, ...]
    motor_types: tuple[int, ...] = ()
    version: str = "1.01"
    checksum: Checksum = "right"


def checksum(body: bytes) -> bytes:
    """Return the two bytes that follow the lines of a file."""
    return (~sum(body) & 0xFFFF).to_bytes(2, "big")


def parse(content: bytes) -> MtnFile:
    """Return the content of a file; raise InputError naming an invalid line."""
    body, end = _parted(content)
    lines = _Lines(body)
    head: dict[str, str] = {}
    at: dict[str, int] = {}
    pages: list[Page] = []
    width = SERVOS
    while (entry := lines.next()) is not None:
        key, value = entry
        if key == "page_begin":
            if len(pages) == MOST_PAGES:
                raise lines.wrong(f"it has more than {MOST_PAGES} pages")
            if not pages:
                width = len(_wholes(lines, head.get("enable", "0 " * SERVOS), "enable", at))
            pages.append(_page(lines, len(pages) + 1, width))
        elif key in _HEAD and not pages and key not in head:
            head[key], at[key] = value, lines.number
        else:
            raise lines.wrong(f"'{short(key)}' does not belong here; is it a motion file?")
    if head.get("type") != "motion":
        raise InputError("line 1: it does not say type=motion; is it a motion file?")
    if not pages:
        raise InputError(f"line {lines.number}: the file has no page; it may have been cut off")
    flags = _wholes(lines, head.get("enable", "1 " * width), "enable", at)
    types = _wholes(lines, head.get("motor_type", ""), "motor_type", at)
    enabled = tuple(servo for servo, flag in enumerate(flags) if flag)
    return MtnFile(tuple(pages), enabled, tuple(types), head.get("version", ""), _judged(body, end))


def write(file: MtnFile) -> bytes:
    """Return the content of a file; times to the millisecond."""
    width = max((len(step.positions) for page in file.pages for step in page.steps), default=SERVOS)
    types = file.motor_types or (0,) * width
    lines = [
        "type=motion",
        f"version={file.version}",
        f"enable={_listed(int(servo in file.enabled) for servo in range(width))}",
        f"motor_type={_listed(types)}",
    ]
    for page in file.pages:
        lines += [
            "page_begin",
            f"name={' '.join(page.name.split())}",
            f"compliance={_listed(page.compliance or (5,) * width)}",
            f"play_param={page.next} {page.exit} {page.times} {page.speed:.3f} {page.inertia}",
            *(f"step={_listed(one.positions)} {one.pause_s:.3f} {one.time_s:.3f}" for one in page.steps),
            "page_end",
        ]
    body = BOM + "".join(f"{line}\n" for line in lines).encode()
    return body + checksum(body)


def _parted(content: bytes) -> tuple[bytes, bytes]:
    """Return the lines of a file, ended by LF, and the bytes in the place of its checksum."""
    content = _utf8(content)
    ends = list(_PAGE_END.finditer(content))
    at = ends[-1].end() if ends else len(content)
    if len(content) - at > _LONGEST_CHECKSUM or content[at:].startswith(b"page_begin"):
        at = len(content)  # more than a checksum follows: its line is read, and named in an error
    return _LINE_END.sub(b"\n", content[:at]), content[at:]


def _judged(body: bytes, end: bytes) -> Checksum:
    """Judge the checksum; an editor may have written its bytes as text, or added more after them."""
    right = checksum(BOM + body if body.endswith(b"\n") else BOM + body + b"\n")
    if not end.strip(b"\0\r\n\t "):
        return "right" if end.startswith(right) else "missing"
    is_right = end.startswith(right) or bytes.fromhex(b"".join(_HEX.findall(end)).decode())[-2:] == right
    return "right" if is_right else "stale"


def _page(lines: "_Lines", number: int, width: int) -> Page:
    fields: dict[str, str] = {}
    steps: list[Step] = []
    compliance: tuple[int, ...] = ()
    played = Page("", ())
    begun = lines.number
    while (found := lines.next()) is not None:
        key, value = found
        if key == "page_end":
            return played._replace(name=_printable(fields.get("name", "")), steps=tuple(steps), compliance=compliance)
        if key not in _OF_PAGE or (key in fields and key != "step"):
            raise lines.wrong(f"'{short(key)}' does not belong into page {number}, which has no page_end before it")
        fields[key] = value
        if key == "step":
            steps.append(_step(lines, value, width))
        elif key == "compliance":
            compliance = tuple(_wholes(lines, value, key, {}))
        elif key == "play_param":
            played = _played(lines, value)
    raise InputError(
        f"line {lines.number}: the file ends within page {number}, which began in line {begun}: page_end is missing"
    )


def _printable(name: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in name.strip())[:LONGEST_NAME]


def _step(lines: "_Lines", text: str, width: int) -> Step:
    parts = text.split()
    if len(parts) != width + 2:
        raise lines.wrong(f"a step has {width} positions, a pause and a time; this one has {len(parts)} numbers")
    positions = tuple(_whole(lines, part, "position") for part in parts[:width])
    pause_s, time_s = (_number(lines, part, "seconds", MOST_SECONDS) for part in parts[width:])
    return Step(positions, pause_s, time_s, lines.number)


def _played(lines: "_Lines", text: str) -> Page:
    parts = text.split()
    if len(parts) != 5:
        raise lines.wrong(f"play_param has 5 numbers; this one has {len(parts)}")
    after, after_stop, times, inertia = (_whole(lines, parts[index], "play_param") for index in (0, 1, 2, 4))
    speed = _number(lines, parts[3], "speed", 1000.0)
    if speed <= 0.0:
        raise lines.wrong("a speed of 0 would never get anywhere")
    return Page("", (), next=after, exit=after_stop, times=times, speed=speed, inertia=inertia)


def _wholes(lines: "_Lines", text: str, meaning: str, at: dict[str, int]) -> list[int]:
    parts = text.split()
    if len(parts) > MOST_SERVOS or (meaning == "enable" and not parts):
        raise lines.wrong(f"{meaning} has {len(parts)} numbers, and 1 to {MOST_SERVOS} may be", at.get(meaning))
    return [_whole(lines, part, meaning, at.get(meaning)) for part in parts]


def _whole(lines: "_Lines", text: str, what: str, line: int | None = None) -> int:
    if not _WHOLE.fullmatch(text) or int(text) > MOST_COUNTS:
        raise lines.wrong(f"{what}: '{short(text)}' is not a whole number from 0 to {MOST_COUNTS}", line)
    return int(text)


def _number(lines: "_Lines", text: str, what: str, most: float) -> float:
    found = float(text.replace(",", ".")) if _NUMBER.fullmatch(text) else math.nan
    if not found <= most:
        raise lines.wrong(f"'{short(text)}' is not a number of {what} from 0 to {most:g}")
    return found


def _listed(numbers: object) -> str:
    return " ".join(map(str, numbers))  # type: ignore[call-overload]


class _Lines:
    """Yields one line after the other, and knows its number for an error."""

    def __init__(self, content: bytes) -> None:
        self._lines = content.split(b"\n")
        self.number = 0

    def next(self) -> tuple[str, str] | None:
        """Return the key of the next line that is not empty, and the text after its `=`."""
        while self.number < len(self._lines):
            line = self._lines[self.number].strip(b"\0\t ")
            self.number += 1
            if line:
                key, _, value = line.partition(b"=")
                return _text(key).strip(), _text(value)
        return None

    def wrong(self, text: str, line: int | None = None) -> InputError:
        """Return an error that names the line."""
        return InputError(f"line {line or self.number}: {text}")


def _utf8(content: bytes) -> bytes:
    """Return the lines of a file as bytes: only names can be other than ASCII, and each may have its own encoding."""
    if content[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        try:
            return content.decode("utf-16").encode()
        except UnicodeError as err:
            raise InputError("line 1: it begins as UTF-16, and goes on as something else") from err
    return content.removeprefix(BOM)


def _text(line: bytes) -> str:
    for encoding in ("utf-8", "cp949"):
        try:
            return line.decode(encoding)
        except UnicodeDecodeError:
            continue
    return line.decode("latin-1")
