"""Twins of devices: lbr's own without a list, and those of packages; test_plugins.py has what is refused of any field."""

from pathlib import Path
from textwrap import dedent

import pytest

from lbr import plugins
from lbr.capability import twins
from lbr.capability.twins import TwinError
from lbr.simulation import devices
from lbr.simulation.faults import Faults
from tests.support.packages import imported_from, package

GOOD = """
    from msgspec import Struct
    from lbr.capability.twins import DeviceTwin
    from lbr.simulation.faults import Faults

    class Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
        faults: Faults = Faults()

    class Twin:
        def __init__(self, device, around):
            self.name = device.name

    TWIN = DeviceTwin(device="{device}", row=Row, entry={entry})
"""


@pytest.fixture
def installed(tmp_path):
    """Installs packages as pip leaves them: modules, and metadata with entry points."""

    def install(name: str, source: str) -> None:
        package(
            tmp_path,
            name.replace("_", "-"),
            version="1.0",
            brings={"twins": {"feetech": f"{name}:TWIN"}},
            files={f"{name}.py": dedent(source)},
        )
        plugins.forget()

    with imported_from(tmp_path):
        yield install


def own() -> set[str]:
    return {one.name for one in plugins.own("twins")}


def test_every_twin_of_lbr_s_own_is_named_as_its_module_and_loads():
    folder = Path(devices.__file__).parent
    assert own() >= {path.parent.name for path in folder.glob("*/__init__.py")}
    for name in own():
        twin = twins.find(name)
        assert twin.device == name
        assert isinstance(twin.row().faults, Faults)
        assert callable(twin.load())
    assert twins.find("speaker") is None


@pytest.mark.parametrize("entry", ["Twin", '"a_package:Twin"'])
def test_a_package_brings_a_twin_with_no_edit_in_lbr(installed, entry):
    installed("a_package", GOOD.format(device="feetech", entry=entry))
    assert "feetech" in twins.names()
    assert twins.find("feetech").load().__name__ == "Twin"
    assert twins.refused() == ()


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("TWIN = 3", "a_package:TWIN is no DeviceTwin(…), but of type int"),
        (
            GOOD.format(device="other", entry="Twin"),
            "it calls itself 'other'",
        ),
        (GOOD.replace("faults: Faults = Faults()", "size: int = 1").format(device="feetech", entry="Twin"), "`faults`"),
    ],
)
def test_a_broken_package_is_named_with_what_is_wrong_and_the_others_are_found(installed, source, said):
    installed("a_package", source)
    with pytest.raises(TwinError, match=r"the twin 'feetech' of package 'a-package 1\.0'") as caught:
        twins.find("feetech")
    assert said in str(caught.value)
    assert twins.find("roboteq") is not None


def test_a_class_that_is_not_there_is_said_when_the_world_makes_it(installed):
    installed("a_package", GOOD.format(device="feetech", entry='"a_package:Missing"'))
    with pytest.raises(TwinError, match="a_package:Missing"):
        twins.find("feetech").load()
