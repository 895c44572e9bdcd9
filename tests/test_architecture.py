"""The floors: who may import whom, what stays light, and how large a module may grow."""

import ast
import json
import re
import statistics
import sys
import tomllib
from collections.abc import Iterable
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from lbr import plugins
from lbr.component import Component
from lbr.plugins import GROUP
from tests.support import programs

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "lbr"
MODULES = sorted(PACKAGE.rglob("*.py"))
MACHINERY = ("support", "models", "scenarios", "fuzzing", "intrusion")
"""Rooms of `tests/` for what tests and benchmarks share; each may import itself and those before it."""
COPIED = ROOT / "tests" / "support" / "victims"
"""Kinds that are copied into a robot's home, where they have only each other."""
AROUND = [
    path
    for folder in ("tests", "benchmarks")
    for path in sorted((ROOT / folder).rglob("*.py"))
    if path.parent != COPIED
]

GROUND = {"disk", "errors", "messages", "names"}
BUS = GROUND | {"bus"}
CAPABILITY = BUS | {"capability", "component", "leases", "ownership", "plugins"}
ROBOT = GROUND | {"component", "plugins", "resources", "robot"}
FLOORS = {
    "disk": set(),
    "errors": {"messages"},
    "messages": {"messages"},
    "ownership": {"errors"},
    "home": {"disk", "errors", "ownership"},
    "surroundings": {"errors"},
    "component": set(),
    "plugins": {"component", "errors"},
    "resources": {"errors"},
    "names": set(),
    "qr": set(),
    "robot": ROBOT,
    "bus": BUS,
    "leases": BUS | {"leases"},
    "capability": CAPABILITY,
    "drivers": CAPABILITY | {"drivers"},
    "operations": CAPABILITY | {"operations"},
    "database": GROUND | ROBOT | {"database", "ownership"},
    "client": BUS | {"client", "console", "home", "leases"},
    "console": BUS | {"console", "database", "home", "leases", "ownership"},
    "why": GROUND | {"why"},
    "executive": CAPABILITY | ROBOT | {"executive", "console", "database", "home", "qr", "why"},
    "apps": CAPABILITY | ROBOT | {"apps", "bodies", "client", "home", "qr", "recording", "why"},
    "robots": ROBOT | {"robots"},
    "simulation": CAPABILITY | ROBOT | {"simulation"},
    "bodies": ROBOT | {"bodies"},
    "recording": GROUND | {"recording"},
    "ros2": CAPABILITY | ROBOT | {"apps", "bodies", "ros2"},
    "rerun": CAPABILITY | {"apps", "database", "drivers", "home", "recording", "rerun", "simulation"},
    "testing": CAPABILITY | {"database", "simulation", "testing"},
}
TOP = {"cli", "commands", "gym", "start"}
"""What people start: may import everything below."""
CORE = set(FLOORS) - {"apps", "robots", "simulation", "bodies", "recording", "rerun", "ros2", "testing"} | {
    "cli",
    "start",
}
"""Floors that stand without a component, `commands` in their own folder among them."""
ROOMS = {
    "lbr.apps.bodies": "bodies",
    "lbr.apps.recorder.recording": "recording",
    "lbr.apps.recorder.rerun": "rerun",
    "lbr.apps.ros2.commands": "commands",
    "lbr.apps.ros2": "ros2",
    "lbr.robots.lbr.beacon": "operations",
    "lbr.robots.lbr.original": "apps",
    "lbr.robots.uxa90.driver": "drivers",
    "lbr.robots.uxa90.rest": "apps",
    "lbr.robots.uxa90.twin": "simulation",
}
"""Rooms of components that keep the rules of a floor of the core, or of a lower one than their folder's."""
LIBRARIES = {
    "lbr.apps.bodies",
    "lbr.apps.http",
    "lbr.apps.motion_requests",
    "lbr.apps.program",
    "lbr.apps.retry",
    "lbr.apps.sound",
}
"""What several components are built on, and no component itself."""
OUTSIDE = {"lbr.gym": "lbr.simulation", "lbr.testing": "lbr.simulation"}
"""Doors for programs of others, by whose rights they import."""
PROGRAMS = {"lbr.apps.autodock": (), "lbr.apps.docksignal": (), "lbr.apps.navcam": ("web",)}
"""Programs that rows of `external_command` start, and the components that they need: no other part of lbr names them."""

