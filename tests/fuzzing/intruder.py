"""Sessions of those who should not get far: at the local door, and with the credentials of a process."""

from pathlib import Path

import msgspec

from lbr.bus import session
from lbr.capability.config import ProcessConfig

SPY_ROW = (
    "INSERT INTO capability (robot, name, kind) VALUES ('lbr', '{name}', 'spy')",
    "INSERT INTO channel (robot, source, target) VALUES ('lbr', 'drive.state', '{name}.seen')",
)


def spy_rows(name: str = "spy") -> tuple[str, ...]:
    """Return the statements that add a spy to the rows."""
    return tuple(row.format(name=name) for row in SPY_ROW)


def stolen(home: Path, name: str = "spy") -> ProcessConfig:
    """Return the whole document that a spy was started with."""
    return msgspec.json.decode((home / f"{name}.json").read_bytes(), type=ProcessConfig)


def come_in_as(config: ProcessConfig) -> session.Session:
    """Open a session with a process's own endpoint and password."""
    return session.open_client(config.endpoints, config.credentials)
