"""A page with a slider for the head and a button for each motion."""

from collections.abc import Callable
from importlib import resources

from starlette.responses import Response

from lbr.apps.web import face as web
from lbr.apps.web.face import Request, Route

PARTS = {
    "/demo": ("demo.html", web.HTML),
    "/demo.js": ("demo.js", "text/javascript"),
    "/demo.css": ("demo.css", "text/css"),
}


def routes() -> tuple[Route, ...]:
    """Return the page with the buttons, and its parts."""
    return tuple(
        Route(
            method="GET",
            path=path,
            handle=_page(name, media),
            summary="A page to move the head and to play motions",
            replies={200: media},
            role=None,
            page=True,
            hidden=path != "/demo",
        )
        for path, (name, media) in PARTS.items()
    )


def _page(name: str, media: str) -> Callable[[Request], Response]:
    content = (resources.files("lbr.robots.uxa90.rest") / "pages" / name).read_text()
    return lambda _request: web.text(content, media=media)
