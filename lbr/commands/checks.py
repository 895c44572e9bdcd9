"""The checks of `lbr doctor`: each reports the state of one thing, and its cure."""

import grp
import importlib.util
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import home, ownership, plugins
from lbr.bus import stamp, wire
from lbr.capability.border import border
from lbr.commands import device_checks, power_checks, service_checks
from lbr.commands.finding import Finding
from lbr.commands.rows import opened
from lbr.console import target
from lbr.errors import LbrError, told
from lbr.executive.planning import joining
from lbr.robot import registry

EXTRAS = {
    "sim": (("mujoco", "PIL"), "simulated robots need it"),
    "camera": (("linuxpy",), "V4L2 cameras need it"),
    "phidgets": (("Phidget22",), "a PhidgetSpatial on USB needs it"),
    "polly": (("botocore",), "the cloud's voices need it"),
    "recordings": (("av",), "recordings that are not PCM WAV need it"),
    "vision": (("cv2",), "robots that follow what they see need it"),
    "web": (
        ("segno", "starlette", "uvicorn", "websockets", "zeroconf"),
        "a robot's API and programs that serve over HTTP, such as navcam, need it",
    ),
}
SERIAL_GROUPS = ("dialout", "uucp", "tty")
FREE_MB = 500


class DeviceState(Struct):
    """The state of a driver's line, as its device reports it."""

    heard: bool | None = None


def examine() -> Iterator[Finding]:
    """Yield every finding; a check that fails itself is also a finding."""
    checks: tuple[Callable[[], Iterator[Finding]], ...] = (
        _python, _packages, _robots, _extras, _home, _disk, _database, _bus, _serial,
        device_checks.speech, device_checks.emulated, device_checks.of_packages, _governor, _clock, _running,
        service_checks.services, power_checks.power,
    )  # fmt: skip
    for check in checks:
        faults: list[Exception] = []
        with border(faults.append):
            yield from check()
        for err in faults:
            text = str(err) if isinstance(err, LbrError | OSError) else told(err)
            yield Finding(about=check.__name__.strip("_"), level="bad", text=text)


def _python() -> Iterator[Finding]:
    version = ".".join(map(str, sys.version_info[:3]))
    good = sys.version_info >= (3, 11)
    yield Finding(
        about="python",
        level="good" if good else "bad",
        text=f"{version} at {sys.executable}",
        do="" if good else "install Python 3.11 or newer",
    )


def _packages() -> Iterator[Finding]:
    missing = []
    for requirement in (one for one in metadata.requires("lbr") or () if ";" not in one):
        name = re.split(r"[<>=!~\[ ]", requirement)[0]
        try:
            metadata.version(name)
        except metadata.PackageNotFoundError:
            missing.append(name)
    if missing:
        yield Finding(about="packages", level="bad", text=f"missing: {', '.join(missing)}", do="pip install lbr")
    else:
        yield Finding(about="packages", level="good", text=f"lbr {plugins.version()} and all that it needs")


def _robots() -> Iterator[Finding]:
    """Check whether the robots of packages are usable."""
    for found in registry.every():
        if fault := joining.fault(found):
            yield Finding(about=f"robot '{found.name}'", level="hint", text=f"{fault}; all others run")


def _extras() -> Iterator[Finding]:
    for extra, (modules, what_for) in EXTRAS.items():
        missing = [module for module in modules if importlib.util.find_spec(module) is None]
        if missing:
            yield Finding(
                about=f"extra '{extra}'",
                level="hint",
                text=f"not installed ({', '.join(missing)}); {what_for}",
                do=f"pip install 'lbr[{extra}]'",
            )
        else:
            yield Finding(about=f"extra '{extra}'", level="good", text="installed")


def _home() -> Iterator[Finding]:
    place = home.home()
    keys = sorted((place / "credentials").glob("*"))
    faults = [fault for name in (".", "run", "logs", "credentials") for fault in ownership.faults(place / name)]
    faults += [fault for key in keys for fault in home.key_faults(key)]
    faults += ownership.database_faults(home.default_database())
    for fault in dict.fromkeys(faults):
        yield Finding(about="home", level="bad", text=f"{fault.path} {fault.text}", do=fault.do)
    if not os.access(place, os.W_OK | os.X_OK):
        yield Finding(about="home", level="bad", text=f"{place} cannot be written", do=f"chmod u+rwx {place}")
    elif not faults:
        yield Finding(about="home", level="good", text=str(place))


