"""`lbr service`."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import click

from lbr.commands import placing, unitfiles
from lbr.commands.options import FileName, complete_profile
from lbr.commands.placing import Step
from lbr.commands.unitfiles import DEFAULT_USER, UNIT, this_site, user_of

BOOTED = Path("/run/systemd/system")
MACHINE = Path("/")
TELL_S = 30.0
RULED = ("tty", "usb", "usb-serial", "i2c-dev", "lirc")
"""The subsystems with device rules; plugged-in devices are examined again."""

profile_argument = click.argument("profile", default="lbr", shell_complete=complete_profile)
user_option = click.option(
    "--user", metavar="NAME", help="Run as this user, who exists; 'lbr', made again, if left out."
)
root_option = click.option(
    "--root", type=FileName(exists=True, file_okay=False), default=MACHINE, metavar="DIR",
    help="Not this machine, but the system in this directory, such as an image.",
)  # fmt: skip
power_off_option = click.option(
    "--power-off", is_flag=True, help="Let the robot's user power this computer off, for a shutdown in time."
)
motor_relay_option = click.option(
    "--motor-relay", metavar="ADDRESS", help="Have the relay of the UPS PIco there (i2c:1:0x69) feed the motors."
)
dry_run_option = click.option("--dry-run", is_flag=True, help="Show the effects, and write nothing.")
overwrite_option = click.option("--overwrite", is_flag=True, help="Files that were edited by hand, too.")


@click.group("service")
def command() -> None:
    """Run a robot as a service of systemd, from the start of the machine on."""


@command.command("show")
@profile_argument
@user_option
@power_off_option
@motor_relay_option
@root_option
def show(profile: str, user: str | None, power_off: bool, motor_relay: str | None, root: Path) -> None:
    """Print the files that 'install' writes: unit, user, device rules."""
    for name, text in _files(profile, user, root, power_off=power_off, motor_relay=motor_relay).items():
        click.echo(f"# ---- {root / name}\n{text}")


@command.command("install")
@profile_argument
@user_option
@power_off_option
@motor_relay_option
@root_option
@dry_run_option
@overwrite_option
def install(
    profile: str, user: str | None, power_off: bool, motor_relay: str | None, root: Path, dry_run: bool, overwrite: bool
) -> int:
    """Make the robot with launch profile PROFILE (default lbr) a service; starts nothing.

    May be repeated: user, right to power off and relay stay as they were unless an option changes them.
    """
    files = _files(profile, user, root, power_off=power_off, motor_relay=motor_relay)
    code = _report(lambda: placing.install(root, files, overwrite=overwrite, dry_run=dry_run))
    if code == 0:
        _tell(root, (("systemd-sysusers",), *_RELOAD), dry_run=dry_run)
        _say_next(profile, user, root)
    return code


@command.command("remove")
@root_option
@dry_run_option
@overwrite_option
def remove(root: Path, dry_run: bool, overwrite: bool) -> int:
    """Stop and remove the services and their files. The robot's rows and logs stay."""
    if (root / UNIT).exists() and os.access((root / UNIT).parent, os.W_OK):
        _tell(root, (("systemctl", "stop", "lbr@*.service"),), dry_run=dry_run)
    code = _report(
        lambda: [*_disable(root, dry_run=dry_run), *placing.remove(root, overwrite=overwrite, dry_run=dry_run)]
    )
    if code == 0:
        _tell(root, _RELOAD, dry_run=dry_run)
        click.echo("rows, logs and the user stay; for these too: sudo rm -r /var/lib/lbr; sudo userdel lbr")
    return code


_RELOAD = (
    ("systemctl", "daemon-reload"),
    ("udevadm", "control", "--reload"),
    ("udevadm", "trigger", *(f"--subsystem-match={name}" for name in RULED)),
)


def _files(profile: str, user: str | None, root: Path, *, power_off: bool, motor_relay: str | None) -> dict[str, str]:
    before = unitfiles.extras_of(root)
    extras = unitfiles.Extras(
        power_off=power_off or before.power_off, motor_relay=before.motor_relay if motor_relay is None else motor_relay
    )
    return unitfiles.files(profile, _user(user, root), unitfiles.this_site(root), extras)


def _user(user: str | None, root: Path) -> str:
    """Return the user for the service: the given one, or the previous one."""
    unit = root / UNIT
    return user or (user_of(unit.read_text(errors="replace")) if unit.exists() else DEFAULT_USER)


def _report(do: Callable[[], Iterable[Step]]) -> int:
    try:
        steps = list(do())
    except PermissionError:
        click.echo(f"lbr: this needs root. Type:\n  sudo {' '.join((*this_site().program, *sys.argv[1:]))}", err=True)
        return 1
    except OSError as err:
        click.echo(f"lbr: {err.filename}: {err.strerror}", err=True)
        return 1
    for step in steps:
        click.echo(f"{step.path}: {step.done}")
    return 1 if any("--overwrite" in step.done for step in steps) else 0


def _disable(root: Path, *, dry_run: bool) -> list[Step]:
    """Remove the links that start the services with the machine."""
    links = sorted((root / "etc/systemd/system").glob("*.wants/lbr@*.service"))
    for link in () if dry_run else links:
        link.unlink()
    return [Step(link, "would be removed" if dry_run else "removed") for link in links]


def _tell(root: Path, commands: Iterable[tuple[str, ...]], *, dry_run: bool) -> None:
    """Run the commands by which the running system learns of the change; missing or failed ones are only reported."""
    if root != MACHINE or not BOOTED.exists():
        return
    for words in commands:
        if dry_run:
            click.echo(f"would run: {' '.join(words)}")
        elif shutil.which(words[0]) is None:
            click.echo(f"not run, {words[0]} is not installed: {' '.join(words)}", err=True)
        elif subprocess.run(words, stdin=subprocess.DEVNULL, timeout=TELL_S, check=False).returncode:
            click.echo(f"failed: {' '.join(words)}", err=True)


def _say_next(profile: str, user: str | None, root: Path) -> None:
    name = unitfiles.instance_of(profile)[0]
    account = _user(user, root)
    if root == MACHINE:
        closed = unitfiles.unreadable(account)
        if closed:
            click.echo(
                f"user '{account}' may not enter {closed}, where lbr is; install it elsewhere, such as in /opt/lbr"
            )
        click.echo(f"to start it now and with the machine: sudo systemctl enable --now lbr@{name}")
    else:
        click.echo(f"to start it with that system: systemctl --root={root} enable lbr@{name}")
