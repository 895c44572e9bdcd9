"""Numbers measured on one device, written by the capability that measured them."""

from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from typing import Annotated

from msgspec import Meta

from lbr.messages.rows import NOW, Row
from lbr.messages.units import Name


class CalibrationValue(Row, frozen=True, kw_only=True):
    """Numbers measured on a device by calibration, for its driver's next start."""

    TABLE = "calibration"
    KEY = ("device", "name")
    OF = "device"

    device: Annotated[Name, "the measured device"]
    name: Annotated[Name, "the quantity, with its unit as a suffix"]
    value: Annotated[float, Meta(ge=-1e300, le=1e300), "the number"]
    measured_at: Annotated[str, NOW, "when"]

    @property
    def full_name(self) -> str:
        """Return the device's name: the numbers of one measurement are reported together."""
        return f"calibration of '{self.device}'"


def values(rows: Iterable[CalibrationValue]) -> dict[str, float]:
    """Return the numbers by name."""
    return {row.name: row.value for row in rows}


def measured(device: str, found: Mapping[str, float]) -> Iterator[CalibrationValue]:
    """Yield a row for each number that has just been measured on a device."""
    now = datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    for name, value in found.items():
        yield CalibrationValue(device=device, name=name, value=value, measured_at=now)
