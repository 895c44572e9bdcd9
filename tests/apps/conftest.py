"""A browser for the modules that look at a robot's page."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.support import browsers

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture(scope="module")
def browser(request: pytest.FixtureRequest) -> Iterator["Browser"]:
    """The one without windows, started with the module's `ARGUMENTS` if it has some."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        found = browsers.start(started, *getattr(request.module, "ARGUMENTS", ()))
        yield found
        found.close()