OWNERS = {
    "zenoh": {"bus", "ros2"},
    "argon2": {"bus"},
    "cryptography": {"bus"},
    "sqlalchemy": {"database"},
    "alembic": {"database"},
    "mcap": {"apps", "recording"},
    "zstandard": {"recording"},
    "lz4": {"recording"},
    "sqlite3": {"database", "testing"},
    "mujoco": {"simulation"},
    "gymnasium": {"gym"},
    "numpy": {"apps", "gym", "ros2", "operations", "simulation"},
    "cv2": {"apps"},
    "imufusion": {"operations"},
    "dbus_fast": {"operations"},
    "smbus2": {"drivers"},
    "Phidget22": {"drivers"},
    "linuxpy": {"drivers"},
    "picamera2": {"drivers"},
    "pyttsx3": {"apps"},
    "packaging": {"plugins"},
    "starlette": {"apps"},
    "uvicorn": {"apps"},
    "websockets": {"apps"},
    "segno": {"qr"},
    "zeroconf": {"apps", "client"},
    "keyring": {"console"},
    "IPython": {"client"},
    "matplotlib": {"client"},
    "ifaddr": {"apps", "client"},
    "PIL": {"apps", "simulation"},
    "mcp": {"apps"},
    "mcp_types": {"apps"},
    "paho": {"apps"},
    "rosbags": {"ros2"},
    "xxhash": {"ros2"},
    "serial": {"drivers", *TOP},
    "prompt_toolkit": {"console", *TOP},
    "rich": TOP,
    "plotille": TOP,
    "click": TOP,
    "psutil": {"executive", *TOP},
}
"""Which floor may import a library, so that replacing one stays a matter of one package."""

HEAVY = (
    "Phidget22",
    "gymnasium",
    "numpy",
    "cv2",
    "imufusion",
    "mujoco",
    "pyttsx3",
    "starlette",
    "uvicorn",
    "segno",
    "paho",
    "rosbags",
    "xxhash",
    "zeroconf",
    "keyring",
    "IPython",
    "matplotlib",
    "sqlalchemy",
    "alembic",
    "PIL",
    "prompt_toolkit",
    "rich",
    "click",
    "psutil",
    "argon2",
    "cryptography",
    "dbus_fast",
)
NUMERIC = ("lbr.operations.attitude.fit", "lbr.operations.attitude.fusion")
"""What computes with arrays; no driver does."""
FAMILIES = {"wheels": {"roboteq"}, "servos": {"dynamixel", "uxa90"}}
"""What drivers of one sort have in common, and the drivers of that sort: they alone may import it."""

LARGEST_LINES = 600
MEDIAN_LINES = 150


def dotted(path: Path, root: Path = ROOT) -> str:
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def by_package(paths: Iterable[Path]) -> list[Any]:
    """Return one parameter for each package: its modules, under its name."""
    found: dict[str, list[Path]] = {}
    for path in paths:
        found.setdefault(dotted(path.parent), []).append(path)
    return [pytest.param(tuple(modules), id=package) for package, modules in found.items()]


def of(path: Path) -> frozenset[str]:
    """Every module that a module imports, by full name."""
    return imports(text(path), dotted(path), package=path.name == "__init__.py")


COMMENT = re.compile(r"#.*")
IMPORT = re.compile(r"^[ \t]*(?:from +(\.*)([\w.]*) +)?import +(\([^)]*\)|.+)", re.MULTILINE)
"""A statement that imports begins its line, as the formatter sees to; one in a text of code counts as well."""


