"""Build the docs as a site: `python docs/site/build.py [FOLDER]` writes FOLDER/VERSION/, and a start page beside all versions.

The folder is `build/site` unless another is given; what other versions have been built there stays. `--check` only reads the
pages: each link and each anchor in them, and that none is missing beside them. Any warning is an error.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from packaging.version import InvalidVersion, Version
from sphinx.cmd.build import build_main

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
START = """<!doctype html>
<meta charset="utf-8">
<title>lbr</title>
<meta http-equiv="refresh" content="0; url={newest}/README.html">
<a href="{newest}/README.html">lbr {newest}</a>
"""


def main(words: list[str]) -> int:
    """Build or check; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "build" / "site", help="where to (build/site)")
    parser.add_argument("--check", action="store_true", help="write nothing")
    given = parser.parse_args(words)
    with tempfile.TemporaryDirectory() as trees:
        if given.check:
            return _run("dummy", trees, Path(trees) / "nothing")
        from conf import release  # noqa: PLC0415 - the configuration stands beside this program

        code = _run("html", trees, given.folder / release)
    if code == 0:
        _list_versions(given.folder)
        print(f"open {given.folder / 'index.html'}")
    return code


def _run(builder: str, trees: str, target: Path) -> int:
    return build_main(["-q", "-W", "--keep-going", "-b", builder, "-c", str(HERE), "-d", trees, str(ROOT), str(target)])


def _list_versions(folder: Path) -> None:
    found = sorted(filter(_is_version, (path.name for path in folder.iterdir() if path.is_dir())), key=Version)[::-1]
    (folder / "versions.json").write_text(json.dumps(found))
    (folder / "index.html").write_text(START.format(newest=found[0]))


def _is_version(name: str) -> bool:
    try:
        Version(name)
    except InvalidVersion:
        return False
    return True


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
