"""Packages of somebody else: a distribution's metadata and modules in a folder that PYTHONPATH names, as pip leaves them."""

import os
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from lbr import plugins

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CRAWLER = """
INSERT INTO robot (name, model) VALUES ('crawler', 'two tracks');
INSERT INTO device (robot, name, type, address) VALUES
    ('crawler', 'controller', 'roboteq', '/dev/ttyACM9'),
    ('crawler', 'board', 'ultrasonic_ring', '/dev/ttyUSB9');
INSERT INTO range_sensor (robot, name, kind, x_m, yaw_rad, min_m, max_m, stop_m) VALUES
    ('crawler', 'forward', 'ultrasonic', 0.2, 0.0, 0.17, 8.0, NULL),
    ('crawler', 'back', 'ultrasonic', -0.2, 3.1416, 0.17, 8.0, NULL);
INSERT INTO capability (robot, name, kind, settings, needs) VALUES
    ('crawler', 'motors', 'roboteq', '{"device": "controller"}', '[]'),
    ('crawler', 'ranges', 'ultrasonic_ring', '{"device": "board"}', '[]'),
    ('crawler', 'drive', 'drive', '{}', '["motors"]'),
    ('crawler', 'world', 'world', '{}', '[]');
INSERT INTO channel (robot, source, target) VALUES
    ('crawler', 'drive.setpoint', 'motors.setpoint'),
    ('crawler', 'motors.state', 'drive.motors'),
    ('crawler', 'ranges.readings', 'drive.ranges');
INSERT INTO phrase (name, language, text) VALUES ('crawler_hello', 'en', 'I crawl.');
"""
"""A robot of rows alone."""
DECLARED = """
from pathlib import Path
from lbr.robot import Robot

HERE = Path(__file__).parent
ROBOT = Robot(name="{name}", summary="a robot on tracks", rows=HERE / "rows.sql", profiles=HERE / "profiles")
"""
PROFILES = {
    "{name}": 'robot = "{name}"\n',
    "{name}-sim": 'robot = "{name}"\nsimulate = true\n',
}


def package(
    site: Path,
    distribution: str,
    *,
    version: str = "0.1",
    requires: Iterable[str] = ("lbr",),
    brings: Mapping[str, Mapping[str, str]],
    files: Mapping[str, str],
) -> None:
    """Put a distribution with one component into a folder: `brings` are its fields, `files` texts by path."""
    module = distribution.replace("-", "_")
    points = {module: f"{module}_component:COMPONENT"}
    metadata(site, distribution, version=version, requires=requires, points=points)
    (site / f"{module}_component.py").write_text(component(brings))
    for name, text in files.items():
        (site / name).parent.mkdir(parents=True, exist_ok=True)
        (site / name).write_text(text)


def component(brings: Mapping[str, Mapping[str, str]]) -> str:
    """Return a module with a component of these fields; the help of its commands is their names."""
    fields = dict(brings)
    commands = "".join(
        f"{name!r}: CliCommand(entry={where!r}, help={name!r}), " for name, where in fields.pop("commands", {}).items()
    )
    given = "".join(f"{field}={dict(names)!r}, " for field, names in fields.items())
    return f"from lbr.component import CliCommand, Component\nCOMPONENT = Component({given}commands={{{commands}}})\n"


def metadata(
    site: Path, distribution: str, *, version: str, requires: Iterable[str], points: Mapping[str, str]
) -> None:
    """Put what pip leaves of a distribution into a folder: its entry points of components are `points`."""
    info = site / f"{distribution.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    needs = "".join(f"Requires-Dist: {text}\n" for text in requires)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n{needs}")
    lines = "".join(f"{name} = {where}\n" for name, where in points.items())
    (info / "entry_points.txt").write_text(f"[{plugins.GROUP}]\n{lines}")


def robot_package(
    site: Path,
    name: str = "crawler",
    *,
    distribution: str = "",
    version: str = "0.1",
    requires: Iterable[str] = ("lbr",),
    declared: str = DECLARED,
    rows: str | None = None,
    profiles: Mapping[str, str] = PROFILES,
) -> None:
    """Put a package into a folder that brings one robot, whose rows are those of the crawler unless said."""
    distribution = distribution or f"my-{name}"
    module = distribution.replace("-", "_")
    text = CRAWLER.replace("crawler", name) if rows is None else rows
    files = {f"{module}/__init__.py": declared.format(name=name), f"{module}/rows.sql": text}
    files |= {
        f"{module}/profiles/{one.format(name=name)}.toml": body.format(name=name) for one, body in profiles.items()
    }
    package(
        site,
        distribution,
        version=version,
        requires=requires,
        brings={"robots": {name: f"{module}:ROBOT"}},
        files=files,
    )


def of_project(folder: Path, site: Path) -> str:
    """Install a folder with a project file as `pip install -e` does; return the PYTHONPATH by which it is found."""
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    points, needs = project["entry-points"][plugins.GROUP], project["dependencies"]
    metadata(site, project["name"], version=project["version"], requires=needs, points=points)
    return os.pathsep.join((str(folder), on_path(site)))


@contextmanager
def beside(folder: Path, *names: str) -> Iterator[str]:
    """Have this process find packages of `examples/`, by their metadata in a folder; give the PYTHONPATH for others."""
    path = [os.environ.get("PYTHONPATH", "")]
    with ExitStack() as stack:
        for name in names:
            project, site = EXAMPLES / name, folder / f"site-{name}"
            path.insert(0, of_project(project, site))
            stack.enter_context(imported_from(project))
            stack.enter_context(imported_from(site))
        yield os.pathsep.join(filter(None, path))


def on_path(site: Path) -> str:
    """Return a PYTHONPATH with a folder before all others."""
    return os.pathsep.join(filter(None, (str(site), os.environ.get("PYTHONPATH"))))


@contextmanager
def imported_from(site: Path) -> Iterator[None]:
    """Have this process find what is installed in a folder, and forget all of it afterwards."""
    before = set(sys.modules)
    sys.path.insert(0, str(site))
    plugins.forget()
    try:
        yield
    finally:
        sys.path.remove(str(site))
        plugins.forget()
        for name in set(sys.modules) - before:
            if str(getattr(sys.modules[name], "__file__", None) or "").startswith(str(site)):
                del sys.modules[name]