@cache
def imports(source: str, module: str, *, package: bool = False) -> frozenset[str]:
    """Every module that a source imports, at its top or inside a function, by full name."""
    base = module.split(".") if package else module.split(".")[:-1]
    found = set()
    for dots, origin, names in IMPORT.findall(COMMENT.sub("", source)):
        start = base[: len(base) + 1 - len(dots)] if dots else []
        place = [*start, *([origin] if origin else [])]
        found |= {".".join([*place, name.split()[0]]) for name in names.strip("()").split(",") if name.strip()}
    return frozenset(found)


def tied(sources: dict[str, tuple[str, bool]]) -> dict[str, set[str]]:
    """Which of these modules each of them imports; what a package's name stands for is the package itself."""
    return {
        name: {
            known
            for found in imports(source, name, package=package)
            if (known := found if found in sources else found.rpartition(".")[0]) in sources and known != name
        }
        for name, (source, package) in sources.items()
    }


def circle(sources: dict[str, tuple[str, bool]]) -> list[str]:
    """Return modules that import each other in a circle, if there are any."""
    try:
        TopologicalSorter(tied(sources)).prepare()
    except CycleError as err:
        return list(err.args[1])
    return []


@cache
def components() -> dict[str, Component]:
    """Return lbr's components by the modules that declare them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    modules = (where.partition(":")[0] for where in project["entry-points"][GROUP].values())
    return {name: import_module(name).COMPONENT for name in modules}


def within(module: str, place: str) -> bool:
    """Say whether a module is a package, or below it."""
    return f"{module}.".startswith(f"{place}.")


def floor(module: str) -> str:
    """The floor of `lbr.drivers.roboteq.protocol` is `drivers`; messages that a component declares are for all."""
    parts = module.split(".")
    if any(within(module, name) for one in components().values() for name in one.messages):
        return "messages"
    if room := next((room for place, room in ROOMS.items() if within(module, place)), ""):
        return room
    if parts[1:2] != ["commands"] and "commands" in parts[3 if parts[1:2] != ["simulation"] else 2 :]:
        return "commands"
    return parts[1] if len(parts) > 1 else ""


def component_of(module: str) -> str:
    """Return the package of the component that a module is part of; empty for the core and for libraries of all."""
    place = ".".join(module.split(".")[: 2 if within(module, "lbr.simulation") else 3])
    for door, whose in OUTSIDE.items():
        place = whose if within(module, door) else place
    return place if within(place, "lbr.simulation") or re.match(r"lbr\.(apps|robots)\.", place) else ""


def abroad(source: str, module: str, *, package: bool = False) -> list[str]:
    """Return what a module imports of components that it must not: of any in the core, in one of those that it does not need,
    and of these what they do not show."""
    here, declared = component_of(module), components()
    needs = declared[here].needs if here in declared else PROGRAMS.get(here, ())
    named = {name: place for place, name in component_names().items()}
    shown = [name for one in needs for name in (*declared[named[one]].public, *declared[named[one]].messages)]
    wrong = []
    for name in sorted(imports(source, module, package=package)):
        there = component_of(name)
        if not there or there == here or (here and any(within(name, place) for place in LIBRARIES)):
            continue
        if not any(within(name, place) for place in shown):
            wrong.append(name)
    return wrong


@cache
def component_names() -> dict[str, str]:
    """Return the names of lbr's components by the packages that declare them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return {where.partition(":")[0]: name for name, where in project["entry-points"][GROUP].items()}


@pytest.mark.parametrize("paths", by_package(MODULES))
def test_the_core_imports_no_component_and_components_of_each_other_what_is_shown(paths):
    wrong = [
        f"{dotted(path)} must not import {name}"
        for path in paths
        for name in abroad(text(path), dotted(path), package=path.name == "__init__.py")
    ]
    assert not wrong, "; ".join(wrong)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lbr.capability.runtime", "from lbr.apps.web import face"),
        ("lbr.commands.run", "def f():\n    from lbr.simulation import port"),
        ("lbr.apps.speech.capability", "from lbr.apps.web import face"),
        ("lbr.apps.foxglove.socket", "from lbr.apps.web import pairing"),
        ("lbr.apps.http.names", "from lbr.apps.web import face"),
        ("lbr.robots.uxa90.rest.service", "from lbr.robots.bioloid import mtn"),
    ],
)
def test_the_check_sees_what_crosses_the_border(module, source):
    assert abroad(source, module)


