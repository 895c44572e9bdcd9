"""A package's one entry point brings whatever lbr's own components do; a broken one is told, and keeps nobody else out."""

import json
import os
import re
import sys
from pathlib import Path

import pytest

from lbr import cli, plugins
from lbr.capability import registry, twins
from lbr.capability.kind import KindError
from lbr.robot import registry as robots
from tests.support import programs
from tests.support.commands import here
from tests.support.packages import imported_from, metadata, on_path, package
from tests.support.robot import LBR, environment

GRIPPER = """
import click
from click.shell_completion import CompletionItem
from lbr.capability import Capability, Kind, OnDevice
from lbr.capability.twins import DeviceTwin
from lbr.errors import InputError
from lbr.simulation.faults import Faults
from msgspec import Struct

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    device: str

class Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    faults: Faults = Faults()

class Gripper(Capability[Settings]):
    pass

class Twin:
    pass

KIND = Kind(name="gripper", summary="grips", family="driver", entry=Gripper, settings=Settings,
    device=OnDevice("gripper"))
TWIN = DeviceTwin(device="gripper", row=Row, entry=Twin)

def complete(context, parameter, begun):
    return [CompletionItem(one) for one in ("softly", "hard") if one.startswith(begun)]

@click.command("grip")
@click.argument("how", shell_complete=complete)
def command(how):
    '''Grip something.'''
    if how != "softly":
        raise InputError(f"nothing grips {how}")
    click.echo("gripped")
    return 0
"""
BRINGS = {
    "kinds": {"gripper": "gripper:KIND"},
    "twins": {"gripper": "gripper:TWIN"},
    "commands": {"grip": "gripper:command"},
}


@pytest.fixture
def site(tmp_path):
    with imported_from(tmp_path / "site"):
        yield tmp_path / "site"


def put(site: Path, name: str, code: str, *, requires: tuple[str, ...] = ("lbr",)) -> None:
    """Install a package whose component is whatever the code declares."""
    site.mkdir(exist_ok=True)
    metadata(site, name, version="0.1", requires=requires, points={name: f"{name}:COMPONENT"})
    (site / f"{name}.py").write_text(f"from lbr.component import CliCommand, Component\n{code}")
    plugins.forget()


def lbr(site: Path, home: Path, *words: str, **more: str) -> "tuple[int, str, str]":
    env = environment(home) | {"PYTHONPATH": on_path(site)} | more
    done = programs.run([*LBR, *words], env=env, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def typed(home: Path, *words: str) -> "tuple[int, str, str]":
    """Run a command in this process, which has the packages of the test on its path."""
    plugins.forget()
    done = here(home, *words)
    return done.returncode, done.stdout, done.stderr


def test_one_entry_point_brings_a_kind_a_twin_and_a_command(site):
    package(site, "my-gripper", brings=BRINGS, files={"gripper.py": GRIPPER})
    plugins.forget()
    assert registry.find("gripper", site).device_type == "gripper"
    assert twins.find("gripper").device == "gripper"
    assert [one.name for one in plugins.every("commands")][-1] == "grip"


def test_a_command_of_a_package_has_help_completion_and_exit_codes_as_ours_have(site, tmp_path):
    package(site, "my-gripper", brings=BRINGS, files={"gripper.py": GRIPPER})
    _, said, _ = lbr(site, tmp_path, "--help")
    ours, _, theirs = said.partition("Commands of package 'my-gripper 0.1':")
    assert "  run " in ours
    assert theirs.split() == ["grip", "grip"]
    assert lbr(site, tmp_path, "grip", "--help")[1].startswith("Usage: lbr grip")
    assert lbr(site, tmp_path, "grip", "softly")[:2] == (0, "gripped\n")
    assert lbr(site, tmp_path, "grip", "it")[0] == cli.BAD_INPUT
    tab = {"_LBR_COMPLETE": "bash_complete", "COMP_CWORD": "1"}
    assert lbr(site, tmp_path, COMP_WORDS="lbr gr", **tab)[1].split() == ["plain,graph", "plain,grip"]
    assert lbr(site, tmp_path, COMP_WORDS="lbr grip s", **tab | {"COMP_CWORD": "2"})[1].split() == ["plain,softly"]


def test_the_help_lists_each_command_of_lbr_below_one_of_six_headings(site, tmp_path):
    said = typed(tmp_path, "--help")[1]
    headings = ["Start", "Drive", "Look", "Change", "Build", "Run for good"]
    assert re.findall(r"^(\w.*):$", said.partition("Options:")[2], re.MULTILINE) == headings
    listed = re.findall(r"^  ([a-z]+) ", said.partition("Start:")[2], re.MULTILINE)
    assert sorted(listed) == sorted(one.name for one in plugins.own("commands"))


def test_what_lbr_brings_itself_is_found_without_an_import_of_other_packages(site):
    put(site, "loud", "COMPONENT = Component()")
    code = (
        "import sys; from lbr import plugins as p; print(p.find('kinds', 'web').ours, p.find('commands', 'run').ours)"
    )
    code += "\nprint('loud' in sys.modules); p.installed('kinds'); print('importlib.metadata' in sys.modules)"
    env = {**os.environ, "PYTHONPATH": on_path(site)}
    done = programs.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "True", "False", "False"]


