"""The thread of a world: physics on time, and devices that answer at once."""

import selectors
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.measured import ImuReading, Sensed
from lbr.simulation.stepped import SteppedEngine
from lbr.simulation.twins import Feeling, Twin

E = TypeVar("E", bound=SteppedEngine)
SWITCH_S = 0.0005
"""The time within which a world's thread gets its turn; the default 5 ms would show in the devices' answers."""

_LATEST_S = 0.1
"""The world never catches up by more than this: a machine that slept does not find its robot elsewhere."""

_SENSE_EVERY = 5

_REST_S = 0.04
"""The interval of looks at a resting world; the same as for measurements while it moves."""

_RESTING_S = 0.3
_RESTING_LOOK_S = 0.005


class Physics(ABC, Generic[E]):
    """The parts that a loop keeps on time: an engine with the twins that move it, and the cameras in its world."""

    def __init__(self, engine: E, cameras: CameraHost) -> None:
        self.timestep_s = engine.timestep_s
        self._engine = engine
        self._cameras = cameras

    @abstractmethod
    def advance(self, now: float, dt_s: float) -> None:
        """Run for `dt_s`, moved by the present state of its twins."""

    @abstractmethod
    def resting(self, now: float) -> bool:
        """Return whether nothing moves or is about to: then time needs no steps."""

    def rest(self, dt_s: float) -> None:
        """Let time pass in which nothing has moved."""
        self._engine.rest(dt_s)

    def imu(self) -> ImuReading:
        """Return an inertial unit's measurement at the newest step."""
        return self._engine.imu()

    @abstractmethod
    def look(self, now: float) -> Sensed:
        """Look around: return the present measurements of devices, and keep the data that others ask for."""

    @abstractmethod
    def moved_by(self, twin: Twin) -> bool:
        """Return whether a twin moves parts of the world: such a one exists from the beginning."""

    @abstractmethod
    def at_rest(self, now: float) -> bool:
        """Return whether no power moves anything any more."""


class WorldLoop:
    """Runs physics and twins until closed; `failure` is why it ended early."""

    def __init__(self, physics: Physics[Any], twins: Sequence[Twin], clock: Callable[[], float]) -> None:
        self.failure: BaseException | None = None
        self._physics = physics
        self._twins = tuple(twins)
        self._coming: deque[Twin] = deque()
        self._feeling: list[Feeling] = [twin for twin in twins if isinstance(twin, Feeling)]
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

    def add(self, twin: Twin) -> str:
        """Plug in one more device while time runs; return why that fails. For another thread."""
        if self._physics.moved_by(twin):
            return f"'{twin.name}' moves what is in the world, and so is there from its beginning"
        self._coming.append(twin)
        return ""

    def step(self, dt_s: float) -> None:
        """Do all that is due, then let time pass; for a caller with its own clock and no thread."""
        now = self._clock()
        self._let_in()
        for twin in self._twins:
            twin.service(now)
        self._advance(now, dt_s)
        self._share()

    def close(self) -> None:
        """End the thread, then pull every device out; a controller outlives its host for a while if its motors turn."""
        for _ in range(round(_RESTING_S / _RESTING_LOOK_S)):
            if not self._thread.is_alive() or self._physics.at_rest(self._clock()):
                break
            self._closing.wait(_RESTING_LOOK_S)
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        for twin in (*self._twins, *self._coming):
            twin.close()

    def _run(self) -> None:
        try:
            with selectors.SelectSelector() as selector:  # others wait in whole milliseconds; a servo answers sooner
                self._live(selector)
        except BaseException as err:  # noqa: BLE001  the owner of the thread raises it again
            self.failure = err

    def _live(self, selector: selectors.BaseSelector) -> None:
        last = self._clock()
        due = last + self._physics.timestep_s
        while not self._closing.is_set():
            self._let_in()
            self._watch(selector)
            times = {id(twin): at for twin in self._twins if (at := twin.next_due()) is not None}
            heard = selector.select(max(0.0, min((due, *times.values())) - self._clock()))
            now = self._clock()
            busy = {id(key.data) for key, _ in heard} | {twin for twin, at in times.items() if at <= now}
            rests = self._physics.resting(now)
            if rests and now - last >= self._physics.timestep_s and any(id(twin) in busy for twin in self._feeling):
                self._advance(now, min(now - last, _LATEST_S))  # twins that follow each step then have the newest
                last = now
            for twin in self._twins:
                if now >= due or id(twin) in busy:
                    twin.service(now)
            if rests and not self._physics.resting(now):
                self._physics.rest(min(now - last, _LATEST_S))  # before this power came
                last, due = now, now + self._physics.timestep_s
            elif now >= due:
                self._advance(now, min(now - last, _LATEST_S))
                self._rounds += _SENSE_EVERY if rests else 1
                if self._rounds >= _SENSE_EVERY:
                    self._rounds = 0
                    self._share()
                step_s = _REST_S if self._physics.resting(now) else self._physics.timestep_s
                last, due = now, max(due + step_s, now)
        for twin in self._twins:
            twin.service(self._clock())  # events of the last step: a watchdog, the host's last bytes

    def _let_in(self) -> None:
        while self._coming:
            twin = self._coming.popleft()
            twin.sense(self._physics.look(self._clock()))
            self._twins = (*self._twins, twin)
            if isinstance(twin, Feeling):
                self._feeling.append(twin)

    def _watch(self, selector: selectors.BaseSelector) -> None:
        """Wait for bytes only where they will be read; a full port would wake the loop forever."""
        for twin in self._twins:
            wanted = twin.watched()
            watched = self._watched.get(twin.name)
            if wanted == watched:
                continue
            if watched is not None:
                selector.unregister(self._watched.pop(twin.name))
            if wanted is not None:
                selector.register(wanted, selectors.EVENT_READ, twin)
                self._watched[twin.name] = wanted

    def _advance(self, now: float, dt_s: float) -> None:
        self._physics.advance(now, dt_s)
        if self._feeling:
            reading = self._physics.imu()
            for twin in self._feeling:
                twin.feel(reading, now)

    def _share(self) -> None:
        sensed = self._physics.look(self._clock())
        for twin in self._twins:
            twin.sense(sensed)
