"""The API in the capability's loop: the robot's description, queries to the robot, and the motion of pages."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import TypeVar

import msgspec

from lbr.apps.web.api.catalog import EVENT, STATUS, Catalog, Described
from lbr.apps.web.api.feeds import Feeds
from lbr.apps.web.api.holds import Holds
from lbr.apps.web.api.link_age import slowed
from lbr.apps.web.api.page_message import Wanted
from lbr.apps.web.api.patience import silent_s
from lbr.apps.web.api.robot_bus import RobotBus
from lbr.apps.web.api.stops import AT_ONCE, Stops, Waiting
from lbr.apps.web.face import Client, Refused
from lbr.apps.web.robot import Robot
from lbr.bus import keys
from lbr.bus.codec import Decoder
from lbr.bus.stamp import Origin
from lbr.bus.wire import PendingQuery, PolledSubscription
from lbr.capability.kind import STOP
from lbr.errors import BusError, MalformedError
from lbr.leases.client import Transport
from lbr.messages.codes import Reason
from lbr.messages.description import RobotDescription
from lbr.messages.system import CapabilityStatus, EstopState, Role, Status, role_missing

NO_BUS = "the API serves where the robot runs; this server is on another machine"
NOT_YET = "the robot has not described itself yet; ask again"
REPORT = b"/report/robot"
REPORT_S, AGAIN_S = 2.0, 0.5
T = TypeVar("T")
_statuses = Decoder(Status)


class _Told(msgspec.Struct):
    """The answer to the report, in the form of a console line's result."""

    data: RobotDescription


_reports = Decoder(_Told)


