"""A hand on a gamepad: its twist, its pressed buttons, and why the robot must stand. Pure.

The robot moves only while the gamepad is connected and its dead-man button is held. Since the gamepad came, the button
must have been released once, and since then the sticks at rest. Unknown values, and all but numbers, count as rest.
"""

from collections.abc import Iterable
from math import hypot, inf, isfinite
from typing import NamedTuple

from lbr.apps.teleop.kind import TeleopSettings
from lbr.messages.codes import Reason
from lbr.messages.gamepad import Axis, Button, GamepadState

CURVE = 1.6
"""The exponent from a stick's way to its speed, for fine control near the centre."""
AT_REST_S = 2.0
"""The age of a report that counts at rest. A driver reports at 2 Hz, and at 20 Hz while anything is held."""
NO_PAD = "no gamepad reports; see /report/health"
AT_REST = Reason("idle", "the sticks are at rest")


class Twist(NamedTuple):
    """A velocity (REP 103): ahead and to the left in metres a second, anticlockwise in radians a second."""

    vx_mps: float = 0.0
    vy_mps: float = 0.0
    wz_rps: float = 0.0


REST = Twist()


class Hand:
    """One person's hand on one gamepad."""

    def __init__(self, settings: TeleopSettings) -> None:
        self._settings = settings
        self._pad: GamepadState | None = None
        self._heard_at = 0.0
        self._released = self._rested = False

    @property
    def dead_man(self) -> bool:
        """Return whether the dead-man button is held, by the last report."""
        return self._pad is not None and self._settings.dead_man in self._pad.pressed

    @property
    def has_pad(self) -> bool:
        """Return whether there is a gamepad."""
        return self._pad is not None

    def receive(self, pad: GamepadState, sent_s: float) -> tuple[Button, ...]:
        """Receive a state of the gamepad; return the buttons pressed since the last one.

        A button that is already held when a gamepad comes was not pressed.
        """
        if not pad.connected:
            self.lose()
            return ()
        before, self._pad, self._heard_at = self._pad, pad, sent_s
        if not self.dead_man:
            self._released, self._rested = True, False
        elif self._released and wanted(pad.axes, self._settings) == REST:
            self._rested = True
        if before is None:
            return ()
        return tuple(one for one in pad.pressed if one not in before.pressed)

    def lose(self) -> None:
        """Forget the gamepad; with the next one the dead-man button must be pressed again."""
        self._pad = None
        self.let_go()

    def let_go(self) -> None:
        """Require a new press of the dead-man button."""
        self._released = self._rested = False

    def centre(self) -> None:
        """Require the sticks at rest once."""
        self._rested = False

    def stands(self, now: float) -> Reason | None:
        """Return why the robot must stand, whatever the sticks do; None if it may move."""
        pad = self._pad
        if pad is None:
            return Reason("unreachable", NO_PAD)
        limit_s = self._settings.stale_s if self.dead_man else AT_REST_S
        if not now - self._heard_at <= limit_s:  # this way round, NaN is too old
            self.lose()
            return Reason("stale_sensor", "the gamepad's driver has fallen silent")
        return self._not_meant(pad) or self._out_of_range(pad, now)

    def twist(self) -> tuple[Twist, Reason]:
        """Return the twist of the sticks and the reason; at rest if they were not centred yet."""
        if self._pad is None or not self._rested:
            return REST, Reason("rest_first", "let the sticks go to their centre first")
        found = wanted(self._pad.axes, self._settings)
        return found, AT_REST if found == REST else Reason("done", "it drives")

    def _not_meant(self, pad: GamepadState) -> Reason | None:
        """Return why held buttons are ignored, or None."""
        settings = self._settings
        if not self.dead_man:
            return Reason("idle", f"the button {settings.dead_man} is not held")
        if not self._released:
            return Reason("rest_first", f"release the button {settings.dead_man}, and press it again")
        if {settings.stop, settings.estop} & set(pad.pressed):
            self.let_go()
            return Reason("stopped", "a button that stops is held")
        return None

    def _out_of_range(self, pad: GamepadState, now: float) -> Reason | None:
        """Return why a radio gamepad may be out of range, or None; one out of range reports a held button for ever."""
        settings = self._settings
        if pad.link != "bluetooth" and not settings.wireless:
            return None
        silent_s = inf if pad.silent_s is None else pad.silent_s + now - self._heard_at
        if silent_s <= settings.silent_s:
            return None
        return Reason("stale_sensor", f"the gamepad sent nothing for {settings.silent_s:g} s: it may be out of range")


def wanted(axes: dict[Axis, float], settings: TeleopSettings) -> Twist:
    """Return the twist of the sticks; rest if an axis is not a number."""
    ahead, aside = axes.get("left_y", 0.0), axes.get("left_x", 0.0)
    turn = axes.get("right_x", 0.0)
    if not all(map(isfinite, (ahead, aside, turn))):
        return REST
    if settings.sideways:
        ahead, aside = _together(ahead, aside, settings.dead_zone)
    else:
        ahead, aside, turn = _share(ahead, settings.dead_zone), 0.0, max(aside, turn, key=abs)
    return Twist(
        vx_mps=_neat(ahead * settings.speed_mps),
        vy_mps=_neat(-aside * settings.speed_mps),
        wz_rps=_neat(-_share(turn, settings.dead_zone) * settings.turn_rps),
    )


def _together(ahead: float, aside: float, dead_zone: float) -> tuple[float, float]:
    """Return the two shares of a stick that moves any way: its direction stays, its length is scaled."""
    way = hypot(ahead, aside)
    share = _share(way, dead_zone)
    return (ahead / way * share, aside / way * share) if share else (0.0, 0.0)


def _share(way: float, dead_zone: float) -> float:
    """Return the share of full speed for a stick's way."""
    beyond = min(1.0, abs(way)) - dead_zone
    if not beyond > 0.0:
        return 0.0
    share: float = (beyond / (1.0 - dead_zone)) ** CURVE
    return share if way > 0.0 else -share


def _neat(value: float) -> float:
    return round(value, 3) or 0.0


def presses(pressed: Iterable[Button], settings: TeleopSettings) -> list[str]:
    """Return the actions of pressed buttons, stops first: `stop`, `estop`, or a line."""
    found = list(pressed)
    asked = [word for word, button in (("estop", settings.estop), ("stop", settings.stop)) if button in found]
    return asked + [settings.lines[one] for one in found if one in settings.lines]
