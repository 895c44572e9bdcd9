"""Things that appear and vanish, and what ultrasonic sensors make of legs, table tops and walls at a slant."""

import pytest

from lbr.errors import InputError
from lbr.simulation.engine import Engine
from lbr.simulation.messages import WorldBox
from lbr.simulation.room import BoxSettings, on_legs, post
from lbr.simulation.settings import StartPose, Ultrasonic, WorldSettings

EXACT = Ultrasonic(noise_m=0.0)


def world(*walls, **settings):
    return Engine(WorldSettings(**{"walls": walls, "dock": None, "ultrasonic": EXACT, **settings}))


def box(name="somebody", x=1.0, y=0.0, size=0.4, **more):
    return WorldBox(name=name, x_m=x, y_m=y, length_m=size, width_m=size, **more)


def ahead(engine):
    engine.step(0, 0, 0.04)
    return engine.ranges_m["forward"]


def test_what_appears_is_seen_and_what_vanishes_is_not():
    engine = world()
    assert ahead(engine) is None
    engine.place(box())
    assert ahead(engine) == pytest.approx(1.0 - 0.2 - 0.215)
    assert [thing.name for thing in engine.scene().walls] == ["somebody"]
    engine.place(box(x=2.0, yaw_rad=0.0))
    assert ahead(engine) == pytest.approx(2.0 - 0.2 - 0.215)
    engine.remove("somebody")
    assert ahead(engine) is None
    assert engine.scene().walls == ()


def test_what_appears_can_be_bumped_into():
    engine = world()
    engine.step(0.5, 0.5, 1.0)
    engine.place(box(x=engine.pose().x_m + 0.8, size=0.5))
    for _ in range(100):
        engine.step(0.5, 0.5, 0.02)
    pose = engine.pose()
    assert pose.touching
    assert abs(pose.speed_mps) < 0.05


def test_four_things_fit_and_a_fifth_is_refused_by_name():
    engine = world()
    for number in range(4):
        engine.place(box(f"thing {number}", x=1.0 + number))
    with pytest.raises(InputError, match=r"4 things are placed already .*thing 2"):
        engine.place(box("one more", x=-2.0))
    engine.place(box("thing 2", x=-2.0))
    engine.remove("thing 0")
    engine.place(box("one more", x=1.0))
    assert len(engine.scene().walls) == 4
    assert ahead(engine) == pytest.approx(0.585)


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        (box(x=0.3), "where the robot is"),
        (box(kind="cylinder"), "only boxes"),
        (box(x=5.0, size=10.0), "where the robot"),
    ],
)
def test_what_cannot_appear_is_refused(thing, said):
    with pytest.raises(InputError, match=said):
        world().place(thing)


def test_nothing_of_that_name_to_remove():
    engine = world()
    engine.place(box())
    with pytest.raises(InputError, match="nothing called 'nobody' was placed; there is: somebody"):
        engine.remove("nobody")


def test_a_chair_leg_as_thick_as_a_thumb_is_seen():
    for aside in (-0.1, -0.03, 0.0, 0.05, 0.12):
        engine = world(post("leg", (1.2, aside), 0.025, 0.45, "#5a4632"))
        assert engine.ranges_m["forward"] == pytest.approx(1.2 - 0.215, abs=0.03)


def test_a_table_top_is_seen_from_afar_and_missed_from_near():
    table = on_legs(
        BoxSettings(name="table", x_m=4.0, y_m=0.0, length_m=1.0, width_m=2.4, bottom_m=0.72, height_m=0.03), 0.05
    )
    assert world(*table).ranges_m["forward"] == pytest.approx(3.5 - 0.215, abs=0.6)
    under = world(*table, start=StartPose(x_m=2.6)).ranges_m["forward"]
    assert under is None


def test_what_is_only_seen_neither_echoes_nor_stops():
    rug = BoxSettings(name="rug", x_m=1.0, y_m=0.0, length_m=1.0, width_m=1.0, height_m=2.0, solid=False)
    engine = world(rug)
    assert ahead(engine) is None
    engine.step(0.5, 0.5, 3.0)
    assert engine.pose().x_m > 1.2
    assert not engine.touching()


def test_a_smooth_wall_at_a_slant_throws_the_sound_away():
    wall = BoxSettings(name="wall", x_m=2.0, y_m=0.0, length_m=0.1, width_m=12.0, yaw_rad=0.9)
    assert world(wall).ranges_m["forward"] is not None
    assert world(wall, ultrasonic=Ultrasonic(grazing_deg=30.0)).ranges_m["forward"] is None
    facing = BoxSettings(name="wall", x_m=2.0, y_m=0.0, length_m=0.1, width_m=12.0)
    assert world(facing, ultrasonic=Ultrasonic(noise_m=0.0, grazing_deg=30.0)).ranges_m["forward"] == pytest.approx(
        1.735
    )


def test_readings_fail_as_often_as_is_set_and_the_same_each_time():
    wall = BoxSettings(name="wall", x_m=3.0, y_m=0.0, length_m=0.1, width_m=8.0)

    def run(seed):
        engine = world(wall, seed=seed, ultrasonic=Ultrasonic(dropout=0.2, noise_per_m=0.02))
        return [ahead(engine) for _ in range(500)]

    seen = run(1)
    assert seen.count(None) == pytest.approx(100, abs=35)
    assert seen == run(1) != run(2)
    found = [value - 2.735 for value in seen if value is not None]
    assert (sum(value**2 for value in found) / len(found)) ** 0.5 == pytest.approx(0.008 + 2.735 * 0.02, rel=0.15)
