"""A page with a slider for the head and a button for each motion."""

from collections.abc import Callable
from importlib import resources
from typing import Annotated

from starlette.responses import Response

from lbr.apps.web import face as web
from lbr.apps.web.face import Route

PARTS = {"demo.js": "text/javascript", "demo.css": "text/css"}


def routes() -> list[Route]:
    """Return the page with the buttons, and its parts."""
    handlers = {"demo": _page, **{name: _part(name, media) for name, media in PARTS.items()}}
    return [
        Route(method="GET", path=f"/{path}", handle=handle, role=None, page=True) for path, handle in handlers.items()
    ]


def _page() -> Annotated[Response, web.HTML]:
    """A page to move the head and to play motions."""
    return web.html(_content("demo.html"))


def _part(name: str, media: str) -> Callable[[], Response]:
    content = _content(name)
    return lambda: web.text(content, media=media)


def _content(name: str) -> str:
    return (resources.files("lbr.robots.uxa90.rest") / "pages" / name).read_text()
