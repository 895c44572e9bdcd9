"""The checks of `lbr doctor` on a robot that watches its supply: can it shut this computer down in time?"""

from collections.abc import Iterator
from pathlib import Path

from lbr import home
from lbr.commands import unitfiles
from lbr.commands.finding import Finding
from lbr.commands.rows import opened
from lbr.commands.service import BOOTED, MACHINE
from lbr.operations.power.logind import ask

KIND = "power"
ANSWER_S = 3.0


def power(root: Path = MACHINE, booted: Path = BOOTED, bus: str = "") -> Iterator[Finding]:
    """Check the rule and ask logind, as this user; skipped without a robot that watches its supply."""
    if not booted.exists() or not (_watches() or unitfiles.extras_of(root).power_off):
        return
    yield _rule(root)
    yield _logind(bus)


def _watches() -> bool:
    """Return whether a robot of this home watches its supply."""
    path = home.default_database()
    if not path.exists():
        return False
    with opened(path) as rows:
        parts = (row for name in rows.robots() for row in rows.load(name).capabilities)
        return any(row.kind == KIND and row.enabled for row in parts)


def _rule(root: Path) -> Finding:
    rule = root / unitfiles.POLKIT
    try:
        installed = rule.exists()
    except PermissionError:
        text = "where polkit has its rules only root may look"
        return Finding(about="power-off rule", level="hint", text=text, do="sudo lbr doctor")
    if installed:
        return Finding(about="power-off rule", level="good", text=f"{rule} lets the robot's user power off")
    text = "no rule lets a service power this computer off"
    do = f"sudo {' '.join(unitfiles.this_site().program)} service install PROFILE --power-off"
    return Finding(about="power-off rule", level="hint", text=text, do=do)


def _logind(bus: str) -> Finding:
    answer = ask(bus, "CanPowerOff", ANSWER_S)
    if answer.trouble:
        text = f"you could not power off: {answer.trouble}"
        program = " ".join(unitfiles.this_site().program)
        do = f"as the robot's user it may be another matter: sudo -u lbr {program} doctor"
        return Finding(about="power off", level="hint", text=text, do=do)
    return Finding(about="power off", level="good", text="logind lets you power this computer off")
