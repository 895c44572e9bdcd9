"""What `lbr new` writes runs at once: its own tests pass, on robots, and it is as clean as lbr itself."""

import json
import os
import re
import subprocess
import sys
import tomllib
from importlib import resources
from pathlib import Path

import pytest

from lbr.commands import scaffold
from lbr.errors import InputError
from tests.docs.pages import ROOT
from tests.support import programs
from tests.support.packages import imported_from, of_project, package
from tests.support.robot import lbr

KINDS = ("robot", "driver", "servos", "wheels", "silent_wheels", "capability")

UNFED = {
    "wheels": ["drive.ranges", "drive.attitude", "odometry.attitude"],
    "silent_wheels": ["drive.ranges", "drive.attitude", "drive.odometry"],
}
"""What a bench of wheels leaves out, as it has no sensor."""


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> dict[str, Path]:
    into = tmp_path_factory.mktemp("new")
    return {what: scaffold.write(what, f"hexa-{what}", into) for what in KINDS}


@pytest.fixture
def environment(written, tmp_path) -> dict[str, str]:
    """Install all of them, beside one another."""
    paths = [of_project(folder, tmp_path / "site") for folder in written.values()]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "LBR_HOME": str(tmp_path / "home")}


def run(*argv: str, cwd: Path, env: dict[str, str]) -> "subprocess.CompletedProcess[str]":
    return programs.run([sys.executable, "-m", *argv], cwd=cwd, env=env, capture_output=True, text=True)


@pytest.mark.slow_start
@pytest.mark.timeout(120)
@pytest.mark.parametrize("what", KINDS)
def test_its_own_tests_pass(what, written, environment):
    done = run("pytest", "-q", "-p", "no:cacheprovider", cwd=written[what], env=environment)
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]


@pytest.mark.slow_start
@pytest.mark.timeout(120)
def test_a_driver_of_a_device_that_seldom_speaks_passes_them_too(tmp_path):
    folder = scaffold.write("driver", "hexa-rain", tmp_path)
    for name, usual, slow in (("twin", "] = 0.1", "] = 30.0"), ("kind", "] = 1.0", "] = 60.0")):
        module = folder / "hexa_rain" / f"{name}.py"
        assert module.read_text().count(usual) == 1
        module.write_text(module.read_text().replace(usual, slow))
    environment = os.environ | {"PYTHONPATH": of_project(folder, tmp_path / "site"), "LBR_HOME": str(tmp_path / "home")}
    done = run("pytest", "-q", "-p", "no:cacheprovider", "-k", "silent or bad_line", cwd=folder, env=environment)
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]


@pytest.mark.slow_start
@pytest.mark.timeout(120)
def test_they_pass_the_checks_that_lbr_passes(written, environment, tmp_path):
    """All of them in one test, so that mypy reads lbr once: what it knows of it is kept in between."""
    ruff = ("--no-cache", "--config", str(ROOT / "pyproject.toml"), ".")
    mypy = ("--strict", "--warn-unreachable", "--cache-dir", str(tmp_path / "mypy"))
    for what, folder in written.items():
        for words in (
            ("ruff", "check", *ruff),
            ("ruff", "format", "--check", *ruff),
            ("mypy", *mypy, f"hexa_{what}", "tests"),
        ):
            done = run(*words, cwd=folder, env=environment)
            assert done.returncode == 0, done.stdout + done.stderr


