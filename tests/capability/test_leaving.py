"""The text of a crash names the line of its author, not one of the runtime or of Python's own library."""

import importlib
import json
from pathlib import Path

import pytest

from lbr.capability import leaving
from lbr.capability.border import border
from lbr.errors import InputError
from tests.support.packages import imported_from


def of_the_runtime():
    with border(lambda err: InputError(f"it does not load: {err}")):
        raise ValueError("no")


def of_python():
    json.loads("{")


@pytest.mark.parametrize("crashes", [of_the_runtime, of_python])
def test_a_crash_is_told_with_the_last_line_that_its_author_wrote(crashes):
    with pytest.raises(Exception) as caught:  # noqa: PT011
        crashes()
    line = crashes.__code__.co_firstlineno + 1
    assert leaving.text(caught.value).endswith(f" ({Path(__file__).name}, line {line})")


def test_an_installed_package_has_an_author_of_its_own(tmp_path):
    site = tmp_path / "lib" / "python3.11" / "site-packages"
    site.mkdir(parents=True)
    (site / "crab_breaks.py").write_text("def go():\n    return 1 / 0\n")
    with imported_from(site):
        go = importlib.import_module("crab_breaks").go
    with pytest.raises(ZeroDivisionError) as caught:
        go()
    assert leaving.text(caught.value).endswith(" (crab_breaks.py, line 2)")
