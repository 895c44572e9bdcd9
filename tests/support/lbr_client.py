"""The distribution lbr-client as a release builds it, and an interpreter that has it and what it needs, but no lbr."""

import sys
import sysconfig
import tarfile
import venv
import zipfile
from importlib.metadata import files
from pathlib import Path

from tests.support import programs

PROJECT = Path(__file__).resolve().parents[2] / "client"
NEEDS = ("eclipse-zenoh", "msgspec")
_BUILD = "import sys; from hatchling import build; print(getattr(build, 'build_' + sys.argv[1])(sys.argv[2]))"


def build(what: str, folder: Path, project: Path = PROJECT) -> Path:
    """Build the `wheel`, `sdist` or `editable` of a project's folder."""
    argv = [sys.executable, "-c", _BUILD, what, str(folder)]
    built = programs.run(argv, cwd=project, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder / built.stdout.split()[-1]


def unpacked(archive: Path, folder: Path) -> Path:
    """Unpack a wheel, as pip would, or a source distribution; return where its files are."""
    if archive.suffix == ".whl":
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)
        return folder
    with tarfile.open(archive) as packed:
        packed.extractall(folder, filter="data")
    return folder / archive.name.removesuffix(".tar.gz")


def alone(folder: Path, wheel: Path) -> Path:
    """Make an environment of the wheel and what it needs; return its interpreter."""
    venv.create(folder, symlinks=True)
    unpacked(wheel, site_packages(folder))
    give_needs(folder)
    return folder / "bin" / "python"


def give_needs(environment: Path) -> None:
    """Give an environment what the distribution needs, as it is installed here."""
    site = site_packages(environment)
    for name in NEEDS:
        for top in {Path(path.parts[0]) for path in files(name) or ()}:
            (site / top).symlink_to(Path(sysconfig.get_path("platlib")) / top)


def site_packages(environment: Path) -> Path:
    """Return where a virtual environment has its packages."""
    return Path(sysconfig.get_path("purelib", "venv", {"base": str(environment)}))
