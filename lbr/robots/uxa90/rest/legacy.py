"""The UXA-90's API as a face of the server."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from starlette.responses import Response

from lbr.apps.web import face as web
from lbr.apps.web.face import Route, declared, get
from lbr.apps.web.robot import Robot
from lbr.robots.uxa90.rest.editing import Editor
from lbr.robots.uxa90.rest.handlers import Handlers
from lbr.robots.uxa90.rest.service import Service

HERE = "lbr.robots.uxa90.rest"


class Uxa90Face(web.Face):
    """The API of motors and motions (`Service`), and a page to try it."""

    name = "uxa90"

    def __init__(self, robot: Robot) -> None:
        self._work = Service(robot)
        self._handlers = Handlers(self._work)
        self._editor = Editor(robot, self._work.motors, self._work.buttons)
        layer, layers = robot.settings.layer, sorted({motor.layer for motor in robot.motors})
        if layers and layer not in layers:
            text = f"no row of the table motor has the layer '{layer}', so the API has no motors; there are "
            robot.ctx.event("no_motors", text + ", ".join(layers), level="warning")

    def routes(self) -> Sequence[Route]:
        """Return its routes."""
        return [*declared(self._handlers), *declared(self._editor), *declared(self)]

    @get("/demo", role=None, page=True)
    def _demo(self) -> Annotated[Response, web.HTML]:
        """A page to move the head and to play motions."""
        return web.static(HERE, "demo.html")

    @get("/demo.js", role=None, page=True)
    def _demo_js(self) -> Response:
        return web.static(HERE, "demo.js", web.SCRIPT)

    @get("/demo.css", role=None, page=True)
    def _demo_css(self) -> Response:
        return web.static(HERE, "demo.css", web.STYLE)

    def step(self, now: float) -> None:
        """Renew leases, and begin due moves."""
        self._work.step(now)

    def stopped(self, reason: str) -> None:
        """Drop everything that waits."""
        self._work.stopped(reason)

    def state(self) -> Mapping[str, Any]:
        """Return the commanded positions of motors, the current motion, and the number of waiting jobs."""
        return self._work.state()

    @property
    def jobs(self) -> int:
        """Return the number of waiting jobs."""
        return self._work.jobs.waiting