def test_the_check_lets_pass_what_a_component_needs_and_another_shows():
    assert not abroad("from lbr.apps.web import face\nfrom lbr.apps.http import rates", "lbr.apps.foxglove.socket")


def test_each_folder_of_components_is_one_or_a_library_and_says_what_it_is():
    folders = [
        path.parent
        for part in ("apps", "robots")
        for path in sorted((PACKAGE / part).glob("*/__init__.py"))
        if dotted(path.parent / "x").rpartition(".")[0] not in PROGRAMS
    ]
    places = {dotted(folder / "x").rpartition(".")[0] for folder in (*folders, PACKAGE / "simulation")}
    declared = {name for name in component_names() if component_of(name)}
    assert places - LIBRARIES == declared
    assert not [str(folder) for folder in folders if not (folder / "README.md").is_file()]


def forbidden(source: str, module: str, *, package: bool = False) -> list[str]:
    here = floor(module)
    wrong = []
    for name in sorted(imports(source, module, package=package)):
        library = name.split(".")[0]
        if library == "lbr":
            target = floor(name)
            if here not in TOP and target and target not in FLOORS.get(here, set()):
                wrong.append(name)
        elif here not in OWNERS.get(library, {here}):
            wrong.append(name)
    return wrong


def test_no_modules_import_each_other_in_a_circle_not_even_inside_functions():
    sources = {dotted(path): (text(path), path.name == "__init__.py") for path in MODULES}
    assert not (found := circle(sources)), f"a circle of imports: {' -> '.join(found)}"


def test_the_check_sees_a_circle_that_hides_in_functions():
    hidden = "def late():\n    from lbr.bus import b\n"
    assert circle({"lbr.bus.a": (hidden, False), "lbr.bus.b": ("from lbr.bus.a import x\n", False)})
    assert not circle({"lbr.bus.a": (hidden, False), "lbr.bus.b": ("import os\n", False)})


@pytest.mark.parametrize("paths", by_package(MODULES))
def test_imports_go_down_only_and_each_library_has_one_owner(paths):
    wrong = [
        f"{dotted(path)} must not import {name}"
        for path in paths
        for name in forbidden(text(path), dotted(path), package=path.name == "__init__.py")
    ]
    assert not wrong, "; ".join(wrong)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lbr.messages.drive", "from lbr.bus import keys"),
        ("lbr.robots.uxa90.driver.messages", "from lbr.robots.uxa90.driver import packets"),
        ("lbr.robots.uxa90.rest.service", "from lbr.robots.uxa90.driver import packets"),
        ("lbr.bus.wire", "import lbr.capability.kind"),
        ("lbr.drivers.roboteq.capability", "from lbr.operations.drive import KIND"),
        ("lbr.drivers.roboteq.capability", "from lbr.executive.planning import plan"),
        ("lbr.simulation.devices.roboteq.device", "from lbr.drivers.roboteq import protocol"),
        ("lbr.executive.executive", "from lbr.commands import run"),
        ("lbr.console.terminal", "def f():\n    from lbr.executive import executive"),
        ("lbr.capability.runtime", "import zenoh"),
        ("lbr.executive.planning.plan", "from sqlalchemy.orm import Session"),
        ("lbr.bus.wire", "from ..capability import kind"),
    ],
)
def test_the_check_sees_what_goes_up(module, source):
    assert forbidden(source, module)


