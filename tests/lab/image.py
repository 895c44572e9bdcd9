"""Builds the machine's files: Debian by mmdebstrap, the project's wheel with its locked dependencies, and no compiler."""

import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from tests.lab import processor
from tests.lab.processor import PROCESSORS
from tests.support import programs

ROOT = Path(__file__).resolve().parents[2]
SUITES = {"bookworm": "3.11", "trixie": "3.13"}
"""Debian's releases, and the Python that each has."""
PROGRAMS = ("mmdebstrap", "qemu-img", "mke2fs", "ssh", "ssh-keygen")
PACKAGES = (
    "systemd-sysv", "dbus", "polkitd", "udev", "kmod", "iproute2", "openssh-server", "procps", "psmisc", "python3-venv",
    "ca-certificates", "alsa-utils", "espeak-ng", "ir-keytable", "i2c-tools", "initramfs-tools", "zstd",
)  # fmt: skip
FOR_TESTS = ("linuxpy", "pytest", "pytest-timeout", "hypothesis")
FOR_FIRST_START = ("cloud-init", "git", "sqlite3", "sudo")
FOR_SOURCE = ("hatchling",)
"""What builds the project from its source."""
WHEELS = "/opt/wheels"
LEFT_OUT = ("man", "doc", "locale", "info")
DISK = "3G"
MASKED = (
    "systemd-networkd-wait-online", "systemd-timesyncd", "apt-daily.timer", "apt-daily-upgrade.timer", "dpkg-db-backup.timer",
    "e2scrub_all.timer", "e2scrub_reap",
)  # fmt: skip
FILES = {
    "etc/initramfs-tools/conf.d/lab": "MODULES=list\nRESUME=none\n",
    "etc/initramfs-tools/modules": "virtio_pci\nvirtio_blk\next4\ncrc32c_generic\n",
    "etc/hostname": "lab\n",
    "etc/hosts": "127.0.0.1 localhost lab\n",
    "etc/fstab": "/dev/vda / ext4 errors=remount-ro 0 1\n",
    "etc/ssh/sshd_config.d/lab.conf": "UseDNS no\nUsePAM no\nLoginGraceTime 900\n",
    "etc/systemd/journald.conf.d/lab.conf": "[Journal]\nStorage=persistent\n",
    "etc/systemd/system/lab-network.service": """[Unit]
DefaultDependencies=no
Before=network.target ssh.service
Wants=network.target
[Service]
Type=oneshot
RemainAfterExit=yes
ExecStart=/bin/sh -c 'until ip link show eth0; do sleep 1; done; ip link set lo up; ip address add 10.0.2.15/24 dev eth0; ip link set eth0 up; ip route add default via 10.0.2.2'
[Install]
WantedBy=multi-user.target
""",
}
"""An address that is known from the start: nothing waits for a network to be configured."""
FIRST_START_FILES = {
    "etc/cloud/cloud.cfg.d/lab.cfg": "datasource_list: [NoCloud]\ndisable_root: false\nlocale: false\nnetwork: {config: disabled}\n",
    "etc/pip.conf": f"[global]\nno-index = true\nfind-links = {WHEELS}\n",
}


def why_not(arch: str) -> str:
    """Return why no machine of that processor can be built here; nothing if one can."""
    if os.geteuid() != 0:
        return "only root may build a root file system"
    missing = [name for name in (*PROGRAMS, *PROCESSORS[arch].programs) if shutil.which(name) is None]
    return f"missing here: {', '.join(missing)}; docs/lab.md names their packages" if missing else ""


def build(folder: Path, suite: str, arch: str) -> None:
    """Make `disk.qcow2`, `vmlinuz`, `initrd.img` and `key` in a folder: a machine with the project and what its tests need."""
    pip = f"env -u PIP_FIND_LINKS -u PIP_INDEX_URL /opt/lbr/bin/pip install -q --no-index --find-links {WHEELS}"
    _make(
        folder, suite, arch, (), FILES, FOR_TESTS,
        "chroot $1 python3 -m venv /opt/lbr",
        f"chroot $1 {pip} 'lbr[sim]' {' '.join(FOR_TESTS)}",
        f"rm -r $1{WHEELS}",
    )  # fmt: skip


