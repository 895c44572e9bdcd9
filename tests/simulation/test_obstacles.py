"""Things that appear in the running world, as a client asks for them."""

import threading

import pytest

from lbr.simulation.requests import PlaceRequest, RemoveRequest
from tests.simulation.world_bench import Bench


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path, walls=())
    made.world.open()
    yield made
    made.world.close()


def test_a_thing_that_is_placed_is_seen_until_it_is_removed(bench):
    call = bench.ask("place", PlaceRequest(x_m=1.2, y_m=0.0))
    assert call.answer.things == ("obstacle",)
    assert bench.until(lambda: (bench.world._physics.ranges_m["forward"] or 9.0) < 1.2)
    assert bench.until(lambda: [wall.name for wall in bench.ctx.said("scene")[-1].walls] == ["obstacle"])
    assert bench.ctx.events[-1] == ("world_changed", "'obstacle' stands in the world")
    assert bench.ask("remove", RemoveRequest()).answer.things == ()
    assert bench.until(lambda: bench.world._physics.ranges_m["forward"] is None)


@pytest.mark.parametrize(
    ("name", "message", "reason"),
    [
        ("place", PlaceRequest(x_m=0.1, y_m=0.0), "where the robot is"),
        ("remove", RemoveRequest(name="ghost"), "nothing called 'ghost'"),
    ],
)
def test_what_cannot_be_is_refused_with_a_reason(bench, name, message, reason):
    assert reason in bench.ask(name, message).refused


def test_things_come_and_go_while_the_world_runs(bench):
    for turn in range(30):
        assert bench.ask("place", PlaceRequest(name=f"box {turn % 3}", x_m=1.0 + turn / 10, y_m=0.5)).answer
        threading.Event().wait(0.002)
    boxes = {"box 0", "box 1", "box 2"}
    assert bench.until(lambda: {wall.name for wall in bench.ctx.said("scene")[-1].walls} == boxes)
