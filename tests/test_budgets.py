"""Each part of lbr has a ceiling of lines; raising one needs a decision record (docs/decisions)."""

import tomllib
from pathlib import Path

import pytest

LBR = Path(__file__).parents[1] / "lbr"
CORE, COMPONENTS = tomllib.loads((Path(__file__).parent / "budgets.toml").read_text()).values()
BUDGETS: dict[str, int] = {**CORE, **COMPONENTS}
CORE_LINES = 60_300


def lines(part: str) -> int:
    """Return the lines of Python in a part; `.` is what stands directly in the package."""
    paths = LBR.glob("*.py") if part == "." else (LBR / part).rglob("*.py")
    return sum(len(path.read_text().splitlines()) for path in paths)


@pytest.mark.parametrize("part", BUDGETS)
def test_a_part_keeps_within_its_budget(part: str) -> None:
    assert lines(part) <= BUDGETS[part]


def test_the_core_keeps_within_its_budget() -> None:
    assert sum(map(lines, CORE)) <= CORE_LINES


def test_every_part_has_a_budget() -> None:
    modules = {path.parent.relative_to(LBR).as_posix() for path in LBR.rglob("*.py")}
    without = {name for name in modules if not any(f"{name}/".startswith(f"{part}/") for part in BUDGETS)}
    assert without <= {"apps", "robots"}
