"""A robot as a page sees it that also takes calls: the real capability, its media and its connections, in this process."""

import threading
import time
from typing import Any

from lbr.apps.call.capability import Call
from lbr.apps.call.kind import KIND, CallSettings
from lbr.apps.call.messages import CallState, CallWord, RingCommand
from lbr.messages.camera import CameraState, JpegFrame
from lbr.testing.context import FakeCall, FakeContext
from tests.apps.web.page_robot import CAPABILITIES, OPERATE, PageRobot, PageStage, capability, commands, outputs

FPS = 15
CALL = capability("call", "call", "takes calls", outputs(state="CallState"), commands(answer="admin", decline=OPERATE, end=OPERATE))  # fmt: skip


class CallRobot(PageRobot):
    """`camera_on` is the privacy switch; `away` says that the call's process is gone."""

    capabilities, faces = [*CAPABILITIES, CALL], ("page", "cameras", "call")

    def __init__(self) -> None:
        super().__init__()
        self.camera_on = True
        self.away = False
        self._turn = threading.RLock()
        self._seen_s = 0.0
        self._begin(microphone="tone")

    @property
    def state(self) -> CallState:
        """The newest that it told."""
        told = [message for output, message in self.ctx.published if output == "state"]
        return told[-1] if told else CallState()

    def row(self, **given: Any) -> None:
        """Have it start again, with another row, as its process does."""
        with self._turn:
            self.call._desk.orders.clear()
            if self.call._media is not None:
                self.call._media.stop()
            self._begin(**{"microphone": "tone", **given})

    def over(self) -> None:
        """End what calls there are."""
        self.ask("end", CallWord())

    def close(self) -> None:
        self.call.close()

    def _begin(self, **settings: Any) -> None:
        self.ctx = FakeContext(KIND, CallSettings(**settings), simulated=True, name="call")
        self.ctx.now = time.monotonic()
        self.call = Call(self.ctx)
        self.call.open()

    def streams(self) -> dict[str, Any]:
        return super().streams() | {"call/state": self.state, "camera_front/state": self._camera}

    @property
    def _camera(self) -> CameraState:
        return CameraState(on=self.camera_on, phase="streaming" if self.camera_on else "off", device="/dev/video0")

    def look(self, stage: PageStage) -> None:
        stage.show("camera_front", self._camera, self.picture())

    def step(self) -> None:
        super().step()
        with self._turn:
            now = self.ctx.now = time.monotonic()
            if now - self._seen_s >= 1 / FPS:
                self._seen_s = now
                self.ctx.arrive("cameras", self._camera, source="camera_front")
                if self.camera_on:
                    self.ctx.arrive("frames", JpegFrame(self.picture()), source="camera_front")
            self.call.step()
            del self.ctx.published[:-4]

    def ask(self, name: str, message: Any) -> Any:
        """Give the capability a command, and return its answer."""
        asked = FakeCall(name, message, source="console")
        with self._turn:
            self.call.command(asked)
        return asked.answer

    def answer(self, request: str, message: Any) -> Any:
        if not request.startswith("call_"):
            return super().answer(request, message)
        if self.away:
            return None
        return self.ask("ring" if isinstance(message, RingCommand) else "keep", message)

    def command(self, name: str, given: dict[str, Any]) -> Any:
        capability, _, word = name.partition("/")
        return self.ask(word, CallWord()) if capability == "call" else super().command(name, given)
