"""What packages bring by their components is refused in the same words, and all else is there."""

import os
import sys

import pytest

from lbr import plugins
from lbr.apps.web import faces
from lbr.capability import registry, twins
from lbr.errors import LbrError
from lbr.robot import registry as robots
from tests.support import programs
from tests.support.packages import imported_from, package
from tests.support.waiting import HANG_S


def kind(name, folder):
    return registry.find(name, folder)


def robot(name, _folder):
    found = robots.find(name)
    if found.robot is None:
        raise LbrError(found.fault)
    return found.robot


def twin(name, _folder):
    return twins.find(name)


def face(name, _folder):
    return faces._made(plugins.find("faces", name), None)


FIELDS = {
    "kinds": (kind, "the installed kind", "exec"),
    "robots": (robot, "robot", "lbr"),
    "twins": (twin, "the twin", "roboteq"),
    "faces": (face, "", "cameras"),
}
BROKEN = {
    "does not import": (
        "import nothing_like_this",
        (),
        "it does not load: ModuleNotFoundError: No module named 'nothing_like",
    ),
    "ends the process": ("raise SystemExit(3)", (), "it does not load: SystemExit: 3"),
    "raises what is no Exception": (
        "class Bare(BaseException): pass\nraise Bare('so')",
        (),
        "it does not load: Bare: so",
    ),
    "raises as Ctrl-C does": ("raise KeyboardInterrupt", (), "it does not load: KeyboardInterrupt"),
    "takes signals": (
        "import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)",
        (),
        "it does not load: ValueError: signal only works in main thread",
    ),
    "is no Python": ("def (:", (), "it does not load: SyntaxError"),
    "declares nothing": ("", (), "it does not load: AttributeError"),
    "is for another version": ("", ("lbr>=99",), "it requires lbr >=99, and this is lbr "),
    "asks for no version that can be read": ("", ("lbr ~~ 1",), "it requires 'lbr ~~ 1', which cannot be read"),
    "declares something else": ("def IT(robot=None): return 3", (), " is no "),
}


@pytest.fixture
def site(tmp_path):
    with imported_from(tmp_path):
        yield tmp_path


def put(site, field, name, code, *, distribution="theirs", requires=()):
    package(
        site,
        distribution,
        requires=requires,
        brings={field: {name: f"{distribution}:IT"}},
        files={f"{distribution}.py": code},
    )
    plugins.forget()


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize(("code", "requires", "why"), BROKEN.values(), ids=BROKEN)
def test_a_broken_package_is_refused_by_its_name_and_what_lbr_brings_is_there(field, code, requires, why, site):
    find, begins, ours = FIELDS[field]
    put(site, field, "crab", code, requires=requires)
    with pytest.raises(LbrError) as caught:
        find("crab", site)
    assert f"{begins} 'crab' of package 'theirs 0.1' ({field} of component 'theirs'): ".strip() in str(caught.value)
    assert why in str(caught.value)
    if find is not face:  # which needs a robot to show
        assert find(ours, site) is not None


@pytest.mark.parametrize("field", FIELDS)
def test_a_name_of_lbr_stays_its_own_and_of_two_packages_neither_has_it(field, site):
    find, _, ours = FIELDS[field]
    put(site, field, ours, "raise RuntimeError('never imported')")
    refused = [one for one in plugins.every(field) if one.refusal]
    assert [(one.package, one.refusal) for one in refused] == [
        ("theirs 0.1", f"lbr has its own '{ours}': choose another name")
    ]
    assert plugins.find(field, ours).ours
    put(site, field, "crab", "IT = 1", distribution="one")
    put(site, field, "crab", "IT = 1", distribution="two")
    with pytest.raises(LbrError, match=r"packages one 0\.1 and two 0\.1"):
        find("crab", site)


def test_a_thread_that_a_package_leaves_behind_keeps_no_program_from_its_end(site):
    put(
        site,
        "kinds",
        "crab",
        "import threading\nthreading.Thread(target=threading.Event().wait).start()\nIT = 1",
    )
    program = "from lbr import plugins; print(plugins.find('kinds', 'crab').load())"
    env = {**os.environ, "PYTHONPATH": os.pathsep.join((str(site), *filter(None, sys.path)))}
    assert (
        programs.run([sys.executable, "-c", program], env=env, capture_output=True, text=True, timeout=HANG_S).stdout
        == "1\n"
    )


def test_a_kind_that_was_installed_beside_a_robot_that_runs_is_no_kind_until_its_next_start(site):
    plugins.installed("kinds")
    package(site, "late", brings={"kinds": {"crab": "late:IT"}}, files={"late.py": "IT = 1"})
    with pytest.raises(LbrError, match=r"'crab' of package 'late 0\.1' was installed after .*: start the robot again"):
        registry.find("crab", site)
