"""A robot as a service: files that systemd understands, put in place and taken away, edited ones left alone."""

import re
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from lbr.cli import cli
from lbr.commands import placing, service, service_checks, unitfiles
from lbr.commands.unitfiles import RULES, SYSUSERS, UNIT, Site
from lbr.errors import InputError
from tests.support import needs, programs
from tests.support.waiting import HANG_S

EXPOSURE_TENTHS = 25
SITE = Site(program=(str(Path(sys.prefix) / "bin" / "lbr"),), groups=("dialout", "video", "i2c"))
analyze = needs.program("systemd-analyze", "systemd")


def lbr(*arguments: str) -> tuple[int, str]:
    """Run `lbr service …` here; return its code and what it said."""
    done = CliRunner().invoke(cli, ["service", *arguments], standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return done.return_value, done.output


def contents(root: Path) -> dict[str, str]:
    return {str(path.relative_to(root)): path.read_text() for path in root.rglob("*") if path.is_file()}


# -- what the files say -------------------------------------------------------------------------------------------


@pytest.fixture
def unit(tmp_path: Path) -> Path:
    """The unit as an instance, with groups that every machine has."""
    site = Site(program=SITE.program, groups=("tty",))
    path = tmp_path / "lbr@lbr-sim.service"
    path.write_text(unitfiles.files("lbr-sim", "daemon", site)[UNIT])
    return path


@analyze
def test_systemd_understands_the_unit_without_a_word(unit):
    done = programs.run(
        ["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True, check=False, timeout=HANG_S
    )
    said = [line for line in done.stderr.splitlines() if unit.name in line]
    assert (done.returncode, said) == (0, [])


@analyze
def test_the_unit_exposes_little(unit):
    words = ["systemd-analyze", "security", "--offline=yes", f"--threshold={EXPOSURE_TENTHS}", "--no-pager", unit]
    done = programs.run(words, capture_output=True, text=True, check=False, timeout=HANG_S)
    if "unrecognized option" in done.stderr:
        pytest.skip("this systemd-analyze knows no --offline")
    assert done.returncode == 0, done.stdout[-300:]


def test_the_unit_is_watched_restarted_slowly_and_without_any_capability(unit):
    lines = unit.read_text().splitlines()
    for line in (
        "Type=notify", "NotifyAccess=main", "WatchdogSec=2", "TimeoutStartSec=120", "Restart=on-failure", "KillMode=mixed", "UMask=0077",
        "CapabilityBoundingSet=", "AmbientCapabilities=", "NoNewPrivileges=yes", "User=daemon",
    ):  # fmt: skip
        assert line in lines, line


def test_every_marker_of_the_templates_is_filled():
    for name, text in unitfiles.files("lbr", "lbr", SITE).items():
        assert not re.search(r"@[A-Z0-9_]+@", text), name


def test_an_image_that_is_not_there_is_not_made(tmp_path):
    with pytest.raises(click.BadParameter, match="does not exist"):
        lbr("install", "--root", str(tmp_path / "imgae"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["/home/ada/robot/.venv", "/root/x", "/tmp/try"])
def test_a_program_in_a_place_that_the_unit_hides_is_shown_to_it_read_only(place):
    site = Site(program=(f"{place}/bin/lbr",), inside_hidden=(Path(place),))
    text = unitfiles.files("lbr", "lbr", site)[UNIT]
    assert f"ProtectHome=tmpfs\nBindReadOnlyPaths={place}\n" in text
    assert "ProtectHome=yes" in unitfiles.files("lbr", "lbr", SITE)[UNIT]


def test_groups_are_those_of_the_machine_that_it_is_for(tmp_path):
    (tmp_path / "etc").mkdir()
    (tmp_path / "etc/group").write_text("root:x:0:\nuucp:x:14:\ni2c:x:99:\n")
    site = unitfiles.this_site(tmp_path)
    assert site.groups == ("uucp", "i2c")
    found = unitfiles.files("lbr", "lbr", site)
    assert "SupplementaryGroups=uucp i2c\n" in found[UNIT]
    assert 'GROUP="uucp"' in found[RULES]
    assert '"i2c-dev", GROUP="i2c"' in found[RULES]
    assert "m lbr uucp\nm lbr i2c\n" in found[SYSUSERS]


def test_what_is_plugged_in_already_is_looked_at_again_for_every_rule():
    groups = tuple(unitfiles.RULES_BY_GROUP)
    text = unitfiles.files("lbr", "lbr", Site(program=SITE.program, groups=groups))[RULES]
    assert set(re.findall(r'SUBSYSTEM=="([^"]+)"', text)) == set(service.RULED)


RULE = re.compile(
    r'(SUBSYSTEM|ACTION|KERNEL|DRIVER|ATTRS?\{\w+\}|ENV\{\w+\}|GROUP|MODE|SYMLINK|LABEL|GOTO)(==|!=|\+=|=)"([^"]*)"'
)
MATCHED = ("SUBSYSTEM", "ACTION", "KERNEL", "DRIVER", "ATTR")
WRITTEN = {"ATTR{latency_timer}"}


@pytest.mark.parametrize("groups", [(), ("dialout",), ("dialout", "i2c"), ("i2c", "video")])
def test_device_rules_are_well_formed_and_open_nothing_to_everybody(groups):
    text = unitfiles.files("lbr", "lbr", Site(program=SITE.program, groups=groups))[RULES]
    labels, jumps = set(), set()
    for line in (one for one in text.splitlines() if one and not one.startswith("#")):
        for token in line.split(", "):
            rule = RULE.fullmatch(token)
            assert rule is not None, token
            key, operator, value = rule.groups()
            assert operator in {"==", "!="} or not key.startswith(MATCHED) or key in WRITTEN, token
            assert key != "MODE" or value == "0660", token
            assert key != "GROUP" or value in {*groups, "root"}, token
            labels |= {value} if key == "LABEL" else set()
            jumps |= {value} if key == "GOTO" else set()
        assert "GROUP=" not in line or "MODE=" in line, line
    assert jumps <= labels


@pytest.mark.parametrize(
    ("profile", "user", "program"),
    [
        ("lbr", "root", "/opt/lbr/bin/lbr"),
        ("lbr", "a b", "/opt/lbr/bin/lbr"),
        ("lbr", "x\nExecStartPre=/bin/sh", "/opt/lbr/bin/lbr"),
        ("lbr", "lbr", "/opt/my robot/bin/lbr"),
        ("lbr", "lbr", "/opt/%h/bin/lbr"),
        ("nope", "lbr", "/opt/lbr/bin/lbr"),
    ],
)
def test_what_no_unit_can_say_is_refused(profile, user, program, wording):
    with wording.of(InputError):
        unitfiles.files(profile, user, Site(program=(program,)))


def test_a_profile_of_your_own_becomes_an_instance_with_its_file(tmp_path, monkeypatch):
    monkeypatch.setattr(unitfiles, "HIDDEN", ())
    path = tmp_path / "kitchen.toml"
    path.write_text('robot = "lbr"\n')
    found = unitfiles.files(str(path), "lbr", SITE)
    drop_in = found["etc/systemd/system/lbr@kitchen.service.d/10-lbr-profile.conf"]
    assert f"ExecStart=\nExecStart={SITE.program[0]} run {path} --no-console\n" in drop_in


def test_a_profile_that_the_service_could_not_read_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(unitfiles, "HIDDEN", (tmp_path,))
    path = tmp_path / "kitchen.toml"
    path.write_text('robot = "lbr"\n')
    with pytest.raises(InputError, match=r"move it, such as to /etc/lbr/kitchen\.toml"):
        unitfiles.files(str(path), "lbr", SITE)


# -- in place and away --------------------------------------------------------------------------------------------


def test_install_writes_what_show_prints_and_again_changes_nothing(tmp_path):
    root = str(tmp_path)
    shown = lbr("show", "--root", root)[1]
    assert lbr("install", "--root", root)[0] == 0
    placed = contents(tmp_path)
    assert set(placed) == {UNIT, RULES, SYSUSERS}
    assert all(text in shown for text in placed.values())
    assert all(path.stat().st_mode & 0o777 == 0o644 for path in (tmp_path / name for name in placed))
    code, said = lbr("install", "--root", root)
    assert (code, said.count("is as it should be")) == (0, 3)
    assert contents(tmp_path) == placed


def test_a_dry_run_writes_nothing(tmp_path):
    code, said = lbr("install", "--root", str(tmp_path), "--dry-run")
    assert (code, said.count("would be written")) == (0, 3)
    assert contents(tmp_path) == {}
    lbr("install", "--root", str(tmp_path))
    placed = contents(tmp_path)
    assert lbr("remove", "--root", str(tmp_path), "--dry-run")[1].count("would be removed") == 3
    assert contents(tmp_path) == placed


def test_an_edited_file_stays_until_told_otherwise_and_then_a_copy_does(tmp_path):
    root = str(tmp_path)
    lbr("install", "--root", root)
    mine = (tmp_path / UNIT).read_text().replace("RestartSec=3", "RestartSec=9")
    (tmp_path / UNIT).write_text(mine)
    for do in ("install", "remove"):
        code, said = lbr(do, "--root", root)
        assert code == 1
        assert f"{tmp_path / UNIT}: was edited" in said
        assert (tmp_path / UNIT).read_text() == mine
    assert lbr("install", "--root", root, "--overwrite")[0] == 0
    assert "RestartSec=3" in (tmp_path / UNIT).read_text()
    assert (tmp_path / f"{UNIT}.edited").read_text() == mine


def test_a_file_of_an_older_version_is_replaced(tmp_path):
    lbr("install", "--root", str(tmp_path))
    (tmp_path / RULES).write_text(unitfiles.stamped("# as it was once\n"))
    code, said = lbr("install", "--root", str(tmp_path))
    assert (code, said.count("replaced")) == (0, 1)
    assert "Phidgets" in (tmp_path / RULES).read_text()


def test_another_user_stays_the_user(tmp_path):
    lbr("install", "--root", str(tmp_path), "--user", "ada")
    assert set(contents(tmp_path)) == {UNIT, RULES}
    lbr("install", "--root", str(tmp_path))
    assert "User=ada\n" in (tmp_path / UNIT).read_text()


def test_remove_takes_files_and_links_away_and_nothing_else(tmp_path):
    lbr("install", "--root", str(tmp_path))
    wants = tmp_path / "etc/systemd/system/multi-user.target.wants"
    wants.mkdir()
    (wants / "lbr@lbr.service").symlink_to(f"/{UNIT}")
    (wants / "ssh.service").symlink_to("/lib/systemd/system/ssh.service")
    (tmp_path / "etc/udev/rules.d/99-mine.rules").write_text("# mine\n")
    assert lbr("remove", "--root", str(tmp_path))[0] == 0
    assert set(contents(tmp_path)) == {"etc/udev/rules.d/99-mine.rules"}
    assert [path.name for path in wants.iterdir()] == ["ssh.service"]


def test_without_the_right_to_write_it_says_what_to_type(tmp_path, monkeypatch):
    def refused(*_arguments: object, **_options: object) -> None:
        raise PermissionError(13, "Permission denied", str(tmp_path))

    monkeypatch.setattr(placing, "_write", refused)
    monkeypatch.setattr(sys, "argv", ["lbr", "service", "install"])
    code, said = lbr("install", "--root", str(tmp_path))
    assert code == 1
    assert re.search(r"this needs root. Type:\n  sudo /\S*lbr service install", said)


# -- what the doctor says -----------------------------------------------------------------------------------------


def found(root: Path) -> dict[str, tuple[str, str]]:
    booted = root / "not-booted"
    return {one.about: (one.level, one.text) for one in service_checks.services(root, booted)}


def test_the_doctor_says_nothing_where_there_is_neither_systemd_nor_a_unit(tmp_path):
    assert found(tmp_path) == {}


def test_the_doctor_offers_the_service_where_there_is_systemd(tmp_path):
    assert [one.level for one in service_checks.services(tmp_path, tmp_path)] == ["good"]


def test_the_doctor_sees_what_is_current_edited_old_missing_and_not_enabled(tmp_path):
    me = "daemon"
    lbr("install", "--root", str(tmp_path), "--user", me)
    assert found(tmp_path)["file lbr@.service"][0] == "good"
    assert found(tmp_path)["service at start"][0] == "hint"
    wants = tmp_path / "etc/systemd/system/multi-user.target.wants"
    wants.mkdir()
    (wants / "lbr@lbr.service").symlink_to(f"/{UNIT}")
    (tmp_path / RULES).unlink()
    with (tmp_path / UNIT).open("a") as file:
        file.write("# mine\n")
    seen = found(tmp_path)
    assert seen["file lbr@.service"][0] == seen["file 70-lbr.rules"][0] == "hint"
    assert "was edited" in seen["file lbr@.service"][1]
    assert seen["service at start"] == ("good", "lbr@lbr starts with the machine")


def test_the_doctor_knows_a_user_and_a_group_that_are_not_there(tmp_path):
    lbr("install", "--root", str(tmp_path), "--user", "nobody-of-this-name")
    assert found(tmp_path)["service user"][0] == "bad"
    (tmp_path / UNIT).write_text("[Service]\nUser=nobody\nSupplementaryGroups=no-such-group\n")
    assert "no-such-group" in found(tmp_path)["service user"][1]


RUNS = {"Id": "lbr@lbr.service", "ActiveState": "active", "WatchdogUSec": "2s", "NRestarts": "0", "StatusText": "ready"}


@pytest.mark.parametrize(
    ("changed", "limits", "level", "words"),
    [
        ({}, "Max nice priority         35                   35", "good", "ready, watchdog on"),
        ({}, "", "good", "ready"),
        ({}, "Max nice priority         0                    0", "hint", "cannot be raised"),
        ({"WatchdogUSec": "0"}, "", "bad", "without a watchdog"),
        ({"NRestarts": "3"}, "", "hint", "restarted 3 times"),
        ({"ActiveState": "failed", "Result": "exit-code"}, "", "bad", "failed (exit-code)"),
        ({"ActiveState": "inactive"}, "", "hint", "inactive"),
        ({"ActiveState": "activating", "Result": "timeout"}, "", "bad", "a time limit of the unit ended it (timeout)"),
        ({"ActiveState": "failed", "Result": "watchdog"}, "", "bad", "a time limit of the unit ended it (watchdog)"),
    ],
)
def test_the_doctor_judges_a_service_by_what_systemd_says(changed, limits, level, words):
    finding = service_checks.judged(RUNS | changed, limits)
    assert finding.level == level
    assert words in finding.text
    assert finding.do or level == "good"


def test_a_place_that_the_user_may_not_enter_is_named(tmp_path, monkeypatch):
    closed = tmp_path / "opt"
    closed.mkdir(mode=0o700)
    monkeypatch.setattr(unitfiles, "HIDDEN", ())
    monkeypatch.setattr(unitfiles, "program_places", lambda: (closed,))
    blocked = unitfiles.unreadable("nobody-of-this-name")
    assert blocked in map(str, (closed, *closed.parents))
    assert Path(blocked).stat().st_mode & 1 == 0
