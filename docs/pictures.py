"""Takes the pictures of the page that README and docs show, of the three robots in simulation: python docs/pictures.py [ROBOT ...].

Run by hand after the page has changed, with the extras `sim` and `dev` installed and Chromium on the machine. Each is small: WebP,
at most 150 kB; a short film at most 700 kB. NAME.webp is light and NAME_dark.webp dark: the site shows either. `--all FOLDER` takes every view instead, on a phone and at a desk, dark and light, to
look at before the page is changed further.
"""

import argparse
import base64
import io
import re
import shutil
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from lbr.testing.robot import Robot, running, until

HERE = Path(__file__).parent / "pictures"
PHONE, DESK = {"width": 390, "height": 844}, {"width": 1280, "height": 800}
MOST_BYTES, MOST_FILM_BYTES = 150_000, 700_000
SLOWLY_MS = 120_000
FRAME_MS, LAST_MS = 70, 600
THEME_MS = 1500
THEMES = (("light", ""), ("dark", "_dark"))
"""By theme, the end of a picture's name."""
BODY_MS = 8000
"""A body of thirty links drawn without a graphics card needs some seconds until it stands still."""


def address(robot: Robot) -> str:
    """Return where this machine reaches the page, also of a robot that is open to the network."""
    return re.sub(r"https://[^:/]+", "http://127.0.0.1", robot.ask("web/state")["urls"][0].rstrip("/") + "/")


@contextmanager
def shown(browser: Browser, robot: Robot, size: dict[str, int], theme: str, language: str = "en-GB") -> Iterator[Page]:
    """Open a robot's page, and wait until it is drawn."""
    context = browser.new_context(viewport=size, color_scheme=theme, locale=language, has_touch=size is PHONE)  # type: ignore[arg-type]
    context.add_init_script("localStorage.setItem('lbr.solid', 'true')")  # no graphics card draws here
    page = context.new_page()
    page.set_default_timeout(SLOWLY_MS)
    page.goto(address(robot))
    page.wait_for_selector(".nav-item")
    yield page
    context.close()


def look(page: Page, view: str, settle_ms: int = 4000) -> None:
    """Go to a view and let it come to rest."""
    page.evaluate(f"location.hash = '#{view}'")
    page.wait_for_timeout(settle_ms)


def keep(page: Page, name: str) -> None:
    """Write the view as two small files, light and dark, once the page hears the robot: drawing a body may hold it up."""
    for theme, suffix in THEMES:
        page.emulate_media(color_scheme=theme)  # type: ignore[arg-type]
        page.wait_for_timeout(THEME_MS)
        page.wait_for_function("!document.body.innerText.includes('The link to the robot is lost')")
        picture, path = Image.open(io.BytesIO(page.screenshot())).convert("RGB"), HERE / f"{name}{suffix}.webp"
        for quality in (88, 75, 60):
            picture.save(path, quality=quality, method=6)
            if path.stat().st_size <= MOST_BYTES:
                break
        print(f"{path.name} {path.stat().st_size // 1024} kB")


def film(
    page: Page, name: str, act: Callable[[], object], *, frame_ms: int = FRAME_MS, width: int = 0, quality: int = 70
) -> None:
    """Write what is shown while something is done, in its own time, as an animation; a width scales it down."""
    shots: list[tuple[float, str]] = []
    seen = page.context.new_cdp_session(page)

    def took(frame: dict[str, Any]) -> None:
        shots.append((frame["metadata"]["timestamp"], frame["data"]))
        seen.send("Page.screencastFrameAck", {"sessionId": frame["sessionId"]})

    seen.on("Page.screencastFrame", took)
    seen.send("Page.startScreencast", {"format": "jpeg", "quality": 92})
    act()
    page.wait_for_timeout(LAST_MS)
    seen.send("Page.stopScreencast")
    kept = [shots[0]]
    for shot in shots[1:]:
        if shot[0] - kept[-1][0] >= frame_ms / 1000:
            kept.append(shot)
    frames = [Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB") for _, data in kept]
    if width:
        frames = [
            frame.resize((width, round(frame.height * width / frame.width)), Image.Resampling.LANCZOS)
            for frame in frames
        ]
    lasts = [round(1000 * (after - before)) for (before, _), (after, _) in pairwise(kept)] + [LAST_MS]
    path = HERE / f"{name}.webp"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=lasts, loop=0, quality=quality, method=4)
    print(f"{path.name} {path.stat().st_size // 1024} kB, {len(frames)} frames, {sum(lasts) / 1000:.1f} s")
    assert path.stat().st_size <= MOST_FILM_BYTES, "the film is too large"


def beside(page: Page, act: Callable[[], object]) -> None:
    """Do something that needs no browser, while the page goes on."""
    thread = threading.Thread(target=act)
    thread.start()
    while thread.is_alive():
        page.wait_for_timeout(FRAME_MS)


def drive_about(page: Page) -> None:
    """Drive ahead, turn to the left, and drive ahead again, by the buttons of the page."""
    page.wait_for_timeout(500)
    for move in ("Ahead 50 cm", "Turn -90°", "Ahead 50 cm"):
        page.get_by_role("button", name=move).click()
        page.wait_for_timeout(4500)


