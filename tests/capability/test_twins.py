"""Twins of devices: lbr's own without a list, and those of installed packages, of which none takes another down."""

import sys
from collections.abc import Iterator
from textwrap import dedent

import pytest

from lbr.capability import twins
from lbr.capability.twins import TwinError
from lbr.simulation.faults import Faults

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
def installed(tmp_path, monkeypatch):
    """Installs packages as pip leaves them: modules, and metadata with entry points."""
    monkeypatch.syspath_prepend(tmp_path)
    for cache in (twins._ours, twins._brought, twins._declared):
        cache.cache_clear()

    def install(name: str, source: str, device: str = "feetech") -> None:
        (tmp_path / f"{name}.py").write_text(dedent(source))
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name.replace('_', '-')}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[lbr.twins]\n{device} = {name}:TWIN\n")
        twins._brought.cache_clear()

    yield install
    for cache in (twins._ours, twins._brought, twins._declared):
        cache.cache_clear()
    for name in [name for name in sys.modules if name.startswith("a_package")]:
        del sys.modules[name]


def own() -> Iterator[str]:
    return (name for name in twins.names() if not twins._brought().get(name))


def test_every_twin_of_lbr_s_own_is_named_as_its_module_and_loads():
    assert {"roboteq", "dynamixel", "uxa90", "camera", "ultrasonic_ring"} <= set(own())
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
        ("import no_such_thing", "does not load: ModuleNotFoundError"),
        ("TWIN = 3", "is no DeviceTwin"),
        (GOOD.format(device="other", entry="Twin"), "is of device 'other'"),
        (GOOD.replace("faults: Faults = Faults()", "size: int = 1").format(device="feetech", entry="Twin"), "`faults`"),
    ],
)
def test_a_broken_package_is_named_with_what_is_wrong_and_the_others_are_found(installed, source, said):
    installed("a_package", source)
    with pytest.raises(TwinError, match="package 'a-package'") as caught:
        twins.find("feetech")
    assert said in str(caught.value)
    assert twins.find("roboteq") is not None


def test_a_class_that_is_not_there_is_said_when_the_world_makes_it(installed):
    installed("a_package", GOOD.format(device="feetech", entry='"a_package:Missing"'))
    with pytest.raises(TwinError, match="a_package:Missing"):
        twins.find("feetech").load()


def test_of_two_packages_for_one_device_neither_is_guessed(installed):
    installed("a_package", GOOD.format(device="feetech", entry="Twin"))
    installed("a_package_too", GOOD.format(device="feetech", entry="Twin"))
    with pytest.raises(TwinError, match="package 'a-package' and package 'a-package-too': uninstall one"):
        twins.find("feetech")


def test_a_package_cannot_take_the_place_of_lbr_s_own(installed):
    installed("a_package", "raise RuntimeError('never imported')", device="roboteq")
    assert twins.find("roboteq").entry.startswith("lbr.")
    (said,) = twins.refused()
    assert "the twin of 'roboteq' from package 'a-package' is not used" in said
