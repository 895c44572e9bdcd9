"""A robot, its dock and four walls as plain geometry: enough to see whether docking docks."""

from collections.abc import Iterator
from math import atan2, cos, degrees, hypot, inf, pi, radians, remainder, sin, tau

from lbr.apps.behaviours.cells import Value
from lbr.apps.behaviours.keys import Key
from lbr.leases.holder import FINAL
from lbr.messages.codes import Code
from lbr.robots.lbr.beacon import BeaconSettings
from lbr.robots.lbr.beacon.view import STAND, Action, Back, Ending, Go, Turn, View
from tests.models.table_run import TableRun, dock_table

STEP_S = 0.1
WALLS = (-1.5, 4.5, -2.5, 2.5)
DOCK = (-1.14, 1.2)
HALF_M = 0.215
REACH_M, SPREAD_DEG, OVERLAP_DEG, RECEIVER_DEG = 3.0, 25.0, 6.0, 120.0
PLATE_M, CONTACT_M, GIVE_M = 0.03, 0.05, 0.02
CORNER_M = 0.11
TURN_DPS, FULL_DPS = 60.0, 400.0


class Room:
    """Moves the robot as asked, and shows it what its sensors would."""

    def __init__(self, x_m: float = 0.0, y_m: float = 0.0, yaw_deg: float = 0.0, *, charger: bool = True) -> None:
        self.x_m, self.y_m, self.yaw = x_m, y_m, radians(yaw_deg)
        self.now = 0.0
        self.charger = charger
        self.dock_there = True
        self.contact_at = inf
        self.said: list[str] = []
        self.state = ""
        self.refuse = ""
        self.code: Code = "not_armed"
        self._action: object = None
        self._left = 0.0
        self._ending: Ending | None = None

    def run(self, settings: BeaconSettings | None = None, *, limit_s: float = 900.0) -> Ending:
        """Dock by the table; return how it ended."""
        running = TableRun(dock_table(), self.now, lambda count: count - 1, settings or BeaconSettings())
        action: Action = STAND
        while self.now < limit_s:
            self._act(action)
            self.now += STEP_S
            action = running.round(self.view(), self.now, self._look)
            if (ending := running.ending) is not None:
                self.said, self.state = running.said, running.run.state
                return ending
        raise AssertionError("docking does not end")

    def _look(self, key: Key, newest_s: float) -> Value | None:
        """Return what a column of the table asks for."""
        del newest_s
        view = self.view()
        charging_s = self.now - self.contact_at if self.charger else -1.0
        return {
            "battery.charging": float(bool(view.charging)),
            "dock.power": float("power" in view.beams),
            "beacon.risen_v": 0.1 + 0.018 * charging_s if charging_s > 0.0 else 0.0,
        }[key.name]

    def view(self) -> View:
        touching = self.touching()
        self.contact_at = min(self.contact_at, self.now) if touching else inf
        charging_s = self.now - self.contact_at if self.charger else -1.0
        return View(
            time_s=self.now,
            direction_deg=-degrees(self.yaw),
            forward_m=self._range(self.yaw),
            back_m=self._range(self.yaw + pi),
            beams=frozenset(self._beams()),
            charging=charging_s > 8.0,
            ending=self._ending,
        )

    def touching(self) -> bool:
        """Both contacts on their plates."""
        x, y = self._back()
        turned = remainder(self.yaw, tau)
        gaps = [x + side * CONTACT_M * -sin(turned) - DOCK[0] for side in (-1, 1)]
        return self.dock_there and abs(y - DOCK[1]) <= PLATE_M and all(abs(gap) <= GIVE_M for gap in gaps)

    def _act(self, action: object) -> None:
        if action is not self._action and not (isinstance(action, Back) and isinstance(self._action, Back)):
            self._begin(action)
        self._action = action
        if self._ending is None and isinstance(action, Turn):
            self._turn()
        elif self._ending is None and isinstance(action, Go):
            self._ahead(action)
        elif self._ending is None and isinstance(action, Back):
            steer = sin(radians(action.steer_deg))
            ahead = cos(radians(action.steer_deg))
            share = action.power / (abs(steer) + ahead)
            self.yaw -= radians(steer * share * FULL_DPS) * STEP_S
            self._move(-share * ahead * STEP_S)

    def _begin(self, action: object) -> None:
        self._ending = None
        if self.refuse and isinstance(action, Turn | Go | Back):
            self._ending = Ending(good=False, text=self.refuse, code=self.code, final=self.code in FINAL)
        self._left = action.angle_deg if isinstance(action, Turn) else 0.0
        if isinstance(action, Go):
            self._left = action.distance_m

    def _turn(self) -> None:
        part = max(-TURN_DPS * STEP_S, min(TURN_DPS * STEP_S, self._left))
        self._left -= part
        self.yaw -= radians(part)
        if not self._left:
            self._ending = Ending(good=True, text="turned")

    def _ahead(self, action: Go) -> None:
        part = max(-action.power * STEP_S, min(action.power * STEP_S, self._left))
        self._left -= part
        if self._range(self.yaw if part > 0.0 else self.yaw + pi) < 0.3:
            self._ending = Ending(good=False, text="the forward rule stops the base", code="obstacle")
        else:
            self._move(part)
            if not self._left:
                self._ending = Ending(good=True, text="drove")

    def _move(self, way_m: float) -> None:
        before = self.x_m, self.y_m
        self.x_m += way_m * cos(self.yaw)
        self.y_m += way_m * sin(self.yaw)
        if way_m < 0.0 and self._hits_dock():
            self.x_m, self.y_m = before

    def _hits_dock(self) -> bool:
        x, y = self._back()
        nearest = x - CORNER_M * abs(sin(self.yaw))
        return self.dock_there and nearest < DOCK[0] - 0.005 and abs(y - DOCK[1]) < 0.15 + CORNER_M

    def _back(self) -> tuple[float, float]:
        return self.x_m - HALF_M * cos(self.yaw), self.y_m - HALF_M * sin(self.yaw)

    def _range(self, heading: float) -> float:
        west, east, south, north = WALLS
        walls = ((west, east, self.x_m, cos(heading)), (south, north, self.y_m, sin(heading)))
        ways = [((high if way > 0 else low) - at) / way for low, high, at, way in walls if abs(way) > 1e-9]
        return min(ways) - HALF_M

    def _beams(self) -> Iterator[str]:
        if not self.dock_there:
            return
        if self.touching():
            yield "power"
        x, y = self._back()
        ahead, aside = x - DOCK[0] + 0.05, y - DOCK[1]
        bearing = degrees(atan2(aside, ahead))
        away = degrees(remainder(atan2(-aside, -ahead) - self.yaw - pi, tau))
        if hypot(ahead, aside) > REACH_M or abs(away) > RECEIVER_DEG / 2:
            return
        if -OVERLAP_DEG / 2 <= bearing <= SPREAD_DEG:
            yield "left"
        if -SPREAD_DEG <= bearing <= OVERLAP_DEG / 2:
            yield "right"
