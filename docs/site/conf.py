"""The docs as a site: the pages as they stand in the repository, in an order that a reader takes. Read by Sphinx."""

import re
import tomllib
from os.path import normpath
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]

_ROW = re.compile(r"^\| \*\*(.+)\*\* \| (.+) \|$", re.MULTILINE)


def _listed_in(page: str) -> dict[str, list[str]]:
    rows = _ROW.findall((ROOT / page).read_text())
    folder = Path(page).parent
    return {
        heading: [normpath(folder / link) for link in re.findall(r"\]\((\S+)\.md\)", links)] for heading, links in rows
    }


PAGES = _listed_in("README.md")
"""What stands beside each page, by heading: the table at the end of README.md."""
DEEPER = [page for pages in _listed_in("docs/architecture.md").values() for page in pages]
"""The pages for developers below that of the architecture: the table at its end."""
PARTS = sorted(
    str(page.relative_to(ROOT).with_suffix(""))
    for pattern in ("apps/*", "robots/*", "simulation", "operations")
    for page in (ROOT / "lbr").glob(f"{pattern}/README.md")
)
"""The page of each part of lbr that has one, below the page of the architecture."""

_PICTURE = re.compile(r"(!\[[^\]]*\]\()(\S+)\.webp\)")
_project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
project = _project["name"]
version = release = _project["version"]
author = "the authors of lbr"
html_title = f"lbr {version}"

root_doc = "README"
include_patterns = [f"{page}.md" for pages in (*PAGES.values(), DEEPER) for page in pages]
include_patterns += ["README.md", "docs/decisions/0*.md", *(f"{part}.md" for part in PARTS)]
extensions = ["myst_parser"]
myst_heading_anchors = 4
myst_enable_extensions = ["attrs_block", "attrs_inline"]
suppress_warnings = [
    "myst.header",  # a page that is read in a repository, too, may begin where it likes
]
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = [("versions.js", {"defer": "defer"})]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b6e4f", "color-brand-content": "#0b6e4f"},
    "dark_css_variables": {"color-brand-primary": "#4fc896", "color-brand-content": "#4fc896"},
}
highlight_language = "text"


def _listed() -> str:
    parts = []
    for heading, pages in PAGES.items():
        lines = "\n".join(f"/{page}" for page in pages)
        parts.append(f"\n\n```{{toctree}}\n:hidden:\n:caption: {heading}\n\n{lines}\n```\n")
    return "".join(parts)


def _read(_app: Sphinx, name: str, source: list[str]) -> None:
    """Add the menu to the front page, the decisions to their list, and the developers' pages and the parts to the architecture.

    A picture that has a dark one beside it becomes both: the theme shows either.
    """
    source[0] = _PICTURE.sub(lambda found: _by_theme(ROOT / name, *found.groups()), source[0])
    if name == root_doc:
        source[0] += _listed()
    elif name == "docs/decisions/README":
        records = sorted(path.stem for path in (ROOT / "docs" / "decisions").glob("0*.md"))
        source[0] += "\n\n```{toctree}\n\n" + "\n".join(records) + "\n```\n"
    elif name == "docs/architecture":
        deeper = [f"/{page}" for page in DEEPER]
        parts = [f"{part.split('/', 1)[1].removesuffix('/README')} </{part}>" for part in PARTS]
        source[0] += "\n\n```{toctree}\n:hidden:\n\n" + "\n".join([*deeper, *parts]) + "\n```\n"


def _by_theme(page: Path, begin: str, picture: str) -> str:
    light, dark = f"{begin}{picture}.webp)", f"{begin}{picture}_dark.webp)"
    return f"{light}{{.only-light}}{dark}{{.only-dark}}" if (page.parent / f"{picture}_dark.webp").is_file() else light


def setup(app: Sphinx) -> None:
    """Be called by Sphinx."""
    app.connect("source-read", _read)
    for plain in ("csv", "http"):  # requests and answers are shown together, which no lexer of HTTP reads
        app.add_lexer(plain, TextLexer)