BROKEN = {
    "does not import": ("raise RuntimeError('no servo')", "it does not load: RuntimeError: no servo"),
    "is no component": ("COMPONENT = 3", "is no Component(…), but of type int"),
    "has a field that there is not": ("COMPONENT = Component(kind={})", "keyword argument 'kind'"),
    "has a list in a field": ("COMPONENT = Component(kinds=['claw'])", "'kinds' is of type list"),
    "names no attribute": ("COMPONENT = Component(robots={'claw': 'claw'})", "'robots' has 'claw' as 'claw'"),
    "has a command without help": ("COMPONENT = Component(commands={'c': 'a:b'})", "'commands' has 'c' as 'a:b'"),
    "has a command that cannot be typed": (
        "COMPONENT = Component(commands={'a b': CliCommand(entry='a:b', help='')})",
        "'commands' has 'a b'",
    ),
}


@pytest.mark.parametrize(("code", "why"), BROKEN.values(), ids=BROKEN)
def test_a_broken_component_is_told_by_its_package_and_field_and_all_else_is_there(site, code, why):
    put(site, "theirs", code)
    (said,) = plugins.broken()
    assert said.startswith("component 'theirs' of package 'theirs 0.1' (theirs:COMPONENT): ")
    assert why in said
    assert "uninstall the package" in said
    assert plugins.installed("kinds").keys() == {one.name for one in plugins.own("kinds")}
    with pytest.raises(KindError) as caught:
        registry.find("claw", site)
    assert said in str(caught.value)


def test_a_component_that_does_not_load_since_it_is_for_another_lbr_says_so(site):
    put(site, "theirs", "COMPONENT = Component(legs={})", requires=("lbr>=99",))
    (said,) = plugins.broken()
    assert "it requires lbr >=99" in said


def test_the_command_line_tells_of_broken_components_in_its_help_and_where_a_command_is_not_there(site, tmp_path):
    put(site, "theirs", "COMPONENT = 3")
    assert "package 'theirs 0.1'" in typed(tmp_path, "--help")[1].partition("Not loaded:")[2]
    code, _, said = typed(tmp_path, "grip")
    assert (code, "package 'theirs 0.1'" in said) == (cli.BAD_INPUT, True)
    assert "theirs" not in typed(tmp_path, "topic", "lsit")[2]


def test_commands_that_two_claim_are_neithers_and_those_of_lbr_stay(site, tmp_path):
    for name in ("one", "two"):
        package(site, name, brings={"commands": {"run": f"{name}:c", "grip": f"{name}:c"}}, files={f"{name}.py": ""})
    code, said, told = typed(tmp_path, "grip")
    assert (code, said) == (cli.FAILED, "")
    assert "packages one 0.1 and two 0.1 bring it" in told
    assert typed(tmp_path, "run", "--help")[1].startswith("Usage: lbr run")
    assert "grip" not in typed(tmp_path, "--help")[1]
    findings = json.loads(typed(tmp_path, "doctor", "--json")[1])
    told = [one["text"] for one in findings if one["about"] == "commands of packages"]
    assert len(told) == 4


def test_of_two_components_of_one_package_neither_has_a_name_that_both_claim(site):
    metadata(site, "theirs", version="0.1", requires=("lbr",), points={"left": "l:COMPONENT", "right": "r:COMPONENT"})
    for name in "lr":
        code = "from lbr.component import Component\nCOMPONENT = Component(robots={'claw': 'claw:ROBOT'})"
        (site / f"{name}.py").write_text(code)
    plugins.forget()
    found = robots.find("claw")
    assert "components 'left' and 'right' of it bring it" in found.fault


def test_the_first_of_a_package_on_the_path_counts_however_its_name_is_written(site, tmp_path):
    put(site, "theirs", "COMPONENT = Component(kinds={'claw': 'claw:KIND'})")
    other = tmp_path / "other"
    metadata(other, "Theirs", version="0.2", requires=(), points={"theirs": "theirs:COMPONENT"})
    sys.path.append(str(other))
    try:
        plugins.forget()
        assert [one.package for one in plugins.entries() if not one.ours] == ["theirs 0.1"]
    finally:
        sys.path.remove(str(other))


def test_a_package_is_named_by_the_head_of_its_metadata_alone(site):
    put(site, "theirs", "COMPONENT = Component()", requires=("lbr", "numpy>=2"))
    (path,) = site.glob("*.dist-info/METADATA")
    head = path.read_text().replace("Version: 0.1", "License: a\n        Name: b\n        \nVersion: 0.1")
    path.write_text(f"{head}\nName: another\nRequires-Dist: lbr>=99\n")
    plugins.forget()
    (found,) = (one for one in plugins.entries() if not one.ours)
    assert (found.package, found.requires) == ("theirs 0.1", ("lbr", "numpy>=2"))
