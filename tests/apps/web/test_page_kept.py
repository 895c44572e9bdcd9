"""The page in a browser beyond the moment: kept on the device for when the robot is off, and never older than its robot."""

import ssl
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import replace
from hashlib import sha256

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

from lbr.apps.web import capability
from lbr.apps.web.page import files
from tests.apps.web.page_robot import page_robot
from tests.apps.web.test_page_browser import Opened, grip
from tests.support import browsers, needs
from tests.support.browsers import within

needs.modules("playwright")

from playwright.sync_api import Browser, expect, sync_playwright  # noqa: E402

pytestmark = [needs.program("chromium", "chromium")]
KEPT = """async () => {
  await navigator.serviceWorker.ready;
  const all = await Promise.all((await caches.keys()).map(async (name) => (await (await caches.open(name)).keys()).map((one) => one.url)));
  return all.flat();
}"""
FAILS = """() => navigator.serviceWorker.register("./worker.js").then((one) => new Promise((done) => {
  one.installing.addEventListener("statechange", (event) => done(event.target.state));
}))"""
MET = {"in-incognito"}
"""What a test's browser always lacks to install a page."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory) -> Iterator[Browser]:
    with sync_playwright() as started:
        found = browsers.start_windowed(started, tmp_path_factory.mktemp("browser"))
        yield found
        found.close()


def test_a_page_that_was_kept_says_that_its_robot_is_off(browser):
    with page_robot() as (robot, url):
        opened = Opened(browser, url)
        page = opened.page(service_workers="allow")
        kept = page.evaluate(KEPT)
        names = {one.name for one in files.built()}
        assert f"{url}/" in kept
        assert {one.removeprefix(f"{url}/") or files.INDEX for one in kept} <= names
        told = page.context.new_cdp_session(page)
        assert told.send("Page.getAppManifest")["errors"] == []
        errors = {one["errorId"] for one in told.send("Page.getInstallabilityErrors")["installabilityErrors"]}
        assert errors <= MET
        page.goto("about:blank")
        assert within(page, lambda: robot.sockets == 0)
    page.goto(f"{url}/#drive")
    expect(page.get_by_role("heading", name="The robot does not answer")).to_be_visible()
    expect(page.locator("#stop")).to_be_visible()
    opened.close()


def test_by_tls_a_page_is_kept_where_the_certificate_is_known_and_not_where_a_warning_was_passed(browser, tmp_path):
    with page_robot(tls=True) as (robot, url):
        certificate = ssl.get_server_certificate(("127.0.0.1", robot.served.port)).encode()
        public = x509.load_pem_x509_certificate(certificate).public_key()
        spki = public.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)
        known = b64encode(sha256(spki).digest()).decode()
        opened = Opened(browser, url)
        page = opened.page(service_workers="allow", ignore_https_errors=True)
        assert "SecurityError" in page.evaluate("() => navigator.serviceWorker.register('./worker.js').catch(String)")
        opened.close()
        opened.errors.clear()
        context = browser.browser_type.launch_persistent_context(
            tmp_path / "profile",
            **browsers.windowed(tmp_path, f"--ignore-certificate-errors-spki-list={known}"),
        )
        page = context.new_page()
        page.goto(url)
        assert f"{url}/" in page.evaluate(KEPT)
        told = context.new_cdp_session(page).send("Page.getInstallabilityErrors")["installabilityErrors"]
        assert {one["errorId"] for one in told} <= MET
        page.goto("about:blank")
        assert within(page, lambda: robot.sockets == 0)
        context.close()


def test_a_file_that_is_not_the_one_that_was_built_is_not_kept(browser, monkeypatch):
    other = [replace(one, plain=one.plain + b" " * (one.name == "icon-192.png")) for one in files.built()]
    monkeypatch.setattr(files, "built", lambda: other)
    with page_robot() as (_, url):
        opened = Opened(browser, url)
        page = opened.page(path="/licences.md", service_workers="allow")
        assert page.evaluate(FAILS) == "redundant"
        page.goto("about:blank")
        opened.close()


def test_a_page_that_is_behind_its_robot_loads_itself_once_and_then_moves_nothing(browser, monkeypatch):
    with page_robot() as (robot, url):
        port = robot.served.port
        opened = Opened(browser, url)
        page = opened.page()
        grip(page)
        assert within(page, lambda: robot.moves)
        page.mouse.up()
        assert within(page, lambda: not robot.moves)
        loads: list[str] = []
        page.on("load", lambda page: loads.append(page.url))
    monkeypatch.setattr(capability, "build", lambda: "of tomorrow")
    with page_robot(port=port) as (robot, _):
        sign = page.get_by_role("alert").filter(has_text="another version")
        expect(sign).to_be_visible(timeout=10_000)
        assert len(loads) == 1
        grip(page)
        expect(page.locator(".drive-why")).to_contain_text("another version")
        page.mouse.up()
        assert (robot.moves, robot.held) == (False, [])
        page.locator("#stop").click()
        assert within(page, lambda: ("stop", None) in robot.asked)
        loads.clear()
        sign.get_by_role("button", name="Load again").click()
        assert within(page, lambda: loads)
        expect(sign).to_be_visible()
    monkeypatch.undo()
    with page_robot(port=port) as (robot, _):
        expect(sign).to_have_count(0)
        grip(page)
        assert within(page, lambda: robot.moves)
        opened.close()
    ended = ("net::ERR", " 503 ")  # a server that has ended, or has just begun
    assert [one for one in opened.errors if not any(how in one for how in ended)] == []
