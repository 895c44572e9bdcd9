"""The files that make a robot a service: unit, user and device rules, from the templates beside this module."""

import grp
import hashlib
import pwd
import re
import sys
from contextlib import suppress
from importlib import resources
from pathlib import Path

from msgspec import Struct

from lbr import plugins
from lbr.errors import InputError
from lbr.executive.planning import profile as profiles

DEFAULT_PROFILE, DEFAULT_USER = "lbr", "lbr"
UNIT = "etc/systemd/system/lbr@.service"
RULES = "etc/udev/rules.d/70-lbr.rules"
SYSUSERS = "etc/sysusers.d/lbr.conf"
DROP_IN = "etc/systemd/system/lbr@{}.service.d/10-lbr-profile.conf"
POLKIT = "etc/polkit-1/rules.d/50-lbr-power-off.rules"
RELAY_UNIT = "etc/systemd/system/lbr-motor-relay.service"
RELAY_DROP_IN = "etc/systemd/system/lbr@{}.service.d/20-lbr-motor-relay.conf"
GROUPS = ("dialout", "uucp", "video", "audio", "i2c", "input", "gpio", "spi")
SERIAL_GROUPS = ("dialout", "uucp")
RULES_BY_GROUP = {
    "i2c": '\n# i2c buses\nSUBSYSTEM=="i2c-dev", GROUP="i2c", MODE="0660"\n',
    "video": '\n# Infrared receivers\nSUBSYSTEM=="lirc", GROUP="video", MODE="0660"\n',
}
"""Rules for devices that belong to a group, where the machine has it."""
HIDDEN = tuple(map(Path, ("/home", "/root", "/run/user", "/tmp", "/var/tmp")))  # noqa: S108 - the unit hides them
_NAME = re.compile(r"[a-z_][a-z0-9_-]{0,31}")
_INSTANCE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")
_PLAIN_PATH = re.compile(r"/[\w/.+,-]*", re.ASCII)
_I2C = re.compile(r"i2c:\d{1,3}:0x[0-9a-f]{2}")
_RELAY = re.compile(r"^ExecStart=.* --address (\S+)", re.MULTILINE)
_HEAD = re.compile(
    r"(?:#|//) Written by 'lbr service install', version (\S+); sha256 of the lines below: ([0-9a-f]{64})\n"
)


class Site(Struct, frozen=True, kw_only=True):
    """The facts about a machine that the files contain: the program, its parts in hidden places, and the groups."""

    program: tuple[str, ...]
    inside_hidden: tuple[Path, ...] = ()
    groups: tuple[str, ...] = ()


class Extras(Struct, frozen=True, kw_only=True):
    """For some robots only: the right to power off the computer, and a UPS PIco whose relay feeds the motors."""

    power_off: bool = False
    motor_relay: str = ""


NO_EXTRAS = Extras()


def this_site(root: Path = Path("/")) -> Site:
    """Return the running program, and the groups of the machine at `root`."""
    command = Path(sys.prefix) / "bin" / "lbr"
    program = (str(command),) if command.exists() else (sys.executable, "-m", "lbr.start")
    return Site(
        program=program,
        inside_hidden=tuple(place for place in program_places() if _is_hidden(place)),
        groups=tuple(name for name in GROUPS if name in _groups(root)),
    )


def program_places() -> tuple[Path, ...]:
    """Return the directories that the service must be able to read."""
    package = Path(__file__).resolve().parent.parent
    places: list[Path] = []
    for place in sorted({Path(sys.prefix), Path(sys.base_prefix).resolve(), package.parent}):
        if not any(place.is_relative_to(known) for known in places):
            places.append(place)
    return tuple(places)


def extras_of(root: Path) -> Extras:
    """Return the extras that are installed at `root`, as far as this user may read: polkit's rules only root may."""
    unit, power_off = root / RELAY_UNIT, False
    found = _RELAY.search(unit.read_text(errors="replace")) if unit.exists() else None
    with suppress(PermissionError):
        power_off = (root / POLKIT).exists()
    return Extras(power_off=power_off, motor_relay=found[1] if found else "")


def files(profile: str, user: str, site: Site, extras: Extras = NO_EXTRAS) -> dict[str, str]:
    """Return text by path, relative to the root of the machine; raise InputError for values that no unit can hold."""
    _check_user(user)
    for place in (*site.program[:1], *map(str, site.inside_hidden)):
        if not _PLAIN_PATH.fullmatch(place):
            raise InputError(f"{place}: install lbr at a path of letters, digits and . _ + , - only, such as /opt/lbr")
    unit = _filled(
        "lbr@.service",
        PROGRAM=" ".join(site.program),
        USER=user,
        GROUPS=" ".join(site.groups),
        PROTECT_HOME=_protect_home(site.inside_hidden),
    )
    serial = next((name for name in SERIAL_GROUPS if name in site.groups), "root")
    others = "".join(rule for group, rule in RULES_BY_GROUP.items() if group in site.groups)
    texts = {UNIT: unit, RULES: _filled("lbr.rules", SERIAL_GROUP=serial, OTHERS=others)}
    if user == DEFAULT_USER:
        texts[SYSUSERS] = _sysusers(site.groups)
    instance, own = instance_of(profile)
    if own is not None:
        words = f"{' '.join(site.program)} run {own} --no-console"
        texts[DROP_IN.format(instance)] = f"[Service]\nExecStart=\nExecStart={words}\n"
    texts |= _extras(instance, user, site, extras)
    return {name: stamped(text, "//" if name == POLKIT else "#") for name, text in texts.items()}


