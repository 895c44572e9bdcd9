"""Numbers measured on one device, written back by the capability that measured them."""

from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from typing import Annotated

from msgspec import Meta

from lbr.messages.rows import Fault, Others, Row
from lbr.messages.units import Name


def _device(row: "CalibrationValue", others: Others) -> Iterator[Fault]:
    if row.device not in others.names("device"):
        yield "device", f"there is no device '{row.device}'"


class CalibrationValue(Row, frozen=True, kw_only=True):
    """One measured number of a device; `measured_at` is ISO 8601 in UTC."""

    TABLE = "calibration"
    KEY = ("device", "name")
    CHECKS = (_device,)

    device: Name
    name: Name
    value: Annotated[float, Meta(ge=-1e300, le=1e300)]
    measured_at: str

    @property
    def told(self) -> str:
        """Return whose it is: the many numbers of one measurement are told once."""
        return f"calibration of '{self.device}'"


def values(rows: Iterable[CalibrationValue]) -> dict[str, float]:
    """Return the numbers by their names."""
    return {row.name: row.value for row in rows}


def measured(device: str, found: Mapping[str, float]) -> Iterator[CalibrationValue]:
    """Yield a row for each number that was measured on a device now."""
    now = datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    for name, value in found.items():
        yield CalibrationValue(device=device, name=name, value=value, measured_at=now)
