"""How many words the pages may have: one that grows beyond is shortened elsewhere."""

import pytest

from tests.docs.pages import EVERY_ROBOT, PAGES, ROOT

DOCS, DECISIONS, REFERENCE = ROOT / "docs", ROOT / "docs" / "decisions", ROOT / "docs" / "reference"
HAND_WRITTEN = [ROOT / "README.md", *(page for page in PAGES if DOCS in page.parents and REFERENCE not in page.parents)]
BUILT = [DOCS / f"{name}.md" for name in ("architecture", "safety_promises", "security_threats")]
BUILT += [*DECISIONS.glob("*.md"), ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
LONGER = {
    **dict.fromkeys(EVERY_ROBOT.parent.glob("*.md"), 1500),
    **{DOCS / f"{name}.md": 1500 for name in ("tutorial", "safety_promises", "servo_lines")},
    DOCS / "drivers.md": 1500,  # a table of it is generated
    DOCS / "compared.md": 600,
    ROOT / "README.md": 700,
    **dict.fromkeys(DECISIONS.glob("0*.md"), 100),
}
GUIDE = 1200


def words(page):
    return len(page.read_text().split())


@pytest.mark.parametrize("page", HAND_WRITTEN, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_is_no_longer_than_a_reader_reads(page):
    assert words(page) <= LONGER.get(page, GUIDE)


@pytest.mark.parametrize(
    ("pages", "most"),
    [(HAND_WRITTEN, 45_000), (BUILT, 6_000), (list(REFERENCE.glob("*.md")), 22_000)],
    ids=["written by hand", "how lbr is built", "reference"],
)
def test_pages_together_are_no_longer_than_their_part(pages, most):
    assert sum(map(words, pages)) <= most
