"""The docs as a site: it builds without a warning, which is each link and each anchor, and stands beside every page."""

import importlib.util
import sys
from pathlib import Path

import pytest

from tests.support import programs

ROOT = Path(__file__).resolve().parents[2]
SITE = ROOT / "docs" / "site"


@pytest.fixture(scope="module")
def pages() -> list[str]:
    spec = importlib.util.spec_from_file_location("conf", SITE / "conf.py")
    assert spec
    assert spec.loader
    conf = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(conf)
    return [page for listed in (*conf.PAGES.values(), conf.DEEPER) for page in listed]


@pytest.mark.timeout(90)
def test_it_builds_without_a_warning_and_every_link_leads_somewhere():
    command = [sys.executable, str(SITE / "build.py"), "--check"]
    done = programs.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_page_is_listed_beside_all_others(pages):
    there = {
        str(path.relative_to(ROOT).with_suffix(""))
        for part in ("docs", "examples", "client")
        for path in (ROOT / part).rglob("*.md")
        if not path.relative_to(ROOT).parts[-2].startswith((".", "_"))
    }
    unlisted = {page for page in there - set(pages) if not page.startswith("docs/decisions/0")}
    assert not unlisted, f"add to the table at the end of README.md or docs/architecture.md: {sorted(unlisted)}"
    assert len(pages) == len(set(pages))
    assert not [page for page in pages if not (ROOT / f"{page}.md").is_file()]
