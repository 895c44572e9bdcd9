"""One attitude capability at rest, for all tests of it."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.operations.attitude.attitude_context import AttitudeContext
from tests.operations.attitude.imu_bench import MadeUpImu


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[AttitudeContext]:
    imu = MadeUpImu(yaw_deg=35.0, bias_dps=(0.4, -0.6, 0.9), hard_iron_ut=(12.0, -9.0, 4.0))
    context = AttitudeContext(tmp_path, imu)
    context.run(1.5)
    yield context
    context.capability.close()