def _disk() -> Iterator[Finding]:
    found = os.statvfs(home.home())
    free_mb = found.f_bavail * found.f_frsize // 1_000_000
    good = free_mb >= FREE_MB
    do = "" if good else f"free some space; see {home.home() / 'logs'}"
    yield Finding(about="disk", level="good" if good else "hint", text=f"{free_mb} MB free", do=do)


def _database() -> Iterator[Finding]:
    path = home.default_database()
    if not path.exists():
        text = f"{path} is not there yet; the first 'lbr run' makes it"
        yield Finding(about="database", level="good", text=text)
        return
    with opened(path) as rows:
        for name in rows.robots():
            loaded = rows.load(name)
            if loaded.problems:
                text = f"robot '{name}' in {path} has {len(loaded.problems)} bad rows; the first: {loaded.problems[0]}"
                yield Finding(about="database", level="bad", text=text, do="lbr db check")
            else:
                yield Finding(about="database", level="good", text=f"robot '{name}' in {path}")
            for device in loaded.devices:
                yield device_checks.device(name, device)
                yield from device_checks.numbered(device)
                yield from device_checks.latency(device)
            for brought in plugins.every("checks"):
                yield from brought.load()(name, loaded.capabilities)


def _bus() -> Iterator[Finding]:
    from lbr.bus import session  # noqa: PLC0415 - the bus library is one of the things to check

    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        endpoint = f"unixsock-stream/{place}/doctor.sock"
        with session.open_router(session.Router(listen=(endpoint,))), session.open_client([endpoint]):
            yield Finding(about="bus", level="good", text="a router and a client of it open")


def _serial() -> Iterator[Finding]:
    ports = sorted(Path("/dev/serial/by-id").glob("*")) if Path("/dev/serial/by-id").exists() else []
    text = ", ".join(port.name for port in ports) or "none plugged in"
    yield Finding(about="serial ports", level="good", text=text)
    groups = {group.gr_name: group.gr_gid for group in grp.getgrall()}
    known = [name for name in SERIAL_GROUPS if name in groups]
    if os.getuid() == 0 or not known or any(groups[name] in os.getgroups() for name in known):
        yield Finding(about="serial rights", level="good", text="serial ports may be opened")
    else:
        do = f"sudo usermod -aG {known[0]} $USER, then log in again"
        yield Finding(about="serial rights", level="hint", text=f"you are not in the group '{known[0]}'", do=do)


def _governor() -> Iterator[Finding]:
    path = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    governor = path.read_text().strip() if path.exists() else ""
    if governor == "powersave":
        do = f"echo performance | sudo tee {path}"
        yield Finding(about="CPU", level="hint", text=f"governor '{governor}' makes motion loops late", do=do)
    else:
        text = f"{os.cpu_count()} cores" + (f", governor '{governor}'" if governor else "")
        yield Finding(about="CPU", level="good", text=text)


def _clock() -> Iterator[Finding]:
    if stamp.boot_id():
        yield Finding(about="clock", level="good", text="the age of messages is known")
    else:
        text = "no boot id: the age of messages is unknown"
        yield Finding(about="clock", level="hint", text=text, do="mount /proc")


def _running() -> Iterator[Finding]:
    robots = home.running()
    names = [f"{one.robot} ({one.profile}, pid {one.pid})" for one in robots]
    yield Finding(about="running", level="good", text=", ".join(names) or "no robot runs here")
    for one in robots:
        yield from _unheard(one.robot)


def _unheard(robot: str) -> Iterator[Finding]:
    """Report drivers whose device has sent nothing since its line was opened."""
    with target.connected(target.find(robot, None)) as bus:
        states = wire.ask(bus, f"{robot}/*/state", None, source=target.source("lbr doctor"))
    for state in states:
        if msgspec.json.decode(state.payload, type=DeviceState).heard is False:
            name = state.key.split("/")[1]
            text = (
                f"the device of '{name}' has sent nothing since its line was opened: its state is what was sent to it"
            )
            yield Finding(about=f"{robot}/{name}", level="hint", text=text, do="check the device's power and cable")