def instance_of(profile: str) -> tuple[str, Path | None]:
    """Return the unit's instance for a profile, and the profile's file if it is one of your own."""
    profiles.load(profile)
    if profile in profiles.names():
        return profile, None
    path = Path(profile).absolute()
    if not _INSTANCE.fullmatch(path.stem) or path.stem in profiles.names():
        raise InputError(f"{path}: a name of letters, digits, '.', '_' and '-' that no shipped profile has is allowed")
    if _is_hidden(path) or not _PLAIN_PATH.fullmatch(str(path)):
        raise InputError(f"{path}: a service cannot read it there; move it, such as to /etc/lbr/{path.name}")
    return path.stem, path


def stamped(text: str, comment: str = "#") -> str:
    """Add a head to a file that later shows whether it was edited."""
    digest = hashlib.sha256(text.encode()).hexdigest()
    head = (
        f"{comment} Written by 'lbr service install', version {plugins.version()}; sha256 of the lines below: {digest}"
    )
    return f"{head}\n{text}"


def is_pristine(text: str) -> bool:
    """Return whether a file is unchanged since it was written."""
    head = _HEAD.match(text)
    return head is not None and hashlib.sha256(text[head.end() :].encode()).hexdigest() == head[2]


def user_of(unit: str) -> str:
    """Return the user that a unit's text names."""
    found = re.search(r"^User=(\S+)$", unit, re.MULTILINE)
    return found[1] if found else DEFAULT_USER


def unreadable(user: str) -> str:
    """Return the first directory of the program that the user may not enter, or an empty text."""
    try:
        known = pwd.getpwnam(user)
        uid, gids = known.pw_uid, {known.pw_gid, *(one.gr_gid for one in grp.getgrall() if user in one.gr_mem)}
    except KeyError:
        uid, gids = -1, set()
    for place in program_places():
        ways = (place,) if _is_hidden(place) else (*reversed(place.parents), place)
        for way in ways:
            found = way.stat()
            shift = 6 if found.st_uid == uid else 3 if found.st_gid in gids else 0
            if not found.st_mode >> shift & 1:
                return str(way)
    return ""


def _extras(instance: str, user: str, site: Site, extras: Extras) -> dict[str, str]:
    texts = {}
    if extras.power_off:
        texts[POLKIT] = _filled("lbr-power-off.rules", USER=user)
    if extras.motor_relay:
        if not _I2C.fullmatch(extras.motor_relay):
            raise InputError(f"motor relay '{extras.motor_relay}': i2c:BUS:ADDRESS is allowed, such as i2c:1:0x69")
        texts[RELAY_UNIT] = _filled(
            "lbr-motor-relay.service",
            PYTHON=_python(site),
            ADDRESS=extras.motor_relay,
            USER=user,
            GROUPS="i2c" if "i2c" in site.groups else "",
            PROTECT_HOME=_protect_home(site.inside_hidden),
        )
        name = Path(RELAY_UNIT).name
        texts[RELAY_DROP_IN.format(instance)] = f"[Unit]\nBindsTo={name}\nAfter={name}\n"
    return texts


def _python(site: Site) -> str:
    """Return the interpreter that the program runs in."""
    program = Path(site.program[0])
    return str(program.with_name("python")) if program.name == "lbr" else str(program)


def _check_user(user: str) -> None:
    if not _NAME.fullmatch(user):
        raise InputError(f"user {user!r}: small letters, digits, '_' and '-' are allowed")
    if user == "root":
        raise InputError("a robot does not run as root; name another user, or leave --user out")


def _protect_home(inside: tuple[Path, ...]) -> str:
    if not inside:
        return "ProtectHome=yes"
    return f"ProtectHome=tmpfs\nBindReadOnlyPaths={' '.join(map(str, inside))}"


def _sysusers(groups: tuple[str, ...]) -> str:
    lines = [f'u {DEFAULT_USER} - "lbr robot" /var/lib/lbr', *(f"m {DEFAULT_USER} {name}" for name in groups)]
    return "\n".join(lines) + "\n"


def _filled(template: str, **words: str) -> str:
    text = (resources.files("lbr.commands") / "templates" / template).read_text()
    for name, value in words.items():
        text = text.replace(f"@{name}@", value)
    return text


def _is_hidden(path: Path) -> bool:
    return any(path.is_relative_to(place) for place in HIDDEN)


def _groups(root: Path) -> set[str]:
    if root == Path("/"):
        return {group.gr_name for group in grp.getgrall()}
    table = root / "etc/group"
    if not table.exists():
        return {*GROUPS[:1], "video", "audio"}
    return {line.split(":")[0] for line in table.read_text().splitlines()}
