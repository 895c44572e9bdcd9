"""Installs and removes the service's files; a file that was edited by hand is only touched on request."""

from pathlib import Path
from typing import Literal

from msgspec import Struct

from lbr import disk
from lbr.commands.unitfiles import DROP_IN, POLKIT, RELAY_DROP_IN, RELAY_UNIT, RULES, SYSUSERS, UNIT, is_pristine

State = Literal["absent", "current", "outdated", "edited"]
MODE = 0o644
KEPT = ".edited"


class Step(Struct, frozen=True):
    """The result for one file, done or to be done."""

    path: Path
    done: str


def state(path: Path, text: str) -> State:
    """Compare a file with its intended text."""
    if not path.exists():
        return "absent"
    found = path.read_text(errors="replace")
    if found == text:
        return "current"
    return "outdated" if is_pristine(found) else "edited"


def installed(root: Path) -> list[Path]:
    """Return the installed files, whichever program wrote them."""
    fixed = (root / name for name in (UNIT, RULES, SYSUSERS, POLKIT, RELAY_UNIT))
    drop_ins = (path for name in (DROP_IN, RELAY_DROP_IN) for path in sorted(root.glob(name.format("*"))))
    return [*(path for path in fixed if path.exists()), *drop_ins]


def install(root: Path, files: dict[str, str], *, overwrite: bool, dry_run: bool) -> list[Step]:
    """Write the files that differ; edited ones only with `overwrite`, after a copy."""
    steps = []
    for name, text in files.items():
        path = root / name
        present = state(path, text)
        if present == "current":
            steps.append(Step(path, "is as it should be"))
        elif present == "edited" and not overwrite:
            steps.append(Step(path, "was edited and stays as it is; --overwrite replaces it"))
        else:
            note = f"; the edited one is kept as {path.name}{KEPT}" if present == "edited" else ""
            done = "written" if present == "absent" else "replaced"
            steps.append(Step(path, f"{'would be ' if dry_run else ''}{done}{note}"))
            if not dry_run:
                _write(path, text, keep=bool(note))
    return steps


def remove(root: Path, *, overwrite: bool, dry_run: bool) -> list[Step]:
    """Remove the installed files; edited ones only with `overwrite`."""
    steps = []
    for path in installed(root):
        if not overwrite and not is_pristine(path.read_text(errors="replace")):
            steps.append(Step(path, "was edited and stays; --overwrite removes it"))
            continue
        steps.append(Step(path, "would be removed" if dry_run else "removed"))
        if not dry_run:
            path.unlink()
            if path.parent.name.endswith(".service.d") and not any(path.parent.iterdir()):
                path.parent.rmdir()
    return steps


def _write(path: Path, text: str, *, keep: bool) -> None:
    path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    with disk.replacing(path) as draft:
        draft.write_text(text)
        draft.chmod(MODE)
        if keep:
            path.replace(path.with_name(path.name + KEPT))
