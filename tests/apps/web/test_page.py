"""The page as it is served: built of the sources beside it, by a strict policy, and kept by browsers while it holds."""

import gzip
import json
import re
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import msgspec
import pytest

import lbr
from lbr import plugins
from lbr.apps.web.face import HTML, Route, text
from lbr.apps.web.page.files import NotBuiltError, PageFace, built, file
from lbr.capability import registry
from tests.apps.web.test_web_server import Plain
from tests.apps.web.web_stage import Served, serving

PAGE = Path(lbr.__file__).parent / "apps" / "web" / "page"
DIST = PAGE / "dist"
SOURCES = ("index.html", "package.json", "package-lock.json", "vite.config.ts", "tsconfig.json", "src", "public")
BROWSER = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8", "Accept-Encoding": "gzip, deflate, br"}
LARGEST_FIRST_LOAD = 350_000
HEAVY = re.compile(r"three|uPlot", re.IGNORECASE)
in_checkout = pytest.mark.skipif(not (PAGE / "src").exists(), reason="the page's sources are not in the wheel")


def digest(path: Path) -> str:
    return sha256(path.read_bytes()).hexdigest()


def sources() -> list[Path]:
    found = [PAGE / name for name in SOURCES]
    return [one for place in found for one in (place.rglob("*") if place.is_dir() else [place]) if one.is_file()]


@pytest.fixture(scope="module")
def served(tmp_path_factory) -> Iterator[Served]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LBR_HOME", str(tmp_path_factory.mktemp("home")))
        with serving(Plain(), faces=("page",), requests_per_s=4000.0) as found:
            yield found


def index() -> str:
    return (DIST / "index.html").read_text(encoding="utf-8")


def first_load() -> list[str]:
    """Return what the page itself names, and what the view that is shown first loads besides."""
    named = re.findall(r'(?:src|href)="\./([^"]+)"', index())
    views = [f"assets/{one.name}" for one in (DIST / "assets").iterdir() if one.name.startswith("Drive-")]
    return ["index.html", *named, *views]


@in_checkout
def test_what_is_committed_was_built_of_these_sources():
    lines = sorted((str(one.relative_to(PAGE).as_posix()), digest(one)) for one in sources())
    told = sha256("".join(f"{content}  {name}\n" for name, content in lines).encode()).hexdigest()
    assert json.loads((DIST / "manifest.json").read_text())["sources"] == told, "the page is not built: `make page`"


def test_what_is_committed_is_what_the_build_wrote():
    told = json.loads((DIST / "manifest.json").read_text())["files"]
    there = {one.relative_to(DIST).as_posix(): digest(one) for one in DIST.rglob("*") if one.is_file()}
    del there["manifest.json"]
    assert there == told


@in_checkout
def test_the_lock_names_exact_packages_and_no_place_to_get_them():
    lock = json.loads((PAGE / "package-lock.json").read_text())
    packages = {name: one for name, one in lock["packages"].items() if name}
    assert packages
    assert all(one.get("integrity", "").startswith("sha512-") for one in packages.values())
    assert not any("resolved" in one for one in packages.values())


def test_the_page_has_no_map_and_no_script_or_style_within_its_text():
    assert not list(DIST.rglob("*.map"))
    assert "<style" not in index()
    assert " style=" not in index()
    assert all('src="' in tag for tag in re.findall(r"<script[^>]*>", index()))


def test_the_first_load_is_small():
    total = sum(len(gzip.compress((DIST / name).read_bytes(), 6)) for name in first_load())
    assert not [name for name in first_load() if HEAVY.search(name)]
    assert total < LARGEST_FIRST_LOAD


def test_a_browser_gets_the_page_and_all_that_it_names(served):
    answer = served.ask("GET", "/", headers=BROWSER)
    assert answer.status == 200
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert gzip.decompress(answer.body).decode() == index() or answer.body.decode() == index()
    for name in first_load()[1:]:
        part = served.ask("GET", f"/{name}")
        assert (part.status, part.body) == (200, (DIST / name).read_bytes())


def test_who_asks_for_no_page_is_answered_by_another_face(served):
    assert served.ask("GET", "/").body == b"OK"
    assert served.ask("GET", "/", headers={"Accept": "*/*"}).body == b"OK"
    assert served.ask("GET", "/", headers={"Accept": "application/json, text/htmlx"}).body == b"OK"
    assert b"<!doctype html>" in served.ask("GET", "/", headers={"Accept": "text/plain, TEXT/HTML;q=0.1"}).body


