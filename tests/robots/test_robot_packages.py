"""Anybody's robot is a package: installed, it runs by its name; what is wrong with it is told, and keeps out no other.

Commands run in this process, which finds the package for as long as each takes, unless the test is of a whole robot.
"""

import json
import sqlite3
import sys
import zipfile
from subprocess import CompletedProcess

import pytest

from lbr import cli
from lbr.executive.processes import scheduling
from tests.support import programs
from tests.support import robot as whole
from tests.support.packages import CRAWLER, DECLARED, PROFILES, imported_from, on_path, package, robot_package
from tests.support.robot import running
from tests.support.waiting import until


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", on_path(tmp_path / "site"))
    return tmp_path / "home"


@pytest.fixture
def site(tmp_path):
    return tmp_path / "site"


@pytest.fixture
def lbr(site, home, capfd, monkeypatch):
    """Run a command as one that starts after the package was installed."""
    monkeypatch.setenv("LBR_HOME", str(home))
    monkeypatch.setattr(scheduling, "rank", lambda *_values: None)  # of the process of the tests

    def run(*arguments):
        with imported_from(site):
            code = cli.main(list(arguments))
        return CompletedProcess(arguments, code, *capfd.readouterr())

    return run


@pytest.fixture
def robots(lbr):
    return lambda: {row["name"]: row for row in json.loads(lbr("robots", "--json").stdout)}


def looked(home, sql):
    with sqlite3.connect(home / "robot.db") as database:
        found = database.execute(sql).fetchall()
    database.close()
    return found


@pytest.mark.slow_start
def test_a_robot_that_was_installed_runs_with_nothing_else_and_can_be_driven(site, home):
    """Its database is older than it is."""
    assert whole.lbr(home, "db", "init").returncode == 0
    robot_package(site)
    with running(home, profile="crawler-sim") as robot:
        until(lambda: robot.capability("drive")["phase"] == "ready")
        until(lambda: robot.line("/r/0.1/0")["code"] == 0, what="its motors are armed, and it drives")
        assert robot.line("s")["text"] == "stopped"
        assert "/r/power/angle" in robot.line("help")["text"]
        assert robot.line("/report/health")["code"] == 0
    assert looked(home, "SELECT text FROM phrase WHERE name = 'crawler_hello'") == [("I crawl.",)]
    assert "the rows of robot 'crawler' (package 'my-crawler 0.1') are in" in (home / "stderr.txt").read_text()


def test_a_new_database_has_all_robots_that_there_are_and_begins_at_no_revision(site, home, lbr):
    robot_package(site)
    done = lbr("db", "init")
    assert (done.returncode, done.stderr) == (0, "")
    assert looked(home, "SELECT name FROM robot") == [("bioloid",), ("crawler",), ("lbr",), ("uxa90",)]
    assert looked(home, "SELECT count(*) FROM revision") == [(0,)]
    assert lbr("db", "check").returncode == 0
    assert lbr("db", "diff").stdout == "the rows are as shipped\n"


def test_it_is_listed_and_named_where_another_is_asked_for(site, lbr, robots):
    robot_package(site, profiles={"{name}-sim": PROFILES["{name}-sim"]})
    assert robots()["crawler"] == {
        "name": "crawler",
        "package": "my-crawler 0.1",
        "summary": "a robot on tracks",
        "profiles": ["crawler", "crawler-sim"],
        "fault": "",
    }
    assert "  lbr run crawler-sim\n" in lbr("robots").stdout
    assert "crawler-sim" in lbr("run", "crowler", "--no-console").stderr
    assert "crawler" in lbr("db", "init").stdout or lbr("db", "add", "c3po").stderr.count("crawler")


def test_rows_that_are_there_stay_and_those_that_are_not_are_added_by_command(site, home, lbr):
    robot_package(site)
    lbr("db", "init")
    with sqlite3.connect(home / "robot.db") as database:
        database.execute("UPDATE capability SET help = 'mine' WHERE robot = 'crawler' AND name = 'drive'")
        database.execute("DELETE FROM channel WHERE robot = 'crawler' AND target = 'drive.ranges'")
    database.close()
    assert json.loads(lbr("db", "add", "crawler", "--json").stdout) == {"channel": 1}
    assert looked(home, "SELECT help FROM capability WHERE robot = 'crawler' AND name = 'drive'") == [("mine",)]