@pytest.mark.parametrize(
    "around",
    [
        "def f():\n  {}",
        "class A:\n  async def f():\n    {}",
        "if x:\n  pass\nelse:\n  {}",
        "try:\n  pass\nexcept E:\n  {}",
        "try:\n  pass\nfinally:\n  {}",
        "match x:\n  case 1:\n    {}",
        "for x in y:\n  pass\nelse:\n  with z:\n    while w:\n      {}",
    ],
)
def test_an_import_is_seen_wherever_it_stands(around):
    assert imports(around.format("import zenoh"), "lbr.drivers.pico") == {"zenoh"}


def test_the_check_lets_pass_what_goes_down():
    assert not forbidden("from lbr.robots.uxa90.driver.messages import COUNT_RAD", "lbr.robots.uxa90.rest.counts")
    source = "from lbr.bus import keys\nfrom lbr.capability import Kind\nimport json\nfrom . import protocol"
    assert not forbidden(source, "lbr.drivers.roboteq.capability")


def of_another_family(path: Path) -> list[str]:
    """Return what a driver or an operation imports of its floor that is neither its family's nor for all."""
    place, sort = dotted(path).split("."), floor(dotted(path))
    shared = {dotted(other) for other in (PACKAGE / sort).glob("*.py")}
    wrong = []
    for name in sorted(of(path)):
        parts = name.split(".")
        if parts[1:2] == [sort] and len(parts) > 2:
            own = len(place) > 2 and (parts[1:3] == place[1:3] or place[2] in FAMILIES.get(parts[2], ()))
            if not own and ".".join(parts[:3]) not in shared:
                wrong.append(name)
    return wrong


@pytest.mark.parametrize("paths", by_package(p for p in MODULES if floor(dotted(p)) in {"drivers", "operations"}))
def test_families_of_devices_and_operations_do_not_import_one_another(paths):
    wrong = [f"{dotted(path)} imports {name} of another family" for path in paths for name in of_another_family(path)]
    assert not wrong, "; ".join(wrong)


ROBOT_NAMES = re.compile(r"uxa_?-?90|bioloid|lbr_sim|roboteq|ax-?12", re.IGNORECASE)
"""Particular robots, and products that they are built of."""
OF_PRODUCTS = ("lbr.robots", "lbr.drivers", "lbr.simulation.devices")
"""Where a package may be one robot's or one product's: its own, its driver, what emulates it."""


def is_general(module: str) -> bool:
    """Say whether a module is no part of a package of one robot, product or face, and no list of what a component has."""
    if module in components():
        return False
    for place in OF_PRODUCTS:
        part = module.removeprefix(f"{place}.").partition(".")[0]
        if (
            module.startswith(f"{place}.")
            and part not in FAMILIES
            and (ROOT.joinpath(*place.split("."), part)).is_dir()
        ):
            return False
    return True


@pytest.mark.parametrize("paths", by_package(p for p in MODULES if is_general(dotted(p))))
def test_no_general_floor_knows_a_particular_robot(paths):
    wrong = [
        f"{dotted(path)} names {', '.join(sorted(found))}"
        for path in paths
        if (found := set(ROBOT_NAMES.findall(f"{dotted(path)} {text(path)}")))
    ]
    assert not wrong, f"{'; '.join(wrong)}: that belongs to the robot's package, driver or face"


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lbr.messages.uxa90", ""),
        ("lbr.simulation.bioloid.body", ""),
        ("lbr.apps.web.states", "HEARD = 'what the UXA-90 says'"),
        ("lbr.drivers.wheels.arming", "if kind == 'roboteq': ..."),
        ("lbr.console.toolbar", '"""AX-12A servos."""'),
    ],
)
def test_the_check_sees_a_robot_on_a_general_floor(module, source):
    assert is_general(module)
    assert ROBOT_NAMES.search(f"{module} {source}")


def test_packages_of_one_robot_are_no_general_floor():
    assert not any(
        map(is_general, ("lbr.robots.uxa90.driver.bus", "lbr.robots.uxa90.rest.service", "lbr.robots.bioloid"))
    )
    assert all(
        map(
            is_general,
            ("lbr.drivers.servos.targets", "lbr.apps.web.face", "lbr.drivers.mover", "lbr.robot.declaration"),
        )
    )


