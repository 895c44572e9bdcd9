"""The right to power off and the relay of the motors' power, as files of a service and in what the doctor says."""

import json
import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from lbr.commands import placing, power_checks, service_checks, unitfiles
from lbr.commands.service import command
from lbr.commands.unitfiles import POLKIT, RELAY_DROP_IN, RELAY_UNIT, RULES, SYSUSERS, UNIT, Extras, Site
from lbr.drivers.pico import relay
from lbr.errors import InputError
from tests.support import databases, needs, programs
from tests.support.waiting import HANG_S

SITE = Site(program=(str(Path(sys.prefix) / "bin" / "lbr"),), groups=("tty",))
BOTH = Extras(power_off=True, motor_relay="i2c:1:0x69")
DROP_IN = RELAY_DROP_IN.format("bioloid")
EXPOSURE_TENTHS = 25
analyze = needs.program("systemd-analyze", "systemd")


def lbr(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(command, arguments, standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return done.return_value, done.output


def files(extras: Extras = BOTH, user: str = "daemon") -> dict[str, str]:
    return unitfiles.files("bioloid", user, SITE, extras)


def placed(root: Path) -> set[str]:
    return {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}


def test_without_being_asked_a_robot_gets_neither():
    assert set(files(Extras(), "lbr")) == {UNIT, RULES, SYSUSERS}
    assert set(files(BOTH, "lbr")) == {UNIT, RULES, SYSUSERS, POLKIT, RELAY_UNIT, DROP_IN}


# -- the rule ---------------------------------------------------------------------------------------------------------


def test_the_rule_allows_two_actions_to_one_user_and_nothing_else():
    text = files(user="ada")[POLKIT]
    assert set(re.findall(r'"(org[^"]*)"', text)) == {
        "org.freedesktop.login1.power-off",
        "org.freedesktop.login1.power-off-multiple-sessions",
    }
    assert 'subject.user === "ada"' in text
    assert text.count("Result.YES") == 1


@needs.program("node", "nodejs")
def test_the_rule_decides_so():
    """Run as polkit does, in whatever runs JavaScript here."""
    text = files(user="lbr")[POLKIT]
    cases = {
        ("lbr", "power-off"): "yes",
        ("lbr", "power-off-multiple-sessions"): "yes",
        ("lbr", "power-off-ignore-inhibit"): "next",
        ("lbr", "reboot"): "next",
        ("lbr2", "power-off"): "next",
    }
    asked = [[user, f"org.freedesktop.login1.{action}"] for user, action in cases]
    script = f"""var rules = [];
    var polkit = {{addRule: function (rule) {{ rules.push(rule); }}, Result: {{YES: "yes", NOT_HANDLED: "next"}}}};
    {text}
    {json.dumps(asked)}.forEach(function (one) {{ console.log(rules[0]({{id: one[1]}}, {{user: one[0]}})); }});"""
    done = programs.run(["node", "-e", script], capture_output=True, text=True, check=True, timeout=HANG_S)
    assert done.stdout.split() == list(cases.values())


def test_the_rules_head_is_a_comment_of_its_own_language_and_tells_an_edit():
    text = files()[POLKIT]
    assert text.startswith("// Written by 'lbr service install'")
    assert all(line.startswith("//") for line in text.splitlines()[:3])
    assert unitfiles.is_pristine(text)
    assert not unitfiles.is_pristine(text.replace("YES", "NO"))


# -- the relay --------------------------------------------------------------------------------------------------------


@analyze
def test_systemd_understands_the_relays_unit_and_it_exposes_little(tmp_path):
    unit = tmp_path / "lbr-motor-relay.service"
    unit.write_text(files()[RELAY_UNIT])
    done = programs.run(
        ["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True, check=False, timeout=HANG_S
    )
    assert (done.returncode, [line for line in done.stderr.splitlines() if unit.name in line]) == (0, [])
    words = ["systemd-analyze", "security", "--offline=yes", f"--threshold={EXPOSURE_TENTHS}", "--no-pager", unit]
    done = programs.run(words, capture_output=True, text=True, check=False, timeout=HANG_S)
    if "unrecognized option" not in done.stderr:
        assert done.returncode == 0, done.stdout[-300:]


def test_the_relay_is_on_before_the_robot_and_off_after_it():
    found = files()
    unit = found[RELAY_UNIT].splitlines()
    for line in (
        "Type=oneshot",
        "RemainAfterExit=yes",
        "StopWhenUnneeded=yes",
        "User=daemon",
        "CapabilityBoundingSet=",
    ):
        assert line in unit, line
    assert found[DROP_IN].splitlines()[1:] == [
        "[Unit]", "BindsTo=lbr-motor-relay.service", "After=lbr-motor-relay.service",
    ]  # fmt: skip


@pytest.mark.parametrize("what", ["ExecStart", "ExecStop"])
def test_what_the_unit_types_is_what_the_program_takes(what, monkeypatch):
    line = next(line for line in files()[RELAY_UNIT].splitlines() if line.startswith(f"{what}="))
    python, *words = line.removeprefix(f"{what}=").replace("${LBR_RELAY_ON}", "1").split()
    assert Path(python).exists()
    assert words[:3] == ["-P", "-m", "lbr.drivers.pico.relay"]
    monkeypatch.setattr(relay, "_done", lambda device, do, on_is: f"{do} {device.address} {on_is}")
    monkeypatch.setattr(relay.time, "sleep", lambda _seconds: None)
    assert relay.main(words[3:]) == 0


@pytest.mark.parametrize("address", ["i2c:1", "i2c:1:0x69 --x", "unix:/tmp/x", "i2c:1:0x69\nUser=root", "1:0x69"])
def test_an_address_that_no_unit_can_say_is_refused(address):
    with pytest.raises(InputError, match=r"such as i2c:1:0x69"):
        files(Extras(motor_relay=address))


# -- in place, again and away -----------------------------------------------------------------------------------------


def test_what_was_installed_stays_so_at_the_next_install_and_goes_at_the_removal(tmp_path):
    root = ("--root", str(tmp_path))
    assert lbr("install", "bioloid", "--power-off", "--motor-relay", "i2c:1:0x69", *root)[0] == 0
    everything = {UNIT, RULES, SYSUSERS, POLKIT, RELAY_UNIT, DROP_IN}
    assert placed(tmp_path) == everything
    assert unitfiles.extras_of(tmp_path) == BOTH
    code, said = lbr("install", "bioloid", *root)
    assert (code, said.count("is as it should be")) == (0, 6)
    (tmp_path / POLKIT).write_text("// mine\n")
    assert lbr("install", "bioloid", *root)[0] == 1
    assert (tmp_path / POLKIT).read_text() == "// mine\n"
    assert lbr("remove", *root)[0] == 1
    assert placed(tmp_path) == {POLKIT}
    assert lbr("remove", "--overwrite", *root)[0] == 0
    assert placed(tmp_path) == set()


def test_the_doctor_knows_these_files_too(tmp_path):
    root = ("--root", str(tmp_path))
    lbr("install", "bioloid", "--power-off", "--motor-relay", "i2c:1:0x69", "--user", "daemon", *root)
    about = {one.about: one.level for one in service_checks.services(tmp_path, tmp_path / "not-booted")}
    assert about["file 50-lbr-power-off.rules"] == about["file lbr-motor-relay.service"] == "good"
    with (tmp_path / RELAY_UNIT).open("a") as file:
        file.write("# mine\n")
    about = {one.about: one.level for one in service_checks.services(tmp_path, tmp_path / "not-booted")}
    assert about["file lbr-motor-relay.service"] == "hint"


def test_rules_that_only_root_may_see_are_no_error(tmp_path, monkeypatch):
    there = Path.exists

    def closed(path: Path) -> bool:
        if "polkit-1" in path.parts:
            raise PermissionError(13, "Permission denied")
        return there(path)

    monkeypatch.setattr(Path, "exists", closed)
    assert unitfiles.extras_of(tmp_path) == Extras()
    assert power_checks._rule(tmp_path).do == "sudo lbr doctor"


# -- what the doctor says of powering off -----------------------------------------------------------------------------


@pytest.fixture
def watching(tmp_path, monkeypatch):
    """A home whose robot watches its supply."""
    home = tmp_path / "home"
    home.mkdir(mode=0o700)
    monkeypatch.setenv("LBR_HOME", str(home))
    databases.fresh(home / "robot.db")
    return tmp_path


def test_the_doctor_says_how_a_robot_comes_to_power_off(watching):
    nowhere = f"unix:path={watching / 'no-bus'}"
    found = {one.about: one for one in power_checks.power(watching, watching, nowhere)}
    assert found["power-off rule"].level == "hint"
    assert "--power-off" in found["power-off rule"].do
    assert found["power off"].level == "hint"
    assert "cannot be asked" in found["power off"].text
    lbr("install", "--power-off", "--root", str(watching))
    found = {one.about: one for one in power_checks.power(watching, watching, nowhere)}
    assert found["power-off rule"].level == "good"


def test_the_doctor_says_nothing_of_it_without_systemd_or_such_a_robot(watching, tmp_path, monkeypatch):
    assert list(power_checks.power(watching, watching / "not-booted")) == []
    empty = tmp_path / "empty"
    empty.mkdir(mode=0o700)
    monkeypatch.setenv("LBR_HOME", str(empty))
    assert list(power_checks.power(tmp_path, tmp_path)) == []


def test_files_that_are_installed_are_known_to_the_removal(tmp_path):
    placing.install(tmp_path, files(), overwrite=False, dry_run=False)
    assert {str(path.relative_to(tmp_path)) for path in placing.installed(tmp_path)} == set(files())