@pytest.mark.parametrize("accept", ["*/*", "application/json", "text/html"])
@pytest.mark.parametrize("method", ["GET", "HEAD"])
def test_a_page_without_another_face_beside_it_answers_everybody(accept, method):
    with serving(faces=("page",)) as found:
        answer = found.ask(method, "/", headers={"Accept": accept})
    assert (answer.status, answer.headers["content-type"]) == (200, "text/html; charset=utf-8")


@pytest.mark.parametrize(
    ("suffix", "media"),
    [
        (".js", "text/javascript; charset=utf-8"),
        (".css", "text/css; charset=utf-8"),
        (".svg", "image/svg+xml"),
        (".webmanifest", "application/manifest+json"),
        (".ico", "image/x-icon"),
    ],
)
def test_each_part_has_its_type(served, suffix, media):
    part = next(one for one in DIST.rglob(f"*{suffix}"))
    answer = served.ask("GET", f"/{part.relative_to(DIST).as_posix()}")
    assert answer.headers["content-type"].replace("; charset=utf-8", "") == media.replace("; charset=utf-8", "")
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_what_carries_its_content_in_its_name_is_kept_and_the_page_is_not(served):
    named = next(name for name in first_load() if name.startswith("assets/"))
    assert "immutable" in served.ask("GET", f"/{named}").headers["cache-control"]
    page = served.ask("GET", "/", headers=BROWSER)
    assert page.headers["cache-control"] == "no-cache"
    again = served.ask("GET", "/", headers={**BROWSER, "If-None-Match": f'"other", W/{page.headers["etag"]}'})
    assert (again.status, again.body) == (304, b"")


def test_large_parts_are_compressed_for_who_takes_that(served):
    named = next(name for name in first_load() if name.endswith(".js"))
    packed = served.ask("GET", f"/{named}", headers={"Accept-Encoding": "br, gzip;q=0.5"})
    assert packed.headers["content-encoding"] == "gzip"
    assert gzip.decompress(packed.body) == (DIST / named).read_bytes()
    assert "accept-encoding" in packed.headers["vary"].lower()
    assert "content-encoding" not in served.ask("GET", f"/{named}", headers={"Accept-Encoding": "gzip;q=0"}).headers


def test_the_policy_lets_nothing_in_from_elsewhere_or_from_within_the_text(served):
    policy = served.ask("GET", "/", headers=BROWSER).headers["content-security-policy"]
    told = dict(part.strip().split(" ", 1) for part in policy.split(";"))
    assert told["default-src"] == "'none'"
    assert told["script-src"] == told["style-src"] == told["connect-src"] == "'self'"
    assert "unsafe" not in policy


@pytest.mark.parametrize("path", ["/assets/nothing.js", "/assets/..%2findex.html", "/assets/%2e%2e", "/manifest.json"])
def test_nothing_else_is_served(served, path):
    assert served.ask("GET", path).status == 404


def test_a_page_that_is_not_built_says_what_to_do(tmp_path):
    with pytest.raises(NotBuiltError, match="make page"):
        built(tmp_path / "dist")


def test_two_faces_may_not_answer_the_same_askers_at_one_path(served):
    class Second(Plain):
        name = "second"

        def routes(self):
            return [Route(method="GET", path="/", handle=lambda: text("mine"), role=None, page=True, accept=HTML)]

    with serving(PageFace((file("index.html", b"<!doctype html>"),)), Second(), faces=()) as found:
        assert b"doctype" in found.ask("GET", "/", headers=BROWSER).body
        assert found.ask("HEAD", "/").status == found.ask("GET", "/", headers={"Accept": "*/*"}).status == 200
        assert "GET / is taken by face 'page'" in found.web._faces.trouble


@in_checkout
def test_each_setting_that_people_ask_for_first_has_its_title_in_each_language():
    words = (PAGE / "src" / "words" / "system.ts").read_text()
    written = dict(re.findall(r'"setting\.([a-z_]+\.[a-z_]+)": \["([^"]+)", "[^"]+"\]', words))
    groups = set(re.findall(r'"settings\.([a-z]+)":', words))
    titles = dict(basics())
    assert {name: title for name, title in written.items() if name in titles} == titles
    assert {name.partition(".")[0] for name in titles} <= groups


def basics() -> Iterator[tuple[str, str]]:
    """Yield group and name of each such setting of all kinds, and its title as it is declared."""
    for one in plugins.own("kinds"):
        schema = msgspec.json.schema(registry.find(one.name, Path("/nowhere")).settings)
        for struct in schema["$defs"].values():
            for setting, declared in struct.get("properties", {}).items():
                if group := declared.get("x-basic"):
                    yield f"{group}.{setting}", declared["title"]
