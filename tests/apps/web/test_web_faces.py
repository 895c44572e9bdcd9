"""Faces that packages bring: shown beside ours, or refused in words, while the rest is served."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from lbr import plugins
from tests.apps.web.web_stage import Served, serving
from tests.docs.pages import ROOT
from tests.support.packages import imported_from, package
from tests.support.waiting import until

FACE = '''
from lbr.apps.web.face import Face, Message, get, post

class Hello(Face):
    name = "hello"

    def __init__(self, robot):
        self.robot = robot

    @get("/hello")
    def hello(self) -> Message:
        """Say hello."""
        return Message(message="hello")

    @get("/whom")
    async def whom(self) -> Message:
        """Say whom."""
        reply = await self.robot.ask("halt", __import__("lbr.messages.leases", fromlist=["x"]).StopCommand())
        return Message(message=str(reply.accepted))

    @post("/break")
    async def end(self) -> Message:
        """Break."""
        self.step = self.broken
        return Message(message="soon")

    def broken(self, now):
        raise KeyError("gone")

    def state(self):
        return {"here": True}
'''


class Packages:
    """A folder on the path of Python, into which packages are installed as pip would."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def install(self, name: str, face: str, code: str, *, needs: str = "") -> None:
        module = name.replace("-", "_")
        package(
            self._folder,
            name,
            version="1.5",
            requires=(needs,) if needs else (),
            brings={"faces": {face: f"{module}:Hello"}},
            files={f"{module}.py": code},
        )
        plugins.forget()


@pytest.fixture
def packages(tmp_path) -> Iterator[Packages]:
    with imported_from(tmp_path):
        yield Packages(tmp_path)


def test_a_package_brings_a_face(packages):
    packages.install("friendly-robot", "hello", FACE)
    with serving(faces=("hello",)) as served:
        assert served.ask("GET", "/hello").said == "hello"
        assert served.ask("GET", "/whom").said == "True"
        assert served.ask("GET", "/state").json["faces"] == {"hello": {"here": True}}
        assert "/hello" in served.ask("GET", "/openapi.json").json["paths"]
        assert served.stage.warned == []


def trouble(served: Served) -> str:
    """Return the sentence about what is not shown; all else is served."""
    assert served.ask("GET", "/state").status == 200
    assert served.ask("POST", "/stop").status == 200
    assert [(kind, level) for kind, _, level in served.stage.events if kind == "face_refused"] == [
        ("face_refused", "error")
    ]
    (said,) = served.stage.warned
    assert "face 'hello'" in said
    assert "capability 'uxa90/web'" in said
    until(lambda: served.stage.published["state"].reason == said)
    return said


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import nothing_of_this_name", "it does not load: ModuleNotFoundError: No module named 'nothing_of"),
        ("def Hello(robot): return 1 / 0", "it cannot be made: ZeroDivisionError"),
        (FACE.replace('name = "hello"', 'name = "hi"'), "calls itself 'hi'"),
        (FACE.replace('"/hello"', '"/State/"'), "GET /State/ is taken by the server"),
        (FACE.replace("-> Message", "-> object"), "cannot be described"),
        (FACE.replace("def hello(self)", "def hello(self, hat)"), "GET /hello takes hat, which no request has"),
        (FACE + "    def routes(self): return 5", "cannot be described"),
    ],
)  # fmt: skip
def test_a_face_that_does_not_fit_is_refused_in_words_and_the_rest_is_served(packages, code, said):
    packages.install("friendly-robot", "hello", code)
    with serving(faces=("hello",)) as served:
        told = trouble(served)
    assert said in told
    assert "package 'friendly-robot 1.5'" in told


def test_a_face_that_nobody_brings_is_told_with_those_there_are(packages, wording):
    with serving(faces=("hello",)) as served:
        wording(trouble(served))


def test_a_path_that_another_face_has_is_taken(packages):
    packages.install("friendly-robot", "hello", FACE)
    packages.install("other-robot", "hello2", FACE.replace('"hello"', '"hello2"'))
    with serving(faces=("hello", "hello2")) as served:
        assert served.ask("GET", "/hello").status == 200
        assert "GET /hello is taken by face 'hello'" in served.stage.warned[0]
        until(lambda: served.stage.published["state"].faces == ("hello",))


def test_a_face_that_breaks_ends_and_no_other(packages):
    packages.install("friendly-robot", "hello", FACE)
    with serving(faces=("hello",)) as served:
        assert served.ask("POST", "/break").status == 200
        until(lambda: served.stage.warned)
        answer = served.ask("GET", "/hello")
        assert (answer.status, "KeyError" in answer.said) == (503, True)
        assert "KeyError" in trouble(served)


def test_what_lbr_ships_is_installed_as_anybodys():
    assert plugins.installed("faces")["uxa90"].value == "lbr.robots.uxa90.rest.legacy:Uxa90Face"


def test_the_face_that_the_page_shows_is_one(packages):
    page = (ROOT / "lbr" / "apps" / "web" / "README.md").read_text()
    blocks = re.findall(r"```(?:python|toml)\n(.*?)```", page, re.DOTALL)
    project, component, code = blocks[:3]
    declared: dict[str, Any] = {}
    exec(component, declared)
    assert declared["COMPONENT"].faces == {"hello": "friendly_robot.hello:Hello"}
    said = tomllib.loads(project)["project"]
    assert said["entry-points"][plugins.GROUP] == {"hello": "friendly_robot:COMPONENT"}
    packages.install(said["name"], "hello", code, needs=said["dependencies"][0])
    with serving(faces=("hello",)) as served:
        assert served.ask("GET", "/hello").said == "127.0.0.1: the robot stands"
