"""A robot as a page sees it that also takes calls: the real capability, its media and its connections, in this process."""

import asyncio
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from lbr.apps.call.capability import Call
from lbr.apps.call.kind import KIND, CallSettings
from lbr.apps.call.messages import CallState, CallWord, KeepCommand, RingCommand
from lbr.apps.web.page.files import INDEX, POLICY
from lbr.messages.camera import CameraState, JpegFrame
from lbr.testing.context import FakeCall, FakeContext
from tests.apps.web.page_robot import CAPABILITIES, OPERATE, PageRobot, capability, commands, outputs, page_files

FPS = 15
CALL = capability("call", "call", "takes calls", outputs(state="CallState"), commands(answer="admin", decline=OPERATE, end=OPERATE))  # fmt: skip


class CallRobot(PageRobot):
    """`camera_on` is the privacy switch; `away` says that the call's process is gone."""

    def __init__(self, **settings: Any) -> None:
        super().__init__()
        self.ctx = FakeContext(KIND, CallSettings(**{"microphone": "tone", **settings}), simulated=True, name="call")
        self.ctx.now = time.monotonic()
        self.call = Call(self.ctx)
        self.call.open()
        self.camera_on = True
        self.away = False
        self.who = "ann at 192.0.2.7"
        self._todo: deque[tuple[Callable[[], object], threading.Event]] = deque()

    @property
    def state(self) -> CallState:
        """The newest that it told."""
        told = [message for output, message in self.ctx.published if output == "state"]
        return told[-1] if told else CallState()

    def row(self, **given: Any) -> None:
        """Have it start again, with another row, as its process does; from any thread."""
        self._do(lambda: self._restart(**given))

    def over(self) -> None:
        """End what calls there are; from any thread."""
        self.who = "ann at 192.0.2.7"
        self._do(lambda: self.ask("end", CallWord()))

    def _restart(self, **given: Any) -> None:
        self.call._desk.orders.clear()
        if self.call._media is not None:
            self.call._media.stop()
        self.ctx.settings = CallSettings(**{"microphone": "tone", **given})
        self.ctx.events.clear()
        self.call = Call(self.ctx)
        self.call.open()

    def _do(self, work: Callable[[], object]) -> None:
        done = threading.Event()
        self._todo.append((work, done))
        assert done.wait(10.0)

    def describe(self) -> dict[str, Any]:
        return super().describe() | {"capabilities": [*CAPABILITIES, CALL]}

    def streams(self) -> dict[str, Any]:
        told = {name: getattr(self.state, name) for name in self.state.__struct_fields__}
        camera = {"on": self.camera_on, "phase": "streaming" if self.camera_on else "off", "device": "/dev/video0"}
        return super().streams() | {"call/state": told, "camera_front/state": camera}

    def more_routes(self) -> list[Route]:
        post = ["POST"]
        return [
            Route("/call", self._ring, methods=post),
            Route("/call/{id}", self._keep, methods=post),
            Route("/api/call/{word}", self._word, methods=post),
            Route("/display", self._display),
        ]

    async def go_on(self) -> None:
        """Let time pass, and have the camera see something."""
        room = asyncio.create_task(super().go_on())
        shown = 0.0
        while not self.closed:
            now = self.ctx.now = time.monotonic()
            if now - shown >= 1 / FPS:
                shown = now
                on = CameraState(
                    on=self.camera_on, phase="streaming" if self.camera_on else "off", device="/dev/video0"
                )
                self.ctx.arrive("cameras", on, source="camera_front")
                if self.camera_on:
                    self.ctx.arrive("frames", JpegFrame(self.picture()), source="camera_front")
            while self._todo:
                work, done = self._todo.popleft()
                work()
                done.set()
            self.call.step()
            del self.ctx.published[:-4]
            await asyncio.sleep(0.01)
        self.call.close()
        await room

    def ask(self, name: str, message: Any) -> Any:
        """Give the capability a command, and return its answer."""
        asked = FakeCall(name, message, source="console")
        self.call.command(asked)
        return asked.answer

    async def _ring(self, request: Request) -> Response:
        if self.away:
            return JSONResponse({"message": "'call' does not answer", "code": "unreachable"}, 503)
        given = await request.json()
        asked = RingCommand(purpose=given["purpose"], offer=given["offer"], by=self.who, role=self.role)  # type: ignore[arg-type]
        return _told(self.ask("ring", asked), 409)

    async def _keep(self, request: Request) -> Response:
        given = await request.json()
        if self.away:
            return JSONResponse({"message": "'call' does not answer", "code": "unreachable"}, 503)
        return _told(self.ask("keep", KeepCommand(id=request.path_params["id"], leave=given.get("leave", False))), 404)

    async def _word(self, request: Request) -> Response:
        return _told(self.ask(request.path_params["word"], CallWord()), 409)

    async def _display(self, _request: Request) -> Response:
        found = page_files()[INDEX]
        return Response(found.content, media_type=found.media, headers={"Content-Security-Policy": POLICY})


def _told(reply: Any, status: int) -> Response:
    told = {name: getattr(reply, name) for name in reply.__struct_fields__}
    if reply.accepted:
        return JSONResponse(told)
    return JSONResponse({"message": reply.reason, "code": reply.code}, status)