class Api:
    """The API. All but `known`, `may`, `feeds`, `wake`, `now` and `holds.add` is for the capability's loop alone."""

    def __init__(self, robot: Robot, bus: RobotBus | None, version: str) -> None:
        self._robot = robot
        self._bus = bus
        self._version = version
        self._status: Status | None = None
        self._described: tuple[int, int] | None = None
        self._asked: PendingQuery | None = None
        self._ask_at = 0.0
        self._statuses: PolledSubscription | None = bus.hear(keys.status(robot.name)) if bus is not None else None
        self._stops = Stops()
        self.known: Catalog | None = None
        self.feeds = Feeds(bus, self._key, robot.ctx.name, robot.now) if bus is not None else None
        self.holds = Holds(self._transport, self._keys_of, robot.now, self._silent_s, self._slowed)

    def step(self) -> None:
        """Do one round of work."""
        self.holds.step()
        if self._bus is not None and self._robot.ctx.on_tick:
            self._look(self._bus, self._robot.now())

    def release(self, why: str) -> None:
        """Release the motion of all pages, as the server ends."""
        self.holds.close(why)

    def close(self) -> None:
        """Leave the bus."""
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()

    @property
    def phases(self) -> tuple[CapabilityStatus, ...]:
        """Return the status of each capability."""
        return self._status.capabilities if self._status is not None else ()

    @property
    def estop(self) -> EstopState | None:
        """Return the last reported emergency stop, or None."""
        return self._status.estop if self._status is not None else None

    def catalog(self) -> Catalog:
        """Return the catalog; raise Refused (503) while it is unknown."""
        if self.known is None:
            raise Refused(503, NOT_YET if self._bus is not None else NO_BUS, {"Retry-After": "1"}, "not_ready")
        return self.known

    def described(self, role: Role | None) -> Described:
        """Return the description of the robot for a role."""
        robot = self._robot
        return self.catalog().described(
            role=role,
            version=self._version,
            phases=self.phases,
            joints=robot.joints,
            motions=robot.motions,
            buttons=robot.buttons,
        )

    def query(
        self, name: str, payload: bytes, *, source: str, timeout_s: float, waiting: Waiting = AT_ONCE
    ) -> PendingQuery:
        """Query a key below the robot's name."""
        return self._ask(self._key(name), payload, source=source, timeout_s=timeout_s, waiting=waiting)

    def line(self, line: str, *, role: Role, source: str, timeout_s: float, waiting: Waiting = AT_ONCE) -> PendingQuery:
        """Send a console line with the rights of a role."""
        key = keys.console_of_pages(self._robot.name, role)
        return self._ask(key, line.encode(errors="replace"), source=source, timeout_s=timeout_s, waiting=waiting)

    def stopped(self, came_s: float, capability: str = "") -> None:
        """Note a stop of a capability, or of all, that was received at `came_s`."""
        self._stops.note(min(came_s, self.now()), capability)

    def waiting(self, came_s: float, capability: str = "") -> Waiting:
        """Return how long a request received at `came_s` has waited, and its date if a stop came after it."""
        overtaken = self._stops.overtook(came_s, capability)
        return Waiting(waited_s=max(0.0, self.now() - came_s), sent_s=came_s if overtaken else None)

    def manage(self, payload: bytes, *, source: str, timeout_s: float) -> PendingQuery:
        """Query the executive about rows, tokens and logs."""
        return self._ask(keys.manage(self._robot.name), payload, source=source, timeout_s=timeout_s)

    def now(self) -> float:
        """Monotonic seconds."""
        return self._robot.now()

    def wake(self) -> None:
        """Wake the loop for a page's message; from any thread."""
        self._robot.ctx.wake()

    def tell(self, kind: str, text: str, data: dict[str, object] | None = None) -> None:
        """Publish an event."""
        self._robot.ctx.event(kind, text, data=data)

    def may(self, client: Client) -> Callable[[Wanted], Reason | None]:
        """Return a function that gives the reason why a client may not have a motion, or None."""
        return partial(self._why_not, client)

    def _why_not(self, client: Client, wanted: Wanted) -> Reason | None:
        command = self.known.commands.get(wanted.to) if self.known is not None else None
        if self.known is None:
            return Reason("not_ready", NOT_YET)
        if command is None:
            return Reason("unknown_name", f"there is no command '{wanted.to}' on this robot")
        if not command.leased:
            return Reason("not_possible", f"'{wanted.to}' is not held: POST /api/{wanted.to} asks for it")
        return role_missing(command.role, client.role)

    def _silent_s(self, wanted: Wanted) -> float:
        command = self.known.commands.get(wanted.to) if self.known is not None else None
        return silent_s(command, wanted.message)

    def _slowed(self, wanted: Wanted, speed: float) -> Mapping[str, object]:
        command = self.known.commands.get(wanted.to) if self.known is not None else None
        return slowed(command, wanted.message, speed)

    def _keys_of(self, wanted: Wanted) -> Mapping[str, str]:
        stop = f"{wanted.capability}/{STOP}"
        found = {"motion": self._key(wanted.to)}
        return found | ({"halt": self._key(stop)} if self.known is not None and stop in self.known.commands else {})

    def _transport(self, source: str, wanted: Mapping[str, str], origin: Origin) -> Transport:
        if self._bus is None:
            raise BusError(NO_BUS)
        return self._bus.transport(source, wanted, self._robot.ctx.wake, origin)

    def _key(self, name: str) -> str:
        system = {STATUS: keys.status, EVENT: keys.event}
        return system[name](self._robot.name) if name in system else f"{self._robot.name}/{name}"

    def _ask(
        self, key: str, payload: bytes, *, source: str, timeout_s: float, waiting: Waiting = AT_ONCE
    ) -> PendingQuery:
        if self._bus is None:
            raise Refused(503, NO_BUS, code="not_possible")
        try:
            return self._bus.ask(
                key,
                payload,
                source=source,
                timeout_s=timeout_s,
                waited_s=waiting.waited_s,
                sent_s=waiting.sent_s,
                wake=self._robot.ctx.wake,
            )
        except BusError as err:
            raise Refused(503, str(err), {"Retry-After": "1"}) from None

    def _look(self, bus: RobotBus, now: float) -> None:
        """Read the robot's status, and request its description whenever its rows or processes change."""
        for raw in self._statuses.take() if self._statuses is not None else ():
            self._status = _read(_statuses, raw.payload) or self._status
        if self._asked is not None and (self._asked.replies or self._asked.done):
            self._take(self._asked)
            self._asked = None
        run = (self._status.pid, self._status.revision) if self._status is not None else None
        if self._asked is None and now >= self._ask_at and (self.known is None or run != self._described):
            self._ask_at = now + AGAIN_S
            key = keys.console_of_pages(self._robot.name, "view")
            with suppress(BusError):
                self._asked = bus.ask(
                    key, REPORT, source=self._robot.ctx.name, timeout_s=REPORT_S, wake=self._robot.ctx.wake
                )

    def _take(self, asked: PendingQuery) -> None:
        report = _read(_reports, asked.replies[0].payload) if asked.replies else None
        if report is None:
            return
        self.known = Catalog(report.data)
        if self._status is not None:
            self._described = self._status.pid, report.data.revision


def _read(decoder: Decoder[T], payload: bytes) -> T | None:
    try:
        return decoder.decode(payload)
    except MalformedError:
        return None
