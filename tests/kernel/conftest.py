"""Devices played to the kernel that these tests run on; where that cannot be, they are skipped and say why."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support import packages
from tests.support.usb import rig, vhci

LIMIT_S = 600.0
"""An emulated processor is thirty times slower than a real one."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "kernel" in item.path.parts and item.get_closest_marker("timeout") is None:
            item.add_marker(pytest.mark.timeout(LIMIT_S))


@pytest.fixture(scope="session")
def played() -> None:
    """Skip where no USB device can be played."""
    if why := vhci.why_not():
        pytest.skip(why)


@pytest.fixture(scope="session")
def service(played: None) -> str:
    """Return the service's user; skip where there is none."""
    if not (user := rig.service_user()):
        pytest.skip("no user 'lbr' here: type lbr service install")
    return user


@pytest.fixture(scope="module")
def place() -> Iterator[Path]:
    """Return a folder that other users may enter."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as name:
        Path(name).chmod(0o755)
        yield Path(name)


@pytest.fixture(scope="module")
def outside(place: Path) -> Iterator[None]:
    """The packages of drivers outside lbr, for this process and for what it starts."""
    with packages.beside(place, "roboclaw", "so101") as path, pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", path)
        yield