def test_its_robots_are_listed_and_their_rows_are_good(written, environment, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", environment["PYTHONPATH"])
    home = tmp_path / "home"
    found = {one["name"]: one for one in json.loads(lbr(home, "robots", "--json").stdout)}
    assert [one["fault"] for one in found.values()] == [""] * len(found)
    assert found["hexa_robot"]["profiles"] == ["hexa-robot", "hexa-robot-sim"]
    assert lbr(home, "db", "init").stderr == ""
    checked = json.loads(lbr(home, "db", "check", "--json").stdout)
    mine = {one["robot"].removeprefix("hexa_"): one for one in checked if "hexa" in one["robot"]}
    assert {what: one["problems"] for what, one in mine.items()} == {what: [] for what in KINDS}
    hints = {what: [re.search(r"'(.+?)'", hint)[1] for hint in one["hints"]] for what, one in mine.items()}
    assert hints == {what: UNFED.get(what, []) for what in KINDS}


def test_it_says_what_to_do_next_and_the_page_is_there(tmp_path):
    done = lbr(tmp_path / "home", "new", "driver", "hexa_lamp", "--into", str(tmp_path))
    assert done.returncode == 0, done.stderr
    first, install, start, test, read = done.stdout.splitlines()
    assert first.startswith(f"wrote {tmp_path}/hexa_lamp")
    assert install.endswith(f"pip install -e {tmp_path}/hexa_lamp")
    assert start.endswith("lbr run hexa-lamp-sim")
    assert test.endswith(f"pytest {tmp_path}/hexa_lamp")
    assert "docs/drivers.md" in read
    assert sorted(path.name for path in (tmp_path / "hexa_lamp").iterdir()) == [
        ".gitignore", "README.md", "hexa_lamp", "pyproject.toml", "tests",
    ]  # fmt: skip
    for what in KINDS:
        *_, page = scaffold.next_steps(what, "x", Path("x"))
        assert (ROOT / page.rpartition(", ")[2].split()[0]).is_file()


def test_nothing_is_overwritten_and_nothing_half_written_stays(tmp_path, monkeypatch):
    folder = scaffold.write("robot", "hexa", tmp_path)
    (folder / "README.md").write_text("mine")
    with pytest.raises(InputError, match="is there already, and stays as it is"):
        scaffold.write("robot", "hexa", tmp_path)
    assert (folder / "README.md").read_text() == "mine"
    with pytest.raises(InputError, match=r"there is no folder .*: make it first"):
        scaffold.write("robot", "hexa", tmp_path / "none")
    monkeypatch.setattr(
        scaffold, "_templates", lambda _folder: iter([("a.in", "a"), ("a.in/b.in", "b"), ("a/b.in", "c")])
    )
    with pytest.raises(InputError, match="cannot be written"):
        scaffold.write("robot", "other", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["hexa"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("My_Arm2", "did you mean 'my-arm2'?"),
        ("MyArm", "did you mean 'my-arm'?"),
        ("3d printer", "did you mean 'd-printer'?"),
        ("../evil", "did you mean 'evil'?"),
        ("a--b", "did you mean 'a-b'?"),
        ("", "small letters, digits and single dashes"),
        ("ö", "small letters, digits"),
        ("a" * 31, "30 at most"),
        ("class", "is a word of Python itself: choose another name; did you mean 'my-class'?"),
        ("json", "is a module of Python's own library"),
        ("tests", "is a name of lbr itself"),
        ("lbr-client", "is a name of lbr itself"),
        ("bioloid", "is a robot of package 'lbr' already"),
        ("ultrasonic-ring", "is a kind of capability of package 'lbr' already"),
        ("bioloid-two", "is a launch profile of the robot 'bioloid' already"),
        ("msgspec", "is a module that is installed already"),
    ],
)
def test_a_name_that_cannot_be_is_refused_with_one_that_can(name, said):
    for what in KINDS:
        with pytest.raises(InputError) as caught:
            scaffold.check_name(what, name)
        assert said in str(caught.value)


@pytest.mark.parametrize("name", ["reset", "picture", "estop"])
def test_a_capability_is_called_as_no_word_of_the_console(name):
    with pytest.raises(InputError, match="is a word of the console already"):
        scaffold.check_name("capability", name)
    scaffold.check_name("robot", name)


def test_what_another_package_or_a_file_of_ones_own_has_is_taken(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    (tmp_path / "home" / "capabilities").mkdir(parents=True)
    (tmp_path / "home" / "capabilities" / "greeter.py").touch()
    package(tmp_path / "site", "theirs", brings={"twins": {"claw": "theirs:TWIN"}}, files={})
    with imported_from(tmp_path / "site"):
        for name, said in (("claw", "a type of device of package 'theirs 0.1'"), ("greeter", "of your own already")):
            with pytest.raises(InputError, match=said):
                scaffold.check_name("driver", name)


def test_a_wheel_has_the_templates():
    """What is a file of the package is in the wheel, unless the project file leaves it out."""
    found = {path for path, _ in scaffold._templates(resources.files("lbr.commands") / "templates" / "new")}
    assert {"robot/NAME/rows.sql.in", "driver/NAME/twin.py.in", "capability/.gitignore.in"} <= found
    build = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]
    left_out = [pattern for part in (build, *build["targets"].values()) for pattern in part.get("exclude", ())]
    assert all(pattern.startswith("/lbr/apps/web/page/") for pattern in left_out), left_out
