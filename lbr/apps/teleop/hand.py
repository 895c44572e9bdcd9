"""The meaning of a hand on a gamepad: which twist, which buttons were pressed, and why the robot is to stand. Pure.

The robot moves only while all of this is so: the dead-man button is held, and was seen released since the gamepad came;
the sticks were seen at rest since then; the gamepad is connected. An unknown value, and anything but a number, is rest.
"""

from collections.abc import Iterable
from math import hypot, inf, isfinite
from typing import NamedTuple

from lbr.apps.teleop.kind import TeleopSettings
from lbr.messages.codes import Reason
from lbr.messages.gamepad import Axis, Button, GamepadState

CURVE = 1.6
"""Fine near the centre: the speed grows with this power of the way."""
AT_REST_S = 2.0
"""A driver speaks twice a second while nothing is held on its gamepad, and twenty times while anything is."""
NO_PAD = "no gamepad is heard of; see /report/health"
AT_REST = Reason("idle", "the sticks are at rest")


class Twist(NamedTuple):
    """REP 103: ahead and to the left in metres a second, anticlockwise in radians a second."""

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
        """Return whether the dead-man button is held, as far as is known."""
        return self._pad is not None and self._settings.dead_man in self._pad.pressed

    @property
    def has_pad(self) -> bool:
        """Return whether there is a gamepad."""
        return self._pad is not None

    def receive(self, pad: GamepadState, sent_s: float) -> tuple[Button, ...]:
        """Receive a state of the gamepad; return the buttons that were pressed since the last one.

        A button that is held already when a gamepad comes was not pressed.
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
        """Have no gamepad: once there is one, the dead-man button must be pressed again before anything moves."""
        self._pad = None
        self.let_go()

    def let_go(self) -> None:
        """Ask for the dead-man button to be pressed again before anything moves."""
        self._released = self._rested = False

    def centre(self) -> None:
        """Have the sticks at rest before anything moves."""
        self._rested = False

    def stands(self, now: float) -> Reason | None:
        """Return why nothing may move, wherever the sticks are; None if it may."""
        pad = self._pad
        if pad is None:
            return Reason("unreachable", NO_PAD)
        limit_s = self._settings.stale_s if self.dead_man else AT_REST_S
        if not now - self._heard_at <= limit_s:  # this way round, NaN is too old
            self.lose()
            return Reason("stale_sensor", "the gamepad's driver has fallen silent")
        return self._not_meant(pad) or self._out_of_range(pad, now)

    def twist(self) -> tuple[Twist, Reason]:
        """Return how a robot that may move is to move, and if not at all, why."""
        if self._pad is None or not self._rested:
            return REST, Reason("rest_first", "let the sticks go to their centre first")
        found = wanted(self._pad.axes, self._settings)
        return found, AT_REST if found == REST else Reason("done", "it drives")

    def _not_meant(self, pad: GamepadState) -> Reason | None:
        """Return why what is held means nothing."""
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
        """Return why a gamepad that has a radio may not be where its hand is: one out of range is held for ever."""
        settings = self._settings
        if pad.link != "bluetooth" and not settings.wireless:
            return None
        silent_s = inf if pad.silent_s is None else pad.silent_s + now - self._heard_at
        if silent_s <= settings.silent_s:
            return None
        return Reason("stale_sensor", f"the gamepad said nothing for {settings.silent_s:g} s: it may be out of range")


def wanted(axes: dict[Axis, float], settings: TeleopSettings) -> Twist:
    """Return the twist of the sticks; rest if one of them is not a number."""
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
    """Return the shares of one stick that moves any way: its direction stays, its way is what counts."""
    way = hypot(ahead, aside)
    share = _share(way, dead_zone)
    return (ahead / way * share, aside / way * share) if share else (0.0, 0.0)


def _share(way: float, dead_zone: float) -> float:
    """Return how much of what is possible a way of a stick means."""
    beyond = min(1.0, abs(way)) - dead_zone
    if not beyond > 0.0:
        return 0.0
    share: float = (beyond / (1.0 - dead_zone)) ** CURVE
    return share if way > 0.0 else -share


def _neat(value: float) -> float:
    return round(value, 3) or 0.0


def presses(pressed: Iterable[Button], settings: TeleopSettings) -> list[str]:
    """Return what pressed buttons ask for, stops first: `stop`, `estop`, or a line."""
    found = list(pressed)
    asked = [word for word, button in (("estop", settings.estop), ("stop", settings.stop)) if button in found]
    return asked + [settings.lines[one] for one in found if one in settings.lines]