def every_view(page: Page, folder: Path, name: str) -> None:
    """Write each view, and each page of System, as it is and down to its end."""
    for view in page.locator(".nav-item").evaluate_all("found => found.map((one) => one.hash.slice(1))"):
        look(page, view, BODY_MS if view == "joints" else 3000)
        pages = page.locator(".system-head [role=radio]") if view == "system" else None
        for part in range(pages.count() if pages else 1):
            if pages:
                pages.nth(part).click()
                page.wait_for_timeout(1500)
            page.screenshot(path=folder / f"{name}-{view}{part or ''}.png")
            page.evaluate("document.querySelector('.main').scrollTo(0, 1e6); window.scrollTo(0, 1e6)")
            page.wait_for_timeout(300)
            page.screenshot(path=folder / f"{name}-{view}{part or ''}-end.png")
            page.evaluate("document.querySelector('.main').scrollTo(0, 0); window.scrollTo(0, 0)")


def take_all(browser: Browser, robot: Robot, folder: Path, name: str) -> None:
    """Take each view of a robot: on a phone and at a desk, dark in German and light in English."""
    for size, screen in ((PHONE, "phone"), (DESK, "desk")):
        for theme, language in (("dark", "de-DE"), ("light", "en-GB")):
            with shown(browser, robot, size, theme, language) as page:
                every_view(page, folder, f"{name}-{screen}-{theme}")


def film_drive(browser: Browser, robot: Robot) -> None:
    """The film of a first drive, light and dark."""
    for theme, suffix in THEMES:
        with shown(browser, robot, {"width": 1120, "height": 700}, theme) as page:
            look(page, "drive")
            film(page, f"drive{suffix}", lambda: drive_about(page), frame_ms=150, width=720, quality=45)


def film_wave(browser: Browser, robot: Robot) -> None:
    """The film of a humanoid that waves, light and dark."""
    for theme, suffix in THEMES:
        with shown(browser, robot, {"width": 640, "height": 520}, theme) as page:
            look(page, "joints", BODY_MS)
            film(page, f"wave{suffix}", lambda: beside(page, lambda: robot.move("/play/wave")))


def of_lbr(browser: Browser, robot: Robot) -> None:
    """Drive, the rows, a table that runs, and a phone's code; the film: a first drive."""
    with shown(browser, robot, PHONE, "dark") as page:
        look(page, "drive")
        keep(page, "drive_phone")
    with shown(browser, robot, DESK, "light") as page:
        look(page, "drive")
        keep(page, "drive_desk")
        look(page, "system")
        page.get_by_role("radio", name="Settings").click()
        page.wait_for_timeout(1500)
        page.locator(".row", has=page.get_by_text("drive", exact=True)).first.click()
        page.get_by_role("dialog").get_by_label("Top speed").fill("0.6")
        page.get_by_text("Restarts drive.").wait_for()
        page.evaluate("document.querySelector('.dialog-veil').scrollTo(0, 0)")
        page.wait_for_timeout(500)
        keep(page, "rows_desk")
    film_drive(browser, robot)
    with shown(browser, robot, DESK, "dark") as page:
        robot.say("/behaviour/run/patrol")
        look(page, "behaviours", 6000)
        keep(page, "behaviours_desk")
        robot.say("s")
        look(page, "system")
        keep(page, "system_desk")
    robot.say("open")
    until(lambda: "https" in str((robot.ask("web/state") or {}).get("urls")), "its page, open to the network", 60.0)
    with shown(browser, robot, DESK, "light") as page:
        look(page, "drive")
        page.get_by_role("button", name="Connect a phone").first.click()
        page.locator(".phone-picture").wait_for()
        page.wait_for_timeout(500)
        keep(page, "phone_desk")


def of_bioloid(browser: Browser, robot: Robot) -> None:
    """Its joints on its own body, and its motions; the film: it waves."""
    robot.say("/torque/on")
    with shown(browser, robot, DESK, "dark") as page:
        look(page, "joints", BODY_MS)
        keep(page, "joints_desk")
        look(page, "motions")
        keep(page, "motions_desk")
    film_wave(browser, robot)


def of_uxa90(browser: Browser, robot: Robot) -> None:
    """Its joints on its own body, and its motions on a phone."""
    with shown(browser, robot, DESK, "light") as page:
        look(page, "joints", BODY_MS)
        keep(page, "uxa90_desk")
    with shown(browser, robot, PHONE, "light") as page:
        look(page, "motions", 6000)
        keep(page, "uxa90_phone")


TAKEN: dict[str, Callable[[Browser, Robot], None]] = {"lbr": of_lbr, "bioloid": of_bioloid, "uxa90": of_uxa90}


def main() -> None:
    """Take those of the robots that are named, or of all."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("robot", nargs="*", choices=[*TAKEN, []], help="of these robots alone")
    asked.add_argument("--all", type=Path, metavar="FOLDER", help="every view, into this folder")
    options = asked.parse_args()
    HERE.mkdir(exist_ok=True)
    with sync_playwright() as started:
        browser = started.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        for name in options.robot or TAKEN:
            with running(f"{name}-sim") as robot:
                until(lambda: (robot.ask("web/state") or {}).get("urls"), "its page", 30.0)
                if options.all is None:
                    TAKEN[name](browser, robot)
                else:
                    options.all.mkdir(parents=True, exist_ok=True)
                    take_all(browser, robot, options.all, name)
        browser.close()


if __name__ == "__main__":
    main()
