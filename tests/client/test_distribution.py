"""The distribution lbr-client: modules of lbr as they are, in a place where they are in nobody's way."""

import inspect
import json
import os
import sys
from pathlib import Path

import pytest

from lbr import client
from lbr.client import aio
from tests.support import lbr_client, programs

ROOT = Path(__file__).resolve().parents[2]
LOOK = """
import json, sys
import lbr_client, lbr_client.aio
import lbr.client, lbr.client.aio
print(json.dumps({
    "from": lbr.client.__file__,
    "exports": lbr_client.__all__,
    "aio": lbr_client.aio.__all__,
    "same": all(getattr(lbr_client, name) is getattr(lbr.client, name) for name in lbr_client.__all__),
    "modules": sorted({name.partition(".")[0] for name in sys.modules} - sys.stdlib_module_names),
}))
"""


def look(python, **environment):
    done = programs.run([python, "-c", LOOK], env=environment, cwd="/", capture_output=True, text=True)
    assert (done.stderr, done.returncode) == ("", 0)
    return json.loads(done.stdout)


@pytest.fixture
def site(wheel, tmp_path):
    """The distribution's files, as pip puts them."""
    return lbr_client.unpacked(wheel, tmp_path / "site")


def test_its_modules_are_the_very_files_of_lbr_and_none_lies_where_lbr_has_its_own(site):
    private, stubs = site / "lbr_client" / "_modules", site / "lbr-stubs"
    modules = sorted(path.relative_to(private / "lbr") for path in private.rglob("*") if path.is_file())
    assert [private / "lbr" / path for path in modules if path.suffix != ".py"] == []
    for path in modules:
        own = (ROOT / "lbr" / path).read_bytes()
        assert (private / "lbr" / path).read_bytes() == (stubs / path).with_suffix(".pyi").read_bytes() == own
    tops = {path.name.partition("-0")[0] for path in site.iterdir()}
    assert tops == {"lbr_client", "lbr-stubs"}


def test_it_needs_two_libraries(site):
    (metadata,) = site.glob("*.dist-info/METADATA")
    needs = [line for line in metadata.read_text().splitlines() if line.startswith("Requires-Dist")]
    bare = [line.split()[1].split("<")[0].split(">")[0] for line in needs if "extra ==" not in line]
    assert sorted(bare) == sorted(lbr_client.NEEDS)


def test_alone_it_exports_what_lbr_client_has_and_loads_nothing_else(alone):
    found = look(alone)
    assert Path(found["from"]).is_relative_to(alone.parent.parent)
    assert found["same"]
    assert found["exports"] == client.__all__
    own = [what for what in vars(aio).values() if inspect.isclass(what) or inspect.isfunction(what)]
    public = {what.__name__ for what in own if what.__module__ == aio.__name__ and not what.__name__.startswith("_")}
    assert set(found["aio"]) == public
    assert set(found["modules"]) == {"__main__", "lbr", "lbr_client", "msgspec", "zenoh"}


def test_beside_lbr_it_is_lbr_s_own_whichever_comes_first_on_the_path(site):
    for path in ([site, ROOT], [ROOT, site]):
        found = look(sys.executable, PYTHONPATH=os.pathsep.join(map(str, path)))
        assert found["from"] == client.__file__
        assert found["same"]


def test_its_source_distribution_builds_the_same_wheel_without_the_tree(wheel, tmp_path):
    archive = lbr_client.build("sdist", tmp_path)
    source = lbr_client.unpacked(archive, tmp_path / "source")
    again = lbr_client.build("wheel", tmp_path / "again", source)
    assert again.read_bytes() == wheel.read_bytes()
