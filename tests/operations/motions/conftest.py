import pytest

from tests.operations.motions.motions_bench import Stage, World


@pytest.fixture
def world():
    return World()


@pytest.fixture
def stage(world):
    return Stage(world)
