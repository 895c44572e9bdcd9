"""The home and its keys: what others could change is refused, in a sentence with the command that mends it."""

import os
import ssl
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from starlette.applications import Starlette

from lbr import disk, home
from lbr.apps.http import listening, serving
from lbr.apps.navcam import server as navcam
from lbr.bus import certificates
from lbr.capability import lifeline
from lbr.commands import checks
from lbr.console import token_store
from lbr.errors import InputError
from lbr.executive.planning import credentials
from lbr.executive.service import latch
from tests.support import databases, needs, programs
from tests.support.commands import here
from tests.support.robot import lbr

STRANGER = 4321
AS_ROOT = needs.root("can act as somebody else")


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A home that was used before, with all its keys."""
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    home.directory("run")
    credentials.token_key()
    credentials.bus_certificate()
    navcam.token()
    return home.home()


@pytest.fixture
def shared():
    """A folder like /tmp, on a way that everybody may go."""
    with tempfile.TemporaryDirectory(prefix="lbr-shared-") as name:
        Path(name).chmod(0o1777)
        yield Path(name)


def as_a_stranger(*words: str) -> subprocess.CompletedProcess[str]:
    return programs.run(
        ["/bin/sh", "-c", *words], user=STRANGER, group=STRANGER, extra_groups=(), umask=0, text=True, check=False,
        capture_output=True, timeout=5,
    )  # fmt: skip


def doctors_findings() -> list[str]:
    return [f"{one.text}: {one.do}" for one in checks._home() if one.level == "bad"]


@pytest.mark.parametrize("folder", [".", "run", "credentials"])
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o1777])
def test_a_folder_that_others_may_fill_is_refused(place, folder, mode):
    (place / folder).chmod(mode)
    with pytest.raises(InputError, match=rf"\(mode {mode:04o}\): `chmod go-w {place / folder}`"):
        home.directory("credentials" if folder == "." else folder)
    assert any(f"chmod go-w {place / folder}" in text for text in doctors_findings())


@AS_ROOT
@pytest.mark.parametrize("folder", [".", "run", "credentials"])
def test_a_folder_of_somebody_else_is_refused(place, folder):
    os.chown(place / folder, STRANGER, STRANGER)
    with pytest.raises(InputError, match=r"belongs to user 4321 \(mode 0700\).*`sudo chown -h "):
        home.directory("credentials" if folder == "." else folder)


@AS_ROOT
def test_root_looks_at_somebodys_robots_but_takes_no_record_of_a_third(place):
    os.chown(place, STRANGER, STRANGER)
    os.chown(place / "run", STRANGER, STRANGER)
    assert home.running() == []
    os.chown(place / "run", STRANGER + 1, STRANGER + 1)
    with pytest.raises(InputError, match="belongs to user 4322"):
        home.running()


@AS_ROOT
def test_a_folder_for_sockets_that_a_stranger_made_first_is_refused(place, shared, monkeypatch):
    monkeypatch.setattr(home.tempfile, "gettempdir", lambda: str(shared))
    monkeypatch.setattr(home, "SOCKET_PATH_LIMIT", 10)
    short = home.socket_path("lbr").parent
    short.rmdir()
    assert not as_a_stranger(f"ln -s /etc {short}").returncode
    with pytest.raises(InputError, match="is a link of user 4321"):
        home.socket_path("lbr")


@pytest.mark.parametrize("content", [b"\xff\xfe", b"-----BEGIN CERTIFICATE-----\n\xff\n-----END CERTIFICATE-----\n"])
def test_a_certificate_that_is_damaged_is_told(place, content):
    (place / "credentials" / "bus.crt").write_bytes(content)
    with pytest.raises(InputError, match=r"bus\.crt has no certificate in it"):
        credentials.certificate_der()


@pytest.mark.parametrize(
    ("name", "use"),
    [
        ("token.key", credentials.token_key),
        ("bus.key", credentials.bus_certificate),
        ("navcam.token", navcam.token),
    ],
)
@pytest.mark.parametrize("fault", ["read", "changed", "empty", "foreign"])
def test_a_key_that_is_not_ours_alone_is_refused(place, name, use, fault):
    path = place / "credentials" / name
    if fault == "read":
        path.chmod(0o640)
        said = rf"{path} could be read by others \(mode 0640\): `chmod go= {path}`"
    elif fault == "changed":
        path.chmod(0o622)
        said = rf"{path} may be changed by others \(mode 0622\): `chmod go-w {path}`"
    elif fault == "empty":
        path.write_bytes(b"")
        said = rf"{path} is empty \(0 bytes\): `rm {path}`"
    elif os.geteuid():
        pytest.skip("only root can give files away")
    else:
        os.chown(path, STRANGER, STRANGER)
        said = rf"{path} belongs to user 4321 \(mode 0600\)"
    with pytest.raises(InputError, match=said):
        use()
    assert [text for text in doctors_findings() if str(path) in text]


def test_saved_tokens_that_others_may_change_are_refused(place):
    path = place / "credentials" / "robots.json"
    disk.write(path, b"{}")
    assert list(token_store.offered("tls/x:1", None)) == []
    path.chmod(0o622)
    with pytest.raises(InputError, match=rf"{path} may be changed by others \(mode 0622\)"):
        list(token_store.offered("tls/x:1", None))
    path.chmod(0o640)
    assert [text for text in doctors_findings() if "could be read by others" in text]


def test_a_key_that_was_cut_is_no_key(place):
    (place / "credentials" / "token.key").write_bytes(b"short")
    with pytest.raises(InputError, match=r"token.key has 5 bytes, and a key has 32: .*every token is void"):
        credentials.token_key()


def test_a_certificate_that_the_owner_put_there_is_what_browsers_are_shown(place, wording):
    folder = place / "credentials"
    assert listening.certificate() == (str(folder / "bus.key"), str(folder / "bus.crt"))
    assert not credentials.is_own_shown()
    of_robot, bus = credentials.fingerprint_shown(), credentials.certificate_der()
    key, own = certificates.self_signed()
    disk.write(folder / "web.crt", b"of an authority\n" + own + (folder / "bus.crt").read_bytes())
    with wording.of(InputError):
        listening.certificate()
    disk.write(folder / "web.key", key)
    assert listening.certificate() == (str(folder / "web.key"), str(folder / "web.crt"))
    assert certificates.first_der(folder / "web.crt") == ssl.PEM_cert_to_DER_cert(own.decode())
    assert credentials.fingerprint_shown() != of_robot
    assert credentials.certificate_der() == bus
    (folder / "web.key").chmod(0o644)
    with pytest.raises(InputError, match=r"web.key could be read by others"):
        listening.certificate()
    (folder / "web.key").chmod(0o600)
    (folder / "web.crt").write_text("no certificate")
    with pytest.raises(InputError, match=r"web.crt has no certificate in it"):
        credentials.fingerprint_shown()
    with pytest.raises(InputError, match=r"web.key and .*web.crt"):
        serving.Server(Starlette(), tls=True)


def test_a_certificate_may_be_read_by_everybody(place):
    (place / "credentials" / "bus.crt").chmod(0o644)
    credentials.bus_certificate()
    assert doctors_findings() == []


@AS_ROOT
@pytest.mark.parametrize(
    "words",
    [
        ["run", "--no-console", "--db"],
        ["db", "check", "--db"],
        ["db", "diff", "--db"],
        ["db", "audit", "--db"],
        ["token", "list", "--db"],
        ["motion", "export", "wave", "--robot", "bioloid", "--db"],
    ],
    ids=" ".join,
)
def test_every_command_refuses_a_strangers_log(shared, tmp_path, words):
    databases.fresh(shared / "robot.db")
    log = shared / "robot.db-wal"
    assert not as_a_stranger(f"echo edits > {log}").returncode
    done = (lbr if words[0] == "run" else here)(tmp_path / "home", *words, str(shared / "robot.db"))
    assert done.returncode == 2
    assert f"{log} belongs to user 4321 (mode 0666)" in done.stderr
    assert "Traceback" not in done.stderr
    assert log.read_text() == "edits\n"


@pytest.mark.parametrize("name", ["a#b", "a?b", "a\nb", "a\x7fb", "a\udcffb"])
@pytest.mark.parametrize("variable", ["LBR_HOME", "TMPDIR"])
def test_a_folder_whose_name_ends_a_sockets_address_is_refused(tmp_path, monkeypatch, variable, name, wording):
    """What the bus takes for the end of the path would have its sockets made elsewhere, where others may be."""
    long = tmp_path / ("long" * 25)
    monkeypatch.setenv("LBR_HOME", str(long / "h"))
    monkeypatch.setenv(variable, str(tmp_path / name))
    monkeypatch.setattr(tempfile, "tempdir", None)
    (tmp_path / name).mkdir()
    with wording.of(InputError):
        home.socket_path("lbr")


def test_a_record_that_is_no_file_says_nothing_and_keeps_nobody_waiting(monkeypatch, tmp_path):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    os.mkfifo(home.directory("run") / "lbr.json")
    assert home.running() == []
    (home.directory("run") / "bioloid.json").write_bytes(b'{"robot": "\xff"}')
    assert home.running() == []
    os.mkfifo(home.directory("run") / "lbr.estop")
    assert latch.read(home.directory("run") / "lbr.estop") == latch.UNREADABLE


def test_a_robot_that_runs_makes_no_second_home_where_its_own_was(tmp_path, wording):
    """A robot that runs makes no second home where its own was"""
    script = (
        "import shutil\n"
        "from lbr import home\n"
        "from lbr.errors import InputError\n"
        "lock = home.RunLock('lbr')\n"
        "shutil.rmtree(home.home())\n"
        "for use in (lambda: home.directory('logs'), lambda: home.credentials(list, 'bus.key'), home.running):\n"
        "    try:\n"
        "        print(use())\n"
        "    except InputError as err:\n"
        "        print(err)\n"
        "print(home.home().exists())\n"
        "lock.release()\n"
        "print(home.home().exists())\n"
    )
    place = tmp_path / "home"
    told = programs.run(
        [sys.executable, "-c", script], env=os.environ | {"LBR_HOME": str(place)}, text=True, check=True,
        capture_output=True, timeout=10,
    ).stdout.splitlines()  # fmt: skip
    wording(*told[:2])
    assert told[2:] == ["[]", "False", "False"]


def test_a_process_of_a_robot_makes_no_home_either(monkeypatch, tmp_path):
    """A process of a robot makes no home either"""
    assert lifeline.MARK == home.RUN_VARIABLE
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    monkeypatch.setenv(lifeline.MARK, "run")
    assert not home.home().exists()
    with pytest.raises(InputError, match="is gone: end the robot"):
        home.directory("credentials")
    assert not home.home().exists()


def test_who_only_looks_whether_a_robot_runs_makes_no_home(monkeypatch, tmp_path):
    """Who only looks whether a robot runs makes no home"""
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    assert home.running() == []
    assert not (tmp_path / "home").exists()
