"""Fallen, the simulated humanoids get up by the motions of their rows."""

import pytest

from tests.support import needs

needs.modules("mujoco")

from tests.models import get_up  # noqa: E402


@pytest.mark.parametrize(("robot", "side"), [(robot, side) for robot, ways in get_up.WAYS.items() for side in ways])
def test_it_gets_up_from_where_it_has_fallen(robot, side):
    assert get_up.gets_up(robot, side, 7)


def test_stopped_in_the_middle_it_holds():
    one = get_up.fallen("bioloid", "face", 7)
    way = get_up.frames(one, "get_up_face")
    one.play(way, 4.0)
    one.stop()
    one.run(1.0)
    rests = one.engine.pose().joints
    one.run(0.5)
    assert all(abs(angle - rests[name]) < 0.02 for name, angle in one.engine.pose().joints.items())