BAD_ROWS = {
    "a table that is not there": ("INSERT INTO sail (name) VALUES ('x');", "rows.sql, line 1: no such table: sail"),
    "a column out of bounds": (
        CRAWLER.replace("'{}', '[\"motors\"]'", "'[]', '[]'"),
        "table capability, settings: must be a JSON object",
    ),
    "rows of another robot": (
        CRAWLER + "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'spy', 'exec');",
        "capability 'lbr/spy' ",
    ),
    "a replacement of what is another's": (
        CRAWLER + "INSERT OR REPLACE INTO phrase (name, language, text) VALUES ('hello', 'en', 'Boo.');",
        "phrase 'hello/en' ",
    ),
    "more than rows": (CRAWLER + "DROP TABLE robot;", "it may insert rows"),
    "an edit": (CRAWLER + "UPDATE robot SET owner = 'me';", "it may insert rows"),
    "another file": (CRAWLER + "ATTACH '/tmp/x.db' AS x;", "it may insert rows"),
    "a trigger": (
        CRAWLER + "CREATE TRIGGER t AFTER INSERT ON event BEGIN DELETE FROM event; END;",
        "it may insert rows",
    ),
    "no robot": ("SELECT 1;", "no row of it in"),
    "a kind that is not there": (
        CRAWLER.replace("'drive', 'drive'", "'drive', 'hovercraft'"),
        "capability 'crawler/drive', kind: there is no kind 'hovercraft'",
    ),
    "a setting that is none": (
        CRAWLER.replace('{"device": "board"}', '{"device": "board", "colour": 1}'),
        "capability 'crawler/ranges', settings: ",
    ),
    "a wire to nowhere": (
        CRAWLER.replace("'drive.motors'", "'drive.engines'"),
        "channel 'crawler/motors.state/drive.engines', target: 'drive' has no input 'engines'",
    ),
    "no SQL": ("\x00\x01 nonsense", "rows.sql, line 1: "),
}


@pytest.mark.parametrize(("rows", "why"), BAD_ROWS.values(), ids=BAD_ROWS)
def test_rows_that_do_not_validate_are_refused_with_package_and_row_and_all_others_are_there(
    site, home, lbr, robots, rows, why
):
    robot_package(site, rows=rows)
    done = lbr("db", "init")
    assert done.returncode == 0
    assert "robot 'crawler' of package 'my-crawler 0.1'" in done.stderr
    assert why in done.stderr
    assert looked(home, "SELECT name FROM robot") == [("bioloid",), ("lbr",), ("uxa90",)]
    refused = lbr("run", "crawler-sim", "--no-console")
    assert refused.returncode == 2
    assert why in refused.stderr
    assert why in robots()["crawler"]["fault"]
    assert looked(home, "SELECT count(*) FROM revision") == [(0,)]


DECLARATIONS = {
    "does not import": ("import nothing_like_this", "does not load: ModuleNotFoundError"),
    "calls itself otherwise": (DECLARED.replace('"{name}"', '"other"'), "it calls itself 'other'"),
    "brings no rows": ("from lbr.robot import Robot\nROBOT = Robot(name='{name}', summary='')", "'rows' is missing"),
    "names a file that is not there": (DECLARED.replace("rows.sql", "none.sql"), "which is not there"),
    "names no path": (DECLARED.replace('HERE / "rows.sql"', '"rows.sql"'), "must be a pathlib.Path"),
}


@pytest.mark.parametrize(("declared", "why"), DECLARATIONS.values(), ids=DECLARATIONS)
def test_a_robot_that_cannot_be_used_is_told_with_its_package_and_all_others_run(site, lbr, robots, declared, why):
    robot_package(site, declared=f"print('noise')\n{declared}")
    found = robots()
    assert "robot 'crawler' of package 'my-crawler 0.1'" in found["crawler"]["fault"]
    assert why in found["crawler"]["fault"]
    assert [name for name, one in found.items() if not one["fault"]] == ["bioloid", "lbr", "uxa90"]
    done = lbr("run", "crawler-sim", "--no-console")
    assert (done.returncode, done.stdout) == (2, "")
    assert why in done.stderr
    assert lbr("db", "init").returncode == 0


def test_a_package_for_this_version_and_one_that_asks_only_elsewhere_are_taken(site, robots):
    robot_package(site, requires=("lbr>=0.1,<99", "lbr-client>=99", 'lbr>=99; python_version < "3"'))
    assert robots()["crawler"]["fault"] == ""


