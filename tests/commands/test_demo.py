"""`lbr demo`: the tours of the shipped robots, and what is refused."""

import pytest

from lbr.executive.planning import profile as profiles
from tests.support import programs
from tests.support.robot import LBR, environment, prepare
from tests.support.waiting import HANG_S, until

TOURS = [name for name in profiles.names() if profiles.load(name).demo]
SHORT = """robot = "lbr"
simulate = true
demo = ["send s", "send nonsense"]
"""


def demo(home, profile, limit_s=HANG_S):
    argv = [*LBR, "demo", profile]
    return programs.run(argv, env=environment(home), capture_output=True, text=True, timeout=limit_s, check=False)


@pytest.fixture
def home(tmp_path):
    return prepare(tmp_path)


def test_a_tour_prints_what_it_types_and_what_comes_of_it_and_ends_the_robot(home, tmp_path):
    profile = tmp_path / "short.toml"
    profile.write_text(SHORT)
    done = demo(home, str(profile))
    typed = [line for line in done.stdout.splitlines() if line.startswith("$")]
    assert typed == [f"$ lbr run {profile}", "$ lbr send s", "$ lbr send nonsense"]
    assert "\nstopped\n" in done.stdout
    assert "nonsense" in done.stderr
    assert done.returncode == 1
    until(lambda: not list((home / "run").glob("*.sock")), what="the robot's end")


@pytest.mark.parametrize(("profile", "why"), [("lbr", "'lbr'"), ("bioloid-two-sim", "demo = "), ("nobody", "nobody")])
def test_a_robot_of_iron_and_one_without_a_tour_are_refused(home, profile, why):
    done = demo(home, profile)
    assert (done.returncode, done.stdout) == (2, "")
    assert why in done.stderr


def test_each_shipped_simulation_of_a_robot_has_a_tour():
    assert {"lbr-sim", "bioloid-sim", "uxa90-sim"} <= set(TOURS)


@pytest.mark.timeout(300)
@pytest.mark.parametrize("profile", TOURS)
def test_a_shipped_tour_comes_to_its_end(tmp_path, profile):
    done = demo(prepare(tmp_path, whole=True), profile, 240)
    assert done.returncode == 0, done.stdout + done.stderr