def test_what_declares_a_component_imports_nothing_else():
    for name in components():
        (path,) = (one for one in MODULES if dotted(one) == name)
        assert {found.rpartition(".")[0] for found in of(path)} == {"lbr.component"}, name


def test_every_name_of_a_component_is_there_and_no_two_have_the_same():
    for field in plugins.FIELDS:
        found = [name for one in components().values() for name in getattr(one, field)]
        assert sorted(found) == sorted(set(found)), field
        for one in plugins.own(field):
            assert one.load() is not None, one.label
    assert not [why for why in plugins.broken() if "package 'lbr'" in why]
    assert {one.name for one in plugins.entries() if one.ours} >= {"core", "drivers", "web"}


def test_only_entry_points_name_a_robots_package():
    robots = {f"lbr.robots.{path.name}" for path in (PACKAGE / "robots").iterdir() if (path / "__init__.py").exists()}
    assert robots >= {"lbr.robots.bioloid", "lbr.robots.lbr", "lbr.robots.uxa90"}
    for path in MODULES:
        module = dotted(path)
        named = {".".join(name.split(".")[:3]) for name in of(path)} & robots
        assert not named - {".".join(module.split(".")[:3])}, f"{module} imports {', '.join(named)}"


def test_the_console_uses_of_the_database_only_its_light_rows_and_patterns():
    light = ("lbr.database.rows", "lbr.database.patterns", "lbr.database.arguments", "lbr.database.builtin")
    wrong = [
        f"{dotted(path)} imports {name}"
        for path in MODULES
        if floor(dotted(path)) == "console"
        for name in sorted(of(path))
        if name.startswith("lbr.database") and not name.startswith(light)
    ]
    assert not wrong, "; ".join(wrong)


def test_the_server_for_people_says_lines_on_keys_of_its_own():
    """By the console's own keys it could ask for the codes that let phones in, and give itself any token."""
    servers = [path for path in MODULES if dotted(path).startswith("lbr.apps.web")]
    assert servers
    wrong = [dotted(path) for path in servers if re.search(r"keys\.console\(", text(path))]
    assert not wrong, f"{', '.join(wrong)}: use keys.console_of_pages, here and in its rights"


def blind_to_bytes(source: str) -> list[int]:
    """Return the lines that await what msgspec says of JSON, and not what it says of bytes that are no text."""
    awaited = {"msgspec.DecodeError", "msgspec.MsgspecError"}
    enough = {"UnicodeDecodeError", "UnicodeError", "ValueError", "Exception"}
    found = []
    for node in ast.walk(ast.parse(source)) if any(name in source for name in awaited) else ():
        if isinstance(node, ast.Try):
            types = [one for handler in node.handlers if handler.type is not None for one in flat(handler.type)]
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("suppress"):
            types = node.args
        else:
            continue
        names = {ast.unparse(one) for one in types}
        if names & awaited and not names & enough:
            found.append(node.lineno)
    return found


def flat(node: ast.expr) -> list[ast.expr]:
    return node.elts if isinstance(node, ast.Tuple) else [node]


@pytest.mark.parametrize("paths", by_package(MODULES))
def test_who_reads_json_awaits_bytes_that_are_no_text(paths):
    """Within a string msgspec lets Python's own error for them through, which is none of its own."""
    wrong = [f"{dotted(path)}:{line}" for path in paths for line in blind_to_bytes(text(path))]
    assert not wrong, f"{', '.join(wrong)}: catch UNREADABLE of lbr.messages.unreadable"


def test_the_check_sees_who_does_not_await_them():
    assert blind_to_bytes("try:\n    f()\nexcept (OSError, msgspec.DecodeError):\n    pass") == [1]
    assert blind_to_bytes("with suppress(msgspec.MsgspecError):\n    f()") == [1]
    assert not blind_to_bytes("try:\n    f()\nexcept (msgspec.DecodeError, UnicodeDecodeError):\n    pass")