def test_a_name_of_lbrs_stays_its_own_and_of_several_others_none_has_it(site, lbr, wording):
    robot_package(site, "bioloid", distribution="their-bioloid")
    robot_package(site, "crawler", distribution="a-crawler")
    robot_package(site, "crawler", distribution="b-crawler")
    found = json.loads(lbr("robots", "--json").stdout)
    assert [(one["name"], one["package"]) for one in found if not one["fault"]] == [
        ("bioloid", "lbr"),
        ("lbr", "lbr"),
        ("uxa90", "lbr"),
    ]
    told = [one["fault"] for one in found if one["fault"]]
    both = "packages a-crawler 0.1 and b-crawler 0.1"
    wording(*sorted(told))
    assert both in lbr("run", "crawler", "--no-console").stderr
    assert lbr("db", "init").stderr.count("left out: ") == 3


def test_a_profile_that_another_robot_has_is_not_taken_from_it(site, robots):
    robot_package(site, "bioloid_two")
    fault = robots()["bioloid_two"]["fault"]
    assert "robot 'bioloid' of package 'lbr' has a launch profile 'bioloid-two' already" in fault


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("somewhere", 'robot = "{name}"', "must be called crawler.toml, or crawler-….toml"),
        ("lbr", 'robot = "lbr"', "must be called crawler.toml, or crawler-….toml"),
    ],
)
def test_a_profile_is_called_as_its_robot(site, robots, name, text, why):
    robot_package(site, profiles={**PROFILES, name: text})
    assert why in robots()["crawler"]["fault"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('robot = "lbr"\n', "of package 'my-crawler 0.1': its robot must be 'crawler'"),
        ('robot = "{name}"\nsimulated = true\n', "crawler.toml: "),
        ('robot = "{name}"\nonly = [\n', "crawler.toml: "),
    ],
)
def test_a_profile_of_a_package_starts_its_own_robot_and_one_that_does_not_is_listed_with_the_reason(
    site, lbr, robots, text, why
):
    robot_package(site, profiles={"{name}": text})
    done = lbr("run", "crawler", "--no-console")
    assert done.returncode == 2
    assert why in done.stderr
    assert why in robots()["crawler"]["fault"]


def test_a_first_run_says_once_what_is_wrong_with_its_robot(site, lbr):
    robot_package(site, rows=CRAWLER.replace("'drive', 'drive'", "'drive', 'hovercraft'"))
    done = lbr("run", "crawler-sim", "--no-console")
    assert done.returncode == 2
    assert done.stderr.count("there is no kind 'hovercraft'") == 1


def test_a_wheel_that_pip_installs_is_enough(site, lbr, robots, tmp_path):
    built = tmp_path / "built"
    robot_package(built)
    wheel = tmp_path / "my_crawler-0.1-py3-none-any.whl"
    (info,) = built.glob("*.dist-info")
    (info / "WHEEL").write_text("Wheel-Version: 1.0\nGenerator: by hand\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
    files = [path for path in sorted(built.rglob("*")) if path.is_file()]
    (info / "RECORD").write_text("".join(f"{path.relative_to(built)},,\n" for path in [*files, info / "RECORD"]))
    with zipfile.ZipFile(wheel, "w") as archive:
        for path in [*files, info / "RECORD"]:
            archive.write(path, path.relative_to(built))
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--disable-pip-version-check"]
    programs.run([*pip, "--target", site, wheel], check=True, env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)})
    assert robots()["crawler"]["profiles"] == ["crawler", "crawler-sim"]
    assert lbr("db", "init").returncode == 0
    assert json.loads(lbr("db", "check", "--robot", "crawler", "--json").stdout)[0]["problems"] == []


def test_a_kind_whose_name_is_taken_stays_with_lbr_and_its_words_are_checked(site, home, lbr):
    kind = "from lbr.capability import Capability, Kind, Word\nclass C(Capability):\n    pass\n"
    package(
        site,
        "their-kinds",
        brings={"kinds": {name: f"their_kinds:{name.upper()}" for name in ("drive", "bad", "worse")}},
        files={
            "their_kinds.py": kind
            + "DRIVE = Kind(name='drive', summary='', family='app', entry=C)\n"
            + "BAD = Kind(name='bad', summary='', family='app', entry=C, words=(Word('/s', 'fly', ''),))\n"
            + "WORSE = Kind(name='worse', summary='', family='app', entry=C, words=('x',))\n"
        },
    )
    lbr("db", "init")
    for name, why in (("bad", "'fly'"), ("worse", "'words'")):
        with sqlite3.connect(home / "robot.db") as database:
            database.execute("DELETE FROM capability WHERE name = 'new'")
            database.execute("INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'new', ?)", (name,))
        database.close()
        told = lbr("db", "check", "--robot", "lbr").stderr
        assert f"capability 'lbr/new', kind: the installed kind '{name}' of package 'their-kinds 0.1'" in told
        assert why in told
        assert "drive" not in told
