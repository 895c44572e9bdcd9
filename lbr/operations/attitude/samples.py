"""Samples of a calibration, while they are collected and as files: CSV below `$LBR_HOME/calibration`."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import islice
from pathlib import Path

from lbr.errors import InputError
from lbr.messages.imu import ImuSample
from lbr.messages.units import Vector

FOLDER = "calibration"
SECTORS = 24
MOST = 4000
MOST_FILE_BYTES = 4 * 1024 * 1024
MOST_KEPT = 50
"""The most files of samples that calibrations leave, each with its picture; the oldest are deleted."""
HEADER = ("time_s", "mag_x_ut", "mag_y_ut", "mag_z_ut", "accel_x_mps2", "accel_y_mps2", "accel_z_mps2", "turned_deg")
MOST_NUMBER = 1e6
SHORT_HEADER = ("x", "y", "z")
"""The columns of the magnetic field in files of other programs; case is ignored."""
_OWN = re.compile(r"mag-\d{8}-\d{6}\.csv")


def coverage_of(angles_deg: Sequence[float]) -> float:
    """Return the fraction of a full turn that these angles cover."""
    return len({int(angle % 360.0 / (360.0 / SECTORS)) % SECTORS for angle in angles_deg}) / SECTORS


@dataclass(slots=True)
class Samples:
    """Magnetic fields along the sensor's axes, each with its upward vector."""

    mags_ut: list[Vector] = field(default_factory=list)
    ups: list[Vector] = field(default_factory=list)
    times_s: list[float] = field(default_factory=list)
    turned_deg: list[float] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.mags_ut)

    @property
    def coverage(self) -> float:
        """Return the fraction of a full turn that the turned angles cover."""
        return coverage_of(self.turned_deg)

    def take(self, sample: ImuSample, turned_deg: float, every_s: float) -> None:
        """Store a sample that has a field, unless the last one is too recent or there are too many."""
        if sample.mag_ut is None or sample.accel_mps2 is None or len(self) >= MOST:
            return
        if self.times_s and sample.time_s - self.times_s[-1] < every_s - 1e-6:
            return
        self.mags_ut.append(sample.mag_ut)
        self.ups.append(sample.accel_mps2)
        self.times_s.append(sample.time_s)
        self.turned_deg.append(turned_deg)

    def thinned(self, most: int) -> "Samples":
        """Return at most this many of them, evenly chosen."""
        if len(self) <= most:
            return self
        chosen = [index * len(self) // most for index in range(most)]
        return Samples([self.mags_ut[i] for i in chosen], [self.ups[i] for i in chosen])


def save(home: str, samples: Samples, when: datetime) -> Path:
    """Write a file with the date in its name and return its path; delete the oldest of such files."""
    path = _folder(home) / f"mag-{when:%Y%m%d-%H%M%S}.csv"
    rows = zip(samples.times_s, samples.mags_ut, samples.ups, samples.turned_deg, strict=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for time_s, mag, up, turned in rows:
            numbers = (*mag, *up, turned)
            writer.writerow([f"{time_s:.3f}", *(f"{number:.4f}" for number in numbers)])
    own = sorted(file for file in path.parent.glob("mag-*.csv") if _OWN.fullmatch(file.name) and file != path)
    for old in own[: 1 - MOST_KEPT]:
        old.unlink(missing_ok=True)
        for picture in (".svg", ".png"):  # of earlier versions
            old.with_suffix(picture).unlink(missing_ok=True)
    return path


def load(home: str, name: str, up: Vector) -> Samples:
    """Read a file by its name; `up` is for a file without an accelerometer. Raise InputError."""
    path = _place(home, name)
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path} is not a file")
        if path.stat().st_size > MOST_FILE_BYTES:
            raise InputError(f"{name} has more than {MOST_FILE_BYTES // 1024} KiB; it is not a file of samples")
        with path.open(newline="", encoding="utf-8") as file:
            return _read(name, list(islice(csv.reader(file), MOST + 1)), up)
    except FileNotFoundError as err:
        raise InputError(f"there is no {path}; {_offer(path.parent)}", "unknown_name") from err
    except (OSError, UnicodeDecodeError, csv.Error) as err:
        raise InputError(f"{path} cannot be read: {err}") from err


def _folder(home: str) -> Path:
    path = Path(home) / FOLDER
    path.mkdir(mode=0o700, exist_ok=True)
    return path


def _place(home: str, name: str) -> Path:
    """Return the file of a name, if it is in that folder."""
    folder = _folder(home).resolve()
    allowed = f"a source is '-' (turn), '-c' (turn, and only draw) or the name of a file in {folder}"
    if name.startswith("-") or "\x00" in name or Path(name).name != name or name in {"", ".", ".."}:
        raise InputError(f"'{name}' is not a source; {allowed}")
    path = (folder / name).resolve()
    if path.parent != folder:
        raise InputError(f"'{name}' leads out of {folder}; {allowed}")
    return path


def _offer(folder: Path) -> str:
    names = sorted(path.name for path in folder.glob("*.csv"))
    return f"there are {', '.join(names[-5:])}" if names else "it has no files yet; '/m/300/-' makes one"


def _read(name: str, rows: Sequence[Sequence[str]], up: Vector) -> Samples:
    if not rows:
        raise InputError(f"{name} is empty")
    header = [column.strip().lower() for column in rows[0]]
    columns = _columns(header, HEADER[1:4]) or _columns(header, SHORT_HEADER)
    if columns is None:
        raise InputError(f"{name} has no columns {', '.join(HEADER[1:4])} in its first line")
    ups, turned = _columns(header, HEADER[4:7]), _columns(header, HEADER[7:])
    samples = Samples()
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        mag = _numbers(name, number, row, columns)
        accel = _numbers(name, number, row, ups) if ups else up
        samples.mags_ut.append((mag[0], mag[1], mag[2]))
        samples.ups.append((accel[0], accel[1], accel[2]))
        if turned:
            samples.turned_deg.append(_numbers(name, number, row, turned)[0])
    return samples


def _columns(header: Sequence[str], names: Sequence[str]) -> list[int] | None:
    return [header.index(name) for name in names] if all(name in header for name in names) else None


def _numbers(name: str, line: int, row: Sequence[str], columns: Sequence[int]) -> list[float]:
    try:
        numbers = [float(row[column]) for column in columns]
    except (ValueError, IndexError) as err:
        raise InputError(f"{name}, line {line}: numbers are expected, not {','.join(row)[:80]!r}") from err
    if not all(abs(number) <= MOST_NUMBER for number in numbers):
        raise InputError(
            f"{name}, line {line}: {','.join(row)[:80]!r} holds a number that is not finite, or far too large"
        )
    return numbers