def loaded_after(*modules: str) -> list[str]:
    script = "import sys, json, importlib\nfor name in json.loads(sys.argv[1]): importlib.import_module(name)\n"
    script += "print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})))"
    done = programs.run([sys.executable, "-c", script, json.dumps(modules)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def registered() -> dict[str, str]:
    return {name: where.partition(":")[0] for one in components().values() for name, where in one.kinds.items()}


def test_declaring_kinds_loads_nothing_heavy():
    loaded = loaded_after(*registered().values())
    assert not set(HEAVY) & set(loaded)
    assert "zenoh" not in loaded


def test_what_device_rows_may_set_is_known_without_loading_what_emulates_them():
    devices = [dotted(path) for path in (PACKAGE / "simulation" / "devices").glob("**/__init__.py")]
    script = "import sys, importlib\nfor name in sys.argv[1:]: importlib.import_module(name)\nprint(*sys.modules)"
    done = programs.run([sys.executable, "-c", script, *devices], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert not set(HEAVY) & {name.split(".")[0] for name in loaded}
    assert len(devices) > 5
    emulating = ("lbr.simulation.twins", "lbr.simulation.cameras")
    assert not [name for name in loaded if name.startswith(emulating) or name.endswith((".twin", ".device"))]


def test_a_driver_or_operation_loads_nothing_heavy_in_its_process():
    entries = [dotted(path) for path in MODULES if floor(dotted(path)) in {"drivers", "operations"}]
    light = [name for name in entries if not name.startswith(NUMERIC)]
    assert not set(HEAVY) & set(loaded_after(*light, "lbr.capability.process"))


def test_an_operation_that_computes_with_arrays_loads_nothing_else_that_is_heavy():
    entries = [dotted(path) for path in MODULES if dotted(path).startswith(NUMERIC)]
    assert not (set(HEAVY) - {"numpy", "imufusion"}) & set(loaded_after(*entries, "lbr.capability.process"))


def test_the_command_line_loads_neither_bus_nor_database_for_its_help():
    script = "import sys; from lbr import cli; cli.main(['--help'])\nprint('loaded', *sys.modules)"
    done = programs.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "lbr.apps.web" in loaded
    assert not {"zenoh", "msgspec", "sqlalchemy", "mujoco", "numpy", "prompt_toolkit", "importlib.metadata"} & loaded


@pytest.mark.parametrize("paths", by_package(MODULES))
def test_modules_stay_small_and_finished(paths):
    large = [dotted(path) for path in paths if len(text(path).splitlines()) >= LARGEST_LINES]
    assert not large, f"{LARGEST_LINES} lines or more: {', '.join(large)}"
    left = [
        f"{dotted(path)} still has a {word}"
        for path in paths
        for word in ("TODO", "FIXME", "XXX", "NotImplementedError")
        if word in text(path)
    ]
    assert not left, "; ".join(left)


def test_half_of_the_modules_fit_on_a_few_screens():
    assert statistics.median(len(text(path).splitlines()) for path in MODULES) < MEDIAN_LINES


def test_every_registered_kind_carries_its_own_name():
    script = "from lbr.capability.registry import find; from pathlib import Path; import sys, json\n"
    script += "print(json.dumps({name: find(name, Path('/nowhere')).name for name in json.loads(sys.argv[1])}))"
    names = sorted(registered())
    done = programs.run([sys.executable, "-c", script, json.dumps(names)], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == {name: name for name in names}


def named(tree: ast.AST, name: str) -> bool:
    """Say whether a module has a function or class of this name, `Class.method` too."""
    first, _, rest = name.partition(".")
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    found = next((one for one in ast.iter_child_nodes(tree) if isinstance(one, kinds) and one.name == first), None)
    return found is not None and (not rest or named(found, rest))


def test_every_file_and_function_that_the_page_of_the_architecture_names_is_there():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    places = re.findall(r"`(lbr/[a-z0-9_/]+\.py)(?::([A-Za-z_.]+))?`", page)
    assert len(places) > 15
    gone = [
        f"{path}:{name}"
        for path, name in places
        if not (ROOT / path).is_file() or (name and not named(ast.parse((ROOT / path).read_text()), name))
    ]
    assert gone == []


def test_the_page_of_the_architecture_has_every_part_of_the_core_and_every_component():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    parts = {part for part in CORE if not re.search(rf"`(lbr/)?{part}(\.py)?`", page)}
    places = ("apps/*", "robots/*", "simulation")
    folders = {path.parent for place in places for path in PACKAGE.glob(f"{place}/README.md")}
    unlisted = {str(folder) for folder in folders if f"(../{folder.relative_to(ROOT)}/README.md)" not in page}
    assert len(folders) > 20
    assert not parts | unlisted


@cache
def is_module(name: str) -> bool:
    place = ROOT.joinpath(*name.split("."))
    return place.with_suffix(".py").exists() or (place / "__init__.py").exists()


def misplaced(source: str, module: str, *, package: bool = False) -> list[str]:
    """Return what a test, a piece of machinery or a benchmark imports that it must not, with the reason."""
    place, room, *_ = [*module.split("."), ""]
    shared = room in MACHINERY and not module.rpartition(".")[2].startswith("test_")
    seen = MACHINERY[: MACHINERY.index(room) + 1] if shared else MACHINERY
    wrong = []
    for name in sorted(imports(source, module, package=package)):
        parts = name.split(".")
        if parts[0] in {"tests", "benchmarks"} and not (
            is_module(name) or ((parent := name.rpartition(".")[0]) != "tests" and is_module(parent))
        ):
            wrong.append(f"{name}: there is no such module")
        elif parts[0] == "benchmarks" and place == "tests":
            wrong.append(f"{name}: tests do not import benchmarks")
        elif parts[0] == "tests" and (shared or place == "benchmarks") and parts[1] not in seen:
            wrong.append(f"{name}: what is shared imports only {', '.join(seen)}")
        elif (
            parts[0] != "lbr"
            and is_module(".".join([*module.split(".")[:-1], parts[0]]))
            and len(module.split(".")) > 1
            and parts[0] not in OWNERS
        ):
            wrong.append(f"{name}: import a neighbour by its full name")
    return wrong


@pytest.mark.parametrize("paths", by_package(AROUND))
def test_tests_and_benchmarks_meet_only_in_what_they_share(paths):
    wrong = [
        f"{dotted(path)} imports {what}"
        for path in paths
        for what in misplaced(text(path), dotted(path), package=path.name == "__init__.py")
    ]
    assert not wrong, "; ".join(wrong)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("tests.drivers.test_pico", "from benchmarks.soak import Soak"),
        ("tests.models.lockstep", "from tests.drivers import peers"),
        ("tests.models.lockstep", "from tests.scenarios.promises import PROMISES"),
        ("tests.support.robot", "import benchmarks"),
        ("benchmarks.soak", "from tests.safety.limits import holds"),
        ("tests.drivers.test_pico", "from peers import FakeContext"),
        ("tests.drivers.test_pico", "from tests.robot import start"),
        ("tests.drivers.test_pico", "from tests import robot as robots"),
    ],
)
def test_the_check_sees_what_does_not_meet_there(module, source):
    assert misplaced(source, module)


def test_what_tests_and_benchmarks_start_ends_with_them():
    free = {ROOT / "tests" / "support" / name for name in ("programs.py", "sweep.py")}
    starts = re.compile(r"\bsubprocess\.(Popen|run|call|check_call|check_output)\(|\bos\.(fork|system)\(|\bpty\.fork\(")
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for folder in ("tests", "benchmarks")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if path not in free
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if starts.search(line)
    ]
    assert not found, f"start it by tests.support.programs: {found}"
