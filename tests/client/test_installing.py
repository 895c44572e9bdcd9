"""lbr-client in an environment of its own and in one with lbr, as pip installs and uninstalls them; and what type checkers see."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import lbr_client, programs

ROOT = Path(__file__).resolve().parents[2]
INSTALL = ("install", "--no-index", "--no-deps", "--no-compile")
TYPED = """
import lbr_client as client
from lbr_client import aio

with client.connect() as robot:
    reveal_type(robot.drive(0.2))
reveal_type(aio.connect())
reveal_type(client.find()[0].connect)
"""


def of_its_own(folder):
    return {"PATH": "/usr/bin:/bin", "HOME": str(folder), "PIP_DISABLE_PIP_VERSION_CHECK": "1"}


@pytest.fixture(scope="module")
def wheels(wheel, tmp_path_factory):
    """The wheels of both distributions, by their names."""
    return {"lbr-client": wheel, "lbr": lbr_client.build("wheel", tmp_path_factory.mktemp("lbr"), ROOT)}


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """An environment of pip and what lbr-client needs."""
    folder = tmp_path_factory.mktemp("fresh")
    programs.run([sys.executable, "-m", "venv", folder], check=True, env=of_its_own(folder))
    lbr_client.give_needs(folder)
    return folder


@pytest.fixture
def pip(fresh):
    """Run pip there; what it installed is uninstalled in the end."""

    def run(*words):
        programs.run([fresh / "bin" / "python", "-m", "pip", "-qq", *words], check=True, env=of_its_own(fresh))

    yield run
    run("uninstall", "--yes", "lbr", "lbr-client")


@pytest.fixture
def lbr_of(fresh):
    """Return where lbr is for a program there that imports a package first."""

    def ask(package):
        argv = [fresh / "bin" / "python", "-I", "-c", f"import {package}, lbr; print(lbr.__path__[0])"]
        return Path(programs.run(argv, stdout=subprocess.PIPE, text=True, check=True).stdout.strip())

    return ask


@pytest.mark.timeout(180)
def test_in_either_order_lbr_has_its_own_modules_and_whichever_is_left_works(fresh, pip, lbr_of, wheels):
    own = lbr_client.site_packages(fresh) / "lbr"
    private = own.parent / "lbr_client" / "_modules" / "lbr"
    pip(*INSTALL, wheels["lbr-client"])
    assert lbr_of("lbr_client.aio") == private
    pip(*INSTALL, wheels["lbr"])
    assert lbr_of("lbr_client.aio") == lbr_of("lbr.client") == own
    pip("uninstall", "--yes", "lbr-client")
    assert lbr_of("lbr.client") == own
    pip(*INSTALL, wheels["lbr-client"])
    assert lbr_of("lbr_client.aio") == lbr_of("lbr.client") == own
    pip("uninstall", "--yes", "lbr")
    assert lbr_of("lbr_client.aio") == private


def test_an_editable_installation_has_the_modules_of_the_tree(pip, lbr_of, tmp_path):
    pip(*INSTALL, lbr_client.build("editable", tmp_path))
    assert lbr_of("lbr_client.aio") == ROOT / "lbr"


def test_a_type_checker_knows_what_it_has(alone, tmp_path):
    (tmp_path / "program.py").write_text(TYPED)
    argv = ["-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", "--python-executable", alone, "program.py"]
    done = programs.run([sys.executable, *argv], cwd=tmp_path, capture_output=True, text=True)
    told = [line.split('"')[1] for line in done.stdout.splitlines() if "Revealed" in line]
    assert told[:2] == ["lbr.client.motion.KeptMotion", "lbr.client.aio.AsyncRobot"]
    assert told[2].endswith("-> lbr.client.robot.Robot")
    assert done.returncode == 0, done.stdout