def build_for_first_start(folder: Path, suite: str, arch: str) -> None:
    """Make the same of a machine that cloud-init makes a robot of: it has wheels of the project, and no network to fetch any."""
    files = {**FILES, **FIRST_START_FILES}
    _make(folder, suite, arch, FOR_FIRST_START, files, FOR_SOURCE, "truncate -s 0 $1/etc/apt/sources.list")


def _make(
    folder: Path,
    suite: str,
    arch: str,
    packages: Sequence[str],
    files: Mapping[str, str],
    wheels_for: Sequence[str],
    *hooks: str,
) -> None:
    kind = PROCESSORS[arch]
    root, wheels = folder / "root", folder / "wheels"
    for place in (root, wheels):
        shutil.rmtree(place, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    wheels.mkdir()
    processor.keep(folder, arch)
    _collect(wheels, SUITES[suite], kind.platforms, wheels_for)
    if not (folder / "key").exists():
        _do("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / "key"))
    _do(
        "mmdebstrap", "--mode=root", "--variant=minbase", "--quiet", "--format=directory",
        f"--architectures={arch}", f"--include={','.join((*PACKAGES, kind.kernel, *packages))}",
        *(f"--dpkgopt=path-exclude=/usr/share/{name}/*" for name in LEFT_OUT),
        f"--essential-hook=cp -r {_laid_out(folder, files)}/. $1/",
        f"--customize-hook=mkdir -p $1{WHEELS} && cp {wheels}/* $1{WHEELS}/",
        *(f"--customize-hook={hook}" for hook in hooks),
        "--customize-hook=chroot $1 systemctl -q enable lab-network ssh",
        f"--customize-hook=chroot $1 systemctl -q mask {' '.join(MASKED)}",
        suite, str(root),
    )  # fmt: skip
    for name in ("vmlinuz", "initrd.img"):
        shutil.copy(next((root / "boot").glob(f"{name}-*")), folder / name)
    raw = folder / "disk.raw"
    raw.unlink(missing_ok=True)
    _do("mke2fs", "-q", "-t", "ext4", "-d", str(root), str(raw), DISK)
    _do("qemu-img", "convert", "-f", "raw", "-O", "qcow2", str(raw), str(folder / "disk.qcow2"))
    raw.unlink()
    shutil.rmtree(root)
    shutil.rmtree(wheels)


def _collect(wheels: Path, python: str, tags: Sequence[str], others: Sequence[str]) -> None:
    """Gather the project's wheel, what it depends on as the lock has it, and what is needed besides."""
    pip = (sys.executable, "-m", "pip")
    _do(*pip, "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(wheels), str(ROOT))
    lock = ROOT / "requirements" / "lock.txt"
    platforms = (word for name in tags for word in ("--platform", name))
    meant_for = ("--implementation", "cp", "--python-version", python, *platforms)
    download = (*pip, "download", "-q", "--only-binary", ":all:", *meant_for, "-d", str(wheels))
    _do(*download, "--require-hashes", "-r", str(lock))
    _do(*download, *others)


def _laid_out(folder: Path, files: Mapping[str, str]) -> Path:
    """Write the machine's own files, and the key that opens it, as they will lie in it."""
    place = folder / "files"
    shutil.rmtree(place, ignore_errors=True)
    for name, text in files.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(text)
    (place / "root/.ssh").mkdir(parents=True, mode=0o700)
    shutil.copy(folder / "key.pub", place / "root/.ssh/authorized_keys")
    (place / "root").chmod(0o700)
    return place


def _do(*words: str) -> None:
    programs.run(["nice", "-n", "19", *words], check=True)
