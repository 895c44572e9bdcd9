"""The checks of `lbr doctor` on a machine where a robot is a service, or could be one; skipped on others."""

import grp
import pwd
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

from lbr.commands import placing, unitfiles
from lbr.commands.finding import Finding, Level
from lbr.commands.service import BOOTED, MACHINE

PROPERTIES = ("Id", "ActiveState", "SubState", "Result", "WatchdogUSec", "NRestarts", "MainPID", "StatusText")
ANSWER_S = 5.0
LIMITS = {"watchdog": "WatchdogSec=10", "timeout": "TimeoutStartSec=600"}
"""The bound to raise on a slow machine, by systemd's result of a service."""
LEAST_NICE_LIMIT = 30
"""The limit in /proc/PID/limits at which niceness may go down to -10: 20 minus the niceness."""


def services(root: Path = MACHINE, booted: Path = BOOTED) -> Iterator[Finding]:
    """Check the files, the services that start with the machine, and those that run."""
    unit = root / unitfiles.UNIT
    if unit.exists():
        yield from _files(root)
        yield from _user(unit.read_text(errors="replace"))
        yield from _enabled(root)
        if booted.exists():
            yield from _running()
    elif booted.exists():
        text = "not installed; 'lbr service install' starts the robot with the machine"
        yield Finding(about="service", level="good", text=text)


def judged(properties: dict[str, str], limits: str) -> Finding:
    """Return the state of one service, from `systemctl show` and its limits."""
    name, state = properties.get("Id", "?"), properties.get("ActiveState", "")
    about = f"service {name.removesuffix('.service')}"
    look = f"journalctl -u {name} -n 50"
    if state != "active":
        level, text, do = _not_active(name, state, properties.get("Result", "?"))
        return Finding(about=about, level=level, text=text, do=f"{look}{do}")
    if properties.get("WatchdogUSec", "") in {"", "0", "infinity"}:
        return Finding(about=about, level="bad", text="runs without a watchdog", do=f"systemctl cat {name}")
    if properties.get("NRestarts", "0") != "0":
        text = f"runs, and was restarted {properties['NRestarts']} times"
        return Finding(about=about, level="hint", text=text, do=look)
    limit = re.search(r"^Max nice priority\s+(\d+)", limits, re.MULTILINE)
    if limit is not None and int(limit[1]) < LEAST_NICE_LIMIT:
        text = f"its motion processes cannot be raised (nice limit {limit[1]}, {LEAST_NICE_LIMIT} is needed)"
        return Finding(about=about, level="hint", text=text, do=f"systemctl cat {name}, and look for LimitNICE")
    return Finding(about=about, level="good", text=f"{properties.get('StatusText') or 'runs'}, watchdog on")


def _not_active(name: str, state: str, result: str) -> tuple[Level, str, str]:
    if result in LIMITS:
        text = f"{state}: a time limit of the unit ended it ({result})"
        return "bad", text, f"; on a slow machine: sudo systemctl edit {name}, and there [Service] {LIMITS[result]}"
    if state == "failed":
        text = f"failed ({result}); bad rows are not tried again by themselves"
        return "bad", text, f"; then: sudo systemctl restart {name}"
    return "hint", state or "not running", ""


def _files(root: Path) -> Iterator[Finding]:
    site = unitfiles.this_site(root)
    user = unitfiles.user_of((root / unitfiles.UNIT).read_text(errors="replace"))
    extras = unitfiles.extras_of(root)
    for name, text in unitfiles.files(unitfiles.DEFAULT_PROFILE, user, site, extras).items():
        path = root / name
        if path.parent.name.endswith(".service.d"):
            continue  # of a profile; the list of profiles is unknown here
        about = f"file {path.name}"
        match placing.state(path, text):
            case "current":
                yield Finding(about=about, level="good", text=f"{path} is as this lbr writes it")
            case "absent":
                yield Finding(about=about, level="hint", text=f"{path} is missing", do=_again())
            case "outdated":
                yield Finding(about=about, level="hint", text=f"{path} is of another lbr or machine", do=_again())
            case "edited":
                do = f"{_again()} --overwrite, if that was not meant"
                yield Finding(about=about, level="hint", text=f"{path} was edited", do=do)


def _user(unit: str) -> Iterator[Finding]:
    user = unitfiles.user_of(unit)
    try:
        pwd.getpwnam(user)
    except KeyError:
        yield Finding(about="service user", level="bad", text=f"there is no user '{user}'", do="sudo systemd-sysusers")
        return
    named = re.search(r"^SupplementaryGroups=(.*)$", unit, re.MULTILINE)
    wanted = named[1].split() if named else []
    missing = [name for name in wanted if name not in {group.gr_name for group in grp.getgrall()}]
    closed = unitfiles.unreadable(user)
    if missing:
        text = f"the unit names the group {', '.join(missing)}, which is not there: it cannot start"
        yield Finding(about="service user", level="bad", text=text, do=_again())
    elif closed:
        text = f"'{user}' may not enter {closed}, where lbr is"
        yield Finding(about="service user", level="bad", text=text, do="install lbr elsewhere, such as in /opt/lbr")
    else:
        text = f"'{user}' with {', '.join(wanted) or 'no further groups'}"
        yield Finding(about="service user", level="good", text=text)


def _enabled(root: Path) -> Iterator[Finding]:
    names = sorted({path.stem for path in (root / "etc/systemd/system").glob("*.wants/lbr@*.service")})
    if names:
        yield Finding(about="service at start", level="good", text=f"{', '.join(names)} starts with the machine")
    else:
        do = f"sudo systemctl enable --now lbr@{unitfiles.DEFAULT_PROFILE}"
        yield Finding(about="service at start", level="hint", text="none starts with the machine", do=do)


def _running() -> Iterator[Finding]:
    words = ["systemctl", "show", "--all", f"--property={','.join(PROPERTIES)}", "lbr@*.service"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=ANSWER_S, check=False)
    except (OSError, subprocess.TimeoutExpired) as err:
        yield Finding(about="service", level="hint", text=f"systemctl does not answer: {err}", do=" ".join(words))
        return
    for block in filter(None, done.stdout.strip().split("\n\n")):
        shown = dict(line.partition("=")[::2] for line in block.splitlines())
        yield judged(shown, _limits(shown.get("MainPID", "0")))


def _limits(pid: str) -> str:
    try:
        return Path(f"/proc/{pid}/limits").read_text()
    except OSError:
        return ""


def _again() -> str:
    return f"sudo {' '.join(unitfiles.this_site().program)} service install"
