"""An agent whose program cannot ask its user: a person lets it by a button of the page."""

import asyncio

import pytest

from tests.apps.mcp.conftest import row
from tests.support import browsers, needs
from tests.support import robot as robots
from tests.support.waiting import HANG_S, until

needs.modules("mcp", "playwright")
from mcp import Client, StdioServerParameters  # noqa: E402 - an extra
from mcp.client.stdio import stdio_client  # noqa: E402
from playwright.async_api import async_playwright  # noqa: E402

pytestmark = [pytest.mark.slow_start, needs.program("chromium", "chromium")]
SPIN = {"power": 0.15, "angle_deg": 90, "seconds": 0.1}


@pytest.fixture
def shared(tmp_path):
    home = robots.prepare(tmp_path / "h", "web", edits=(row("lbr", "agents"),))
    with robots.running(home) as robot:
        yield robot


def test_a_person_lets_an_agent_move_the_robot_by_a_button_of_the_page(shared):
    lbr = StdioServerParameters(
        command=robots.LBR[0], args=[*robots.LBR[1:], "mcp"], env=robots.environment(shared.home)
    )

    async def main():
        async with async_playwright() as playwright, Client(stdio_client(lbr)) as agent:
            browser = await browsers.start(playwright)
            page = await browser.new_page()
            page.set_default_timeout(HANG_S * 1000)
            await page.goto(shared.web)
            await page.get_by_text("Connected").last.wait_for()
            assert (await agent.call_tool("drive", SPIN)).structured_content["code"] == "confirm"
            asked = page.get_by_role("alert").get_by_role("button", name="Let it")
            await asked.click()
            await asked.wait_for(state="detached")
            await asyncio.to_thread(until, lambda: shared.ask("agents/state")["allowed"])
            assert (await agent.call_tool("drive", SPIN)).structured_content["code"] == "done"
            await browser.close()

    asyncio.run(main())
