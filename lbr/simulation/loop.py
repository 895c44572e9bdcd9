"""The thread in which a world lives: physics on time, and devices that answer at once."""

import selectors
import threading
from collections.abc import Callable, Sequence

from lbr.messages.simulation import WorldPose
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.engine import Engine
from lbr.simulation.model import TIMESTEP_S
from lbr.simulation.twins import Feeling, RoboteqTwin, Twin

_LATEST_S = 0.1
"""The world never makes up for more than this: a machine that slept does not find its robot elsewhere."""

_SENSE_EVERY = 5

_RESTING_S = 0.3
_RESTING_LOOK_S = 0.005


class WorldLoop:
    """Runs engine and twins until closed; `pose` and `ranges_m` are the newest, `failure` is why it ended early."""

    def __init__(
        self, engine: Engine, twins: Sequence[Twin], clock: Callable[[], float], cameras: CameraHost | None = None
    ) -> None:
        self.pose: WorldPose = engine.pose()
        self.ranges_m = engine.sensed().ranges_m
        self.failure: BaseException | None = None
        self._engine = engine
        self._twins = twins
        self._motors = next((twin for twin in twins if isinstance(twin, RoboteqTwin)), None)
        self._feeling: list[Feeling] = [twin for twin in twins if isinstance(twin, Feeling)]
        self._cameras = cameras
        self._clock = clock
        self._watched: dict[str, int] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="world", daemon=True)
        self._rounds = 0

    def open(self) -> None:
        """Plug every device in, then start."""
        self._share()
        for twin in self._twins:
            twin.service(self._clock())
        self._thread.start()

    def close(self) -> None:
        """End the thread, then pull every device out; a controller whose motors turn outlives its host for a while."""
        for _ in range(round(_RESTING_S / _RESTING_LOOK_S)):
            if not self._thread.is_alive() or not self._turning():
                break
            self._closing.wait(_RESTING_LOOK_S)
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        for twin in self._twins:
            twin.close()

    def _turning(self) -> bool:
        return self._motors is not None and self._motors.wheels(self._clock()) != (0.0, 0.0)

    def _run(self) -> None:
        try:
            with selectors.DefaultSelector() as selector:
                self._live(selector)
        except BaseException as err:  # noqa: BLE001  whoever owns the thread raises it again
            self.failure = err

    def _live(self, selector: selectors.BaseSelector) -> None:
        last = self._clock()
        due = last + TIMESTEP_S
        while not self._closing.is_set():
            self._watch(selector)
            selector.select(max(0.0, self._next_due(due) - self._clock()))
            now = self._clock()
            for twin in self._twins:
                twin.service(now)
            if now >= due:
                self._advance(now, min(now - last, _LATEST_S))
                last, due = now, max(due + TIMESTEP_S, now)

    def _watch(self, selector: selectors.BaseSelector) -> None:
        """Wait for bytes only where they will be read; a full port would wake the loop for ever."""
        for twin in self._twins:
            wanted = twin.watched()
            watched = self._watched.get(twin.name)
            if wanted == watched:
                continue
            if watched is not None:
                selector.unregister(self._watched.pop(twin.name))
            if wanted is not None:
                selector.register(wanted, selectors.EVENT_READ)
                self._watched[twin.name] = wanted

    def _next_due(self, physics: float) -> float:
        return min([physics, *(at for twin in self._twins if (at := twin.next_due()) is not None)])

    def _advance(self, now: float, dt_s: float) -> None:
        left, right = self._motors.wheels(now) if self._motors else (0.0, 0.0)
        self._engine.step(left, right, dt_s)
        if self._feeling:
            reading = self._engine.imu()
            for twin in self._feeling:
                twin.feel(reading, now)
        self._rounds += 1
        if self._rounds % _SENSE_EVERY == 0:
            self._share()

    def _share(self) -> None:
        sensed = self._engine.sensed()
        self.pose, self.ranges_m = self._engine.pose(), sensed.ranges_m
        for twin in self._twins:
            twin.sense(sensed)
        if self._cameras is not None and self._cameras.running:
            self._cameras.show(self._engine.view(), self._clock())
